"""One rule for the clocks of all logs.

Times must increase. A sample that repeats the one before it, time and values, is dropped and counted. Two samples of
one time that differ, and a clock that goes back, are refused: nobody knows which of the two is right. An interval of
more than five typical ones, the median's, is a gap: it is reported, and nothing is compared between its ends.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from diffdrive_mj._checks import Array
from diffdrive_mj.errors import InvalidValue

Mask = NDArray[np.bool_]
# How many median intervals a gap is longer than.
GAP = 5.0
# In the year 2286: later times are not in seconds.
_LATEST = 1e10


def kept(t: Array, groups: Sequence[tuple[Array, Mask | None]], at: Callable[[int], str]) -> Mask | None:
    """Which samples count (N,), as the rule says; None if all do.

    Args:
        t: times (N,) [s].
        groups: values (M, K) of those M samples that have them, and which these are (N,); None for all.
        at: how messages call a sample.

    Raises:
        InvalidValue: a time that is not later than the one before it.
    """
    step = np.diff(t)
    late = np.flatnonzero(step <= 0)
    if not late.size:
        return None
    repeated = step[late] == 0
    for values, there in groups:
        has = np.ones(len(t), dtype=np.bool_) if there is None else there
        row = np.cumsum(has) - 1
        both = has[late] & has[late + 1]
        repeated &= has[late] == has[late + 1]
        repeated[both] &= (values[row[late[both]]] == values[row[late[both] + 1]]).all(axis=-1)
    if not repeated.all():
        k = int(late[np.argmin(repeated)])
        twice = "" if step[k] else "; only a sample that repeats the one before it in everything is dropped"
        raise InvalidValue(f"{at(k + 1)}: {t[k + 1]:.16g} s after {t[k]:.16g} s: times must increase{twice}")
    result = np.ones(len(t), dtype=np.bool_)
    result[late + 1] = False
    return result


def settled(
    name: str, what: str, t: Array, values: Array, at: Callable[[int], str], least: int = 2
) -> tuple[Array, Array, tuple[str, ...]]:
    """Times and values without repeats, and what to know of the times.

    Args:
        name: of the log and what was sampled in it, for messages.
        what: was sampled, for what there is to know of a log that has a name.
        t: times (N,) [s].
        values: (N, K).
        at: how messages call a sample.
        least: how many must be left.

    Raises:
        InvalidValue: a time that is not later than the one before it, or too few.
    """
    counts = kept(t, [(values, None)], at)
    dropped = 0
    if counts is not None:
        t, values, dropped = t[counts], values[counts], int(np.count_nonzero(~counts))
    if len(t) < least:
        raise InvalidValue(f"{name}: {len(t)} samples: must be at least {('none', 'one', 'two')[least]}")
    return t, values, remarks(what, t, dropped)


def gaps(t: Array) -> NDArray[np.intp]:
    """The samples after which there is a gap."""
    step = np.diff(t)
    return np.flatnonzero(step / GAP > np.median(step)) if step.size else np.zeros(0, dtype=np.intp)


def in_gaps(t: Array, instants: Array) -> Mask:
    """Which instants (S,) lie inside a gap, its ends not among them."""
    before = np.clip(np.searchsorted(t, instants, side="right") - 1, 0, len(t) - 2)
    inside = np.isin(before, gaps(t)) & (instants > t[0]) & (instants < t[-1])
    slack = 1e-9 * np.maximum(1.0, np.abs(instants))
    return inside & (instants - t[before] > slack) & (t[before + 1] - instants > slack)


def remarks(what: str, t: Array, dropped: int = 0) -> tuple[str, ...]:
    """What to know of a clock.

    Args:
        what: was sampled.
        t: its times (T,) [s], increasing.
        dropped: how many repeated samples were dropped.
    """
    found = [f"{what}: {dropped} repeated {'sample' if dropped == 1 else 'samples'} dropped"] if dropped else []
    if t.size and t[-1] > _LATEST:
        found.append(f"{what}: times up to {t[-1]:.3g} s: are they in ms, us or ns (time_unit)?")
    after = gaps(t)
    if after.size:
        step = np.diff(t)
        k = int(after[np.argmax(step[after])])
        found.append(
            f"{what}: {after.size} {'gap' if after.size == 1 else 'gaps'}, the longest of {step[k]:.4g} s at "
            f"{t[k]:.16g} s (the median interval is {np.median(step):.4g} s)"
        )
    return tuple(found)
