"""Counters of encoder ticks: what a counter of 16 or 32 bits shows, and how its wraps are undone.

One rule for encoders and for files. A counter of n bits is signed, -2^(n - 1) to 2^(n - 1) - 1, or unsigned, 0 to
2^n - 1: what it shows must fit one of the two ranges as a whole. Either way a step is taken for the shortest that fits,
which is right as long as the wheel moves by less than half of the range, 2^(n - 1) ticks, between two readings; a step
of exactly half of it could go both ways and is refused.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj._text import shown
from diffdrive_mj.errors import InvalidValue

Counts = NDArray[np.int64]
Name = Callable[[tuple[int, ...]], str]


def counts_at(where: tuple[int, ...]) -> str:
    """How messages call one count, by its index (..., reading, wheel)."""
    run = f"run {list(where[:-2])}, " if len(where) > 2 else ""
    return f"counts: {run}{('left', 'right')[where[-1]]} at reading {where[-2]}"


def held_at_first(phase: ArrayLike, count: int = 2) -> Array:
    """What some counters hold at first (..., count), of one number for all or of one each."""
    held = checks.array("phase", phase)
    return np.full(count, held) if held.ndim == 0 else checks.array("phase", held, count)


def wrap_counts(counts: ArrayLike, bits: int | None) -> Counts:
    """What a signed counter of some bits shows: the remainder in [-2^(bits - 1), 2^(bits - 1)).

    Args:
        counts: (..., T, 2) [ticks].
        bits: None, which changes nothing, or 16 or 32.

    Raises:
        InvalidValue: a wheel moves by half of the range or more between two readings, so that `unwrap_counts` could
            not undo the wrap.
    """
    whole = whole_counts(counts)
    check_bits("bits", bits)
    if bits is None:
        return whole
    half = 1 << (bits - 1)
    why = f"a counter of {bits} bits shows a jump only below {half} ticks; read it more often"
    _refuse_jumps(np.diff(whole, axis=-2), half - 1, why, counts_at)
    return (whole + half) % (2 * half) - half


def unwrap_counts(
    counts: ArrayLike, bits: int | None, max_step: int | None = None, *, name: Name = counts_at
) -> Counts:
    """Undo the wraps of counters, forwards and backwards: of all steps that fit, the shortest.

    A step of more than half of the range looks like a shorter one the other way. Two kinds are detected: one of exactly
    half of the range, which has no shortest way, and one above what the wheel can do, if that is known.

    Args:
        counts: (..., T, 2) [ticks], as read; signed or not.
        bits: of the counters, 16 or 32, or None if they do not wrap.
        max_step: how many ticks a wheel can do between two readings.
        name: what messages call the count at an index.

    Returns:
        (..., T, 2) [ticks], from the first reading on.

    Raises:
        InvalidValue: counts that do not fit in the bits, steps that are detected, a `max_step` of half of the range
            or more.
        InvalidType: counts that are not numbers.
    """
    read = whole_counts(counts, name)
    check_bits("bits", bits)
    most = None if max_step is None else math.floor(checks.positive("max_step", max_step))
    steps = np.diff(read, axis=-2)
    if bits is not None:
        half = 1 << (bits - 1)
        if most is not None and most >= half:
            raise InvalidValue(
                f"max_step = {most} ticks: must be below {half}, half of the range of {bits} bits, or a jump cannot be "
                f"told from a wrap; read more often"
            )
        _refuse_misfits(read, bits, name)
        steps = (steps + half) % (2 * half) - half
        why = f"exactly half of the range of {bits} bits is forwards as well as backwards"
        _refuse_jumps(steps, half - 1, why, name)
    if most is not None:
        _refuse_jumps(steps, most, f"must be at most max_step = {most}", name)
    return summed(read, steps)


def summed(counts: Counts, steps: Counts) -> Counts:
    """Counts (..., T, 2) from the first of them on, by steps (..., T - 1, 2)."""
    return np.cumsum(np.concatenate([counts[..., :1, :], steps], axis=-2), axis=-2)


def check_bits(name: str, bits: object) -> None:
    """Refuse a width that no counter has."""
    if type(bits) not in (int, type(None)) or bits not in (None, 16, 32):
        raise InvalidValue(f"{name} = {shown(bits)}: must be None, 16 or 32")


def ticks_at(angles: Array, tick_angle: float, phase: Array) -> Array:
    """What counters (..., 2) show at wheel angles [rad], in whole ticks."""
    return np.floor(angles / tick_angle + phase)


def whole_counts(counts: ArrayLike, name: Name = counts_at) -> Counts:
    """Counts (..., T, 2) as integers."""
    values = checks.array("counts", counts, "T", 2)
    # Beyond 2^53 neighbouring counts are one floating point number.
    for bad, why in ((np.floor(values) != values, "whole"), (np.abs(values) > 2**53, "at most 2^53 in size")):
        if bad.any():
            where = _first(bad)
            raise InvalidValue(f"{name(where)}: {values[where]:.17g} must be {why}")
    return np.asarray(counts).astype(np.int64)


def _refuse_misfits(counts: Counts, bits: int, name: Name) -> None:
    """Raise if the counts fit neither a signed nor an unsigned counter, and say where."""
    half, low = 1 << (bits - 1), int(counts.min())
    too_high = counts >= (half if low < 0 else 2 * half)
    if low < -half or too_high.any():
        where = _first(counts < -half if low < -half else too_high)
        beside = f" beside {low}" if low < 0 and counts[where] != low else ""
        raise InvalidValue(
            f"{name(where)}: {counts[where]}{beside} does not fit in {bits} bits, which are signed, {-half} to "
            f"{half - 1}, or unsigned, 0 to {2 * half - 1}"
        )


def _refuse_jumps(steps: Counts, most: int, why: str, name: Name) -> None:
    """Raise if steps (..., T - 1, 2) are longer than `most`, and say where."""
    far = np.abs(steps) > most
    if far.any():
        where = _first(far)
        after = (*where[:-2], where[-2] + 1, where[-1])
        raise InvalidValue(f"{name(after)} jumps by {steps[where]} ticks: {why}")


def _first(found: NDArray[np.bool_]) -> tuple[int, ...]:
    return tuple(int(i) for i in np.argwhere(found)[0])
