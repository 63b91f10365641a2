"""Covariance matrices as inputs, and errors measured by them."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj.errors import InvalidValue

# Of correlations: a difference or a negative eigenvalue of this size may be rounding, and an eigenvalue below it has no
# inverse that means anything.
ROUNDING = 1e-5
# A variance that is none: of a nanometre, or of a nanoradian.
NOTHING = 1e-18
# Where x, y and yaw are among x, y, z, roll, pitch and yaw.
IN_PLANE = np.array([0, 1, 5])
# The variance of z, roll and pitch on a floor [m^2, rad^2], with which robot_localization holds them in two_d_mode.
UNSEEN = 1e-6


def covariance(name: str, value: ArrayLike, size: int | None = None) -> Array:
    """Covariances (..., K, K), made exactly symmetric, and not negative; zero ones are allowed.

    Raises:
        InvalidType: not numbers.
        InvalidValue: another shape, or a matrix that is no covariance; the message names the first.
    """
    side: int | str = "K" if size is None else size
    given = checks.array(name, value, side, side)
    if given.shape[-1] != given.shape[-2]:
        raise InvalidValue(f"{name} has shape {given.shape}: must be (..., K, K)")
    variances = np.diagonal(given, axis1=-2, axis2=-1)
    if (at := _first(np.any(variances < 0, axis=-1))) is not None:
        k = int(np.argmax(variances[at] < 0))
        raise InvalidValue(f"{_named(name, at)}: variance {k} is {variances[at][k]:g}: must not be negative")
    scale = np.sqrt(variances[..., :, None] * variances[..., None, :])
    apart = np.abs(given - np.swapaxes(given, -1, -2))
    if (at := _first(np.any(apart > ROUNDING * scale + NOTHING, axis=(-2, -1)))) is not None:
        i, j = (int(k) for k in np.unravel_index(np.argmax(apart[at] - ROUNDING * scale[at]), apart[at].shape))
        raise InvalidValue(
            f"{_named(name, at)}: [{i}, {j}] is {given[at][i, j]:g} and [{j}, {i}] is {given[at][j, i]:g}: must be "
            "symmetric"
        )
    beyond = np.any(np.abs(given) > scale * (1 + ROUNDING) + NOTHING, axis=(-2, -1))
    if (at := _first((least_eigenvalue(given) < -ROUNDING) | beyond)) is not None:
        raise InvalidValue(f"{_named(name, at)}: must be positive, and correlations at most 1 in size")
    return np.asarray((given + np.swapaxes(given, -1, -2)) / 2)


def least_eigenvalue(given: Array) -> Array:
    """The least eigenvalue (...) of the correlations of covariances (..., K, K); 0 where a variance is nothing."""
    return np.asarray(np.linalg.eigvalsh(_correlations(given))[..., 0])


def squared(errors: Array, given: Array) -> Array:
    """The squared Mahalanobis distances e^T C^-1 e (...) of errors (..., K); NaN where a covariance is singular."""
    deviations = np.sqrt(np.diagonal(given, axis1=-2, axis2=-1))
    singular = least_eigenvalue(given) < ROUNDING
    correlations = np.where(singular[..., None, None], np.eye(given.shape[-1]), _correlations(given))
    scaled = errors / np.where(deviations > 0, deviations, 1.0)
    inverse = np.linalg.inv(correlations)
    found: Array = np.einsum("...i,...ij,...j->...", scaled, inverse, scaled)
    return np.where(singular, np.nan, found)


def in_plane(whole: Array) -> Array:
    """The covariance of x, y and yaw (..., 3, 3) of those of poses in space (..., 36), row by row."""
    return whole.reshape(*whole.shape[:-1], 6, 6)[..., IN_PLANE[:, None], IN_PLANE]


def in_space(stated: Array, unseen: float = UNSEEN) -> Array:
    """Covariances of x, y and yaw (..., 3, 3) as those in space (..., 36), with a variance of z, roll and pitch."""
    result = np.zeros((*stated.shape[:-2], 6, 6))
    result[..., [2, 3, 4], [2, 3, 4]] = unseen
    result[..., IN_PLANE[:, None], IN_PLANE] = stated
    return result.reshape(*stated.shape[:-2], 36)


def _correlations(given: Array) -> Array:
    """Correlations (..., K, K): zero rows and columns where a variance is nothing."""
    variances = np.diagonal(given, axis1=-2, axis2=-1)
    inverse = np.where(variances > NOTHING, 1 / np.sqrt(np.maximum(variances, NOTHING)), 0.0)
    return np.asarray(given * inverse[..., :, None] * inverse[..., None, :])


def _first(bad: Array) -> tuple[int, ...] | None:
    """The index of the first bad one; None if there is none."""
    return tuple(int(k) for k in np.argwhere(bad)[0]) if np.any(bad) else None


def _named(name: str, at: tuple[int, ...]) -> str:
    return f"{name}[{', '.join(map(str, at))}]" if at else name
