"""Reading a recording between its samples."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from diffdrive_mj._checks import Array


def bracket(t: Array, instants: Array) -> tuple[NDArray[np.intp], Array]:
    """The sample before each instant, and what part of the way to the next sample has passed: 0 to 1.

    A recorded time, up to rounding, is that sample: rounding must not move an angle across an encoder's edge.
    """
    before = np.clip(np.searchsorted(t, instants, side="right") - 1, 0, len(t) - 2)
    part = (instants - t[before]) / (t[before + 1] - t[before])
    near = np.round(part)
    return before, np.where(np.abs(part - near) < 1e-6, near, part)
