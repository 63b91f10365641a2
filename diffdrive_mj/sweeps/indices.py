"""Sobol' indices: how much of a figure's variance each number that varies makes, alone and together with the others.

They are shares of the variance of a figure as it is kept. A signed error, as that of the heading, is nearly linear in
small tolerances, and its first-order indices add up to one. A size, as a position error, is not linear: the size of a
sum is small where two causes cancel and large where they help each other, so that part of its variance belongs to no
cause alone. The total indices show that, and so does the gap of the first-order ones to one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj._text import html_table, table
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.sweeps._blocks import rows_a_block
from diffdrive_mj.sweeps._shares import part
from diffdrive_mj.sweeps._units import in_words, varied_in_words
from diffdrive_mj.sweeps.percentiles import CONFIDENCE, Estimate
from diffdrive_mj.sweeps.trials import Trials

_RESAMPLES = 1000
_FEWEST = 16  # rows of the blocks
_HEADER = [
    "what varies",
    "alone [% of the variance]",
    "with 95 % confidence",
    "with the others [%]",
    "with 95 % confidence",
]


@dataclass(frozen=True, eq=False)
class Indices:
    """Hold the Sobol' indices of a figure, and print as a table.

    Attributes:
        figure: whose variance is split.
        names: of the D numbers that vary.
        first: first-order indices (D,), what each does alone.
        total: total indices (D,), what would be gone if all the others were known.
        rows: of each block that were used.
        dropped: rows left out, since one of their trials was not driven to its end.

    Example:
        >>> share = Estimate(np.array([1.0]), np.array([0.9]), np.array([1.0]))
        >>> print(Indices("final_heading", ("robot.track_width",), share, share, 64, 0))
        what varies  alone [% of the variance]  with 95 % confidence  with the others [%]  with 95 % confidence
        -------------------------------------------------------------------------------------------------------
        track width                        100             90 to 100                  100             90 to 100
        <BLANKLINE>
        Of the variance of the final heading error, 0 % belongs to no number alone. 64 rows a block.
    """

    figure: str
    names: tuple[str, ...]
    first: Estimate
    total: Estimate
    rows: int
    dropped: int = 0

    @property
    def together(self) -> float:
        """The share of the variance that no number makes alone; a little below zero by chance."""
        return float(1 - self.first.value.sum())

    def __str__(self) -> str:
        return f"{table(_HEADER, self._rows())}\n\n{self.finding}"

    def _repr_html_(self) -> str:
        return html_table(self._rows(), _HEADER, self.finding)

    def _rows(self) -> list[list[object]]:
        return [
            [varied_in_words(name), *_in_percent(self.first[k]), *_in_percent(self.total[k])]
            for k, name in enumerate(self.names)
        ]

    @property
    def finding(self) -> str:
        """How much belongs to no number alone, and what was read."""
        dropped = f", {self.dropped} more left out: a robot in them was refused or lost" if self.dropped else ""
        return (
            f"Of the variance of the {in_words(self.figure)}, {100 * max(self.together, 0):.0f} % belongs to no number "
            f"alone. {self.rows} rows a block{dropped}."
        )


def sobol_indices(
    f_a: ArrayLike, f_b: ArrayLike, f_ab: ArrayLike, *, confidence: float = CONFIDENCE, seed: int = 0
) -> tuple[Estimate, Estimate]:
    """Estimate first-order and total Sobol' indices from a figure on the blocks of a design.

    With A and B two independent draws of all numbers, and AB_k = A with number k out of B,

    ```
    S_k = E[f_B (f_ABk - f_A)] / V        T_k = E[(f_A - f_ABk)^2] / (2 V)
    ```

    where V is the variance of f_A and f_B together, and their mean is taken off before.

    Args:
        f_a: (n,) on A.
        f_b: (n,) on B.
        f_ab: (D, n) on AB_1 to AB_D.
        confidence: of the limits, which come of resampled rows (percentile bootstrap).
        seed: of the resampling.

    Returns:
        First-order and total indices, (D,) each.

    Raises:
        InvalidType: not numbers.
        InvalidValue: shapes that do not fit, fewer than 16 rows, or a figure that does not vary.

    References:
        Sobol' (2001), Global sensitivity indices for nonlinear mathematical models and their Monte Carlo estimates.
        Saltelli and others (2010), Variance based sensitivity analysis of model output, table 2, (b) and (f).

    Example:
        Of a sum each number makes the share of its own variance:

        >>> a, b = np.random.default_rng(0).normal(size=(2, 2, 4096)) * [[2.0], [1.0]]
        >>> first, total = sobol_indices(a.sum(axis=0), b.sum(axis=0), [b[0] + a[1], a[0] + b[1]])
        >>> first.value.round(2).tolist(), total.value.round(2).tolist()
        ([0.77, 0.2], [0.78, 0.2])
    """
    a, b = checks.array("f_a", f_a, "n"), checks.array("f_b", f_b, "n")
    ab = checks.array("f_ab", f_ab, "D", "n")
    if a.ndim != 1 or a.shape != b.shape or ab.shape[1:] != a.shape or ab.ndim != 2:
        raise InvalidValue(f"shapes {a.shape}, {b.shape} and {ab.shape}: must be (n,), (n,) and (D, n)")
    if len(a) < _FEWEST:
        raise InvalidValue(f"{len(a)} rows a block: must be at least {_FEWEST}")
    mean = np.mean([a, b])
    a, b, ab = a - mean, b - mean, ab - mean
    if not np.ptp([a, b]) > 0:
        raise InvalidValue("the figure does not vary, so that there is no variance to split")
    # All that the indices are made of are means over rows, and those of resampled rows are weighted ones.
    parts = np.vstack([b * (ab - a), (a - ab) ** 2 / 2, (a + b) / 2, (a**2 + b**2) / 2])
    rng, whole = np.random.default_rng(checks.whole("seed", seed, least=0)), _indices(parts.mean(axis=1))
    resampled = [
        parts @ np.bincount(rng.integers(len(a), size=len(a)), minlength=len(a)) / len(a) for _ in range(_RESAMPLES)
    ]
    tail = (1 - part("confidence", confidence)) / 2
    low, high = np.quantile(_indices(np.array(resampled)), [tail, 1 - tail], axis=0)
    count = len(ab)
    return (
        Estimate(whole[:count], low[:count], high[:count], confidence),
        Estimate(whole[count:], low[count:], high[count:], confidence),
    )


def indices_of(trials: Trials, figure: str, *, confidence: float = CONFIDENCE, seed: int = 0) -> Indices:
    """Estimate the Sobol' indices of a figure from the trials of a study whose design is "saltelli".

    Args:
        trials: n (D + 2), in blocks A, B, AB_1 to AB_D of n rows; a row of which a trial was not driven to its end is
            left out of all blocks, and counted.
        figure: by its name, a single number a trial, as it is: signed if it is kept signed.
        confidence: of the limits.
        seed: of the resampling.

    Returns:
        The indices, which print as a table.

    Raises:
        InvalidType: not trials.
        UnknownName: a figure that was not kept.
        InvalidValue: trials of another design, too few rows, or a figure that does not vary or is not a single number.

    Example:
        >>> a, b = np.random.default_rng(0).normal(size=(2, 1000))
        >>> drawn, ends = np.concatenate([a, b, b]), np.full(3000, "ok")
        >>> trials = Trials(np.arange(3000), {"robot.left_radius": drawn}, {"final_heading": 2 * drawn}, ends, ends)
        >>> indices_of(trials, "final_heading").total.value.round(1).tolist()
        [0.9]
    """
    values = checks.one_of("figure", figure, checks.instance("trials", trials, Trials).figures)
    if values.ndim != 1:
        raise InvalidValue(f"figure {figure!r} has {values[0].size} numbers a trial: must be a single one")
    rows = rows_a_block(trials.drawn, len(trials))
    if rows is None:
        raise InvalidValue(
            f'{trials!r}: must be the trials of a whole design for Sobol\' indices (Study(design="saltelli"))'
        )
    blocks, whole = np.reshape(values, (-1, rows)), _whole_rows(trials.ok, rows)
    first, total = sobol_indices(
        blocks[0, whole], blocks[1, whole], blocks[2:, whole], confidence=confidence, seed=seed
    )
    return Indices(figure, tuple(trials.drawn), first, total, int(whole.sum()), int((~whole).sum()))


def _indices(means: Array) -> Array:
    """First-order and total indices (..., 2 D) of the means of what they are made of (..., 2 D + 2)."""
    variance = means[..., -1] - means[..., -2] ** 2
    found: Array = means[..., :-2] / variance[..., None]
    return found


def _whole_rows(ok: NDArray[np.bool_], rows: int) -> NDArray[np.bool_]:
    return np.asarray(np.reshape(ok, (-1, rows)).all(axis=0))


def _in_percent(found: Estimate) -> list[object]:
    return [100 * float(found.value), f"{100 * float(found.low):.3g} to {100 * float(found.high):.3g}"]
