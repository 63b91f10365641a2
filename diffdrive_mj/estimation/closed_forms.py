"""Textbook closed forms for a constant twist, as they are printed: to read, to teach, and to check odometry with.

`odometry` and `se2.exp` compute the same arcs with sinc and the half angle, at any turn. The formulas here divide by
omega: they lose digits where it is small and need their limit where it is zero.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj._checks import SMALLEST, Array, array, broadcast


def icc_update(pose: ArrayLike, twist: ArrayLike, dt: ArrayLike) -> Array:
    """Turn a pose about the instantaneous centre of curvature (ICC) for some time.

    ```
    x_c = x - (v / omega) sin(theta)               y_c = y + (v / omega) cos(theta)
    x'  = x_c + (v / omega) sin(theta + omega dt)  y'  = y_c - (v / omega) cos(theta + omega dt)
    ```

    Args:
        pose: at the start (..., 3) [m, m, rad].
        twist: (v, omega) (..., 2) [m/s, rad/s]; where omega = 0 the limit is taken, a straight line.
        dt: the time (...) [s].

    Returns:
        The pose at the end (..., 3) [m, m, rad]; its heading is not wrapped.

    Raises:
        InvalidValue: wrong shapes, or values that are not finite.

    References:
        [Behnke], section ICC, with dt = 0.1 s. As printed it cannot do its own example, omega = 0.

    Example:
        A quarter of a circle of 1 m radius to the left, in 2 s:

        >>> dd.closed_forms.icc_update((0, 0, 0), (np.pi / 4, np.pi / 4), 2.0).round(4)
        array([1.    , 1.    , 1.5708])
    """
    pose, twist, dt = array("pose", pose, 3), array("twist", twist, 2), array("dt", dt)
    x, y, theta = np.moveaxis(pose, -1, 0)
    v, omega = twist[..., 0], twist[..., 1]
    broadcast(pose=x, twist=v, dt=dt)
    straight = np.abs(omega) < SMALLEST
    radius = v / np.where(straight, 1.0, omega)
    after = theta + omega * dt
    x_turned = x + radius * (np.sin(after) - np.sin(theta))
    y_turned = y - radius * (np.cos(after) - np.cos(theta))
    return np.stack(
        np.broadcast_arrays(
            np.where(straight, x + v * dt * np.cos(theta), x_turned),
            np.where(straight, y + v * dt * np.sin(theta), y_turned),
            after,
        ),
        axis=-1,
    )


def arc(start: ArrayLike, twist: ArrayLike, t: ArrayLike) -> Array:
    """Compute the pose on an arc as a function of time.

    ```
    x(t) = x_0 + r (sin(Theta + omega t) - sin(Theta))
    y(t) = y_0 - r (cos(Theta + omega t) - cos(Theta))        r = v / omega
    ```

    Args:
        start: the pose (x_0, y_0, Theta) at t = 0 (..., 3) [m, m, rad].
        twist: (v, omega) (..., 2) [m/s, rad/s].
        t: the time (...) [s].

    Returns:
        The pose at time t (..., 3) [m, m, rad].

    Raises:
        InvalidValue: wrong shapes, or values that are not finite.

    References:
        [Odometrie wiki 2016], forward kinematics, with r = d (v_l + v_r) / (v_r - v_l), and with the start heading that
        its arcs leave out (`arc_as_printed`).

    Example:
        >>> dd.closed_forms.arc((0, 0, np.pi / 2), (1.0, 1.0), [0.0, np.pi / 2]).round(4)
        array([[ 0.    ,  0.    ,  1.5708],
               [-1.    ,  1.    ,  3.1416]])
    """
    return icc_update(start, twist, t)


def arc_as_printed(start: ArrayLike, twist: ArrayLike, t: ArrayLike) -> Array:
    """Compute the pose on an arc with the formulas as printed, which leave the start heading out of x and y.

    ```
    x(t) = x_0 + r sin(omega t)        y(t) = y_0 + r (1 - cos(omega t))
    ```

    They are right for Theta = 0 alone. The straight line, printed beside them, has the start heading.

    Args:
        start: the pose (x_0, y_0, Theta) at t = 0 (..., 3) [m, m, rad].
        twist: (v, omega) (..., 2) [m/s, rad/s].
        t: the time (...) [s].

    Returns:
        What the formulas give (..., 3) [m, m, rad].

    Raises:
        InvalidValue: wrong shapes, or values that are not finite.

    References:
        [Odometrie wiki 2016], forward kinematics, the summary with x_0, y_0 and Theta.

    Example:
        A robot that faces +y and turns left ends up on the wrong side of its start:

        >>> dd.closed_forms.arc_as_printed((0, 0, np.pi / 2), (1.0, 1.0), np.pi / 2).round(4)
        array([1.    , 1.    , 3.1416])
    """
    start, twist = array("start", start, 3), array("twist", twist, 2)
    level = start.copy()
    level[..., 2] = 0.0
    turned = icc_update(level, twist, t)
    turned[..., 2] += start[..., 2]
    straight = (np.abs(twist[..., 1]) < SMALLEST)[..., None]
    return np.where(straight, icc_update(start, twist, t), turned)
