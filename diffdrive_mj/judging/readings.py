"""The law for readings: which of them count, what a pose is where one does not, and how wraps of counters are undone.

A reading counts if its time and both its wheels are finite, and its time is later than that of the last reading that
counts. One that does not count holds the pose and is not taken in: the next one that counts takes the whole motion
since the last one that did. The pose at the first reading that counts is the start, and before it too.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from diffdrive_mj._checks import Array
from diffdrive_mj.errors import InvalidValue

Mask = NDArray[np.bool_]


def counting(t: ArrayLike, wheels: ArrayLike) -> Mask:
    """Say which readings count.

    Args:
        t: times (T,) [s].
        wheels: (T, 2), left then right, in any unit; NaN where nothing was read.

    Returns:
        (T,), True where a reading counts.

    Raises:
        InvalidValue: none does.

    Example:
        >>> counting([0.0, 0.1, 0.1, 0.05, 0.2], [(0, 0), (1, 1), (2, 2), (3, 3), (np.nan, 4)]).tolist()
        [True, True, False, False, False]
    """
    times = np.asarray(t, dtype=np.float64)
    whole = np.isfinite(times) & np.isfinite(np.asarray(wheels, dtype=np.float64)).all(axis=-1)
    latest = np.maximum.accumulate(np.where(whole, times, -np.inf))
    counts: Mask = whole & (times > np.concatenate([[-np.inf], latest[:-1]]))
    if not counts.any():
        raise InvalidValue("no reading has a time and both wheels")
    return counts


def held(poses: Array, counts: Mask) -> Array:
    """Hold the pose where a reading does not count.

    Args:
        poses: (K, 3), one for each reading that counts; the first is the start.
        counts: (T,), which readings these are.

    Returns:
        (T, 3).

    Example:
        >>> held(np.array([(0.0, 0, 0), (1.0, 0, 0)]), np.array([False, True, False, True]))[:, 0].tolist()
        [0.0, 0.0, 0.0, 1.0]
    """
    return poses[np.maximum(np.cumsum(counts) - 1, 0)]


def unwrapped(wheels: ArrayLike, counts: Mask, bits: int | None) -> Array:
    """Count on from the first reading that counts: of all steps that fit, the shortest.

    Args:
        wheels: (T, 2) as read, in any unit; ticks if they wrap.
        counts: (T,), which readings count.
        bits: of the counters; None if they do not wrap.

    Returns:
        (T, 2), zero at the first reading that counts; each reading is as far from the last that counts before it as the
        step between them says.

    Example:
        >>> unwrapped([(32760, 3), (-32760, 5)], np.array([True, True]), 16).tolist()
        [[0.0, 0.0], [16.0, 2.0]]
    """
    read = np.asarray(wheels, dtype=np.float64)
    index = np.flatnonzero(counts)
    since = index[np.maximum(np.cumsum(counts) - 1 - counts, 0)]  # the last that counts before each reading
    steps = shortest(read - read[since], bits)
    total = np.zeros_like(read)
    total[index[1:]] = np.cumsum(steps[index[1:]], axis=0)
    return np.where(counts[:, None], total, total[since] + steps)


def shortest(steps: Array, bits: int | None) -> Array:
    """Take steps of counters for the shortest that fit.

    Args:
        steps: differences of counts (...).
        bits: of the counters; None if they do not wrap.

    Returns:
        (...), in [-2^(bits - 1), 2^(bits - 1)).

    Example:
        >>> shortest(np.array([65530.0, -32768.0, 32768.0]), 16).tolist()
        [-6.0, -32768.0, -32768.0]
    """
    if bits is None:
        return steps
    half = 2.0 ** (bits - 1)
    return (steps + half) % (2 * half) - half
