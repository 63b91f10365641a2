"""Counters of encoder ticks: what a counter of 16 or 32 bits shows, and how its wraps are undone."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from diffdrive_mj import _checks as checks
from diffdrive_mj.errors import InvalidValue

Counts = NDArray[np.int64]
WHEELS = ("left", "right")


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
    refuse_jumps(
        np.diff(whole, axis=-2),
        half - 1,
        f"a counter of {bits} bits tells a jump from a wrap only below {half} ticks; read it more often",
    )
    return (whole + half) % (2 * half) - half


def unwrap_counts(counts: ArrayLike, bits: int | None, max_step: int | None = None) -> Counts:
    """Undo the wraps of counters, forwards and backwards: of all jumps that fit, the shortest.

    A jump of more than half the range looks like a shorter one the other way. Two kinds are found out: one of exactly
    half the range, which has no shortest way, and one above what the wheel can do, if that is known.

    Args:
        counts: (..., T, 2) [ticks], as read; signed or not.
        bits: of the counters, 16 or 32, or None if they do not wrap.
        max_step: how many ticks a wheel can do between two readings.

    Returns:
        (..., T, 2) [ticks], from the first reading on.

    Raises:
        InvalidValue: counts that do not fit into the bits, jumps that are found out, a `max_step` of half the range
            or more.
        InvalidType: counts that are no numbers.
    """
    read = whole_counts(counts)
    check_bits("bits", bits)
    most = None if max_step is None else math.floor(checks.positive("max_step", max_step))
    steps = np.diff(read, axis=-2)
    if bits is not None:
        half = 1 << (bits - 1)
        low, high = int(read.min()), int(read.max())
        if not (-half <= low <= high < half or 0 <= low <= high < 2 * half):
            raise InvalidValue(f"counts from {low} to {high}: must fit into {bits} bits")
        if most is not None and most >= half:
            raise InvalidValue(
                f"max_step = {most} ticks: must be below {half}, half the range of {bits} bits, or a jump cannot be "
                f"told from a wrap; read more often"
            )
        steps = (steps + half) % (2 * half) - half
        refuse_jumps(steps, half - 1, f"exactly half the range of {bits} bits is forwards as well as backwards")
    if most is not None:
        refuse_jumps(steps, most, f"must be at most max_step = {most}")
    return summed(read, steps)


def summed(counts: Counts, steps: Counts) -> Counts:
    """Counts (..., T, 2) from the first of them on, by steps (..., T - 1, 2)."""
    return np.cumsum(np.concatenate([counts[..., :1, :], steps], axis=-2), axis=-2)


def refuse_jumps(steps: Counts, most: int, why: str) -> None:
    """Raise if steps (..., T - 1, 2) are longer than `most`, and say where."""
    far = np.abs(steps) > most
    if far.any():
        where = tuple(int(i) for i in np.argwhere(far)[0])
        run = f"run {list(where[:-2])}, " if len(where) > 2 else ""
        raise InvalidValue(
            f"counts: {run}{WHEELS[where[-1]]} jumps by {steps[where]} ticks at reading {where[-2] + 1}: {why}"
        )


def check_bits(name: str, bits: object) -> None:
    """Refuse a width that no counter has."""
    if isinstance(bits, float) or bits not in (None, 16, 32):
        raise InvalidValue(f"{name} = {bits!r}: must be None, 16 or 32")


def whole_counts(counts: ArrayLike) -> Counts:
    """Counts (..., T, 2) as integers."""
    values = checks.array("counts", counts, "T", 2)
    # Beyond 2^53 neighbouring counts are one floating point number.
    for bad, why in ((np.floor(values) != values, "whole"), (np.abs(values) > 2**53, "at most 2^53 in size")):
        if bad.any():
            raise InvalidValue(f"counts = {values[bad][0]:.17g}: must be {why}")
    return np.asarray(counts).astype(np.int64)
