"""Reading a recording between its samples."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from diffdrive_mj import se2
from diffdrive_mj._checks import Array


def due(duration: float, rate: float, early: float = 0.0, late: float = 0.0) -> Array:
    """The whole numbers k for which k / rate lies in a recording, `early` off its start and `late` off its end [s]."""
    # The slack keeps what is due at the first or the last recorded time, up to rounding.
    first = math.ceil(early * rate - 1e-9)
    last = math.floor((duration - late) * rate + 1e-9)
    return np.arange(first, last + 1, dtype=np.float64)


def bracket(t: Array, instants: Array) -> tuple[NDArray[np.intp], Array]:
    """The sample before each instant, and what part of the way to the next sample has passed: 0 to 1.

    A recorded time, up to rounding, is that sample: rounding must not move an angle across an encoder's edge.
    """
    before = np.clip(np.searchsorted(t, instants, side="right") - 1, 0, len(t) - 2)
    part = (instants - t[before]) / (t[before + 1] - t[before])
    near = np.round(part)
    return before, np.where(np.abs(part - near) < 1e-6, near, part)


def interpolated(t: Array, angles: Array, instants: Array) -> Array:
    """Angles (..., T, 2) at the instants (S,), or (..., S) for each run: (..., S, 2); they change evenly in between."""
    sample, part = bracket(t, instants)
    part = part[..., None]
    if instants.ndim == 1:
        before, after = angles[..., sample, :], angles[..., sample + 1, :]
    else:
        before, after = (np.take_along_axis(angles, at[..., None], axis=-2) for at in (sample, sample + 1))
    return np.where(part == 1, after, before + (after - before) * part)


def poses_between(t: Array, poses: Array, instants: Array) -> Array:
    """Poses (..., M, 3) at the instants, on the arcs through the recorded ones."""
    before, part = bracket(t, instants)
    start, end = poses[..., before, :], poses[..., before + 1, :]
    arc = se2.exp(part[:, None] * se2.log(se2.between(start, end)))
    return np.where(part[:, None] == 1, end, se2.compose(start, arc))
