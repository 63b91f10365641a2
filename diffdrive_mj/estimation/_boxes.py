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
    open_boxes, known = boxes[:0], Enclosures(np.empty(0), np.empty((0, boxes.shape[2])), np.empty((0, boxes.shape[2])))
    fresh, above = boxes, np.full(len(boxes), np.inf)
    while len(fresh):
        inside = enclose(fresh)
        count += len(fresh)
        inside = Enclosures(np.minimum(inside.upper, above), inside.hint, inside.bend)
        best = np.argsort(-inside.upper)[: _AT_ONCE // 2]
        points = np.concatenate([inside.hint[best], fresh[best].mean(axis=1)])
        values = value(points)
        if values.max() > found:
            found, where = float(values.max()), points[values.argmax()]
        open_boxes = np.concatenate([open_boxes, fresh])
        known = Enclosures(*(np.concatenate(pair) for pair in zip(_parts(known), _parts(inside), strict=True)))
        close = known.upper <= found + max(relative * found, absolute)
        settled = max(settled, known.upper[close].max(initial=-np.inf))
        open_boxes, known = open_boxes[~close], Enclosures(*(part[~close] for part in _parts(known)))
        if count >= most:
            break
        next_ones = np.argsort(-known.upper)[:_AT_ONCE]
        fresh, above = _halves(open_boxes[next_ones], known.bend[next_ones]), np.repeat(known.upper[next_ones], 2)
        rest = np.ones(len(open_boxes), dtype=bool)
        rest[next_ones] = False
        open_boxes, known = open_boxes[rest], Enclosures(*(part[rest] for part in _parts(known)))
    return Maximum(float(max(settled, known.upper.max(initial=-np.inf))), found, where, count)


def _parts(known: Enclosures) -> tuple[Array, Array, Array]:
    return known.upper, known.hint, known.bend


def _halves(boxes: Array, bend: Array) -> Array:
    """Each box as two, cut across where it bends the function most: they share the cut, and nothing is left out."""
    across: NDArray[np.intp] = bend.argmax(axis=1)
    halves = np.repeat(boxes, 2, axis=0)
    each = np.arange(len(boxes))
    middle = boxes[each, :, across].mean(axis=1)
    halves[2 * each, 1, across] = middle
    halves[2 * each + 1, 0, across] = middle
    return halves
