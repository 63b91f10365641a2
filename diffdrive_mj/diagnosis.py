"""What looks wrong with a drive's data before a robot is calibrated on it.

The motions over windows of about a second are compared, as the wheels tell them and as the truth has them:
(forward, left, b / 2 times the turn) in the frame of the window's start, all in metres. A robot believed wrongly by
some ten per cent is no reason for suspicion; wheels that are exchanged, and units that are not what they seem, are.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from diffdrive_mj import se2
from diffdrive_mj.checks import Array
from diffdrive_mj.drive import Drive
from diffdrive_mj.robot import Robot

WINDOW = 1.0  # [s]
LONGEST_WINDOW = 5.0  # [s]; truth that is sparser tells nothing of what happened in between.
SLOWEST, FASTEST = 5e-3, 50.0  # The fastest that a wheel's rim runs on a drive, at least and at most [m/s].
OUTSIDE = 0.05  # Of the poses, or of the wheels' turning: what may lie outside the other's time.
SCALE = 3.0  # A robot believed wrong by more is none.
# Of the track width: the smallest motion that only one of the two has, and how much of a drive must be seen.
UNEXPLAINED, ENOUGH = 0.15, 1.0


def suspicions(drive: Drive, believed: Robot) -> tuple[str, ...]:
    """What looks wrong with a drive, each a sentence; none if it looks clean.

    Looked for: truth and wheels of different times; a unit of time, of position or of the wheels that cannot be; a
    heading that is not along the path; wheels that are exchanged or count backwards; a robot that was lifted or
    pushed, by more than 0.15 of its track within a second. Truth sparser than 5 s shows the times alone.

    Args:
        drive: that was measured.
        believed: the nominal robot, to some ten per cent.
    """
    found = _spans(drive, believed)
    if odd := _time_unit(drive, believed):
        return (*found, odd)
    pairs = _windows(drive.clock)
    if not len(pairs):
        return tuple(found)
    wheels, truth = _motions(drive.odometry(believed), pairs, believed), _motions(drive.truth, pairs, believed)
    # Each of these would make all that follow it sound the alarm.
    for odd in (
        _units(wheels, truth, believed),
        _heading(truth, believed),
        _sides(drive, believed, pairs, wheels, truth),
        _pushed(drive.clock, pairs, wheels, truth, believed),
    ):
        if odd:
            return (*found, odd)
    return tuple(found)


def _rolled(drive: Drive, robot: Robot) -> Array:
    """How far the faster rim rolled from each sample to the next (T - 1,) [m]."""
    return np.abs(np.diff(drive.wheel_angles, axis=0) * [robot.left_radius, robot.right_radius]).max(axis=1)


def _spans(drive: Drive, believed: Robot) -> list[str]:
    found = []
    count = drive.dropped + len(drive.truth)
    if drive.dropped > OUTSIDE * count:
        found.append(f"{drive.dropped} of {count} true poses lie outside the time of the wheels: are the clocks one?")
    rolled = _rolled(drive, believed)
    unseen = (drive.t[1:] <= drive.clock[0]) | (drive.t[:-1] >= drive.clock[-1])
    share = rolled[unseen].sum() / rolled.sum() if rolled.any() else 0.0
    if share > OUTSIDE:
        found.append(
            f"{share:.0%} of the wheels' turning lies outside the time of the true poses, {drive.clock[0]:.6g} to "
            f"{drive.clock[-1]:.6g} s: are the clocks one?"
        )
    return found


def _time_unit(drive: Drive, believed: Robot) -> str:
    rolled = _rolled(drive, believed)
    speed = float((rolled / np.diff(drive.t)).max())
    if rolled.sum() < ENOUGH * believed.track_width or SLOWEST <= speed <= FASTEST:
        return ""
    return f"the wheels run at up to {speed:.2g} m/s: is the time in another unit, or the wheels?"


def _windows(clock: Array) -> Array:
    """Pairs of samples (N, 2), each with the first one at least WINDOW later; overlapping."""
    first = np.arange(len(clock))
    last = np.searchsorted(clock, clock + WINDOW - 1e-6)
    there = last < len(clock)
    pairs = np.stack([first[there], last[there]], axis=-1)
    return pairs[clock[pairs[:, 1]] - clock[pairs[:, 0]] <= LONGEST_WINDOW]


def _motions(poses: Array, pairs: Array, robot: Robot) -> Array:
    """Forward, left and b / 2 times the turn over each window (N, 3) [m]."""
    turned = np.concatenate([[0.0], np.cumsum(se2.wrap_angle(np.diff(poses[:, 2])))])
    motion = se2.between(poses[pairs[:, 0]], poses[pairs[:, 1]])
    motion[:, 2] = (turned[pairs[:, 1]] - turned[pairs[:, 0]]) * robot.track_width / 2
    return motion


def _units(wheels: Array, truth: Array, believed: Robot) -> str:
    """Distances and turns of the one against the other, over the windows in which the wheels mostly drive or turn."""
    driven, turned = np.hypot(wheels[:, 0], wheels[:, 1]), np.abs(wheels[:, 2])
    driving = driven > turned
    for mine, other, what, unit in (
        (driven[driving], np.hypot(truth[driving, 0], truth[driving, 1]), "drives", "of x and y"),
        (turned[~driving], np.abs(truth[~driving, 2]), "turns", "of theta"),
    ):
        if max(mine.sum(), other.sum()) < ENOUGH * believed.track_width * (1 + len(mine) / 20):
            continue
        ratio = np.sum(other) / max(np.sum(mine), 1e-300)
        if not 1 / SCALE <= ratio <= SCALE:
            return (
                f"the truth {what} {ratio:.3g} times as far as the wheels say: is the unit {unit} right, are "
                "the ticks of a revolution and the robot's size?"
            )
    return ""
