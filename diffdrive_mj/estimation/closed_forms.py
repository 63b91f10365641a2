"""The sources' closed forms for a constant twist, as they print them: to read, to teach, and to check odometry with.

`odometry` and `se2.exp` compute the same arcs with sinc and the half angle, at any turn; these divide by omega, lose
digits where it is small, and need their limit where it is zero.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj._checks import Array, array


def icc_update(pose: ArrayLike, twist: ArrayLike, dt: ArrayLike) -> Array:
    """The pose after a time dt, turned about the instantaneous centre of curvature.

    x_c = x - (v / omega) sin(theta),              y_c = y + (v / omega) cos(theta)
    x' = x_c + (v / omega) sin(theta + omega dt),  y' = y_c - (v / omega) cos(theta + omega dt)

    Args:
        pose: (..., 3) [m, m, rad].
        twist: (..., 2) [m/s, rad/s]; where omega = 0 the limit is taken, a straight line.
        dt: (...) [s].

    Source: 002, section ICC (dt = 0.1 s there), whose own motion, omega = 0, its formulas cannot do.
    """
    pose, twist, dt = array("pose", pose, 3), array("twist", twist, 2), array("dt", dt)
    x, y, theta = np.moveaxis(pose, -1, 0)
    v, omega = twist[..., 0], twist[..., 1]
    straight = omega == 0
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
    """The pose at time t on an arc from a start pose: 003's formulas (12) to (14) with the start heading put right.

    x(t) = x_0 + r (sin(Theta + omega t) - sin(Theta)),  y(t) = y_0 - r (cos(Theta + omega t) - cos(Theta))

    Args:
        start: (..., 3) [m, m, rad].
        twist: (..., 2) [m/s, rad/s].
        t: (...) [s].

    Source: 003, forward kinematics, with r = d (v_l + v_r) / (v_r - v_l) = v / omega.
    """
    return icc_update(start, twist, t)


def arc_as_printed(start: ArrayLike, twist: ArrayLike, t: ArrayLike) -> Array:
    """003's formulas as the document prints them, which leave the start heading out of an arc (not out of a line).

    x(t) = x_0 + r sin(omega t),  y(t) = y_0 + r (1 - cos(omega t)): right for Theta = 0 alone.

    Args, Returns: as of `arc`.

    Source: 003, forward kinematics, the summary with x_0, y_0 and Theta.
    """
    start, twist = array("start", start, 3), array("twist", twist, 2)
    level = start.copy()
    level[..., 2] = 0.0
    turned = icc_update(level, twist, t)
    turned[..., 2] += start[..., 2]
    straight = (twist[..., 1] == 0)[..., None]
    return np.where(straight, icc_update(start, twist, t), turned)
