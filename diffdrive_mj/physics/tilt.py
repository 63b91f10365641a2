"""Unequal wheels on a rigid axle: how the robot tilts, and which robot with independent axles rolls like it.

The hubs are a track width apart along the axle, the wheels perpendicular to it. Seen from behind, the left end of the
axle is up by the roll angle a (negative where the left wheel is the smaller one). A crowned wheel is an ellipsoid with
the semi-axes r, q, r (q half its width); with c = cos(a), s = sin(a) and h = sqrt(r^2 c^2 + q^2 s^2) its

    hub is above the floor by                    h
    contact is away from its own axis by         r^2 c / h           the rolling radius
    contact is to the left of its hub by         s c (r^2 - q^2) / h

and a follows from h_l - h_r = b s. To second order, for thin wheels, tan(a) = (r_l - r_r) / b and the contacts are
b (1 + a^2 / 2) apart.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

from scipy.optimize import brentq

from diffdrive_mj import _checks as checks
from diffdrive_mj.robot import Robot


@dataclass(frozen=True)
class Tilt:
    """Say where a robot's wheels touch the floor.

    Attributes:
        roll: of the axle, positive with its left end up [rad].
        height: of the axle's middle above the floor [m].
        left_radius, right_radius: the wheels' rolling radii [m].
        track_width: distance between the contacts [m].
        offset: of the contacts' midpoint to the left of the axle's middle, along the floor [m].

    Example:
        >>> robot = Robot(left_radius=0.1, right_radius=0.091, track_width=0.4, axle="rigid")
        >>> print(f"{math.degrees(resting_tilt(robot).roll):.2f} deg")
        1.29 deg
    """

    roll: float
    height: float
    left_radius: float
    right_radius: float
    track_width: float
    offset: float


def resting_tilt(robot: Robot) -> Tilt:
    """Return the tilt of a robot at rest; a robot with independent axles has none.

    Args:
        robot: its radii, track, tyre width and axle.

    Example:
        >>> resting_tilt(Robot(left_radius=0.1, right_radius=0.091, track_width=0.4)).roll
        0.0
    """
    return _resting_tilt(checks.instance("robot", robot, Robot))


@functools.lru_cache(maxsize=256)
def _resting_tilt(robot: Robot) -> Tilt:
    if robot.axle == "independent":
        return Tilt(0.0, robot.mean_radius, robot.left_radius, robot.right_radius, robot.track_width, 0.0)
    roll = _roll(robot)
    c, s, q = math.cos(roll), math.sin(roll), robot.tyres.width / 2
    h_left, h_right = (_height(r, robot, roll) for r in (robot.left_radius, robot.right_radius))
    left = s * c * (robot.left_radius**2 - q**2) / h_left
    right = s * c * (robot.right_radius**2 - q**2) / h_right
    return Tilt(
        roll=roll,
        height=(h_left + h_right) / 2,
        left_radius=robot.left_radius**2 * c / h_left,
        right_radius=robot.right_radius**2 * c / h_right,
        track_width=robot.track_width * c + left - right,
        offset=(left + right) / 2,
    )


def _roll(robot: Robot) -> float:
    """Where the hubs' heights differ by the rise of the axle."""

    def gap(roll: float) -> float:
        rise = robot.track_width * math.sin(roll)
        return _height(robot.left_radius, robot, roll) - _height(robot.right_radius, robot, roll) - rise

    if gap(0.0) == 0:
        return 0.0
    return float(brentq(gap, 0.0, math.copysign(math.pi / 2, gap(0.0)), xtol=1e-16, rtol=1e-15))


def _height(radius: float, robot: Robot, roll: float) -> float:
    return math.hypot(radius * math.cos(roll), robot.tyres.width / 2 * math.sin(roll))


def level_twin(robot: Robot) -> Robot:
    """Return the robot with independent axles that rolls like a tilted one: what its odometry should believe.

    Args:
        robot: whose rolling radii and distance of the contacts count.

    Example:
        >>> robot = Robot(left_radius=0.1, right_radius=0.091, track_width=0.4, axle="rigid")
        >>> print(f"{1e6 * (level_twin(robot).track_width / robot.track_width - 1):.0f} ppm")
        275 ppm
    """
    at = resting_tilt(robot)
    return robot.replace(
        axle="independent", left_radius=at.left_radius, right_radius=at.right_radius, track_width=at.track_width
    )
