"""Branch and bound: the largest value of a function over boxes, between a proven bound and a value that it takes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from diffdrive_mj._checks import Array

# How many boxes are halved at once: many share the cost of a call, few waste none on boxes that are soon ruled out.
_AT_ONCE = 16


@dataclass(frozen=True, eq=False)
class Enclosures:
    """What is known of a function over each of N boxes of P coordinates.

    Attributes:
        upper: no value in the box exceeds it (N,).
        hint: where in the box the function may be largest (N, P).
        bend: how much each coordinate's width loosens the bound (N, P): the largest is halved.
    """

    upper: Array
    hint: Array
    bend: Array

    def of(self, which: NDArray[np.bool_]) -> Enclosures:
        """Those of some of the boxes."""
        return Enclosures(self.upper[which], self.hint[which], self.bend[which])

    def with_more(self, other: Enclosures) -> Enclosures:
        """These, then others."""
        pairs = ((self.upper, other.upper), (self.hint, other.hint), (self.bend, other.bend))
        return Enclosures(*(np.concatenate(pair) for pair in pairs))


@dataclass(frozen=True, eq=False)
class Maximum:
    """The largest value of a function over boxes.

    Attributes:
        upper: no value exceeds it.
        found: the largest value that was found.
        where: there (P,).
        boxes: how many boxes were looked at.
    """

    upper: float
    found: float
    where: Array
    boxes: int


def maximum(
    enclose: Callable[[Array], Enclosures],
    value: Callable[[Array], Array],
    boxes: Array,
    *,
    relative: float,
    absolute: float,
    most: int,
) -> Maximum:
    """Halve the boxes with the largest bounds until the bound and a value found are close.

    Args:
        enclose: bounds over boxes (N, 2, P), from the lower corner to the upper one.
        value: the function at points (N, P): (N,).
        boxes: the first ones (N, 2, P); the maximum is sought in their union.
        relative: how far the bound may lie above the value found, as a part of it.
        absolute: and in the function's unit.
        most: how many boxes to look at; beyond, the bound stays as it is, and holds.
    """
    found, where, count, settled = -np.inf, boxes[0, 0], 0, -np.inf
    fresh, above = boxes, np.full(len(boxes), np.inf)
    left, known = boxes[:0], Enclosures(*(np.empty((0, *shape)) for shape in ((), boxes.shape[2:], boxes.shape[2:])))
    while len(fresh):
        inside = enclose(fresh)
        inside = Enclosures(np.minimum(inside.upper, above), inside.hint, inside.bend)
        count += len(fresh)
        best = np.argsort(-inside.upper)[: _AT_ONCE // 2]
        points = np.concatenate([inside.hint[best], fresh[best].mean(axis=1)])
        values = value(points)
        if values.max() > found:
            found, where = float(values.max()), points[values.argmax()]
        left, known = np.concatenate([left, fresh]), known.with_more(inside)
        loose = known.upper > found + max(relative * found, absolute)
        settled = max(settled, known.upper[~loose].max(initial=-np.inf))
        left, known = left[loose], known.of(loose)
        if count >= most:
            break
        largest = np.zeros(len(left), dtype=bool)
        largest[np.argsort(-known.upper)[:_AT_ONCE]] = True
        fresh, above = _halves(left[largest], known.bend[largest]), np.repeat(known.upper[largest], 2)
        left, known = left[~largest], known.of(~largest)
    return Maximum(float(max(settled, known.upper.max(initial=-np.inf))), found, where, count)


def _halves(boxes: Array, bend: Array) -> Array:
    """Each box as two, cut across where it bends the function most: they share the cut, and nothing is left out."""
    across: NDArray[np.intp] = bend.argmax(axis=1)
    halves = np.repeat(boxes, 2, axis=0)
    each = np.arange(len(boxes))
    middle = boxes[each, :, across].mean(axis=1)
    halves[2 * each, 1, across] = middle
    halves[2 * each + 1, 0, across] = middle
    return halves
