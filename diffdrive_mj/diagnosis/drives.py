"""What looks wrong with a drive's data before a robot is calibrated on it.

The motions over windows of about a second are compared, as the wheels tell them and as the truth has them:
(forward, left, b / 2 times the turn) in the frame of the window's start, all in metres. A robot believed wrongly by
some ten per cent is no reason for suspicion; wheels that are exchanged, and units that are not what they seem, are.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from diffdrive_mj import se2
from diffdrive_mj._checks import Array
from diffdrive_mj.drive import Drive
from diffdrive_mj.robot import Robot

WINDOW = 1.0  # [s]
LONGEST_WINDOW = 1.5  # [s]; truth that is sparser tells nothing of what happened in between.
SLOWEST, FASTEST = 5e-3, 50.0  # The fastest that a wheel's rim runs on a drive, at least and at most [m/s].
OUTSIDE = 0.05  # Of the poses, or of the wheels' turning: what may lie outside the other's time.
SCALE = 3.0  # No robot is believed wrong by more.
MIXED_UP = 0.2  # The least misfit that asks for an explanation, which must be better by SCALE.
OUTLIER = 6.0  # Of the median.
UNEQUAL = 0.13  # How far either wheel may differ from the mean, relative.
MAST = 0.3  # Of the track width: how far from the axle's middle the true pose may be taken.
# Of the track width: the smallest motion that only one of the two has, and how much of a drive must be seen.
UNEXPLAINED, ENOUGH = 0.15, 1.0


def suspicions(drive: Drive, believed: Robot) -> tuple[str, ...]:
    """What looks wrong with a drive, each a sentence; none if it looks clean.

    Looked for: truth and wheels of different times; a unit that cannot be; wheels that are exchanged or count
    backwards; a true heading that is turned, mirrored or in degrees; a robot that was pushed or lifted, by more than
    0.15 of its track and a quarter of its motion within a second. True poses more than 1.5 s apart show nothing but
    the times. That they are taken beside the middle of the axle is no reason for suspicion.

    Args:
        drive: that was measured.
        believed: the nominal robot, right to some ten per cent.
    """
    found = _spans(drive, believed)
    if odd := _time_unit(drive, believed):
        return (*found, odd)
    pairs = _windows(drive.clock)
    if not len(pairs):
        return tuple(found)
    wheels, truth = _motions(drive.odometry(believed), pairs, believed), _motions(drive.truth, pairs, believed)
    near, mast = _rough_fit(drive, believed, pairs, truth)
    # Each of these would make the next ones sound their alarm too.
    odd = (
        _mixed_up(drive, believed, pairs, wheels, truth, _misfit(near, _at_axle(truth, mast, believed)))
        or _scale(drive, believed, wheels, truth)
        or _pushed(drive, believed, pairs, near, _at_axle(truth, mast, believed))
    )
    return (*found, odd) if odd else tuple(found)


def _rolled(drive: Drive, robot: Robot) -> Array:
    """How far the faster rim rolled from each sample to the next (T - 1,) [m]."""
    return np.abs(np.diff(drive.wheel_angles, axis=0) * [robot.left_radius, robot.right_radius]).max(axis=1)


def _spans(drive: Drive, believed: Robot) -> list[str]:
    found = []
    count = drive.dropped + len(drive.truth)
    if drive.dropped > OUTSIDE * count:
        found.append(f"{drive.dropped} of {count} true poses lie outside the time of the wheels: are the clocks one?")
    rolled = _rolled(drive, believed)
    # The last of many poses is not the last sample's.
    slack = float(np.median(np.diff(drive.clock))) if len(drive.clock) > 2 else 0.0
    unseen = (drive.t[1:] <= drive.clock[0] - slack) | (drive.t[:-1] >= drive.clock[-1] + slack)
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


def _misfit(wheels: Array, truth: Array) -> float:
    """How much of the motion the two do not have in common: 0 to 2."""
    larger = np.maximum(_size(wheels), _size(truth)).sum()
    return float(_size(wheels - truth).sum() / larger) if larger else 0.0


def _size(motions: Array) -> Array:
    return np.sqrt((motions**2).sum(axis=1))


def _mixed_up(
    drive: Drive, believed: Robot, pairs: Array, wheels: Array, truth: Array, misfit_of_a_similar_robot: float
) -> str:
    """The explanation that makes wheels and truth agree, if they do not agree as they are."""
    as_it_is = min(_misfit(wheels, truth), misfit_of_a_similar_robot)
    if as_it_is < MIXED_UP:
        return ""
    left, right = drive.wheel_angles.T
    sides = {
        "left and right look swapped (or y and theta of the truth mirrored)": (right, left),
        "the left wheel looks reversed": (-left, right),
        "the right wheel looks reversed": (left, -right),
        "both wheels look reversed": (-left, -right),
    }
    misfits = {}
    for words, angles in sides.items():
        other = replace(drive, wheel_angles=np.stack(angles, axis=-1)).odometry(believed)
        misfits[words] = _misfit(_motions(other, pairs, believed), truth)
    headings = {
        "": 1.0,
        " clockwise": -1.0,
        " given in degrees": np.pi / 180,
    }
    for words, factor in headings.items():
        other = _motions(drive.truth * [1, 1, factor], pairs, believed)
        turned = np.sum((wheels[:, 0] - 1j * wheels[:, 1]) * (other[:, 0] + 1j * other[:, 1]))
        other[:, :2] = se2.rotate(other[:, :2], -np.angle(turned))
        offset = -float(np.degrees(np.angle(turned))) * np.sign(factor)
        far = f"{' and' if words else ''} {offset:.0f} deg off" if abs(offset) > 5 or not words else ""
        misfits[f"the truth's theta looks{words}{far}"] = _misfit(wheels, other)
    best = min(misfits, key=misfits.__getitem__)
    return best if misfits[best] < as_it_is / SCALE else ""


def _scale(drive: Drive, believed: Robot, wheels: Array, truth: Array) -> str:
    """Distances and turns of the one against the other, over the windows in which the wheels drive or turn."""
    driven, turned = np.hypot(wheels[:, 0], wheels[:, 1]), np.abs(wheels[:, 2])
    windows = (drive.clock[-1] - drive.clock[0]) / WINDOW / len(wheels)
    for chosen, mine, other, what, unit in (
        (driven > turned, driven, np.hypot(truth[:, 0], truth[:, 1]), "drives", "of x and y"),
        (turned > driven, turned, np.abs(truth[:, 2]), "turns", "of theta"),
    ):
        told, true = mine[chosen], other[chosen]
        if max(told.sum(), true.sum()) * windows < ENOUGH * believed.track_width:
            continue
        # Weighted by the wheels' motion: noise of the truth at rest is no distance.
        ratio = float((told @ true) / (told @ told))
        if not 1 / SCALE <= ratio <= SCALE:
            return (
                f"the truth {what} {ratio:.3g} times as far as the wheels: is the unit {unit} right, and of the wheels "
                "(ticks of a revolution, radii)?"
            )
    return ""


def _pushed(drive: Drive, believed: Robot, pairs: Array, wheels: Array, truth: Array) -> str:
    gap = _size(wheels - truth)
    # The median is the noise of the truth, and what is left of the belief's error: they go on all the time.
    limit = max(UNEXPLAINED * believed.track_width, OUTLIER * float(np.median(gap)))
    odd = (gap > limit) & (gap > np.maximum(_size(wheels), _size(truth)) / 4)
    if not odd.any():
        return ""
    worst = int(np.argmax(np.where(odd, gap, 0.0)))
    after = worst + int(np.argmin(np.append(odd[worst:], False)))
    before = worst - int(np.argmin(np.append(odd[worst::-1], False)))
    # What happened lies in the last of the windows that saw it, and in the first.
    time = (drive.clock[pairs[after - 1, 0]] + drive.clock[pairs[before + 1, 1]]) / 2
    moved, rolled = 1e3 * _size(truth)[worst], 1e3 * _size(wheels)[worst]
    return (
        f"at about {time:.3g} s the truth moves {moved:.0f} mm where the wheels roll {rolled:.0f} mm: was the robot "
        "pushed or lifted, did it slide?"
    )


def _at_axle(truth: Array, mast: Array, robot: Robot) -> Array:
    """Motions of the middle of the axle, from those of a point that is `mast` ahead and to the left of it [m]."""
    swung = se2.rotate(mast, truth[:, 2] / (robot.track_width / 2)) - mast
    return truth - np.pad(swung, ((0, 0), (0, 1)))


def _rough_fit(drive: Drive, believed: Robot, pairs: Array, truth: Array) -> tuple[Array, Array]:
    """Motions of the robot near the believed one that fits the truth best, and the place of the true pose on it."""
    angles = drive.angles_at(drive.clock)
    turned = angles[pairs[:, 1]] - angles[pairs[:, 0]]
    turn = truth[:, 2] / (believed.track_width / 2)
    swing = np.stack([se2.rotate(axis, turn) - axis for axis in np.eye(2)], axis=-1)
    mast, kept = np.zeros(2), np.ones(len(pairs), dtype=bool)
    for _ in range(3):
        robot = _similar(turned[kept], _at_axle(truth, mast, believed)[kept], believed)
        wheels = _motions(drive.odometry(robot), pairs, believed)
        # A drive with next to no turns does not show it.
        rows, off = swing[kept].reshape(-1, 2), (truth - wheels)[kept, :2].ravel()
        mast[:] = np.linalg.solve(rows.T @ rows + 0.002 * len(rows) * np.eye(2), rows.T @ off)
        mast *= min(1.0, MAST * believed.track_width / max(float(np.hypot(*mast)), 1e-300))
        gap = _size(wheels - _at_axle(truth, mast, believed))
        kept = gap <= max(OUTLIER / 2 * float(np.median(gap)), 2 * UNEXPLAINED * believed.track_width)
    return wheels, mast


def _similar(turned: Array, truth: Array, believed: Robot) -> Robot:
    """The robot near the believed one that moves as the truth does when its wheels turn so far (N, 2) [rad]."""
    rims = turned * [believed.left_radius, believed.right_radius]
    turning = rims * [-0.5, 0.5]
    # What the drive does not show, such as the track on a straight line, stays as believed.
    change = np.linalg.lstsq(turning, truth[:, 2] - turning.sum(axis=1), rcond=0.05)[0]
    mean = np.clip(1 + change.mean(), 0.5, 2.0)
    left, right = mean * np.clip((1 + change) / mean, 1 - UNEQUAL, 1 + UNEQUAL)
    half = truth[:, 2] / believed.track_width
    chord = truth[:, 0] * np.cos(half) + truth[:, 1] * np.sin(half)
    driven = rims @ [left, right] / 2 * se2.sinc(half)
    size = float(np.clip(driven @ chord / (driven @ driven), 0.5, 2.0)) if driven.any() else 1.0
    return believed.replace(
        axle="independent",
        left_radius=believed.left_radius * left * size,
        right_radius=believed.right_radius * right * size,
        track_width=believed.track_width * size,
    )
