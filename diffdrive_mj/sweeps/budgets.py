"""The budget of a study's tolerances: which of them matters, and what it would buy to tighten it."""

from __future__ import annotations

import html
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from diffdrive_mj._text import html_table, table
from diffdrive_mj.sweeps._blocks import rows_a_block
from diffdrive_mj.sweeps._units import in_words, unit_of, varied_in_words
from diffdrive_mj.sweeps.indices import Indices, indices_of
from diffdrive_mj.sweeps.percentiles import CONFIDENCE, Estimate
from diffdrive_mj.sweeps.prices import Prices, prices_of
from diffdrive_mj.sweeps.studies import Study
from diffdrive_mj.sweeps.trials import Trials


@dataclass(frozen=True, eq=False)
class Budget:
    """Hold what each tolerance costs, the dearest first, and print as a table with its finding.

    Attributes:
        figure: that is budgeted.
        percentile: of its size over the robots, in SI units, with limits for any distribution.
        prices: what tightening each tolerance buys.
        indices: Sobol' indices of the figure; None if the trials are of another design.
        spreads: standard deviation of each number as drawn, by its name, over its mean.
        counted: how many trials ended in each way.

    Example:
        >>> robot = dd.Robot.load("matched")
        >>> drive = dd.sweeps.Maneuver("straight", {"speed": 0.5, "distance": 0.5})
        >>> spread = {"robot.left_radius": dd.sweeps.Normal(mean=robot.left_radius, sigma=0.0005)}
        >>> study = dd.sweeps.Study(robot=robot, maneuver=drive, vary=spread, trials=1000, truth="kinematics")
        >>> budget(study, dd.sweep(study)).dearest
        'robot.left_radius'
    """

    figure: str
    percentile: Estimate
    prices: Prices
    indices: Indices | None
    spreads: Mapping[str, float]
    counted: Mapping[str, int]

    @property
    def order(self) -> list[int]:
        """Indices of the prices, the largest fall first."""
        return np.argsort(-self.prices.fall.value, kind="stable").tolist()

    @property
    def dearest(self) -> str:
        """The number whose tolerance buys most."""
        return self.prices.names[self.order[0]]

    @property
    def finding(self) -> str:
        """What to tighten, in a sentence."""
        return self.prices.sentence(self.order[0])

    def __str__(self) -> str:
        return "\n\n".join([self._title(), table(self._header(), self._rows()), self.finding, *self._notes()])

    def _repr_html_(self) -> str:
        lines = "".join(f"<p>{html.escape(line)}</p>" for line in (self.finding, *self._notes()))
        return html_table(self._rows(), self._header(), self._title()) + lines

    def as_dict(self) -> dict[str, Any]:
        """Return the numbers by their names, in SI units, as for JSON.

        Example:
            >>> robot = dd.Robot.load("matched")
            >>> drive = dd.sweeps.Maneuver("straight", {"speed": 0.5, "distance": 0.5})
            >>> spread = {"robot.left_radius": dd.sweeps.Normal(mean=robot.left_radius, sigma=0.0005)}
            >>> study = dd.sweeps.Study(robot=robot, maneuver=drive, vary=spread, trials=1000, truth="kinematics")
            >>> list(budget(study, dd.sweep(study)).as_dict())
            ['figure', 'percentile', 'share', 'factor', 'tolerances']
        """
        fall, found = self.prices.fall, self.indices
        return {
            "figure": self.figure,
            "percentile": [float(each) for each in (self.percentile.value, self.percentile.low, self.percentile.high)],
            "share": self.prices.share,
            "factor": self.prices.factor,
            "tolerances": {
                name: {
                    "spread": self.spreads[name],
                    "fall": [float(each) for each in (fall.value[k], fall.low[k], fall.high[k])],
                    "effective_trials": float(self.prices.effective[k]),
                    **({} if found is None else _first_and_total(found, name)),
                }
                for k, name in enumerate(self.prices.names)
            },
        }

    def _title(self) -> str:
        unit, scale = unit_of(self.figure)
        ends = ", ".join(f"{count} {name}" for name, count in self.counted.items())
        limit = self.percentile.text(unit, scale)
        return f"{100 * self.prices.share:g} % of the robots stay under {limit} of {in_words(self.figure)} ({ends})"

    def _header(self) -> list[str]:
        narrowed = "halved" if self.prices.factor == 0.5 else f"times {self.prices.factor:g}"
        shares = [] if self.indices is None else ["alone [%]", "with the others [%]"]
        return ["tolerance", "spread", f"{narrowed}: {100 * self.prices.share:g} % fall by", *shares]

    def _rows(self) -> list[list[object]]:
        rows: list[list[object]] = []
        for k in self.order:
            name, fall = self.prices.names[k], self.prices.fall[k].text("%", 100, digits=2)
            rows.append([varied_in_words(name), f"{100 * self.spreads[name]:.3g} %", fall, *self._shares(name)])
        others = [name for name in self.spreads if self.indices and name not in self.prices.names]
        return [*rows, *([varied_in_words(name), "", "", *self._shares(name)] for name in others)]

    def _shares(self, name: str) -> list[object]:
        """The two indices of a number, in per cent."""
        if self.indices is None:
            return []
        k = self.indices.names.index(name)
        return [f"{100 * float(each.value[k]):.2g}" for each in (self.indices.first, self.indices.total)]

    def _notes(self) -> list[str]:
        effective = self.prices.effective
        lines = [f"Reweighted, the trials are worth {effective.min():.0f} independent ones at least."]
        if self.indices is not None:
            lines.append(f"{self.indices.finding} The shares are of the variance.")
        return ["\n".join(lines)]


