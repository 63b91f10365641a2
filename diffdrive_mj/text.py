"""How results read in print."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike


def span(value: ArrayLike, unit: str, scale: float = 1.0) -> str:
    """One number to four digits, or the range of many."""
    low, high = (f"{scale * extreme:.4g}" for extreme in (np.min(value), np.max(value)))
    return f"{low} {unit}" if low == high else f"{low} to {high} {unit}"
