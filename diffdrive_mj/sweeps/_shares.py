"""Shares of all the values of a distribution, and of all robots."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj.errors import InvalidValue


def shares(share: ArrayLike) -> Array:
    """A float64 array of any shape, all of it from zero to one."""
    result = checks.array("share", share)
    outside = (result < 0) | (result > 1)
    if np.any(outside):
        raise InvalidValue(f"share = {result[outside][0]:g}: must lie between 0 and 1")
    return result


def part(name: str, value: object) -> float:
    """A share of all robots, or a confidence: between zero and one, neither of which it is."""
    result = checks.number(name, value)
    if not 0 < result < 1:
        raise InvalidValue(f"{name} = {result:g}: must be between 0 and 1, as 0.99")
    return result
