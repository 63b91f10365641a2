"""Truth and estimate, pose by pose."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from diffdrive_mj._checks import Array, array
from diffdrive_mj.errors import InvalidValue


def paired(truth: ArrayLike, estimate: ArrayLike) -> tuple[Array, Array]:
    """Truth and estimate (..., T, 3), checked and broadcast to one shape."""
    truth, estimate = array("truth", truth, "T", 3), array("estimate", estimate, "T", 3)
    if truth.shape[-2] != estimate.shape[-2]:
        raise InvalidValue(
            f"estimate has {estimate.shape[-2]} samples and truth {truth.shape[-2]}: must be the same samples"
        )
    try:
        a, b = np.broadcast_arrays(truth, estimate)
    except ValueError:
        raise InvalidValue(
            f"estimate has shape {estimate.shape}: must broadcast with truth, shape {truth.shape}"
        ) from None
    return a, b


def complex_positions(poses: Array) -> NDArray[np.complex128]:
    """The positions of poses (..., 3) as x + iy (...): turning by an angle is multiplying by exp(i angle)."""
    result = np.empty(poses.shape[:-1], dtype=np.complex128)
    result.real, result.imag = poses[..., 0], poses[..., 1]
    return result
