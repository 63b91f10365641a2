"""The standard maneuvers, and how closely odometry with the true parameters agrees with the physics on them.

The floor of the physics is what such odometry is off by: the smallest error that can be blamed on anything else. It is
given in parts per million, of the distance driven for positions and of the angle turned for headings.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from diffdrive_mj import maneuvers, metrics
from diffdrive_mj.commands import Commands
from diffdrive_mj.errors import PhysicsWarning
from diffdrive_mj.kinematics import body_twist
from diffdrive_mj.physics.simulation import simulate
from diffdrive_mj.recording import Recording
from diffdrive_mj.robot import Robot
from diffdrive_mj.solver import Physics

# What `Physics()` keeps on every standard maneuver, and `Physics.fast()` in positions [ppm].
POSITION_FLOOR, HEADING_FLOOR = 0.4, 0.3
FAST_POSITION_FLOOR = 1.0
# What `Physics()` keeps for any robot, on any drive on which its wheels keep their grip [ppm].
ANY_FLOOR = 1.0

PRESETS = ("mismatched", "matched", "ct_bot", "optiodom", "turtlebot3_burger")


def _constant_arc(robot: Robot) -> Commands:
    """Wheels at 12 and 15 rad/s over 10 m: an arc whose radius follows from the robot."""
    rates = (12.0, 15.0)
    return maneuvers.constant_rates(rates, 10.0 / float(body_twist(rates, robot)[0]))


def _clockwise_square(robot: Robot) -> Commands:
    return maneuvers.square(robot, clockwise=True)


STANDARD_MANEUVERS: Mapping[str, Callable[[Robot], Commands]] = MappingProxyType(
    {
        "straight": maneuvers.straight,
        "arc": _constant_arc,
        "square": maneuvers.square,
        "square, clockwise": _clockwise_square,
        "spin": maneuvers.spin,
        "figure eight": maneuvers.figure_eight,
    }
)


@dataclass(frozen=True)
class Residual:
    """What is left between odometry and the physics on a drive.

    Attributes:
        position: largest position error [ppm of the distance driven].
        heading: largest heading error [ppm of the angle turned].

    Example:
        >>> Residual(position=0.07, heading=0.02).within(POSITION_FLOOR, HEADING_FLOOR)
        True
    """

    position: float
    heading: float

    def within(self, position: float, heading: float) -> bool:
        """Whether both keep their bounds [ppm]."""
        return self.position <= position and self.heading <= heading


def residual(recording: Recording, believed: Robot) -> Residual:
    """Compare a robot's odometry with the physics of one run.

    The distance is that of the axle's midpoint, or of a wheel about it where the robot rather spins; a drive that turns
    by less than a radian is compared with a radian.

    Args:
        recording: of one run.
        believed: the robot that the odometry computes with; the true one gives the floor of the physics.

    Returns:
        The largest errors.

    Example:
        >>> robot = dd.Robot.load("mismatched")
        >>> recording = dd.simulate(robot, dd.maneuvers.straight(robot, speed=0.5, distance=1.0))
        >>> residual(recording, robot).within(POSITION_FLOOR, HEADING_FLOOR)
        True
    """
    drift = metrics.drift(recording.truth, recording.odometry(believed))
    turned = float(np.abs(np.diff(recording.truth[:, 2])).sum())
    driven = max(float(drift.distance), turned * believed.track_width / 2)
    return Residual(1e6 * float(drift.max_position) / driven, 1e6 * float(drift.max_heading) / max(turned, 1.0))


def standard_residuals(
    robot: Robot,
    physics: Physics = Physics(),  # noqa: B008
    *,
    believed: Robot | None = None,
) -> dict[str, Residual]:
    """Drive the standard maneuvers and compare odometry with the physics on each.

    Args:
        robot: the true robot.
        physics: how it is solved; wheels that slip are not warned of, their residual shows.
        believed: the robot that the odometry computes with, the true one by default.

    Returns:
        The residuals by maneuver.

    Raises:
        RobotFell: the robot tipped over.

    Example:
        >>> coarse = standard_residuals(dd.Robot.load("ct_bot"), dd.Physics(timestep=0.01))
        >>> coarse["spin"].position < 10 * POSITION_FLOOR
        True
    """
    names, found = list(STANDARD_MANEUVERS), {}
    for pair in zip(names[::2], names[1::2], strict=True):  # of like duration: each goes to a core of its own
        commands = [STANDARD_MANEUVERS[name](robot) for name in pair]
        longest = max(command.duration for command in commands)
        with warnings.catch_warnings(action="ignore", category=PhysicsWarning):
            recording = simulate([robot] * 2, [command.extended(longest) for command in commands], physics=physics)
        found.update({name: residual(run, believed or robot) for name, run in zip(pair, recording.runs, strict=True)})
    return found
