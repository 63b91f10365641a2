"""What is filmed where nobody says: a belief that is worth seeing, and maneuvers that suit the size of a robot."""

from __future__ import annotations

import math
from collections.abc import Callable

from diffdrive_mj import maneuvers
from diffdrive_mj._text import quantity
from diffdrive_mj.commands import Commands
from diffdrive_mj.robot import Robot

# How much smaller the right wheel really is where the radii are equal.
SMALLER = 0.01
# Robots of a wider track are slowed down [m].
_LARGE = 0.5


def usual_belief(robot: Robot) -> tuple[Robot, dict[str, Robot], str]:
    """The true robot, what its odometry takes it for by the name of that belief, and both in words."""
    if robot.left_radius != robot.right_radius:
        believed = robot.replace(left_radius=robot.mean_radius, right_radius=robot.mean_radius)
        words = f"its odometry takes both wheels for {believed.left_radius:g} m, their mean radius"
        return robot, {f"odometry (both wheels {quantity(robot.mean_radius, 'm')})": believed}, words
    true = robot.replace(right_radius=(1 - SMALLER) * robot.right_radius)
    words = f"its right wheel is {100 * SMALLER:g} % smaller than {robot.right_radius:g} m, what its odometry believes"
    return true, {f"odometry (right wheel {100 * SMALLER:g} % too large)": robot}, words


def _slowed(robot: Robot) -> float:
    """By what a large robot drives slower for its size, so that it does not accelerate harder than a small one."""
    return min(1.0, math.sqrt(_LARGE / robot.track_width))


def _speed(robot: Robot) -> float:
    return 2.5 * robot.track_width * _slowed(robot)


def _straight(robot: Robot) -> Commands:
    return maneuvers.straight(robot, distance=15 * robot.track_width, speed=_speed(robot), ramp=1 / _slowed(robot))


def _square(robot: Robot) -> Commands:
    slowed = _slowed(robot)
    return maneuvers.square(
        robot, side=5 * robot.track_width, speed=_speed(robot), yaw_rate=2 * slowed, ramp=0.5 / slowed, rest=0.2
    )


def _figure_eight(robot: Robot) -> Commands:
    radius = 2.5 * robot.track_width
    return maneuvers.figure_eight(robot, radius=radius, speed=_speed(robot), ramp=1 / _slowed(robot))


def _spin(robot: Robot) -> Commands:
    return maneuvers.spin(robot, yaw_rate=2 * _slowed(robot), ramp=1 / _slowed(robot))


def _slalom(robot: Robot) -> Commands:
    wavelength = 8 * robot.track_width
    return maneuvers.slalom(robot, wavelength=wavelength, speed=_speed(robot), ramp=1 / _slowed(robot))


DRIVES: dict[str, Callable[[Robot], Commands]] = {
    "straight": _straight, "square": _square, "figure_eight": _figure_eight, "spin": _spin, "slalom": _slalom,
}  # fmt: skip
