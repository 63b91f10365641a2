"""SE(2), the rigid motions of the plane: poses and how they compose.

A pose is (x, y, theta) [m, m, rad]. Headings are continuous: composing never wraps them. The exponential
uses the chord, sinc and the half angle, which needs no threshold near a turn of zero.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj._checks import Array, array, broadcast


def sinc(angle: Array) -> Array:
    """Compute sin(angle) / angle, which is 1 at zero.

    numpy's own sinc is normalised by pi.

    Args:
        angle: (...) [rad].

    Returns:
        (...).

    Example:
        >>> dd.se2.sinc(np.array([0.0, np.pi / 2])).round(4).tolist()
        [1.0, 0.6366]
    """
    return np.sinc(array("angle", angle) / np.pi)


def wrap_angle(theta: ArrayLike) -> Array:
    """Return the same direction in (-pi, pi]; an angle that lies there already keeps all its bits.

    Args:
        theta: (...) [rad].

    Returns:
        (...) [rad].

    Example:
        >>> np.degrees(dd.se2.wrap_angle(np.radians([350.0, 180.0, -180.0]))).round(9).tolist()
        [-10.0, 180.0, 180.0]
    """
    # The remainder is exact, and so is adding or taking away the one turn that may be too much.
    turned = np.fmod(array("theta", theta), 2 * np.pi)
    too_much = (turned > np.pi).astype(float) - (turned <= -np.pi)
    return turned - 2 * np.pi * too_much


def unwrapped(poses: ArrayLike) -> Array:
    """Make headings continuous: each differs from the one before by at most half a turn.

    Args:
        poses: (..., T, 3) [m, m, rad], whose headings may be wrapped.

    Returns:
        (..., T, 3), the same poses.

    Example:
        >>> turned = dd.se2.unwrapped([(0.0, 0.0, 3.0), (0.0, 0.0, -3.0)])
        >>> turned[:, 2].round(4).tolist()
        [3.0, 3.2832]
    """
    continuous = array("poses", poses, "T", 3).copy()
    continuous[..., 2] = np.unwrap(continuous[..., 2])
    return continuous


def rotate(points: ArrayLike, theta: ArrayLike) -> Array:
    """Turn points counter-clockwise about the origin.

    Args:
        points: (..., 2) [m].
        theta: (...) [rad].

    Returns:
        (..., 2) [m].

    Example:
        >>> dd.se2.rotate((2.0, 1.0), np.pi / 2).round(9).tolist()
        [-1.0, 2.0]
    """
    points, theta = array("points", points, 2), array("theta", theta)
    result = np.empty((*broadcast(points=points[..., 0], theta=theta), 2))
    x, y, c, s = points[..., 0], points[..., 1], np.cos(theta), np.sin(theta)
    result[..., 0], result[..., 1] = c * x - s * y, s * x + c * y
    return result


def _pose(position: Array, theta: Array) -> Array:
    return np.concatenate([position, np.broadcast_to(theta, position.shape[:-1])[..., None]], axis=-1)


def compose(a: ArrayLike, b: ArrayLike) -> Array:
    """Express pose b, given in the frame of pose a, in the frame that a is given in: the product a b.

    Args:
        a: (..., 3) [m, m, rad].
        b: (..., 3) [m, m, rad], relative to a.

    Returns:
        (..., 3): position a + R(theta_a) b, heading theta_a + theta_b.

    Example:
        A robot at (1, 2) that faces along y drives 3 m ahead:

        >>> dd.se2.compose((1.0, 2.0, np.pi / 2), (3.0, 0.0, 0.0)).round(4).tolist()
        [1.0, 5.0, 1.5708]
    """
    a, b = array("a", a, 3), array("b", b, 3)
    broadcast(a=a[..., 0], b=b[..., 0])
    return _pose(a[..., :2] + rotate(b[..., :2], a[..., 2]), a[..., 2] + b[..., 2])


def inverse(a: ArrayLike) -> Array:
    """Return the pose that undoes a pose: composed with it, it gives the origin.

    Args:
        a: (..., 3) [m, m, rad].

    Returns:
        (..., 3) [m, m, rad].

    Example:
        >>> dd.se2.inverse((1.0, 2.0, np.pi / 2)).round(4).tolist()
        [-2.0, 1.0, -1.5708]
    """
    a = array("a", a, 3)
    return _pose(-rotate(a[..., :2], -a[..., 2]), -a[..., 2])


def between(a: ArrayLike, b: ArrayLike) -> Array:
    """Express pose b relative to pose a: a^-1 b, which composed with a gives b.

    Args:
        a: (..., 3) [m, m, rad].
        b: (..., 3) [m, m, rad], in the same frame as a.

    Returns:
        (..., 3) [m, m, rad].

    Example:
        >>> dd.se2.between((1.0, 2.0, np.pi / 2), (1.0, 5.0, np.pi / 2)).round(9).tolist()
        [3.0, 0.0, 0.0]
    """
    a, b = array("a", a, 3), array("b", b, 3)
    broadcast(a=a[..., 0], b=b[..., 0])
    return _pose(rotate(b[..., :2] - a[..., :2], -a[..., 2]), b[..., 2] - a[..., 2])


def exp(twist_times_dt: ArrayLike) -> Array:
    """Find the pose that a constant twist leads to: an arc.

    ```
    p = sinc(theta / 2) R(theta / 2) (u, w)
    ```

    is the chord along the heading turned by half the angle, for a twist that may also move sideways.

    Args:
        twist_times_dt: (..., 3), distance forward u [m], distance to the left w [m], angle theta [rad].

    Returns:
        (..., 3) [m, m, rad], relative to the start.

    References:
        [ct-Sim]: equations 1.7 and 1.12.

    Example:
        A quarter of a circle of radius 1 m to the left:

        >>> dd.se2.exp((np.pi / 2, 0.0, np.pi / 2)).round(4).tolist()
        [1.0, 1.0, 1.5708]
    """
    xi = array("twist_times_dt", twist_times_dt, 3)
    half = xi[..., 2] / 2
    return _pose(sinc(half)[..., None] * rotate(xi[..., :2], half), xi[..., 2])


def log(pose: ArrayLike) -> Array:
    """Find the twist, times its duration, whose arc leads to a pose by the shorter turn: the inverse of `exp`.

    Args:
        pose: (..., 3) [m, m, rad].

    Returns:
        (..., 3): forward [m], left [m], angle in (-pi, pi] [rad].

    Example:
        >>> dd.se2.log((1.0, 1.0, np.pi / 2)).round(4).tolist()
        [1.5708, 0.0, 1.5708]
    """
    pose = array("pose", pose, 3)
    theta = wrap_angle(pose[..., 2])
    half = theta / 2
    return _pose(rotate(pose[..., :2], -half) / sinc(half)[..., None], theta)
