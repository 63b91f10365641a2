"""A path as few straight pieces: what is drawn of thousands of steps."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from diffdrive_mj._checks import Array

# Pieces of a trail: more cost time, and nobody sees them.
_MOST = 400


def corners(path: Array, tolerance: float) -> NDArray[np.intp]:
    """The indices of those points (T, 2) between which straight pieces leave the path by at most the tolerance.

    A longer path is drawn the more coarsely, so that there are never too many pieces.
    """
    while len(kept := _corners(path, tolerance)) > _MOST:
        tolerance *= 2
    return kept


def _corners(path: Array, tolerance: float) -> NDArray[np.intp]:
    kept = {0, len(path) - 1}
    waiting = [(0, len(path) - 1)]
    while waiting:
        first, last = waiting.pop()
        if last - first < 2:
            continue
        along = path[last] - path[first]
        inner = path[first + 1 : last] - path[first]
        length = float(np.hypot(*along))
        off = np.abs(inner @ (-along[1], along[0])) / length if length > tolerance else np.hypot(*inner.T)
        # Where a path comes back on its own line, its turning point counts too.
        beyond = inner @ along / length if length > tolerance else np.zeros(len(inner))
        off = np.maximum(off, np.maximum(-beyond, beyond - length)) if length > tolerance else off
        if off.max() > tolerance:
            middle = first + 1 + int(off.argmax())
            kept.add(middle)
            waiting += [(first, middle), (middle, last)]
    return np.array(sorted(kept))
