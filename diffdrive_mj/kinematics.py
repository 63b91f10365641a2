"""The kinematics of the differential drive with unequal wheels.

Wheel rates are (left, right) [rad/s], twists (v, omega) [m/s, rad/s]. The functions read a robot's radii, track width
and turning gain alone. Everything but the turning gain is linear in the rates, so wheel angles [rad] give distance [m]
and angle [rad] the same way.
"""

from __future__ import annotations

from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj._checks import Array, array, broadcast, instance, positive
from diffdrive_mj.robot import Robot


def body_twist(wheel_rates: ArrayLike, robot: Robot) -> Array:
    """Compute the twist of the axle's midpoint when both wheels roll without slip.

    ```
    v = (r_r phi_r' + r_l phi_l') / 2        omega = (r_r phi_r' - r_l phi_l') / b
    ```

    A robot with a turning gain c turns by omega (1 + c s) instead, with s its `turning_share`: the effective track of
    real tyres depends on how they turn.

    Args:
        wheel_rates: (..., 2) [rad/s], left then right. Angles [rad] give (distance [m], angle [rad]).
        robot: its radii r_l and r_r, track width b and turning gain.

    Returns:
        (..., 2): v [m/s], omega [rad/s].

    References:
        [Behnke]: forward kinematics with unequal radii; its l is b / 2.
        [Odometrie wiki 2016]: equations 1 and 2; its d is b / 2.

    Example:
        >>> robot = dd.Robot(left_radius=0.100, right_radius=0.090, track_width=0.400)
        >>> dd.kinematics.body_twist((10.0, 10.0), robot).round(9).tolist()
        [0.95, -0.25]
    """
    rates = array("wheel_rates", wheel_rates, 2)
    instance("robot", robot, Robot)
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
    """Compute what part of the wheels' motion turns the robot: 1 on the spot, 0 straight ahead and at rest.

    ```
    s = |omega| b / 2 / (|v| + |omega| b / 2)
    ```

    Args:
        twist: (..., 2) [m/s, rad/s].
        track_width: b [m].

    Returns:
        (...), from 0 to 1.

    Example:
        >>> dd.kinematics.turning_share([(0.0, 2.0), (0.2, 1.0), (0.5, 0.0)], 0.4).tolist()
        [1.0, 0.5, 0.0]
    """
    twist = array("twist", twist, 2)
    rim = np.abs(twist[..., 1]) * positive("track_width", track_width) / 2
    total = np.abs(twist[..., 0]) + rim
    return cast(Array, np.divide(rim, total, out=np.zeros_like(rim), where=total > 0))


def wheel_rates(twist: ArrayLike, robot: Robot) -> Array:
    """Compute the wheel rates that drive a twist: the inverse of `body_twist`.

    ```
    phi_l' = (v - omega b / 2) / r_l        phi_r' = (v + omega b / 2) / r_r
    ```

    With a turning gain c, the u = |omega| b / 2 of the wheels solves (1 + c) u^2 + (|v| - w) u - |v| w = 0, w being
    that of the twist.

    Args:
        twist: (..., 2), v [m/s], omega [rad/s].
        robot: its radii, track width b and turning gain.

    Returns:
        (..., 2) [rad/s], left then right.

    Example:
        >>> robot = dd.Robot(left_radius=0.100, right_radius=0.100, track_width=0.400)
        >>> dd.kinematics.wheel_rates((1.0, 0.5), robot).round(9).tolist()
        [9.0, 11.0]
    """
    twist = array("twist", twist, 2)
    instance("robot", robot, Robot)
    v, rim = twist[..., 0], twist[..., 1] * robot.track_width / 2
    if robot.turning_gain:
        along, wanted, c = np.abs(v), np.abs(rim), robot.turning_gain
        half = (along - wanted) / 2
        rim = np.sign(rim) * (np.sqrt(half**2 + (1 + c) * along * wanted) - half) / (1 + c)
    return np.stack([(v - rim) / robot.left_radius, (v + rim) / robot.right_radius], axis=-1)


def turning_radius(twist: ArrayLike) -> Array:
    """Compute the signed radius of the path, v / omega: positive to the left, infinite where omega = 0.

    Args:
        twist: (..., 2) [m/s, rad/s].

    Returns:
        (...) [m].

    References:
        [Odometrie wiki 2016]: equation 3.

    Example:
        >>> dd.kinematics.turning_radius([(1.0, 0.5), (1.0, -0.5), (1.0, 0.0)]).tolist()
        [2.0, -2.0, inf]
    """
    twist = array("twist", twist, 2)
    v, omega = twist[..., 0], twist[..., 1]
    with np.errstate(over="ignore"):  # a turn too small to tell from none
        return cast(Array, np.divide(v, omega, out=np.full_like(v, np.inf), where=omega != 0))


