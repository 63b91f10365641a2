"""The kinematics of the differential drive with unequal wheels (002, 003).

Wheel rates are (left, right) [rad/s], twists (v, omega) [m/s, rad/s]. The functions read a robot's radii and
track width alone. Everything is linear in the rates, so wheel angles give distance and angle the same way.
"""

from __future__ import annotations

from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj._checks import Array, array, broadcast, positive
from diffdrive_mj.robot import Robot


def body_twist(wheel_rates: ArrayLike, robot: Robot) -> Array:
    """The twist of the axle's midpoint when both wheels roll without slip.

    v = (r_r phi_r' + r_l phi_l') / 2,  omega = (r_r phi_r' - r_l phi_l') / b

    A robot with a turning gain c turns by omega (1 + c s), where s = |omega| b / 2 / (|v| + |omega| b / 2) is 1 on the
    spot and 0 straight ahead: real tyres have a track that depends on how they turn.

    Args:
        wheel_rates: (..., 2) [rad/s], left then right. Angles [rad] give (distance [m], angle [rad]).
        robot: its radii, track width b and turning gain.

    Returns:
        (..., 2): v [m/s], omega [rad/s].

    Source: 002, forward kinematics with unequal radii; 003, equations 1 and 2 (their l, d is b / 2).
    """
    rates = array("wheel_rates", wheel_rates, 2)
    left = robot.left_radius * rates[..., 0]
    right = robot.right_radius * rates[..., 1]
    result = np.empty_like(rates)
    np.add(left, right, out=result[..., 0])
    result[..., 0] /= 2
    np.subtract(right, left, out=result[..., 1])
    result[..., 1] /= robot.track_width
    if robot.turning_gain:
        result[..., 1] *= 1 + robot.turning_gain * turning_share(result, robot.track_width)
    return result


def turning_share(twist: ArrayLike, track_width: float) -> Array:
    """What part of the wheels' motion turns the robot: s = |omega| b / 2 / (|v| + |omega| b / 2) (...), 0 at rest.

    Args:
        twist: (..., 2) [m/s, rad/s].
        track_width: b [m].
    """
    twist = array("twist", twist, 2)
    rim = np.abs(twist[..., 1]) * track_width / 2
    total = np.abs(twist[..., 0]) + rim
    return cast(Array, np.divide(rim, total, out=np.zeros_like(rim), where=total > 0))


def wheel_rates(twist: ArrayLike, robot: Robot) -> Array:
    """The wheel rates that drive a twist: `body_twist`'s inverse.

    phi_l' = (v - omega b / 2) / r_l,  phi_r' = (v + omega b / 2) / r_r

    With a turning gain c, u = |omega| b / 2 of the wheels solves (1 + c) u^2 + (|v| - w) u - |v| w = 0, w being that of
    the twist.

    Args:
        twist: (..., 2), v [m/s], omega [rad/s].
        robot: its radii, track width b and turning gain.

    Returns:
        (..., 2) [rad/s], left then right.
    """
    twist = array("twist", twist, 2)
    v, rim = twist[..., 0], twist[..., 1] * robot.track_width / 2
    if robot.turning_gain:
        along, wanted, c = np.abs(v), np.abs(rim), robot.turning_gain
        half = (along - wanted) / 2
        rim = np.sign(rim) * (np.sqrt(half**2 + (1 + c) * along * wanted) - half) / (1 + c)
    return np.stack([(v - rim) / robot.left_radius, (v + rim) / robot.right_radius], axis=-1)


def turning_radius(twist: ArrayLike) -> Array:
    """The signed radius of the path, v / omega [m]: positive to the left, infinite where omega = 0.

    Source: 003, equation 3.
    """
    twist = array("twist", twist, 2)
    v, omega = twist[..., 0], twist[..., 1]
    return cast(Array, np.divide(v, omega, out=np.full_like(v, np.inf), where=omega != 0))


