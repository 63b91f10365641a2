"""Bumps under one wheel: a model of what they do to a drive, without physics."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from diffdrive_mj import _checks as checks
from diffdrive_mj.drive import Drive
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.estimation.obstacles import extra_distance
from diffdrive_mj.kinematics import body_twist
from diffdrive_mj.odometry import integrate
from diffdrive_mj.robot import Robot


def bump_angle(radius: float, height: float) -> float:
    """Compute how much further than on the flat a wheel turns over a thin bump.

    ```
    2 (a - sin(a)),  cos(a) = 1 - height / radius
    ```

    It swings over the bump's edge by twice the angle a at which it meets it, and gets ahead by the chord alone.

    Args:
        radius: of the wheel [m].
        height: of the bump [m], below the radius.

    Returns:
        [rad]

    Raises:
        InvalidValue: lengths that are not positive, or a bump as high as the hub.

    Example:
        >>> round(1e3 * 0.1 * dd.judging.bumps.bump_angle(radius=0.1, height=0.01), 2)  # [mm]
        3.03
    """
    if checks.positive("height", height) >= checks.positive("radius", radius):
        raise InvalidValue(f"height = {height:g} m: must be below the radius of the wheel, {radius:g} m")
    return float(extra_distance(radius, height)) / radius


def over_bumps(drive: Drive, robot: Robot, *, height: float, first: float, spacing: float, count: int) -> Drive:
    """Predict the same drive with bumps under the right wheel: the wheels turn alike, and the right one gets less far.

    Args:
        drive: with a true pose for each sample of the encoder; its wheels slip nowhere.
        robot: the true robot.
        height: of each bump [m].
        first: how far along the path the bumps begin [m].
        spacing: from one to the next [m], over which what a bump takes is spread.
        count: of the bumps.

    Returns:
        The drive, of the same wheel angles and another truth.

    Raises:
        InvalidValue: lengths that are not positive, or a bump as high as the hub.

    Example:
        Ten bumps turn a robot to the right by what its right wheel loses:

        >>> robot = dd.Robot.load("matched")
        >>> t = np.linspace(0, 1, 101)
        >>> drive = dd.Drive(t, np.outer(20 * t, (1, 1)), dd.odometry.integrate(np.outer(20 * t, (1, 1)), robot))
        >>> rough = dd.judging.bumps.over_bumps(drive, robot, height=0.01, first=0.5, spacing=0.05, count=10)
        >>> rough.truth[-1].round(3)
        array([ 1.982, -0.094, -0.076])
    """
    steps = body_twist(np.diff(drive.wheel_angles, axis=0), robot)[:, 0]
    along = np.append(0.0, np.cumsum(np.abs(steps)))
    crossed = np.clip((along - first) / checks.positive("spacing", spacing), 0, checks.whole("count", count))
    rolled = drive.wheel_angles.copy()
    rolled[:, 1] -= bump_angle(robot.right_radius, height) * crossed
    return replace(drive, truth=integrate(rolled, robot, start=drive.truth[0]), truth_t=drive.t)
