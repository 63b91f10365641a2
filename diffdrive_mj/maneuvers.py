"""Maneuvers: the wheel rates that a driver commands, computed for the robot that the driver believes in.

A maneuver is a list of legs; each starts and ends at rest and is driven through its segments without a stop.
A segment is an arc: a distance, an angle, and the time that it takes at full speed. Progress along a leg is a
trapezoid in time, and every command is the mean rate over its period, so that the commanded rates sum up
exactly to the wheel angles of the path, whatever the period.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj.commands import Commands
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.kinematics import wheel_rates
from diffdrive_mj.robot import Robot

PERIOD = 0.01
RAMP = 1.0
REST = 0.5


@dataclass(frozen=True)
class Segment:
    """An arc: straight for an angle of zero, on the spot for a distance of zero.

    Args:
        distance: of the axle's midpoint, negative in reverse [m].
        angle: that the heading turns, counter-clockwise [rad].
        duration: at full speed, ramps apart [s].
    """

    distance: float
    angle: float
    duration: float

    def __post_init__(self) -> None:
        checks.number("Segment.distance", self.distance)
        checks.number("Segment.angle", self.angle)
        checks.positive("Segment.duration", self.duration)


def sequence(
    robot: Robot,
    legs: Sequence[Sequence[Segment]],
    *,
    ramp: float = RAMP,
    rest: float = REST,
    period: float = PERIOD,
) -> Commands:
    """Any piecewise maneuver: legs from rest to rest, each through its segments without a stop.

    Args:
        robot: whom the driver believes to drive; only its radii and track width are read.
        legs: of segments.
        ramp: time from rest to full speed, and back [s]; 0 for a jump.
        rest: standing still at the end, until the servos have caught up [s].
        period: of the commands [s].
    """
    ramp, period = _options(ramp, period)
    if not legs or not all(legs):
        raise InvalidValue("legs: must hold at least one leg, and each leg at least one segment")
    increments = [_leg_increments(leg, ramp, period) for leg in legs]
    increments.append(np.tile(_standing(rest, period), 2))
    return Commands(period, wheel_rates(np.concatenate(increments) / period, robot))


def _options(ramp: float, period: float) -> tuple[float, float]:
    return checks.not_negative("ramp", ramp), checks.positive("period", period)


def _standing(rest: float, period: float) -> Array:
    """No progress (N, 1) while standing still."""
    return np.zeros((math.ceil(checks.not_negative("rest", rest) / period - 1e-9), 1))


def _leg_increments(leg: Sequence[Segment], ramp: float, period: float) -> Array:
    """Distance and angle of every period of a leg (N, 2)."""
    parts = np.array([(0.0, 0.0, 0.0), *((s.distance, s.angle, s.duration) for s in leg)])
    distance, angle, full_speed_time = np.cumsum(parts, axis=0).T
    total = full_speed_time[-1]
    # A leg shorter than its ramps never reaches full speed: half of it speeds up, half slows down.
    up = min(ramp, math.sqrt(total * ramp))
    end = total + ramp if total >= ramp else 2 * up
    edges = np.minimum(np.arange(math.ceil(end / period - 1e-9) + 1) * period, end)
    edges[-1] = end
    progress = _trapezoid(edges, up, end, up / ramp if ramp else 1.0)
    return np.diff(
        np.stack([np.interp(progress, full_speed_time, part) for part in (distance, angle)], axis=-1), axis=0
    )


def _trapezoid(t: Array, up: float, end: float, peak: float) -> Array:
    """Progress at time t: speeding up to `peak` during `up`, cruising, slowing down until `end`."""
    rising, falling = np.minimum(t, up), np.maximum(t - (end - up), 0.0)
    slope = peak / up if up else 0.0
    return peak * (t - rising) + slope * rising**2 / 2 - slope * falling**2 / 2


def constant_rates(
    rates: ArrayLike, duration: float, *, ramp: float = RAMP, rest: float = REST, period: float = PERIOD
) -> Commands:
    """Both wheels at constant rates between common ramps, as of motors that know of no robot.

    Args:
        rates: (2,) [rad/s], left then right.
        duration: at full speed, ramps apart [s].
        ramp, rest, period: as of `sequence` [s].
    """
    rates, duration = checks.vector("rates", rates, 2), checks.positive("duration", duration)
    profile = _leg_increments([Segment(duration, 0.0, duration)], *_options(ramp, period))
    return Commands(period, np.concatenate([profile[:, :1], _standing(rest, period)]) / period * rates)


def straight(robot: Robot, *, speed: float = 1.5, distance: float = 15.0, **options: float) -> Commands:
    """Straight ahead, or back for a negative distance [m], at a speed [m/s]; options as of `sequence`."""
    speed = checks.positive("speed", speed)
    return sequence(robot, [[Segment(distance, 0.0, _time("distance", distance, speed))]], **options)


def arc(
    robot: Robot, *, radius: float = 1.8, distance: float = 10.0, speed: float = 1.35, **options: float
) -> Commands:
    """Along a circle, to the left for a positive radius [m], to the right for a negative one."""
    if checks.number("radius", radius) == 0:
        raise InvalidValue("radius = 0: must not be zero; `spin` turns on the spot")
    duration = _time("distance", distance, checks.positive("speed", speed))
    return sequence(robot, [[Segment(distance, distance / radius, duration)]], **options)


def spin(robot: Robot, *, turns: float = 3.0, yaw_rate: float = 1.0, **options: float) -> Commands:
    """On the spot, counter-clockwise for positive turns, at a yaw rate [rad/s]."""
    return sequence(robot, [[_turn("turns", 2 * math.pi * checks.number("turns", turns), yaw_rate)]], **options)


def square(
    robot: Robot,
    *,
    side: float = 4.0,
    speed: float = 0.5,
    yaw_rate: float = 1.0,
    clockwise: bool = False,
    **options: float,
) -> Commands:
    """Four straight sides [m] and a quarter turn on the spot after each, back to the start pose."""
    speed, side = checks.positive("speed", speed), checks.positive("side", side)
    quarter = _turn("angle", -math.pi / 2 if clockwise else math.pi / 2, yaw_rate)
    return sequence(robot, [[Segment(side, 0.0, side / speed)], [quarter]] * 4, **options)


def figure_eight(robot: Robot, *, radius: float = 1.0, speed: float = 0.5, **options: float) -> Commands:
    """A circle to the left, a stop where the curvature changes sign, a circle to the right; back to the start pose."""
    radius, speed = checks.positive("radius", radius), checks.positive("speed", speed)
    around = 2 * math.pi * radius
    circles = [[Segment(around, turn, around / speed)] for turn in (2 * math.pi, -2 * math.pi)]
    return sequence(robot, circles, **options)


def slalom(
    robot: Robot,
    *,
    amplitude: float = math.pi / 4,
    wavelength: float = 4.0,
    waves: float = 3.0,
    speed: float = 1.0,
    **options: float,
) -> Commands:
    """A path whose curvature varies all the time: the heading swings as amplitude * sin(2 pi s / wavelength).

    Args:
        robot: as for `sequence`.
        amplitude: of the heading [rad].
        wavelength: along the path [m].
        waves: how many.
        speed: [m/s].
        options: as of `sequence`.
    """
    length = checks.positive("wavelength", wavelength) * checks.positive("waves", waves)
    speed = checks.positive("speed", speed)
    s = np.linspace(0.0, length, 1 + math.ceil(200 * waves))
    heading = checks.number("amplitude", amplitude) * np.sin(2 * np.pi * s / wavelength)
    pieces = [Segment(ds, turn, ds / speed) for ds, turn in zip(np.diff(s), np.diff(heading), strict=True)]
    return sequence(robot, [pieces], **options)


def _turn(name: str, angle: float, yaw_rate: float) -> Segment:
    return Segment(0.0, angle, _time(name, angle, checks.positive("yaw_rate", yaw_rate)))


def _time(name: str, amount: float, rate: float) -> float:
    if checks.number(name, amount) == 0:
        raise InvalidValue(f"{name} = 0: must not be zero")
    return abs(amount) / rate
