"""Compensation from recorded wheels: the robot that runs straight though its left wheel turns k times as fast."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from diffdrive_mj import _checks as checks
from diffdrive_mj.calibration.result import Calibration
from diffdrive_mj.diagnosis.refusals import implausible, mixed_up, refuse, repeated
from diffdrive_mj.drive import Drive, checked_drives
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.kinematics import compensated_right_radius
from diffdrive_mj.robot import Robot

# How much of the wheels' turning may be by another ratio than that of the drive: ramps and bumps, but not corners.
_STRAIGHT = 0.05
# Of so many parts of a drive, in which single ticks of an encoder do not count.
_PARTS = 50


def speed_ratio(drives: Sequence[Drive], believed: Robot, *, anyway: bool = False) -> Calibration:
    """Find the speed ratio k of wheels that were commanded to turn alike, and the right radius that makes up for it.

    ```
    k = sum phi_l phi_r / sum phi_r^2        r_r = k r_l
    ```

    summed over the drives, phi being how far a wheel turned. The outcome is the robot to build, not the one that drove:
    fitted with a right wheel of k r_l and commanded as before it runs straight. Only the wheel angles decide; true
    poses, where the drives have some, must agree with them.

    Args:
        drives: with both wheels commanded to turn alike, forward or in reverse.
        believed: the robot, whose left radius stays.
        anyway: accept what would be refused, with a warning.

    Returns:
        Parameter speed_ratio. The covariance comes from the scatter of the drives; NaN for one. residuals:
        phi_l - k phi_r (N,) [rad].

    Raises:
        InvalidType: not drives, not a robot.
        InvalidValue: no drives; a wheel that stands still, wheels that turn against each other, or a drive with turns,
            such as a square; the message names the drive.
        CalibrationRefused: columns or units that look mixed up, a drive given twice, or a right wheel 1.3 times the
            believed one or more.

    References:
        [Behnke]: phi_l' = k phi_r', r_r = k r_l.

    Example:
        >>> believed = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> drive = dd.Drive([0.0, 1.0], [[0.0, 0.0], [9.1, 10.0]], np.zeros((2, 3)))
        >>> found = dd.calibration.speed_ratio([drive], believed)
        >>> round(found.calibrated.right_radius, 6)
        0.091
    """
    drives, believed = checked_drives(drives), checks.instance("believed", believed, Robot)
    seen = [drive for drive in drives if np.ptp(drive.truth, axis=0).any()]
    against = [*repeated(drives), *mixed_up(seen, believed)]
    refused = refuse(against, anyway=checks.boolean("anyway", anyway))
    for drive in drives:
        if np.prod(turned := drive.wheel_angles[-1] - drive.wheel_angles[0]) <= 0:
            raise InvalidValue(
                f"{drive.name}: the wheels turn by {turned[0]:.4g} and {turned[1]:.4g} rad: must both turn the same way"
            )
        if _curved(drive) > _STRAIGHT:
            raise InvalidValue(
                f"{drive.name}: the wheels do not turn alike throughout, but by other ratios in its turns: the speed "
                "ratio needs straight drives; least_squares takes any path"
            )
    left, right = np.stack([drive.wheel_angles[-1] - drive.wheel_angles[0] for drive in drives]).T
    k = float(left @ right / (right @ right))
    residuals = left - k * right
    calibrated = believed.replace(right_radius=compensated_right_radius(believed.left_radius, k))
    refused += refuse(implausible(believed, calibrated), anyway=anyway)
    variance = residuals @ residuals / (len(drives) - 1) / (right @ right) if len(drives) > 1 else np.nan
    return Calibration(
        method="speed ratio",
        believed=believed,
        calibrated=calibrated,
        parameters=("speed_ratio",),
        values=np.array([k]),
        covariance=np.array([[variance]]),
        residuals=residuals,
        warnings=(*refused, *(() if len(drives) > 1 else ("no covariance: it takes at least two drives",))),
    )


def _curved(drive: Drive) -> float:
    """What share of the left wheel's turning is not by the ratio of the whole drive."""
    cuts = np.unique(np.linspace(0, len(drive.t) - 1, _PARTS + 1).round().astype(int))
    left, right = np.diff(drive.wheel_angles[cuts], axis=0).T
    return float(np.abs(left - right * (left.sum() / right.sum())).sum() / np.abs(left).sum())
