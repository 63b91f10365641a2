"""Poses in space as poses in the plane, and what that leaves out."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from diffdrive_mj._checks import Array
from diffdrive_mj.errors import InvalidValue

# Beyond which a pose is reported as not planar: the tilt [rad], and the spread of the height [m].
TILT, HEIGHT = np.radians(1.0), 0.01
# A robot that leans further does not stand on its wheels, or its x axis is another.
MOST_TILT = np.radians(45.0)
# A quaternion's norm may be off by rounding; beyond, it is reported, and refused.
ROUNDED, NO_ROTATION = 1e-3, 0.1
_ORDER = "in the order qx qy qz qw"
# Poses at a time, so that memory does not grow with what is computed on the way.
_BLOCK = 1 << 16


def planar(what: str, poses: Array, at: Callable[[int], str]) -> tuple[Array, tuple[str, ...]]:
    """Take x, y and yaw of poses in space.

    Args:
        what: they are, for the warnings.
        poses: (N, 7), x, y, z [m], and the quaternion qx, qy, qz, qw.
        at: how messages call a pose.

    Returns:
        (N, 3) [m, m, rad], the yaw continuous, and what to know of it.

    Raises:
        InvalidValue: a number that is not finite, a quaternion that is no rotation, or a robot that does not stand.
    """
    result = np.empty((len(poses), 3))
    off = tilt = 0.0
    for first in range(0, len(poses), _BLOCK):
        with np.errstate(over="ignore"):  # numbers beyond all sizes, which are refused
            found, norms, tilts = _taken(poses[first : first + _BLOCK], first, at)
        if first:
            found[:, 2] = np.unwrap([result[first - 1, 2], *found[:, 2]])[1:]
        result[first : first + _BLOCK] = found
        off, tilt = max(off, norms), max(tilt, tilts)
    with np.errstate(over="ignore"):
        spread = float(np.ptp(poses[:, 2])) if len(poses) else 0.0
    known = []
    if off > ROUNDED:
        known.append(f"{what}: quaternions are off their norm of 1 by up to {off:.2g}, and were normalised")
    if tilt > TILT or spread > HEIGHT:
        known.append(
            f"{what}: not planar, tilts by up to {np.degrees(tilt):.2g} deg and spreads over {spread:.2g} m in height; "
            "x, y and yaw were taken"
        )
    return result, tuple(known)


def _taken(poses: Array, first: int, at: Callable[[int], str]) -> tuple[Array, float, float]:
    """What a block of poses comes to, which are numbered from a first one on.

    Returns:
        x, y and continuous yaw (N, 3); the most that a quaternion's norm is off 1; the largest tilt [rad].
    """
    finite = np.isfinite(poses).all(axis=1)
    if not finite.all():
        raise InvalidValue(f"{at(first + int(np.argmin(finite)))}: a number of the pose is not finite")
    x, y, z, w = poses[:, 3:].T
    off = np.abs(np.sqrt(x * x + y * y + z * z + w * w) - 1)
    bad = off > NO_ROTATION
    if bad.any():
        k = int(np.argmax(bad))
        numbers = ", ".join(f"{q:g}" for q in poses[k, 3:])
        raise InvalidValue(f"{at(first + k)}: quaternion ({numbers}): must have a norm of 1, {_ORDER}")
    # The body's upward axis, seen along the world's: its cosine does not see the smallest tilts, its sine does.
    tilt = np.arctan2(2 * np.sqrt((x * x + y * y) * (z * z + w * w)), w * w + z * z - x * x - y * y)
    if tilt.max() > MOST_TILT:
        k = int(np.argmax(tilt > MOST_TILT))
        leans = f"the robot leans by {np.degrees(tilt[k]):.0f} deg"
        raise InvalidValue(f"{at(first + k)}: {leans}: z must point up, and quaternions be {_ORDER}")
    # Of any norm.
    yaw = np.arctan2(2 * (w * z + x * y), w * w + x * x - y * y - z * z)
    return np.column_stack([poses[:, :2], np.unwrap(yaw)]), float(off.max()), float(tilt.max())


def spatial(poses: Array) -> Array:
    """Poses (..., 3) as x, y, z [m] and the quaternion qx, qy, qz, qw (..., 7)."""
    result = np.zeros((*poses.shape[:-1], 7))
    result[..., :2] = poses[..., :2]
    result[..., 5], result[..., 6] = np.sin(poses[..., 2] / 2), np.cos(poses[..., 2] / 2)
    return result
