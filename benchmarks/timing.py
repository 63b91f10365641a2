"""Timing pieces of work side by side, so that all of them meet the same machine."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np


def best(*works: Callable[[], object], rounds: int = 15) -> list[float]:
    """The shortest time of each piece of work [s], taken in turns."""
    times = [np.inf] * len(works)
    for _ in range(rounds):
        for i, work in enumerate(works):
            begin = time.perf_counter()
            work()
            times[i] = min(times[i], time.perf_counter() - begin)
    return times
