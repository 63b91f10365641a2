"""What a tighter tolerance buys: the fall of a percentile, from the trials that are there already.

Trials of the present spreads are trials of a tighter one, if each counts as often as the tighter spread would have
drawn it. No robot is driven again. For a normal spread halved no trial counts more than twice, and 1000 of them are
worth 661. The price scatters a third more than that of new trials at the same shares, which take a sweep a tolerance.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeGuard

import numpy as np
from numpy.typing import ArrayLike, NDArray

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj._text import shown
from diffdrive_mj.errors import InvalidType, InvalidValue
from diffdrive_mj.sweeps._blocks import groups, independent
from diffdrive_mj.sweeps._shares import part
from diffdrive_mj.sweeps._units import in_words, varied_in_words
from diffdrive_mj.sweeps.choices import Grid
from diffdrive_mj.sweeps.distributions import Distribution, Spread
from diffdrive_mj.sweeps.percentiles import CONFIDENCE, Estimate
from diffdrive_mj.sweeps.studies import Study
from diffdrive_mj.sweeps.trials import Trials

_RESAMPLES = 500
_AT_ONCE = 250_000  # counts of trials in memory
# Trials beyond the percentile that a tighter spread must leave: fewer say nothing of it.
_TAIL = 5.0


@dataclass(frozen=True, eq=False)
class Prices:
    """Hold what tightening each tolerance alone buys.

    Attributes:
        figure: whose percentile falls.
        share: of the robots, as 0.99.
        factor: by which each spread is narrowed.
        names: of the P numbers that can be tightened; choices and grids cannot.
        percentile: as it is now, in SI units.
        fall: by what part it falls (P,); negative if it grows.
        effective: what number of independent trials the reweighted ones are worth (P,).

    Example:
        >>> fall = Estimate(np.array([0.31]), np.array([0.28]), np.array([0.34]))
        >>> prices = Prices("max_position", 0.9, 0.5, ("robot.track_width",), 0.04, fall, np.array([661.0]))
        >>> print(prices.sentence(0).partition(", and ")[2])
        the 90th percentile of the max position error falls by 31 % (28 to 34 %).
    """

    figure: str
    share: float
    factor: float
    names: tuple[str, ...]
    percentile: float
    fall: Estimate
    effective: Array

    def sentence(self, index: int) -> str:
        """Say what one of them buys."""
        narrowed = "Halve" if self.factor == 0.5 else f"Take {self.factor:g} times"
        fall = self.fall[index]
        shown = fall.text("%", 100, digits=2)
        moved = f"falls by {shown}" if fall.low > 0 else f"does not fall beyond chance: {shown}"
        return (
            f"{narrowed} the spread of the {varied_in_words(self.names[index])}, and the "
            f"{100 * self.share:g}th percentile of the {in_words(self.figure)} {moved}."
        )


def weights_when_tightened(spread: Spread, values: ArrayLike, factor: float) -> Array:
    """Weigh trials so that they stand for trials of a narrower spread.

    ```
    w(x) = p(x | spread scaled by factor) / p(x | spread)
    ```

    Args:
        spread: from which the values were drawn, with a density.
        values: (N,), in the unit of what varies.
        factor: by which the spread is narrowed about its centre, at most one, so that no weight is large.

    Returns:
        (N,), one in the mean.

    Raises:
        InvalidValue: a factor that is not above zero and at most one.

    References:
        Owen (2013), Monte Carlo theory, methods and examples, chapter 9: importance sampling.

    Example:
        The middle counts twice, and what lies a standard deviation off less than half as much:

        >>> spread = dd.sweeps.Normal(mean=0.4, sigma=0.002)
        >>> weights_when_tightened(spread, [0.4, 0.402], 0.5).round(3).tolist()
        [2.0, 0.446]
    """
    narrower = checks.positive("factor", factor)
    if narrower > 1:
        raise InvalidValue(f"factor = {narrower:g}: must be at most 1, since trials say little beyond where they are")
    drawn = checks.array("values", values)
    if not isinstance(spread, Spread):
        raise InvalidType(f"spread = {shown(spread)}: must be a Normal, a LogNormal or a Uniform")
    return spread.scaled(narrower).density(drawn) / spread.density(drawn)


def tightened(study: Study, name: str, factor: float = 0.5) -> Study:
    """Return a study with one spread narrowed: its trials, at the same shares, check a price by driving.

    Args:
        study: with the distributions.
        name: of what varies.
        factor: by which the spread is narrowed about its centre.

    Returns:
        The study.

    Raises:
        UnknownName: nothing of that name varies.
        InvalidValue: a choice or a grid, which has no width, or a factor that is not positive.

    Example:
        >>> study = dd.sweeps.Study.load("squares")
        >>> tightened(study, "robot.track_width").vary["robot.track_width"]
        Normal(mean=0.16, sigma=0.0005)
    """
    spread = checks.one_of("number that varies", name, checks.instance("study", study, Study).vary)
    if not _has_density(spread):
        raise InvalidValue(f"{name}: {spread!r} has no width to narrow")
    return study.replace(vary={**study.vary, name: spread.scaled(factor)})


def effective_number(weights: ArrayLike) -> float:
    """Compute how many trials that count alike some weighted trials are worth (Kish).

    ```
    (sum w)^2 / sum w^2
    ```

    Args:
        weights: (N,), none negative.

    Returns:
        A number up to N.

    Raises:
        InvalidValue: negative weights.

    References:
        Kish (1965), Survey sampling, section 11.7.

    Example:
        >>> effective_number([1.0, 1.0, 0.0, 0.0])
        2.0
    """
    found = checks.not_negative_array("weights", weights)
    squares = float(np.sum(found**2))
    return float(found.sum() ** 2 / squares) if squares else 0.0


def prices_of(
    study: Study,
    trials: Trials,
    figure: str,
    *,
    share: float = 0.99,
    factor: float = 0.5,
    confidence: float = CONFIDENCE,
    seed: int = 0,
) -> Prices:
    """Estimate by how much a percentile falls if one spread is narrowed and the others stay.

    Args:
        study: of the trials, with the distributions.
        trials: of that study, or of one value of its grid (`Trials.by`), of any design; robots that were
            refused are left out, and lost ones are beyond any limit.
        figure: by its name, a single number a trial, of which the size counts.
        share: of the robots, as 0.99.
        factor: by which each spread is narrowed about its centre.
        confidence: of the limits, which come of resampled trials (percentile bootstrap).
        seed: of the resampling.

    Returns:
        A price for each number that has a density.

    Raises:
        InvalidType: not a study and its trials.
        UnknownName: a figure that was not kept.
        InvalidValue: trials of another study, too few of them, a percentile of nothing, or numbers out of their range.

    Example:
        >>> robot = dd.Robot.load("matched")
        >>> spread = {"robot.left_radius": dd.sweeps.Normal(mean=robot.left_radius, sigma=0.0005)}
        >>> drive = dd.sweeps.Maneuver("straight", {"speed": 0.5, "distance": 0.5})
        >>> study = dd.sweeps.Study(robot=robot, maneuver=drive, vary=spread, trials=400, truth="kinematics")
        >>> found = prices_of(study, dd.sweep(study), "final_position", share=0.9)
        >>> bool(found.fall.low[0] < 0.5 < found.fall.high[0])  # the only tolerance
        True
    """
    values = checks.one_of("figure", figure, checks.instance("trials", trials, Trials).figures)
    _of_the_study(checks.instance("study", study, Study), trials)
    if values.ndim != 1:
        raise InvalidValue(f"figure {figure!r} has {values[0].size} numbers a trial: must be a single one")
    share, confidence = part("share", share), part("confidence", confidence)
    if not any(_has_density(spread) for spread in study.vary.values()):
        raise InvalidValue(f"study {shown(study.name)}: nothing varies whose spread could be narrowed")
    sizes = np.where(trials.ok, np.abs(values), np.inf)
    there = (trials.outcome != "refused").astype(np.float64)
    spreads = {name: spread for name, spread in study.vary.items() if _has_density(spread)}
    tightened = [weights_when_tightened(spread, trials.drawn[name], factor) for name, spread in spreads.items()]
    weights = np.array([there, *(there * weight for weight in tightened)])
    alone = independent(trials.drawn, len(trials))
    effective = np.array([effective_number(row[alone]) for row in weights])
    if (fewest := float(effective.min())) * (1 - share) < _TAIL:
        raise InvalidValue(
            f"{trials!r}: reweighted they are worth {fewest:.0f}, and the {100 * share:g}th percentile takes "
            f"{_TAIL / (1 - share):.0f}: drive more, or choose a smaller share, or a factor nearer to 1"
        )
    quantiles = _quantiles(sizes, weights, share)
    now = float(quantiles(np.ones((1, len(sizes))))[0, 0])
    if not 0 < now < np.inf:
        raise InvalidValue(f"the {100 * share:g}th percentile of {figure!r} is {now:g}: no tolerance changes that")
    whole = _falls(quantiles(np.ones((1, len(sizes)))))[0]
    resampled = _resampled(
        quantiles, groups(trials.drawn, len(trials)), np.random.default_rng(checks.whole("seed", seed, least=0))
    )
    tail = (1 - confidence) / 2
    low, high = np.quantile(_falls(resampled), [tail, 1 - tail], axis=0)
    return Prices(figure, share, factor, tuple(spreads), now, Estimate(whole, low, high, confidence), effective[1:])


def _of_the_study(study: Study, trials: Trials) -> None:
    """Refuse trials of another study, and those of several values of a grid, in which the same robots stand again."""
    first = int(trials.index[0])
    drawn = study.drawn(first, first + 1)
    if list(drawn) != list(trials.drawn) or any(trials.drawn[name][0] != value[0] for name, value in drawn.items()):
        raise InvalidValue(f"{trials!r}: must be the trials of this study, whose numbers are drawn otherwise")
    for name, spread in study.vary.items():
        if isinstance(spread, Grid) and len(found := np.unique(trials.drawn[name])) > 1:
            raise InvalidValue(
                f"{trials!r} have {len(found)} values of the grid {name}: must have one; trials.by({name!r}) has those "
                f"of each"
            )


def _has_density(spread: Distribution) -> TypeGuard[Spread]:
    return hasattr(spread, "density") and hasattr(spread, "scaled")


def _quantiles(sizes: Array, weights: Array, share: float) -> Callable[[Array], Array]:
    """A function from how often each trial counts (B, N) to the percentile under each weighting (B, W)."""
    order = np.argsort(sizes)
    ordered, weighted = sizes[order], weights[:, order]

    def found(counts: Array) -> Array:
        here = counts[:, order]
        quantiles = np.empty((len(counts), len(weighted)))
        for k, weight in enumerate(weighted):
            below = np.cumsum(here * weight, axis=1)
            # Rounding of a sum must not make the next trial of one that is on the mark.
            quantiles[:, k] = ordered[np.argmax(below >= (share - 1e-12) * below[:, -1:], axis=1)]
        return quantiles

    return found


def _falls(quantiles: Array) -> Array:
    """By what part each percentile is below the first (..., 1 + P); not at all where robots are lost in both."""
    now, tighter = quantiles[..., :1], quantiles[..., 1:]
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.nan_to_num(1 - tighter / now, nan=0.0)


def _resampled(quantiles: Callable[[Array], Array], group: NDArray[np.int64], rng: np.random.Generator) -> Array:
    """The percentiles of resampled trials (B, W), those that hang together resampled together."""
    several, at_once = int(group.max()) + 1, max(1, _AT_ONCE // len(group))
    parts = []
    for first in range(0, _RESAMPLES, at_once):
        count = min(at_once, _RESAMPLES - first)
        counts = [np.bincount(rng.integers(several, size=several), minlength=several) for _ in range(count)]
        parts.append(quantiles(np.array(counts, dtype=np.float64)[:, group]))
    return np.concatenate(parts)