def turning_center(pose: ArrayLike, twist: ArrayLike) -> Array:
    """The instantaneous centre of curvature (ICC) in the frame that the pose is given in.

    x_c = x - (v / omega) sin(theta),  y_c = y + (v / omega) cos(theta)

    Args:
        pose: (..., 3) [m, m, rad].
        twist: (..., 2) [m/s, rad/s].

    Returns:
        (..., 2) [m]; both infinite where omega = 0, the motion that 002 aims at.

    Source: 002, section ICC.
    """
    pose = array("pose", pose, 3)
    radius = turning_radius(twist)
    broadcast(pose=pose[..., 0], twist=radius)
    straight = np.isinf(radius)
    radius = np.where(straight, 0.0, radius)
    theta = pose[..., 2]
    center = pose[..., :2] + radius[..., None] * np.stack([-np.sin(theta), np.cos(theta)], axis=-1)
    return np.where(straight[..., None], np.inf, center)


def constraint_residuals(body_velocity: ArrayLike, wheel_rates: ArrayLike, robot: Robot) -> Array:
    """How far a motion breaks the constraints of two fixed standard wheels: zero for pure rolling.

    [ 1 0 -b/2 ]   [ v_x   ]   [ r_l phi_l' ]
    [ 1 0  b/2 ] * [ v_y   ] - [ r_r phi_r' ]
    [ 0 1  0   ]   [ omega ]   [ 0          ]

    Args:
        body_velocity: (..., 3), forward v_x [m/s], left v_y [m/s], omega [rad/s] of the axle's midpoint.
        wheel_rates: (..., 2) [rad/s], left then right.
        robot: its radii and track width b.

    Returns:
        (..., 3) [m/s]: the contacts' slip along the left wheel, along the right wheel, and sideways.

    Source: 002, rolling and no-sideways-slip constraints (right before left there, with l = b / 2).
    """
    velocity, rates = array("body_velocity", body_velocity, 3), array("wheel_rates", wheel_rates, 2)
    broadcast(body_velocity=velocity[..., 0], wheel_rates=rates[..., 0])
    vx, vy, rim = velocity[..., 0], velocity[..., 1], velocity[..., 2] * robot.track_width / 2
    left = vx - rim - robot.left_radius * rates[..., 0]
    right = vx + rim - robot.right_radius * rates[..., 1]
    return np.stack(np.broadcast_arrays(left, right, vy), axis=-1)


def compensated_right_radius(left_radius: float, speed_ratio: float) -> float:
    """The right radius that makes a robot whose left wheel turns k times as fast run straight: r_r = k r_l.

    Args:
        left_radius: [m].
        speed_ratio: k = left rate / right rate.

    Source: 002.
    """
    return positive("speed_ratio", speed_ratio) * positive("left_radius", left_radius)


def radii_for_speed(speed: float, right_rate: float, speed_ratio: float) -> tuple[float, float]:
    """The radii with which a robot runs straight at a given speed: r_l = v / (k phi_r'), r_r = k r_l.

    Args:
        speed: v [m/s]; 002 asks for 1.5 m/s, its formula 3 / (2 k phi_r').
        right_rate: rate of the right wheel phi_r' [rad/s].
        speed_ratio: k = left rate / right rate.

    Returns:
        Left and right radius [m].

    Source: 002.
    """
    left = positive("speed", speed) / (positive("speed_ratio", speed_ratio) * positive("right_rate", right_rate))
    return left, compensated_right_radius(left, speed_ratio)


def belief_matrix(believed: Robot, true: Robot) -> Array:
    """What a robot with wrong parameters takes a true twist for: twist' = M twist, for rolling wheels.

    Both robots see the same wheel rates. With p = r_l' / r_l, q = r_r' / r_r, true track b, believed b':

    M = [ (q + p) / 2    (q - p) b / 4      ]
        [ (q - p) / b'   (q + p) b / (2 b') ]

    A straight line of length s is thus taken for an arc of length M_11 s that turns by M_21 s.

    Args:
        believed: whose radii and track width the odometry computes with.
        true: whose the physics has.

    Returns:
        (2, 2), from and to (v [m/s], omega [rad/s]).

    Source: `body_twist` of the believed robot after `wheel_rates` of the true one.
    """
    left, right = believed.left_radius / true.left_radius, believed.right_radius / true.right_radius
    track, believed_track = true.track_width, believed.track_width
    return np.array(
        [
            [(right + left) / 2, (right - left) * track / 4],
            [(right - left) / believed_track, (right + left) * track / (2 * believed_track)],
        ]
    )
