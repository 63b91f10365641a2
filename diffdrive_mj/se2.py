"""SE(2): poses of the plane and their group.

A pose is (x, y, theta) [m, m, rad]. Headings are continuous: composing never wraps them. The exponential
uses the chord, sinc and the half angle, which needs no threshold near a turn of zero.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj._checks import Array, array, broadcast


def sinc(angle: Array) -> Array:
    """sin(angle) / angle, 1 at zero (numpy's own sinc is normalised by pi)."""
    return np.sinc(angle / np.pi)


def wrap_angle(theta: ArrayLike) -> Array:
    """The same direction in (-pi, pi]; an angle that lies there already keeps all its bits.

    Args:
        theta: (...) [rad].
    """
    # The remainder is exact, and so is adding or taking away the one turn that may be too much.
    turned = np.fmod(array("theta", theta), 2 * np.pi)
    too_much = (turned > np.pi).astype(float) - (turned <= -np.pi)
    return turned - 2 * np.pi * too_much


def rotate(points: ArrayLike, theta: ArrayLike) -> Array:
    """Points turned counter-clockwise about the origin.

    Args:
        points: (..., 2) [m].
        theta: (...) [rad].
    """
    points, theta = array("points", points, 2), array("theta", theta)
    broadcast(points=points[..., 0], theta=theta)
    x, y, c, s = points[..., 0], points[..., 1], np.cos(theta), np.sin(theta)
    return np.stack(np.broadcast_arrays(c * x - s * y, s * x + c * y), axis=-1)


def _pose(position: Array, theta: Array) -> Array:
    return np.concatenate([position, np.broadcast_to(theta, position.shape[:-1])[..., None]], axis=-1)


def compose(a: ArrayLike, b: ArrayLike) -> Array:
    """Pose b, given in the frame of pose a, in the frame that a is given in: a b.

    Args:
        a, b: (..., 3) [m, m, rad].

    Returns:
        (..., 3): position a + R(theta_a) b, heading theta_a + theta_b.
    """
    a, b = array("a", a, 3), array("b", b, 3)
    broadcast(a=a[..., 0], b=b[..., 0])
    return _pose(a[..., :2] + rotate(b[..., :2], a[..., 2]), a[..., 2] + b[..., 2])


def inverse(a: ArrayLike) -> Array:
    """The pose that undoes a: compose(a, inverse(a)) is the origin."""
    a = array("a", a, 3)
    return _pose(-rotate(a[..., :2], -a[..., 2]), -a[..., 2])


def between(a: ArrayLike, b: ArrayLike) -> Array:
    """Pose b seen from pose a: a^-1 b, so that compose(a, between(a, b)) = b.

    Args:
        a, b: (..., 3) [m, m, rad], in one frame.
    """
    a, b = array("a", a, 3), array("b", b, 3)
    broadcast(a=a[..., 0], b=b[..., 0])
    return _pose(rotate(b[..., :2] - a[..., :2], -a[..., 2]), b[..., 2] - a[..., 2])


def exp(twist_times_dt: ArrayLike) -> Array:
    """The pose reached by a constant twist: an arc.

    p = sinc(theta / 2) R(theta / 2) (u, w), the chord along the heading turned by half the angle
    (000, equations 1.7 and 1.12), for a twist that may also move sideways.

    Args:
        twist_times_dt: (..., 3), distance forward u [m], distance to the left w [m], angle theta [rad].

    Returns:
        (..., 3) [m, m, rad], seen from the start.
    """
    xi = array("twist_times_dt", twist_times_dt, 3)
    half = xi[..., 2] / 2
    return _pose(sinc(half)[..., None] * rotate(xi[..., :2], half), xi[..., 2])


def log(pose: ArrayLike) -> Array:
    """The twist (times its duration) whose arc leads to a pose, by the shorter turn: exp's inverse.

    Args:
        pose: (..., 3) [m, m, rad].

    Returns:
        (..., 3): forward [m], left [m], angle in (-pi, pi] [rad].
    """
    pose = array("pose", pose, 3)
    theta = wrap_angle(pose[..., 2])
    half = theta / 2
    return _pose(rotate(pose[..., :2], -half) / sinc(half)[..., None], theta)
