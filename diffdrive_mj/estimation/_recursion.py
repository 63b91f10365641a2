"""The recursion of the pose's moments from step to step: linear, exact, and no difference of nearly equal numbers.

With the position as a complex number p and its deviation P = p - E p,

    p' = p + e^(i theta) C,    theta' = theta + W

and the noise of a step independent of what was before. The heading is Gaussian, with mean mu and variance S, so that
e = E e^(i theta) = exp(i mu - S / 2). Everything else closes among itself: E p, and of the deviation the means of
P e^(i theta), its conjugate times e^(i theta), P^2, |P|^2 and theta P. The first two of these are multiplied by
a = E e^(iW) in each step, all others are sums.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from diffdrive_mj._checks import Array
from diffdrive_mj.estimation._noisy_step import StepMoments, rule, step_moments
from diffdrive_mj.estimation._placed import Spread, size

Complex = NDArray[np.complex128]
# Steps of how many runs are computed together, and how many in all: what stays in the processor's cache.
_RUNS, _STEPS = 64, 8192


class Arithmetic(NamedTuple):
    """The functions that arrays and single numbers each have of their own."""

    exp: Callable[[Any], Any]
    expm1: Callable[[Any], Any]


NUMBERS = Arithmetic(cmath.exp, math.expm1)
ARRAYS = Arithmetic(np.exp, np.expm1)


class Moments(NamedTuple):
    """The moments of a pose seen from its start: arrays, or single numbers.

    Attributes:
        heading: the mean of theta [rad].
        variance: of theta [rad^2].
        place: the mean of p [m].
        turned: E P e^(i theta) [m].
        turned_back: the same with the conjugate of P [m].
        square: E P^2 [m^2].
        spread: E |P|^2 [m^2].
        with_heading: the covariance of theta and p [m rad].
    """

    heading: Any
    variance: Any
    place: Any
    turned: Any
    turned_back: Any
    square: Any
    spread: Any
    with_heading: Any

    @property
    def seen(self) -> Spread:
        """What of it the pose's mean and covariance take."""
        return Spread(self.place, self.heading, self.square, self.spread, self.with_heading, self.variance)


START = Moments(0.0, 0.0, 0j, 0j, 0j, 0j, 0.0, 0j)


def _added(heading: Any, variance: Any, step: StepMoments, arithmetic: Arithmetic) -> Moments:
    """What a step adds to each of the moments that do not depend on the place, by the heading before it."""
    e = arithmetic.exp(1j * heading - variance / 2)
    ee = e * e
    less = arithmetic.expm1(-variance)  # E e^(2 i theta) = (1 + less) e^2
    a, c = step.turned, step.chord
    return Moments(
        heading=0.0,
        variance=0.0,
        place=e * c,
        turned=ee * (step.chord_turned + less * (step.chord_turned + c * a)),
        turned_back=step.chord_turned_back - less * c.conjugate() * a,
        square=ee * (step.square + less * (step.square + c * c)),
        spread=step.spread - less * size(c),
        with_heading=e * (1j * variance * c + step.chord_turn),
    )


def after(before: Moments, step: StepMoments, turn: float, var_turn: float) -> Moments:
    """The moments after a step, in single numbers."""
    new = _added(before.heading, before.variance, step, NUMBERS)
    c, turned, back = step.chord, before.turned, before.turned_back
    return Moments(
        before.heading + turn,
        before.variance + var_turn,
        before.place + new.place,
        step.turned * turned + new.turned,
        step.turned * back + new.turned_back,
        before.square + 2 * turned * c + new.square,
        before.spread + 2 * (back * c).real + new.spread,
        before.with_heading + new.with_heading,
    )


def along(steps: Array) -> Iterator[tuple[slice, slice, Moments]]:
    """The moments after each step of many runs, some runs and some steps at a time.

    Args:
        steps: (5, R, S), of each step the means of distance and turn, and the variance of the distance, the covariance
            of both and the variance of the turn.

    Yields:
        Which runs, which steps, and the moments after these (runs, steps).
    """
    runs, count = steps.shape[1:]
    for first in range(0, runs, _RUNS):
        some = slice(first, min(first + _RUNS, runs))
        width = some.stop - first
        before = Moments(*(np.full((width, 1), value) for value in START))
        length = max(1, _STEPS // width)
        for begin in range(0, count, length):
            part = slice(begin, min(begin + length, count))
            found = _after_each(before, steps[:, some, part])
            yield some, part, found
            before = Moments(*(value[:, -1:] for value in found))


def _after_each(before: Moments, steps: Array) -> Moments:
    """The moments after each of some steps (5, R, S), with those before the first (R, 1)."""
    distance, turn, var_distance, covariance, var_turn = steps
    fine = rule(float(np.abs(turn).max()), float(var_turn.max()))
    moments = step_moments(distance, turn, var_distance, covariance, var_turn, fine, np.exp)
    heading, heading_before = _summed(before.heading, turn)
    variance, variance_before = _summed(before.variance, var_turn)
    new = _added(heading_before, variance_before, moments, ARRAYS)
    turned, back = _scanned(
        moments.turned, np.stack([new.turned, new.turned_back]), np.stack([before.turned, before.turned_back])
    )
    c = moments.chord
    return Moments(
        heading,
        variance,
        _summed(before.place, new.place)[0],
        turned[:, 1:],
        back[:, 1:],
        _summed(before.square, 2 * turned[:, :-1] * c + new.square)[0],
        _summed(before.spread, 2 * (back[:, :-1] * c).real + new.spread)[0],
        _summed(before.with_heading, new.with_heading)[0],
    )


def _summed(before: Any, added: Any) -> tuple[Any, Any]:
    """Sums along the steps (R, S): after each step, and before it."""
    sums = np.cumsum(np.concatenate([before, added], axis=1), axis=1)
    return sums[:, 1:], sums[:, :-1]


def _scanned(factor: Complex, added: Complex, before: Complex) -> Complex:
    """What x' = a x + y makes of two numbers x (2, R, S + 1), from the first on.

    Steps are put together in blocks that are computed beside each other, each from zero, and then from where the block
    before it ends. No division is needed, so that products may become as small as they like.

    Args:
        factor: a (R, S).
        added: y (2, R, S).
        before: the first x (2, R, 1).
    """
    runs, count = factor.shape
    blocks = max(1, round(math.sqrt(count / runs)))
    length = -(-count // blocks)
    filled = np.ones((runs, blocks * length), dtype=complex)
    filled[:, :count] = factor
    a = np.ascontiguousarray(np.moveaxis(filled.reshape(runs, blocks, length), -1, 0))
    summands = np.zeros((2, runs, blocks * length), dtype=complex)
    summands[..., :count] = added
    y = np.ascontiguousarray(np.moveaxis(summands.reshape(2, runs, blocks, length), -1, 0))
    # The third is what a block multiplies by.
    x = np.empty((length + 1, 3, runs, blocks), dtype=complex)
    x[0, :2], x[0, 2] = 0, 1
    for k in range(length):
        np.multiply(x[k], a[k], out=x[k + 1])
        x[k + 1, :2] += y[k]
    begin = np.empty((2, runs, blocks), dtype=complex)
    begin[..., 0] = before[..., 0]
    for block in range(1, blocks):
        begin[..., block] = x[-1, :2, :, block - 1] + x[-1, 2, :, block - 1] * begin[..., block - 1]
    found = x[1:, :2] + x[1:, 2:] * begin
    return np.concatenate([before, np.moveaxis(found, 0, -1).reshape(2, runs, -1)[..., :count]], axis=-1)
