"""Drives on which the wheels must roll: where they slip, no law of odometry holds."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Any, overload

from numpy.typing import ArrayLike

from diffdrive_mj import _checks as checks
from diffdrive_mj.commands import ClosedLoop, Commands
from diffdrive_mj.errors import InvalidValue, PhysicsWarning
from diffdrive_mj.physics.limits import largest_acceleration
from diffdrive_mj.physics.simulation import simulate
from diffdrive_mj.recording import Recording
from diffdrive_mj.robot import Robot
from diffdrive_mj.sensors.optical_flow import FlowSensor
from diffdrive_mj.sensors.passive_wheels import PassiveWheels
from diffdrive_mj.solver import Physics


@overload
def simulate_rolling(
    robot: Robot,
    commands: Commands | ClosedLoop,
    *,
    physics: Physics = ...,
    sample_rate: float = ...,
    start: ArrayLike = ...,
    flow_sensor: FlowSensor | None = ...,
    passive_wheels: PassiveWheels | None = ...,
) -> Recording[Robot, Commands]: ...
@overload
def simulate_rolling(
    robot: Sequence[Robot],
    commands: Commands | ClosedLoop | Sequence[Commands],
    *,
    physics: Physics = ...,
    sample_rate: float = ...,
    start: ArrayLike = ...,
    flow_sensor: FlowSensor | None = ...,
    passive_wheels: PassiveWheels | None = ...,
) -> Recording[tuple[Robot, ...], tuple[Commands, ...]]: ...
def simulate_rolling(
    robot: Robot | Sequence[Robot],
    commands: Commands | ClosedLoop | Sequence[Commands],
    *,
    physics: Physics = Physics(),  # noqa: B008
    sample_rate: float = 100.0,
    start: ArrayLike = (0.0, 0.0, 0.0),
    flow_sensor: FlowSensor | None = None,
    passive_wheels: PassiveWheels | None = None,
) -> Recording[Any, Any]:
    """Simulate drives on which every wheel must roll, as `simulate` does, and refuse those on which one does not.

    Args:
        robot: the true robot, or a sequence of them.
        commands: to be driven, as for `simulate`.
        physics: how it is solved.
        sample_rate: of the recording [Hz].
        start: (..., 3) [m, m, rad].
        flow_sensor: an optical flow sensor on every robot, to be recorded too.
        passive_wheels: wheels without a motor on every robot, to be recorded too.

    Returns:
        The recording; nothing happened that wheel odometry cannot see.

    Raises:
        InvalidValue: a wheel slipped or a contact left the floor; the message says which, and when.
        RobotFell: a robot tipped over.

    Example:
        >>> robot = dd.Robot.load("mismatched")
        >>> simulate_rolling(robot, dd.maneuvers.straight(robot, speed=1.0, distance=1.0, ramp=0.0))
        Traceback (most recent call last):
        diffdrive_mj.errors.InvalidValue: robot mismatched: ... more slowly or with a longer ramp
    """
    with warnings.catch_warnings(action="ignore", category=PhysicsWarning):
        recording = simulate(
            robot,
            commands,
            physics=physics,
            sample_rate=sample_rate,
            start=start,
            flow_sensor=flow_sensor,
            passive_wheels=passive_wheels,
        )
    if recording.events:
        raise InvalidValue(f"{recording.events[0]}: the wheels must roll here; drive more slowly or with a longer ramp")
    return recording


def gentle_ramp(robot: Robot, speed: float, least: float = 1.0) -> float:
    """Choose a ramp on which a robot speeds up by at most half of what its grip and its balance allow.

    Args:
        robot: the true robot.
        speed: to be reached [m/s].
        least: the shortest ramp [s].

    Returns:
        The time from rest to full speed [s].

    Example:
        >>> robot = dd.Robot.load("turtlebot3_burger")
        >>> gentle_ramp(robot, 0.2), gentle_ramp(robot, 2.0) > 1.0
        (1.0, True)
    """
    return max(least, 2 * checks.positive("speed", speed) / largest_acceleration(robot))