def budget(
    study: Study,
    trials: Trials,
    figure: str = "final_position",
    *,
    share: float = 0.99,
    factor: float = 0.5,
    confidence: float = CONFIDENCE,
    seed: int = 0,
) -> Budget:
    """Say which tolerance of a study matters most, and what it buys to tighten each.

    Args:
        study: of the trials, with the distributions.
        trials: of that study; with the design "saltelli" Sobol' indices are there too.
        figure: by its name, a single number a trial.
        share: of the robots that shall stay under a limit.
        factor: by which each spread is narrowed in turn.
        confidence: of all limits.
        seed: of the resampling.

    Returns:
        The budget, which prints as a table.

    Raises:
        InvalidType: not a study and its trials.
        UnknownName: a figure that was not kept.
        InvalidValue: trials of another study, too few of them, or nothing that can be tightened.

    Example:
        >>> robot = dd.Robot.load("matched")
        >>> drive = dd.sweeps.Maneuver("straight", {"speed": 0.5, "distance": 0.5})
        >>> spread = {"robot.left_radius": dd.sweeps.Normal(mean=robot.left_radius, sigma=0.0005)}
        >>> study = dd.sweeps.Study(robot=robot, maneuver=drive, vary=spread, trials=1000, truth="kinematics")
        >>> print(budget(study, dd.sweep(study)).finding[:80])
        Halve the spread of the left radius, and the 99th percentile of the final positi
    """
    prices = prices_of(study, trials, figure, share=share, factor=factor, confidence=confidence, seed=seed)
    designed = rows_a_block(trials.drawn, len(trials)) is not None
    drawn = {name: values for name, values in trials.drawn.items() if values.dtype.kind == "f"}
    return Budget(
        figure,
        trials.percentile(figure, share, confidence),
        prices,
        indices_of(trials, figure, confidence=confidence, seed=seed) if designed else None,
        {name: _relative(drawn[name]) if name in drawn else float("nan") for name in trials.drawn},
        trials.counted,
    )


def _relative(values: Any) -> float:
    mean = float(np.mean(values))
    return float(np.std(values)) / abs(mean) if mean else float("inf")


def _first_and_total(found: Indices, name: str) -> dict[str, float]:
    k = found.names.index(name)
    return {"first": float(found.first.value[k]), "total": float(found.total.value[k])}
