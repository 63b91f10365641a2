"""A wheel that rolls over a bump, in closed form: a cable or a threshold with a round top, or a sharp edge.

A wheel of radius r meets a bump of height h whose top has the radius c where the line from its hub to the top's centre
leans back by the angle a,

    cos(a) = 1 - h / (r + c)

and its hub then swings over the top on an arc of radius r + c by 2 a.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj._checks import Array, array, broadcast
from diffdrive_mj.errors import InvalidValue


def meeting_angle(wheel_radius: ArrayLike, height: ArrayLike, top_radius: ArrayLike = 0.0) -> Array:
    """Compute how steeply a wheel that touches the floor and a bump at once has to go on.

    ```
    a = acos(1 - h / (r + c))
    ```

    Args:
        wheel_radius: r (...) [m].
        height: of the bump, h (...) [m]; below r + c, where the wheel would meet it at the level of its hub.
        top_radius: of the bump's round top, c (...) [m]; 0 for a sharp edge.

    Returns:
        (...) [rad], from the level.

    Raises:
        InvalidValue: lengths that are not positive, or a bump that no wheel gets over.

    Example:
        >>> np.degrees(meeting_angle(0.1, (0.005, 0.02), (0.0025, 0.01))).round(1)
        array([18. , 35.1])
    """
    r, h, c = array("wheel_radius", wheel_radius), array("height", height), array("top_radius", top_radius)
    broadcast(wheel_radius=r, height=h, top_radius=c)
    if not ((r > 0).all() and (h > 0).all() and (c >= 0).all()):
        raise InvalidValue("wheel_radius, height: must be positive; top_radius: must not be negative")
    if (h >= r + c).any():
        raise InvalidValue("height: must be below wheel_radius + top_radius, where the wheel meets the bump at its hub")
    return np.arccos(1 - h / (r + c))


def extra_distance(wheel_radius: ArrayLike, height: ArrayLike, top_radius: ArrayLike = 0.0) -> Array:
    """Compute how much further than the robot gets its odometry says after a wheel has rolled over a bump.

    ```
    d = 2 (r + c) (a - sin(a)),  cos(a) = 1 - h / (r + c)
    ```

    The wheel turns by the arc of its hub over its radius, 2 a (r + c) / r, and gets ahead by the arc's chord. With
    c = h it is a half sunk round cable, 2 (r + h) acos(r / (r + h)) - 2 sqrt((r + h)^2 - r^2).

    Args:
        wheel_radius: r (...) [m].
        height: of the bump, h (...) [m].
        top_radius: of its round top, c (...) [m]; 0 for a sharp edge.

    Returns:
        (...) [m], of this wheel; where one alone rolls over it, the robot believes in a turn as well.

    Raises:
        InvalidValue: as for `meeting_angle`.

    Example:
        >>> (1e3 * extra_distance(0.1, (0.002, 0.005), (0.001, 0.0025))).round(2)  # [mm]
        array([0.27, 1.05])
    """
    angle = meeting_angle(wheel_radius, height, top_radius)
    swing = array("wheel_radius", wheel_radius) + array("top_radius", top_radius)
    return 2 * swing * (angle - np.sin(angle))


def highest_climb(wheel_radius: ArrayLike, friction: ArrayLike, top_radius: ArrayLike = 0.0) -> Array:
    """Compute how high a bump driven wheels climb at a crawl, both at once and without a push from behind.

    ```
    h = (r + c) (1 - cos(atan(mu))) = (r + c) (1 - 1 / sqrt(1 + mu^2))
    ```

    Nothing holds the robot back but the bump, so that the force on a wheel is upright, and leans away from the normal
    of the contact by the meeting angle, which friction allows up to atan(mu). A run-up climbs higher.

    Args:
        wheel_radius: r (...) [m].
        friction: coefficient mu between wheel and bump (...).
        top_radius: of the bump's round top, c (...) [m]; 0 for the edge of a step.

    Returns:
        (...) [m].

    Raises:
        InvalidValue: lengths or coefficients that are not positive.

    Example:
        >>> highest_climb(0.1, (0.5, 1.0)).round(4)
        array([0.0106, 0.0293])
    """
    r, mu, c = array("wheel_radius", wheel_radius), array("friction", friction), array("top_radius", top_radius)
    broadcast(wheel_radius=r, friction=mu, top_radius=c)
    if not ((r > 0).all() and (mu > 0).all() and (c >= 0).all()):
        raise InvalidValue("wheel_radius, friction: must be positive; top_radius: must not be negative")
    return (r + c) * (1 - 1 / np.sqrt(1 + mu**2))
