"""Legs from rest to rest, of which every maneuver is made.

Each leg is driven through its segments without a stop. A segment is an arc: a distance, an angle, and the time
that it takes at full speed. Progress along a leg is a trapezoid in time, and every command is the mean rate over its
period, so that the commanded rates sum up exactly to the wheel angles of the path, whatever the period.
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
        angle: by which the heading turns, counter-clockwise [rad].
        duration: at full speed, without the ramps [s].

    Raises:
        InvalidType: a field is not a number; the message names it.
        InvalidValue: a field is out of its range; the message names it.

    Example:
        >>> quarter_circle = dd.maneuvers.Segment(distance=np.pi / 2, angle=np.pi / 2, duration=3.0)
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
    """Drive any piecewise maneuver: legs from rest to rest, each through its segments without a stop.

    Args:
        robot: the robot the commands are computed for; its radii, track width and turning gain are read.
        legs: lists of segments.
        ramp: time from rest to full speed, and back [s]; 0 for a jump.
        rest: standing still at the end, until the servos have caught up [s].
        period: of the commands [s].

    Returns:
        The wheel rates.

    Raises:
        InvalidType: not a robot, not segments, not numbers.
        InvalidValue: no leg or an empty one, a value out of its range, or more periods than fit in memory.

    Example:
        A metre ahead, then a quarter turn to the left:

        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> Segment = dd.maneuvers.Segment
        >>> dd.maneuvers.sequence(robot, [[Segment(1.0, 0.0, 2.0)], [Segment(0.0, np.pi / 2, 1.0)]])
        Commands(550 periods of 0.01 s, 5.5 s)
    """
    ramp, rest, period = _timing(ramp, rest, period)
    checks.instance("robot", robot, Robot)
    legs = [checks.instances(f"legs[{k}]", leg, Segment) for k, leg in enumerate(checks.several("legs", legs))]
    if not legs or not all(legs):
        raise InvalidValue("legs: must hold at least one leg, and each leg at least one segment")
    increments = [_leg_increments(leg, ramp, period) for leg in legs]
    increments.append(np.tile(_standing(rest, period), 2))
    return Commands(period, wheel_rates(np.concatenate(increments) / period, robot))


def _timing(ramp: float, rest: float, period: float) -> tuple[float, float, float]:
    return checks.not_negative("ramp", ramp), checks.not_negative("rest", rest), checks.positive("period", period)


def _standing(rest: float, period: float) -> Array:
    """No progress (N, 1) while standing still."""
    return np.zeros((checks.samples("rest", rest, period), 1))


def _leg_increments(leg: Sequence[Segment], ramp: float, period: float) -> Array:
    """Distance and angle of every period of a leg (N, 2)."""
    parts = np.array([(0.0, 0.0, 0.0), *((s.distance, s.angle, s.duration) for s in leg)])
    # Sums too large for a number are refused here for a duration, by `wheel_rates` for a distance or an angle.
    with np.errstate(over="ignore", invalid="ignore"):
        distance, angle, full_speed_time = np.cumsum(parts, axis=0).T
        total = float(full_speed_time[-1])
        # A leg shorter than its ramps never reaches full speed: half of it speeds up, half slows down.
        up = min(ramp, math.sqrt(total * ramp))
        end = total + ramp if total >= ramp else 2 * up
        periods = max(checks.samples("a leg", end, period), 1)  # however short the leg is
        edges = np.minimum(np.arange(periods + 1) * period, end)
        edges[-1] = end
        progress = _trapezoid(edges, up, end, up / ramp if ramp else 1.0)
        covered = [np.interp(progress, full_speed_time, part) for part in (distance, angle)]
        return np.diff(np.stack(covered, axis=-1), axis=0)


def _trapezoid(t: Array, up: float, end: float, peak: float) -> Array:
    """Progress at time t: speeding up to `peak` during `up`, cruising, slowing down until `end`."""
    rising, falling = np.minimum(t, up), np.maximum(t - (end - up), 0.0)
    slope = peak / up if up else 0.0
    return peak * (t - rising) + slope * rising**2 / 2 - slope * falling**2 / 2


def constant_rates(
    rates: ArrayLike, duration: float, *, ramp: float = RAMP, rest: float = REST, period: float = PERIOD
) -> Commands:
    """Turn both wheels at constant rates between common ramps, regardless of the robot's geometry.

    Args:
        rates: (2,) [rad/s], left then right.
        duration: at full speed, without the ramps [s].
        ramp: time from rest to full speed, and back [s].
        rest: standing still at the end [s].
        period: of the commands [s].

    Returns:
        The wheel rates.

    Raises:
        InvalidType: not numbers.
        InvalidValue: a value out of its range, or more periods than fit in memory.

    Example:
        >>> commands = dd.maneuvers.constant_rates((9.1, 10.0), duration=2.0)
        >>> commands.wheel_rates.max(axis=0).round(9).tolist()
        [9.1, 10.0]
    """
    rates, duration = checks.vector("rates", rates, 2), checks.positive("duration", duration)
    ramp, rest, period = _timing(ramp, rest, period)
    profile = _leg_increments([Segment(duration, 0.0, duration)], ramp, period)
    return Commands(period, np.concatenate([profile[:, :1], _standing(rest, period)]) / period * rates)
