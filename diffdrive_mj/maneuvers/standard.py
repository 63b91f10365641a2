"""The standard maneuvers: lines, circles, turns on the spot, and what they make together."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np

from diffdrive_mj import _checks as checks
from diffdrive_mj.commands import Commands
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.maneuvers.legs import PERIOD, RAMP, REST, Segment, sequence
from diffdrive_mj.robot import Robot


def straight(
    robot: Robot,
    *,
    speed: float = 1.5,
    distance: float = 15.0,
    ramp: float = RAMP,
    rest: float = REST,
    period: float = PERIOD,
) -> Commands:
    """Drive straight ahead, or in reverse for a negative distance.

    Args:
        robot: the robot the commands are computed for.
        speed: [m/s].
        distance: [m].
        ramp: time from rest to full speed, and back [s].
        rest: standing still at the end [s].
        period: of the commands [s].

    Returns:
        The wheel rates.

    Raises:
        InvalidType: not a robot, not numbers.
        InvalidValue: a value out of its range, or more periods than fit in memory.

    Example:
        >>> robot = dd.Robot(left_radius=0.100, right_radius=0.091, track_width=0.400)
        >>> commands = dd.maneuvers.straight(robot, speed=1.0, distance=2.0)
        >>> (commands.wheel_rates.sum(axis=0) * commands.period).round(4).tolist()  # 2 m over each radius
        [20.0, 21.978]
    """
    speed = checks.positive("speed", speed)
    leg = [Segment(distance, 0.0, _time("distance", distance, speed))]
    return sequence(robot, [leg], ramp=ramp, rest=rest, period=period)


def arc(
    robot: Robot,
    *,
    radius: float = 1.8,
    distance: float = 10.0,
    speed: float = 1.35,
    ramp: float = RAMP,
    rest: float = REST,
    period: float = PERIOD,
) -> Commands:
    """Drive along a circle.

    Args:
        robot: the robot the commands are computed for.
        radius: [m], positive with the centre to the left, negative with the centre to the right.
        distance: along the circle, negative in reverse [m].
        speed: [m/s].
        ramp: time from rest to full speed, and back [s].
        rest: standing still at the end [s].
        period: of the commands [s].

    Returns:
        The wheel rates.

    Raises:
        InvalidType: not a robot, not numbers.
        InvalidValue: a value out of its range, or more periods than fit in memory.

    Example:
        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> commands = dd.maneuvers.arc(robot, radius=1.0, distance=np.pi, speed=1.0)
        >>> turned = commands.wheel_rates.sum(axis=0) * commands.period
        >>> dd.kinematics.body_twist(turned, robot).round(4).tolist()  # half a circle
        [3.1416, 3.1416]
    """
    if checks.number("radius", radius) == 0:
        raise InvalidValue("radius = 0: must not be zero; `spin` turns on the spot")
    duration = _time("distance", distance, checks.positive("speed", speed))
    leg = [Segment(distance, distance / radius, duration)]
    return sequence(robot, [leg], ramp=ramp, rest=rest, period=period)


def spin(
    robot: Robot,
    *,
    turns: float = 3.0,
    yaw_rate: float = 1.0,
    ramp: float = RAMP,
    rest: float = REST,
    period: float = PERIOD,
) -> Commands:
    """Turn on the spot, counter-clockwise for positive turns.

    Args:
        robot: the robot the commands are computed for.
        turns: how many; negative for clockwise.
        yaw_rate: its size [rad/s].
        ramp: time from rest to full speed, and back [s].
        rest: standing still at the end [s].
        period: of the commands [s].

    Returns:
        The wheel rates.

    Raises:
        InvalidType: not a robot, not numbers.
        InvalidValue: a value out of its range, or more periods than fit in memory.

    Example:
        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> dd.maneuvers.spin(robot, turns=-1.0).wheel_rates.max(axis=0).round(9).tolist()
        [2.0, 0.0]
    """
    leg = [_turn("turns", 2 * math.pi * checks.number("turns", turns), yaw_rate)]
    return sequence(robot, [leg], ramp=ramp, rest=rest, period=period)


def square(
    robot: Robot,
    *,
    side: float = 4.0,
    speed: float = 0.5,
    yaw_rate: float = 1.0,
    clockwise: bool = False,
    ramp: float = RAMP,
    rest: float = REST,
    period: float = PERIOD,
) -> Commands:
    """Drive four straight sides with a quarter turn on the spot after each, back to the start pose.

    Args:
        robot: the robot the commands are computed for.
        side: [m].
        speed: along the sides [m/s].
        yaw_rate: in the corners [rad/s].
        clockwise: whether the corners turn to the right.
        ramp: time from rest to full speed, and back [s].
        rest: standing still at the end [s].
        period: of the commands [s].

    Returns:
        The wheel rates.

    Raises:
        InvalidType: not a robot, not numbers, a direction that is neither True nor False.
        InvalidValue: a value out of its range, or more periods than fit in memory.

    Example:
        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> commands = dd.maneuvers.square(robot, side=1.0)
        >>> turned = np.cumsum(np.vstack([(0.0, 0.0), commands.wheel_rates]), axis=0) * commands.period
        >>> path = dd.odometry.integrate(turned, robot)
        >>> path[:, :2].max(axis=0).round(3).tolist(), bool(np.hypot(*path[-1, :2]) < 1e-9)
        ([1.0, 1.0], True)
    """
    speed, side = checks.positive("speed", speed), checks.positive("side", side)
    right_angle = -math.pi / 2 if checks.boolean("clockwise", clockwise) else math.pi / 2
    legs = [[Segment(side, 0.0, side / speed)], [_turn("angle", right_angle, yaw_rate)]] * 4
    return sequence(robot, legs, ramp=ramp, rest=rest, period=period)


def figure_eight(
    robot: Robot,
    *,
    radius: float = 1.0,
    speed: float = 0.5,
    ramp: float = RAMP,
    rest: float = REST,
    period: float = PERIOD,
) -> Commands:
    """Drive a circle to the left, stop where the curvature changes sign, and a circle to the right, back to the start.

    Args:
        robot: the robot the commands are computed for.
        radius: of both circles [m].
        speed: [m/s].
        ramp: time from rest to full speed, and back [s].
        rest: standing still at the end [s].
        period: of the commands [s].

    Returns:
        The wheel rates.

    Raises:
        InvalidType: not a robot, not numbers.
        InvalidValue: a value out of its range, or more periods than fit in memory.

    Example:
        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> commands = dd.maneuvers.figure_eight(robot)
        >>> (commands.wheel_rates.sum(axis=0) * commands.period).round(4).tolist()  # 4 pi m with either wheel
        [125.6637, 125.6637]
    """
    radius, speed = checks.positive("radius", radius), checks.positive("speed", speed)
    around = 2 * math.pi * radius
    circles = [[Segment(around, turn, around / speed)] for turn in (2 * math.pi, -2 * math.pi)]
    return sequence(robot, circles, ramp=ramp, rest=rest, period=period)


def slalom(
    robot: Robot,
    *,
    amplitude: float = math.pi / 4,
    wavelength: float = 4.0,
    waves: float = 3.0,
    speed: float = 1.0,
    ramp: float = RAMP,
    rest: float = REST,
    period: float = PERIOD,
) -> Commands:
    """Drive a path whose curvature varies all the time.

    ```
    heading = amplitude sin(2 pi s / wavelength)
    ```

    at the distance s along the path.

    Args:
        robot: the robot the commands are computed for.
        amplitude: of the heading [rad].
        wavelength: along the path [m].
        waves: how many.
        speed: [m/s].
        ramp: time from rest to full speed, and back [s].
        rest: standing still at the end [s].
        period: of the commands [s].

    Returns:
        The wheel rates.

    Raises:
        InvalidType: not a robot, not numbers.
        InvalidValue: a value out of its range, or more periods than fit in memory.

    Example:
        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> commands = dd.maneuvers.slalom(robot, wavelength=2.0, waves=1.25)
        >>> turned = commands.wheel_rates.sum(axis=0) * commands.period
        >>> dd.kinematics.body_twist(turned, robot).round(4).tolist()  # 2.5 m, and heading out at the amplitude
        [2.5, 0.7854]
    """
    wavelength, waves = checks.positive("wavelength", wavelength), checks.positive("waves", waves)
    length, speed = wavelength * waves, checks.positive("speed", speed)
    s = np.linspace(0.0, length, 1 + checks.samples("slalom", length / speed, wavelength / speed / 200))
    heading = checks.number("amplitude", amplitude) * np.sin(2 * np.pi * s / wavelength)
    pieces = [Segment(ds, turn, ds / speed) for ds, turn in zip(np.diff(s), np.diff(heading), strict=True)]
    return sequence(robot, [pieces], ramp=ramp, rest=rest, period=period)


# What files and commands call them. Each takes a robot, and its options by name.
BY_NAME: Mapping[str, Callable[..., Commands]] = MappingProxyType(
    {each.__name__: each for each in (straight, arc, spin, square, figure_eight, slalom)}
)


def _turn(name: str, angle: float, yaw_rate: float) -> Segment:
    return Segment(0.0, angle, _time(name, angle, checks.positive("yaw_rate", yaw_rate)))


def _time(name: str, amount: float, rate: float) -> float:
    if checks.number(name, amount) == 0:
        raise InvalidValue(f"{name} = 0: must not be zero")
    return abs(amount) / rate
