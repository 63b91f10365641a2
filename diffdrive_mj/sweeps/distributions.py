"""How a number of a robot or its world is spread: each distribution makes a value of a number between zero and one.

A design (`sweeps.designs`) says where in the unit cube each trial lies, one coordinate for each number that varies, and
the distributions say what stands there. The trials of two spreads of one number are thus paired.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj._described import checked, described, described_as
from diffdrive_mj._text import shown
from diffdrive_mj.errors import InvalidType, InvalidValue
from diffdrive_mj.sweeps._shares import shares
from diffdrive_mj.sweeps.choices import Choice, Grid


@runtime_checkable
class Distribution(Protocol):
    """What stands at a share of all the values.

    Example:
        Whatever has the method is one, as a table of measured radii:

        >>> class Measured:
        ...     def at(self, share):
        ...         return np.quantile([0.0329, 0.0330, 0.0332], share)
        >>> isinstance(Measured(), Distribution)
        True
    """

    def at(self, share: ArrayLike) -> NDArray[Any]:
        """Return the values (...) at shares (...) of all values, from zero to one: the quantiles."""
        ...


@runtime_checkable
class Spread(Distribution, Protocol):
    """A distribution over a whole range of numbers, which has a density and can be made narrower.

    Example:
        >>> Normal(mean=1.0, sigma=0.1).scaled(0.5)
        Normal(mean=1.0, sigma=0.05)
    """

    def density(self, values: ArrayLike) -> Array:
        """Return how dense the numbers are (...) at values (...), per unit of what varies."""
        ...

    def scaled(self, factor: float) -> Spread:
        """Return the distribution that is as many times as wide, about the same centre."""
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
        return self.mean + self.sigma * _standard(share)

    def density(self, values: ArrayLike) -> Array:
        """Return the density (...) at values (...), per unit of what varies."""
        return _bell((checks.array("values", values) - self.mean) / self.sigma) / self.sigma

    def scaled(self, factor: float) -> Normal:
        """Return the distribution with its sigma scaled, about the same mean."""
        return Normal(mean=self.mean, sigma=self.sigma * checks.positive("factor", factor))


@described()
@dataclass(frozen=True, kw_only=True)
class LogNormal:
    """Spread a positive number by factors: its logarithm is normal, as that of friction or of a load.

    Args:
        median: in the unit of what varies; half of the values lie below.
        sigma: standard deviation of the natural logarithm; 0.1 is about 10 % to either side.

    Raises:
        InvalidValue: a number that is not positive, or not finite.
        InvalidType: not a number.
        UnknownName: a field that the distribution does not have.

    Example:
        >>> dd.sweeps.LogNormal(median=0.6, sigma=0.1).at([0.025, 0.5, 0.975]).round(3).tolist()
        [0.493, 0.6, 0.73]
    """

    median: float = field(metadata=checked(checks.positive))
    sigma: float = field(metadata=checked(checks.positive))

    def at(self, share: ArrayLike) -> Array:
        """Return the quantiles (...) at shares (...) from zero to one."""
        return np.asarray(self.median * np.exp(self.sigma * _standard(share)))

    def density(self, values: ArrayLike) -> Array:
        """Return the density (...) at values (...), per unit of what varies; zero where they are not positive."""
        given = checks.array("values", values)
        safe = np.where(given > 0, given, self.median)
        bell = _bell(np.log(safe / self.median) / self.sigma) / (self.sigma * safe)
        return np.where(given > 0, bell, 0.0)

    def scaled(self, factor: float) -> LogNormal:
        """Return the distribution with its sigma scaled, about the same median."""
        return LogNormal(median=self.median, sigma=self.sigma * checks.positive("factor", factor))


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
        return self.low + (self.high - self.low) * shares(share)

    def density(self, values: ArrayLike) -> Array:
        """Return the density (...) at values (...), per unit of what varies; zero beyond the limits."""
        given = checks.array("values", values)
        return np.where((self.low <= given) & (given <= self.high), 1 / (self.high - self.low), 0.0)

    def scaled(self, factor: float) -> Uniform:
        """Return the distribution with its width scaled, about the same middle."""
        middle, half = (self.low + self.high) / 2, (self.high - self.low) / 2 * checks.positive("factor", factor)
        return Uniform(low=middle - half, high=middle + half)


# What a study's file calls them.
DISTRIBUTIONS: dict[str, type[Distribution]] = {
    "normal": Normal,
    "lognormal": LogNormal,
    "uniform": Uniform,
    "choice": Choice,
    "grid": Grid,
}


def distribution(name: str, value: object) -> Distribution:
    """Return a distribution as it is, or that of a mapping of its fields and its kind.

    Args:
        name: how the message calls it.
        value: a distribution; or a mapping with `distribution`, its name in `DISTRIBUTIONS`, beside its fields.

    Raises:
        InvalidType: neither of the two.
        UnknownName: another distribution, or a field that it does not have.
        InvalidValue: a field that is out of its range.

    Example:
        >>> distribution("width", {"distribution": "uniform", "low": 0.0, "high": 1.0})
        Uniform(low=0.0, high=1.0)
    """
    if isinstance(value, Mapping) and "distribution" in value:
        kind = checks.one_of(f"distribution of {name}", value["distribution"], DISTRIBUTIONS)
        return described_as(kind, name, {key: item for key, item in value.items() if key != "distribution"})
    if isinstance(value, Distribution) and not isinstance(value, type):
        return value
    example = 'Normal(mean=..., sigma=...), in a file { distribution = "normal", mean = ..., sigma = ... }'
    raise InvalidType(f"{name} = {shown(value)}: must be a distribution of dd.sweeps, such as {example}")


def _standard(share: ArrayLike) -> Array:
    """The quantiles of the standard normal distribution."""
    from scipy.special import ndtri

    return np.asarray(ndtri(shares(share)))


def _bell(z: Array) -> Array:
    """The density of the standard normal distribution."""
    return np.asarray(np.exp(-0.5 * z**2) / math.sqrt(2 * math.pi))
