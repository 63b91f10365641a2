"""A path on the floor as few straight pieces: what is drawn of thousands of steps."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

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
    while waiting and len(kept) <= _MOST:
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


@dataclass(frozen=True, eq=False)
class Piece:
    """A flat box along a straight line: its centre (3,), half of its sides (3,), and its axes (9,), row by row."""

    centre: Array
    half: Array
    axes: Array


def piece(start: Array, end: Array, width: float, height: float) -> Piece:
    """The piece from one place on the floor (2,) to another [m]; it is a little longer, so that bends are closed."""
    along = end - start
    length = float(np.hypot(*along))
    c, s = along / length if length else (1.0, 0.0)
    half = np.array([length / 2 + 0.3 * width, width / 2, height])
    return Piece(np.array([*(start + end) / 2, 0.0]), half, np.array([c, -s, 0, s, c, 0, 0, 0, 1.0]))


def pieces(points: Array, width: float, height: float) -> list[Piece]:
    """The pieces between points (N, 2).

    Every other one is a little higher, so that their ends do not shimmer through each other.
    """
    return [
        piece(start, end, width, height * (1 + 0.06 * (k % 2)))
        for k, (start, end) in enumerate(itertools.pairwise(points))
    ]
