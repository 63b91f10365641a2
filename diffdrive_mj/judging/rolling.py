"""Drives on which the wheels must roll: where they slip, no law of odometry holds."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Any, overload

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj._checks import Array
from diffdrive_mj.commands import ClosedLoop, Commands
from diffdrive_mj.errors import InvalidValue, PhysicsWarning
from diffdrive_mj.kinematics import body_twist
from diffdrive_mj.physics.simulation import simulate
from diffdrive_mj.recording import Recording
from diffdrive_mj.robot import Robot
from diffdrive_mj.sensors.optical_flow import FlowSensor
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
) -> Recording[tuple[Robot, ...], tuple[Commands, ...]]: ...
def simulate_rolling(
    robot: Robot | Sequence[Robot],
    commands: Commands | ClosedLoop | Sequence[Commands],
    *,
    physics: Physics = Physics(),  # noqa: B008
    sample_rate: float = 100.0,
    start: ArrayLike = (0.0, 0.0, 0.0),
    flow_sensor: FlowSensor | None = None,
) -> Recording[Any, Any]:
    """Simulate drives on which every wheel must roll, as `simulate` does, and refuse those on which one does not.

    Args:
        robot: the true robot, or a sequence of them.
        commands: to be driven, as for `simulate`.
        physics: how it is solved.
        sample_rate: of the recording [Hz].
        start: (..., 3) [m, m, rad].
        flow_sensor: an optical flow sensor on every robot, to be recorded too.

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
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PhysicsWarning)
        recording = simulate(
            robot, commands, physics=physics, sample_rate=sample_rate, start=start, flow_sensor=flow_sensor
        )
    if recording.events:
        raise InvalidValue(f"{recording.events[0]}: the wheels must roll here; drive more slowly or with a longer ramp")
    return recording


def steady_twist(recording: Recording[Robot, Any], robot: Robot) -> tuple[Array, float]:
    """Find the constant twist that a stretch of a drive comes closest to.

    Args:
        recording: of one run, the stretch alone (`Recording.during`).
        robot: its radii and track width.

    Returns:
        The twist (2,) [m/s, rad/s] of the mean wheel rates, and how far a wheel strays from turning evenly, along its
        path [m].

    Example:
        >>> robot = dd.Robot.load("matched")
        >>> drive = dd.simulate(robot, dd.maneuvers.arc(robot, radius=2.0, distance=6.0, speed=1.0))
        >>> twist, stray = steady_twist(drive.during(3.0, 6.0), robot)
        >>> twist.round(6).tolist(), stray < 1e-9
        ([1.0, 0.5], True)
    """
    elapsed, turned = recording.t - recording.t[0], recording.wheel_angles - recording.wheel_angles[0]
    rates = turned[-1] / elapsed[-1]
    stray = np.abs(turned - elapsed[:, None] * rates) * (robot.left_radius, robot.right_radius)
    return body_twist(rates, robot), float(stray.max())
