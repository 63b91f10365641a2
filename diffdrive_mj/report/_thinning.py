"""Which samples of some curves are worth keeping."""

from __future__ import annotations

import heapq

import numpy as np
from numpy.typing import NDArray

from diffdrive_mj._checks import Array

# More samples than these are thinned evenly first, so that a recording of hours takes no longer.
_EVENLY = 20_000


def kept(t: Array, curves: Array, tolerances: Array, most: int) -> NDArray[np.intp]:
    """The samples between which straight lines stay within the tolerances of all curves; `most` of them at most.

    The interval that is farthest off is split at its worst sample until none is off: Ramer, Douglas and Peucker's way,
    worst first, so that what a limit leaves out matters least.

    Args:
        t: (T,), increasing.
        curves: (C, T).
        tolerances: (C,), positive.
        most: at least 2.

    Returns:
        Their indices, the first and the last sample among them.
    """
    even = np.unique(np.linspace(0, len(t) - 1, min(len(t), _EVENLY)).round().astype(np.intp))
    times, scaled = t[even], curves[:, even] / tolerances[:, None]
    chosen = {0, len(even) - 1}
    waiting = [_worst(times, scaled, 0, len(even) - 1)]
    while waiting and len(chosen) < most:
        off, first, at, last = heapq.heappop(waiting)
        if -off <= 1.0:
            break
        chosen.add(at)
        for part in ((first, at), (at, last)):
            heapq.heappush(waiting, _worst(times, scaled, *part))
    return even[sorted(chosen)]


def _worst(t: Array, curves: Array, first: int, last: int) -> tuple[float, int, int, int]:
    """How far, negative, and where a straight line between two samples is farthest off the curves."""
    share = (t[first : last + 1] - t[first]) / (t[last] - t[first])
    ends = curves[:, first, None], curves[:, last, None]
    off = np.abs(ends[0] + (ends[1] - ends[0]) * share - curves[:, first : last + 1]).max(axis=0)
    at = int(off.argmax())
    return -float(off[at]), first, first + at, last
