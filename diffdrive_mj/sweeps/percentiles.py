"""What some trials say of all robots: percentiles and shares, with limits that hold for any distribution.

A percentile of some trials is one of them, and how many lie below the true one is a binomial number. Its limits are
therefore two trials of the sorted ones, chosen by the binomial distribution alone: no shape is assumed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj.errors import InvalidType, InvalidValue
from diffdrive_mj.sweeps._shares import part

CONFIDENCE = 0.95


@dataclass(frozen=True, eq=False)
class Estimate:
    """Hold what some trials say of a figure of all robots.

    Attributes:
        value: (...), as the trials have it.
        low: (...), the lower limit; minus infinity if so few trials give none.
        high: (...), the upper limit; infinite if so few trials give none.
        confidence: with which the true one lies between them.

    Example:
        >>> print(Estimate(np.float64(0.01), np.float64(0.005), np.float64(0.02)))
        0.01 (0.005 to 0.02)
    """

    value: Array
    low: Array
    high: Array
    confidence: float = CONFIDENCE

    def __str__(self) -> str:
        return self.text() if np.ndim(self.value) == 0 else f"{np.shape(self.value)} estimates"

    def text(self, unit: str = "", scale: float = 1.0, digits: int = 3) -> str:
        """Write one estimate with its limits.

        Args:
            unit: behind each number.
            scale: to that unit.
            digits: of each number.

        Example:
            >>> Estimate(np.float64(0.01), np.float64(0.005), np.float64(math.inf)).text("%", 100)
            '1 % (0.5 % or more)'
        """
        value, low, high = (_rounded(scale * float(each), digits) for each in (self.value, self.low, self.high))
        end = f" {unit}" if unit else ""
        if math.isinf(self.high):
            return f"{value}{end} ({low}{end} or more)" if math.isfinite(self.low) else f"{value}{end}"
        return (
            f"{value}{end} ({low} to {high}{end})" if math.isfinite(self.low) else f"{value}{end} (up to {high}{end})"
        )

    def __getitem__(self, index: int) -> Estimate:
        return Estimate(self.value[index], self.low[index], self.high[index], self.confidence)


def percentile(values: ArrayLike, share: float, confidence: float = CONFIDENCE) -> Estimate:
    """Estimate below which value a share of all robots stays.

    ```
    X_(l) <= Q <= X_(u)  with  P(l <= K < u) >= confidence,  K binomial (N, share)
    ```

    Args:
        values: (N, ...), of independent trials; infinite where a robot was lost.
        share: of all robots, between zero and one: 0.99 for the 99th percentile.
        confidence: of the limits.

    Returns:
        (...), the percentile and its limits, which hold for any distribution. With fewer than `trials_needed` there is
        no upper limit.

    Raises:
        InvalidType: not numbers.
        InvalidValue: no values, one that is not a number, or a share or a confidence that is not between zero and one.

    References:
        David and Nagaraja (2003), Order statistics, section 7.1.

    Example:
        >>> print(percentile(np.arange(1, 1001), 0.99))
        990 (983 to 997)
    """
    found, share, confidence = (
        _values(values),
        part("share", share),
        part("confidence", confidence),
    )
    from scipy.stats import binom

    count, ordered = len(found), np.sort(found, axis=0)
    lower, upper = (int(binom.ppf(tail, count, share)) for tail in ((1 - confidence) / 2, (1 + confidence) / 2))
    nothing = np.full(found.shape[1:], np.inf)
    return Estimate(
        ordered[max(1, math.ceil(count * share - 1e-9)) - 1],
        np.asarray(ordered[lower - 1] if lower > 0 else -nothing)[()],
        np.asarray(ordered[upper] if upper < count else nothing)[()],
        confidence,
    )


def trials_needed(share: float, confidence: float = CONFIDENCE) -> int:
    """Compute how many trials give a percentile an upper limit: the worst of them.

    ```
    share^N <= (1 - confidence) / 2
    ```

    Args:
        share: of all robots, as 0.99.
        confidence: of the limits on both sides.

    Returns:
        How many trials.

    Raises:
        InvalidType, InvalidValue: not a number between zero and one.

    Example:
        >>> trials_needed(0.99), trials_needed(0.95)
        (368, 72)
    """
    tail = (1 - part("confidence", confidence)) / 2
    return math.ceil(math.log(tail) / math.log(part("share", share)))


def share_of(count: int, trials: int, confidence: float = CONFIDENCE) -> Estimate:
    """Estimate which share of all robots does what some of the trials did (Clopper and Pearson's limits).

    ```
    P(K >= count | low) = P(K <= count | high) = (1 - confidence) / 2,  K binomial (trials, share)
    ```

    Args:
        count: of the trials that did.
        trials: all, independent of each other.
        confidence: of the limits.

    Returns:
        The share, from zero to one, and its limits.

    Raises:
        InvalidType: not whole numbers.
        InvalidValue: more than all, or none at all.

    References:
        Clopper and Pearson (1934), The use of confidence or fiducial limits illustrated in the case of the binomial.

    Example:
        None of 300 robots is no proof that none ever will:

        >>> print(share_of(0, 300).text("%", 100))
        0 % (0 to 1.22 %)
    """
    trials = checks.whole("trials", trials)
    count = checks.whole("count", count, least=0)
    if count > trials:
        raise InvalidValue(f"count = {count}: must be at most trials = {trials}")
    from scipy.special import betaincinv

    tail = (1 - part("confidence", confidence)) / 2
    low = betaincinv(count, trials - count + 1, tail) if count else 0.0
    high = betaincinv(count + 1, trials - count, 1 - tail) if count < trials else 1.0
    value, low, high = (np.asarray(each)[()] for each in (count / trials, low, high))
    return Estimate(value, low, high, confidence)


def _rounded(value: float, digits: int) -> str:
    """A number to some digits, without a power of ten."""
    return f"{float(f'{value:.{digits}g}'):.12g}"


def _values(values: ArrayLike) -> Array:
    try:
        found = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise InvalidType("values: must be numbers (N, ...)") from None
    if found.ndim == 0 or not len(found) or np.isnan(found).any():
        raise InvalidValue(f"values of shape {found.shape}: must be at least one (N, ...), all of them numbers")
    return found
