"""How far figures of a few random runs stray from what is expected of them: what a bound must allow to chance.

Bounds that follow from these functions hold for any number of runs: few runs are allowed much, many little. Chance
alone breaks one of them once in a million times (`ODDS`), whatever the seed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj.report.experiment import Bound

ODDS = 1e-6
# Standard deviations that a normal figure exceeds with these odds.
SIGMAS = float(-special.ndtri(ODDS / 2))


def sigmas(freedom: float) -> float:
    """Return how many standard deviations a normal figure may be off, if these are estimated themselves (Student).

    Args:
        freedom: degrees of freedom of the estimate.

    Returns:
        Standard deviations.

    Raises:
        InvalidValue: not a positive number.

    Example:
        >>> print(f"{sigmas(60):.2f}, and {SIGMAS:.2f} if they are known")
        5.45, and 4.89 if they are known
    """
    return float(special.stdtrit(checks.positive("freedom", freedom), 1 - ODDS / 2))


def rms_tolerance(count: float, kurtosis: float = 3.0) -> float:
    """Return by what part the root mean square of some independent errors may be off the expected one.

    ```
    sqrt(chi2(nu) / nu) - 1,  nu = 2 count / (kurtosis - 1)
    ```

    with the quantile of the chi-squared distribution, which is exact for normal errors.

    Args:
        count: of the errors.
        kurtosis: of their distribution, E e^4 / (E e^2)^2: 3 for normal ones, 1.8 for uniform ones.

    Returns:
        What part of the expected one.

    Raises:
        InvalidValue: numbers that are not positive.

    Example:
        >>> print(f"{rms_tolerance(10_000):.3f}")
        0.035
    """
    freedom = 2 * checks.positive("count", count) / max(checks.positive("kurtosis", kurtosis) - 1, 1e-6)
    return math.sqrt(float(special.chdtri(freedom, ODDS / 2)) / freedom) - 1


def rms(errors: ArrayLike) -> float:
    """Return the root mean square of some errors.

    Args:
        errors: of any shape.

    Returns:
        In their unit.

    Example:
        >>> rms([3.0, -3.0])
        3.0
    """
    return float(np.sqrt(np.mean(np.square(checks.array("errors", errors)))))


@dataclass(frozen=True, eq=False)
class Expected:
    """Errors, and what a law expects of them.

    Args:
        errors: independent of each other, of any shape.
        law: their root mean square as expected, in the same unit.
        kurtosis: of their distribution, E e^4 / (E e^2)^2.

    Example:
        >>> Expected(np.array([3.0, -3.0]), law=2.5).rms
        3.0
    """

    errors: Array
    law: float
    kurtosis: float = 3.0

    @property
    def rms(self) -> float:
        """Their root mean square."""
        return rms(self.errors)


def rms_bound(name: str, *samples: Expected, beyond: float = 0.0) -> Bound:
    """Return the bound that errors, each over its law, have a root mean square of one, as far as chance lets them.

    Args:
        name: of what they are.
        samples: with a law each.
        beyond: by what part the laws are off themselves, such as by their next order.

    Returns:
        A bound in per cent.

    Example:
        >>> print(rms_bound("heading", Expected(np.full(600, 1.02), law=1.0)))
        ok     heading: RMS off its law by: 2 <= 14.38 %
    """
    errors = np.concatenate([np.ravel(sample.errors) / sample.law for sample in samples])
    # A kurtosis below that of normal errors is not relied on.
    kurtosis = max(3.0, *(sample.kurtosis for sample in samples))
    allowed = rms_tolerance(errors.size, kurtosis) + checks.not_negative("beyond", beyond)
    return Bound(f"{name}: RMS off its law by", 100 * abs(rms(errors) - 1), 100 * allowed, "%")


def worst_bound(name: str, errors: ArrayLike, law: ArrayLike, *, kurtosis: float = 3.0, beyond: float = 0.0) -> Bound:
    """Return the bound that at every point of a sweep the errors have the root mean square of their law.

    Args:
        name: of what they are.
        errors: (..., N), N independent ones at each point; from point to point they may follow the same draws, so that
            chance does to one point what it does to most.
        law: (...), what is expected of them.
        kurtosis: of their distributions, the largest.
        beyond: by what part the law is off itself, such as by its next order.

    Returns:
        A bound in per cent, of the point that is farthest off.

    Example:
        >>> print(worst_bound("course", np.full((2, 600), 1.02), [1.0, 1.01]))
        ok     course: RMS off its law by, at worst: 2 <= 14.38 %
    """
    found = checks.array("errors", errors, "N")
    off = np.abs(np.sqrt(np.mean(found**2, axis=-1)) / law - 1)
    allowed = rms_tolerance(found.shape[-1], max(kurtosis, 3.0)) + checks.not_negative("beyond", beyond)
    return Bound(f"{name}: RMS off its law by, at worst", 100 * float(np.max(off)), 100 * allowed, "%")


def ratio_tolerance(count: float) -> float:
    """Return by what part the ratio of two variances, each of some independent normal errors, may be off.

    Args:
        count: of the errors in each.

    Returns:
        What part of the expected ratio.

    Raises:
        InvalidValue: not a positive number.

    Example:
        >>> print(f"{ratio_tolerance(10_000):.3f}")
        0.103
    """
    number = checks.positive("count", count)
    return float(special.fdtri(number, number, 1 - ODDS / 2)) - 1


def share_tolerance(share: ArrayLike, count: float) -> Array:
    """Return by how much the share of some independent trials that succeed may be off its probability.

    Bernstein's inequality, which holds for any number of trials and any probability.

    Args:
        share: the probability of success (...).
        count: of the trials.

    Returns:
        (...)

    Example:
        >>> print(f"{share_tolerance(0.95, 1000):.3f}")
        0.042
    """
    number, log = checks.positive("count", count), math.log(2 / ODDS)
    probability = checks.array("share", share)
    # n t^2 / 2 = log (variance + t / 3)
    root = np.sqrt((log / 3) ** 2 + 2 * number * probability * (1 - probability) * log)
    return np.asarray((log / 3 + root) / number)[()]
