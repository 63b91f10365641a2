"""How a number of a robot or its world is spread: each distribution makes a value of a number between zero and one.

A design (`sweeps.designs`) says where in the unit cube each trial lies, one coordinate for each number that varies, and
the distributions say what stands there. The trials of two spreads of one number are thus paired.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj._described import checked, described
from diffdrive_mj.errors import InvalidValue


class Distribution(Protocol):
    """What stands at a share of all the values."""

    def at(self, share: ArrayLike) -> NDArray[np.float64] | NDArray[np.str_]:
        """Return the values (...) at shares (...) of all values, from zero to one: the quantiles."""
        ...


@described()
@dataclass(frozen=True, kw_only=True)
class Normal:
    """Spread a number around a mean, without limits.

    Args:
        mean: in the unit of what varies.
        sigma: standard deviation, in the same unit.

    Raises:
        InvalidValue: a sigma that is not positive, or numbers that are not finite.
        InvalidType: not a number.
        UnknownName: a field that the distribution does not have.

    Example:
        >>> dd.sweeps.Normal(mean=0.1, sigma=0.001).at([0.5, 0.975]).round(5).tolist()
        [0.1, 0.10196]
    """

    mean: float = field(metadata=checked(checks.number))
    sigma: float = field(metadata=checked(checks.positive))

    def at(self, share: ArrayLike) -> Array:
        """Return the quantiles (...) at shares (...) from zero to one."""
        from scipy.special import ndtri

        quantiles: Array = self.mean + self.sigma * ndtri(checks.array("share", share))
        return quantiles


@described()
@dataclass(frozen=True, kw_only=True)
class Uniform:
    """Spread a number evenly between two limits.

    Args:
        low: in the unit of what varies.
        high: in the same unit, above the lower limit.

    Raises:
        InvalidValue: limits in the wrong order, or not finite.
        InvalidType: not a number.
        UnknownName: a field that the distribution does not have.

    Example:
        >>> dd.sweeps.Uniform(low=0.39, high=0.41).at([0.0, 0.5]).round(3).tolist()
        [0.39, 0.4]
    """

    low: float = field(metadata=checked(checks.number))
    high: float = field(metadata=checked(checks.number))

    def __post_init__(self) -> None:
        if self.low >= self.high:
            raise InvalidValue(f"Uniform: low = {self.low:g}, high = {self.high:g}: high must be above low")

    def at(self, share: ArrayLike) -> Array:
        """Return the quantiles (...) at shares (...) from zero to one."""
        return self.low + (self.high - self.low) * checks.array("share", share)
