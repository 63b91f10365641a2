"""What looks wrong with a drive's data before a robot is calibrated on it.

Wheels and truth are compared over windows of about a second. A robot believed wrongly by some ten per cent is not
reported; wheels that are exchanged, and units that are not what they seem, are.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from diffdrive_mj import _checks as checks
from diffdrive_mj import se2
from diffdrive_mj._checks import Array
from diffdrive_mj.diagnosis._rough_fit import OUTLIER, UNEXPLAINED, rough_fit
from diffdrive_mj.diagnosis._windows import WINDOW, misfit, motions, size, windows
from diffdrive_mj.drive import Drive
from diffdrive_mj.robot import Robot

_SLOWEST, _FASTEST = 5e-3, 50.0  # The fastest that a wheel's rim runs on a drive, at least and at most [m/s].
_OUTSIDE = 0.05  # Of the poses, or of the wheels' turning: what may lie outside the other's time.
_SCALE = 1.5  # No robot is believed wrong by more, in how far it drives or turns.
_BETTER = 3.0  # By what factor an explanation must leave less than there is without it.
_MIXED_UP = 0.2  # The least misfit that asks for an explanation, which must be better by _BETTER.
_ENOUGH = 1.0  # Of the track width: how much of a drive must be seen.


def suspicions(drive: Drive, believed: Robot) -> tuple[str, ...]:
    """Look for faults in a drive's data that no calibration could repair.

    Looked for are: truth and wheels of different times; a unit that cannot be right; wheels that are exchanged or count
    backwards; a true heading that is turned, mirrored or in degrees; a robot that was pushed or lifted, by more than
    0.15 of its track and a quarter of its motion within a second. True poses more than 1.5 s apart show only whether
    the times agree. A marker beside the midpoint of the axle (lever arm) is not reported.

    Args:
        drive: that was measured.
        believed: the nominal robot, right to some ten per cent.

    Returns:
        A sentence for each fault, with the field of `logs.Columns` that cures it; empty if the drive looks clean.

    Raises:
        InvalidType: not a drive, not a robot.

    Example:
        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> t = np.arange(0, 10, 0.1)
        >>> wheel_angles = np.stack([2 * t, 6 * t], axis=-1)
        >>> truth = dd.odometry.integrate(wheel_angles, robot)
        >>> dd.diagnosis.suspicions(dd.Drive(t, wheel_angles, truth), robot)
        ()
        >>> print(*dd.diagnosis.suspicions(dd.Drive(t, wheel_angles[:, ::-1], truth), robot))
        left and right look swapped (or y and theta of the truth mirrored): exchange the columns left and right
    """
    checks.instance("drive", drive, Drive)
    checks.instance("believed", believed, Robot)
    found = _times(drive, believed)
    odd = mix_up(drive, believed) or _pushed(drive, believed)
    return (*found, odd) if odd else tuple(found)


def mix_up(drive: Drive, believed: Robot, *, headings: bool = True) -> str:
    """Look for columns or units that are mixed up, the faults among `suspicions` that make a calibration worthless.

    Args:
        drive: that was measured.
        believed: the nominal robot, right to some ten per cent.
        headings: whether the true headings are read; without them only times and distances are looked at.

    Returns:
        A sentence, with the field of `logs.Columns` that cures it; empty if nothing looks mixed up.

    Raises:
        InvalidType: not a drive, not a robot.

    Example:
        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> t = np.arange(0, 10, 0.1)
        >>> wheel_angles = np.stack([2 * t, 6 * t], axis=-1)
        >>> drive = dd.Drive(t, -wheel_angles, dd.odometry.integrate(wheel_angles, robot))
        >>> mix_up(drive, robot)
        'both wheels look reversed: try reverse_left and reverse_right'
    """
    checks.instance("drive", drive, Drive)
    checks.instance("believed", believed, Robot)
    if odd := _time_unit(drive, believed):
        return odd
    pairs = windows(drive.clock)
    if not len(pairs):
        return ""
    wheels, truth = motions(drive.odometry(believed), pairs, believed), motions(drive.truth, pairs, believed)
    if not headings:
        return _scale(drive, believed, wheels, truth * [1, 1, np.nan])
    similar = rough_fit(drive, believed, pairs, truth)
    # The first would make the second raise an alarm too.
    return _mixed_up(drive, believed, pairs, wheels, truth, misfit(*similar)) or _scale(drive, believed, wheels, truth)


def _rolled(drive: Drive, robot: Robot) -> Array:
    """How far the faster rim rolled from each sample to the next (T - 1,) [m]."""
    return np.abs(np.diff(drive.wheel_angles, axis=0) * [robot.left_radius, robot.right_radius]).max(axis=1)


def _times(drive: Drive, believed: Robot) -> list[str]:
    found = []
    count = drive.dropped + len(drive.truth)
    if drive.dropped > _OUTSIDE * count:
        found.append(
            f"{drive.dropped} of {count} true poses lie outside the times of the wheels: are the clocks synchronised?"
        )
    rolled = _rolled(drive, believed)
    # The last of many poses is not the last sample's.
    slack = float(np.median(np.diff(drive.clock))) if len(drive.clock) > 2 else 0.0
    unseen = (drive.t[1:] <= drive.clock[0] - slack) | (drive.t[:-1] >= drive.clock[-1] + slack)
    share = rolled[unseen].sum() / rolled.sum() if rolled.any() else 0.0
    if share > _OUTSIDE:
        found.append(
            f"{share:.0%} of the wheels' turning lies outside the times of the true poses, {drive.clock[0]:.6g} to "
            f"{drive.clock[-1]:.6g} s: are the clocks synchronised?"
        )
    return found


def _time_unit(drive: Drive, believed: Robot) -> str:
    rolled = _rolled(drive, believed)
    speed = float((rolled / np.diff(drive.t)).max())
    if rolled.sum() < _ENOUGH * believed.track_width or _SLOWEST <= speed <= _FASTEST:
        return ""
    return (
        f"the wheels run at up to {speed:.2g} m/s: is the time in another unit (time_unit), or the wheels "
        "(wheel_unit, ticks_per_revolution)?"
    )


def _mixed_up(
    drive: Drive, believed: Robot, pairs: Array, wheels: Array, truth: Array, misfit_of_a_similar_robot: float
) -> str:
    """The explanation that makes wheels and truth agree, if they do not agree as they are."""
    as_it_is = min(misfit(wheels, truth), misfit_of_a_similar_robot)
    # A drive may hardly turn, so that wheels which are swapped show in its turns alone.
    if max(as_it_is, misfit(wheels * [0, 0, 1], truth * [0, 0, 1])) < _MIXED_UP:
        return ""
    left, right = drive.wheel_angles.T
    sides = {
        "left and right look swapped (or y and theta of the truth mirrored): exchange the columns left and right": (
            right,
            left,
        ),
        "the left wheel looks reversed: try reverse_left": (-left, right),
        "the right wheel looks reversed: try reverse_right": (left, -right),
        "both wheels look reversed: try reverse_left and reverse_right": (-left, -right),
    }
    misfits = {}
    for words, angles in sides.items():
        other = replace(drive, wheel_angles=np.stack(angles, axis=-1)).odometry(believed)
        misfits[words] = misfit(motions(other, pairs, believed), truth)
    for words, factor, cure in (
        ("", 1.0, ""),
        (" clockwise", -1.0, ": it must be counter-clockwise"),
        (" given in degrees", np.pi / 180, ": try angle_unit = deg"),
        (" given in radians", 180 / np.pi, ": try angle_unit = rad"),
    ):
        other = motions(drive.truth * [1, 1, factor], pairs, believed)
        turned = np.sum((wheels[:, 0] - 1j * wheels[:, 1]) * (other[:, 0] + 1j * other[:, 1]))
        other[:, :2] = se2.rotate(other[:, :2], -np.angle(turned))
        offset = -float(np.degrees(np.angle(turned))) * np.sign(factor)
        far = f"{' and' if words else ''} {offset:.0f} deg off" if abs(offset) > 5 or not words else ""
        misfits[f"the truth's theta looks{words}{far}{cure}"] = misfit(wheels, other)
    best = min(misfits, key=misfits.__getitem__)
    return best if misfits[best] < as_it_is / _BETTER else ""


def _scale(drive: Drive, believed: Robot, wheels: Array, truth: Array) -> str:
    """Distances and turns of the one against the other, over the windows in which the wheels drive or turn."""
    driven, turned = np.hypot(wheels[:, 0], wheels[:, 1]), np.abs(wheels[:, 2])
    skids = "" if believed.skid_steer is None else " With skid steer: is track_width its effective_track?"
    in_a_row = (drive.clock[-1] - drive.clock[0]) / WINDOW / len(wheels)
    for chosen, by_wheels, by_truth, what, unit in (
        (driven > turned, driven, np.hypot(truth[:, 0], truth[:, 1]), "drives", "of x and y (position_unit)"),
        (turned > driven, turned, np.abs(truth[:, 2]), "turns", "of theta (angle_unit)"),
    ):
        told, true = by_wheels[chosen], by_truth[chosen]
        if np.isnan(true).any():
            continue
        if max(told.sum(), true.sum()) * in_a_row < _ENOUGH * believed.track_width:
            continue
        # Weighted by the wheels' motion: noise of the truth at rest is no distance.
        moved = float(told @ told)
        ratio = float(told @ true) / moved if moved else math.inf
        if not 1 / _SCALE <= ratio <= _SCALE:
            return (
                f"the truth {what} {ratio:.4g} times as far as the wheels: is the unit {unit} right, and of the wheels "
                f"(wheel_unit, ticks_per_revolution, the radii)?{skids}"
            )
    return ""


def _pushed(drive: Drive, believed: Robot) -> str:
    pairs = windows(drive.clock)
    if not len(pairs):
        return ""
    wheels, truth = rough_fit(drive, believed, pairs, motions(drive.truth, pairs, believed))
    gap = size(wheels - truth)
    # The median is the noise of the truth, and what is left of the belief's error: they go on all the time.
    limit = max(UNEXPLAINED * believed.track_width, OUTLIER * float(np.median(gap)))
    odd = (gap > limit) & (gap > np.maximum(size(wheels), size(truth)) / 4)
    if not odd.any():
        return ""
    worst = int(np.argmax(np.where(odd, gap, 0.0)))
    after = worst + int(np.argmin(np.append(odd[worst:], False)))
    before = worst - int(np.argmin(np.append(odd[worst::-1], False)))
    # What happened lies in the last of the windows that saw it, and in the first.
    time = (drive.clock[pairs[after - 1, 0]] + drive.clock[pairs[before + 1, 1]]) / 2
    moved, rolled = 1e3 * size(truth)[worst], 1e3 * size(wheels)[worst]
    return (
        f"at about {time:.3g} s the truth moves {moved:.0f} mm where the wheels roll {rolled:.0f} mm: was the robot "
        "pushed or lifted, did it slide?"
    )
