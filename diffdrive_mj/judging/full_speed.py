"""Drives at full speed: the arc that constant wheel rates make, against the path in the physics."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from diffdrive_mj import metrics, se2
from diffdrive_mj._checks import Array
from diffdrive_mj.commands import Commands
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.kinematics import body_twist
from diffdrive_mj.recording import Recording
from diffdrive_mj.robot import Robot

# Wheels turn evenly enough if that keeps a path on its arc to this part of its length.
STEADY = 1e-4


@dataclass(frozen=True, eq=False)
class SteadyArc:
    """A stretch of a drive at constant wheel rates, and the arc that they make of it.

    Attributes:
        recording: the stretch alone.
        speed: along the true path [m/s].
        twist: (2,) of the mean wheel rates [m/s, rad/s].
        path: (T, 3) [m, m, rad], the arc from the first true pose.
        off: how far the true path strays from it [ppm of its length].
        unsteady: how much of that the changes of the wheel rates can explain [ppm].

    Example:
        >>> robot = dd.Robot.load("matched")
        >>> drive = dd.simulate(robot, dd.maneuvers.straight(robot, distance=3.0, speed=1.0))
        >>> print(f"{steady_arc(drive, robot).speed:.3f} m/s")
        1.000 m/s
    """

    recording: Recording[Robot, Commands]
    speed: float
    twist: Array
    path: Array
    off: float
    unsteady: float


def steady_arc(recording: Recording[Robot, Commands], believed: Robot) -> SteadyArc:
    """Compare the second half of a drive's time at full speed with the arc of its mean wheel rates.

    Where a wheel strays by e from turning evenly, the heading strays by up to 2 e / b and the place by e (1 + 2 L / b)
    after the length L.

    Args:
        recording: of one run with ramps and constant rates between them.
        believed: its radii and track width b are read.

    Returns:
        The stretch and its arc.

    Raises:
        InvalidValue: the wheels do not come to turn evenly.

    Example:
        >>> robot = dd.Robot.load("matched")
        >>> drive = dd.simulate(robot, dd.maneuvers.arc(robot, radius=2.0, distance=4.0, speed=1.0))
        >>> arc = steady_arc(drive, robot)
        >>> arc.twist.round(4).tolist(), arc.off < 1.0
        ([1.0, 0.5], True)
    """
    commands = recording.commands
    sizes = np.abs(commands.wheel_rates).max(axis=1)
    full = np.flatnonzero(sizes > sizes.max() * (1 - 1e-9)) * commands.period
    stretch = recording.during((full[0] + full[-1]) / 2, full[-1])
    elapsed, turned = stretch.t - stretch.t[0], stretch.wheel_angles - stretch.wheel_angles[0]
    if len(elapsed) < 2:
        raise InvalidValue("the drive is too short: there is no time at full speed")
    rates = turned[-1] / elapsed[-1]
    stray = float(np.abs((turned - elapsed[:, None] * rates) * (believed.left_radius, believed.right_radius)).max())
    twist = body_twist(rates, believed)
    path = se2.compose(stretch.truth[0], se2.exp(elapsed[:, None] * np.array([twist[0], 0.0, twist[1]])))
    drift = metrics.drift(stretch.truth, path)
    length = float(drift.distance)
    unsteady = stray * (1 / length + 2 / believed.track_width)
    if unsteady > STEADY:
        raise InvalidValue(
            "the drive is too short: the wheels still speed up when half of the time at full speed is over"
        )
    speed = length / float(elapsed[-1])
    return SteadyArc(stretch, speed, twist, path, 1e6 * float(drift.max_position) / length, 1e6 * unsteady)
