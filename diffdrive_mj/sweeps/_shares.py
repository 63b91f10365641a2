"""Shares of all the values of a distribution."""

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