def turning_center(pose: ArrayLike, twist: ArrayLike) -> Array:
    """Compute the instantaneous centre of curvature (ICC) in the frame that the pose is given in.

    ```
    x_c = x - (v / omega) sin(theta)        y_c = y + (v / omega) cos(theta)
    ```

    Args:
        pose: (..., 3) [m, m, rad].
        twist: (..., 2) [m/s, rad/s].

    Returns:
        (..., 2) [m]; both infinite where omega = 0, the motion that [Behnke] aims at.

    References:
        [Behnke]: section ICC.

    Example:
        >>> dd.kinematics.turning_center((1.0, 0.0, 0.0), (1.0, 0.5)).tolist()
        [1.0, 2.0]
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
    """Compute how far a motion violates the constraints of two fixed standard wheels: zero for pure rolling.

    ```
    [ 1 0 -b/2 ]   [ v_x   ]   [ r_l phi_l' ]
    [ 1 0  b/2 ] * [ v_y   ] - [ r_r phi_r' ]
    [ 0 1  0   ]   [ omega ]   [ 0          ]
    ```

    Args:
        body_velocity: (..., 3), forward v_x [m/s], left v_y [m/s], omega [rad/s] of the axle's midpoint.
        wheel_rates: (..., 2) [rad/s], left then right.
        robot: its radii and track width b.

    Returns:
        (..., 3) [m/s]: the contacts' slip along the left wheel, along the right wheel, and sideways.

    References:
        [Behnke]: rolling and no-sideways-slip constraints, right before left, with l = b / 2.

    Example:
        Both wheels turn at a rim speed of 1 m/s; the robot moves ahead at 0.9 m/s and slides 0.1 m/s to the left:

        >>> robot = dd.Robot(left_radius=0.100, right_radius=0.100, track_width=0.400)
        >>> dd.kinematics.constraint_residuals((0.9, 0.1, 0.0), (10.0, 10.0), robot).round(9).tolist()
        [-0.1, -0.1, 0.1]
    """
    velocity, rates = array("body_velocity", body_velocity, 3), array("wheel_rates", wheel_rates, 2)
    instance("robot", robot, Robot)
    broadcast(body_velocity=velocity[..., 0], wheel_rates=rates[..., 0])
    vx, vy, rim = velocity[..., 0], velocity[..., 1], velocity[..., 2] * robot.track_width / 2
    left = vx - rim - robot.left_radius * rates[..., 0]
    right = vx + rim - robot.right_radius * rates[..., 1]
    return np.stack(np.broadcast_arrays(left, right, vy), axis=-1)


def compensated_right_radius(left_radius: float, speed_ratio: float) -> float:
    """Compute the right radius with which a robot whose left wheel turns k times as fast runs straight: r_r = k r_l.

    Args:
        left_radius: r_l [m].
        speed_ratio: k = left rate / right rate.

    Returns:
        [m].

    References:
        [Behnke]: r_r = r_l k.

    Example:
        >>> round(dd.kinematics.compensated_right_radius(0.100, speed_ratio=0.91), 9)
        0.091
    """
    return positive("speed_ratio", speed_ratio) * positive("left_radius", left_radius)


def radii_for_speed(speed: float, right_rate: float, speed_ratio: float) -> tuple[float, float]:
    """Compute the radii with which a robot runs straight at a given speed: r_l = v / (k phi_r'), r_r = k r_l.

    Args:
        speed: v [m/s].
        right_rate: rate of the right wheel phi_r' [rad/s].
        speed_ratio: k = left rate / right rate.

    Returns:
        Left and right radius [m].

    References:
        [Behnke]: asks for v = 1.5 m/s, r_l = 3 / (2 k phi_r').

    Example:
        >>> [round(r, 9) for r in dd.kinematics.radii_for_speed(1.5, right_rate=16.5, speed_ratio=0.91)]
        [0.0999001, 0.090909091]
    """
    left = positive("speed", speed) / (positive("speed_ratio", speed_ratio) * positive("right_rate", right_rate))
    return left, compensated_right_radius(left, speed_ratio)


def belief_matrix(believed: Robot, true: Robot) -> Array:
    """Compute what a robot with wrong parameters takes a true twist for: twist' = M twist, for rolling wheels.

    Both robots see the same wheel rates: it is `body_twist` of the believed robot after `wheel_rates` of the true one.
    With p = r_l' / r_l, q = r_r' / r_r, true track b, believed track b':

    ```
    M = [ (q + p) / 2    (q - p) b / 4      ]
        [ (q - p) / b'   (q + p) b / (2 b') ]
    ```

    A straight line of length s is thus taken for an arc of length M_11 s that turns by M_21 s.

    Args:
        believed: the robot that the odometry computes with.
        true: the robot that the physics has.

    Returns:
        (2, 2), from and to (v [m/s], omega [rad/s]).

    Example:
        A right wheel that is 9 % smaller than believed: after 1 m straight ahead odometry has turned by 14 degrees.

        >>> true = dd.Robot(left_radius=0.100, right_radius=0.091, track_width=0.400)
        >>> matrix = dd.kinematics.belief_matrix(true.replace(right_radius=0.100), true)
        >>> np.degrees(matrix[1, 0]).round(1).item()
        14.2
    """
    instance("believed", believed, Robot)
    instance("true", true, Robot)
    left, right = believed.left_radius / true.left_radius, believed.right_radius / true.right_radius
    track, believed_track = true.track_width, believed.track_width
    return np.array(
        [
            [(right + left) / 2, (right - left) * track / 4],
            [(right - left) / believed_track, (right + left) * track / (2 * believed_track)],
        ]
    )
