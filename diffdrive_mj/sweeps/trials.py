"""What is known of the trials of a study: what varied, how each ended, and its figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj._files import write_whole
from diffdrive_mj._text import html_table
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.sweeps import _trials_text as text
from diffdrive_mj.sweeps._blocks import independent
from diffdrive_mj.sweeps.percentiles import CONFIDENCE, Estimate, percentile, share_of

# How a trial ends: driven, tipped over, the physics broke down, or the robot cannot be.
OUTCOMES = ("ok", "fell", "diverged", "refused")


@dataclass(frozen=True, eq=False)
class Trials:
    """Hold the trials of a study, in their order, and print as a table of percentiles.

    What is said of a figure is said of its size: a heading error to the left is as bad as one to the right. A robot
    that fell, or whose physics broke down, is beyond any limit. One that was refused cannot be built, and is left out;
    how many these are is printed. Of the trials of a design for Sobol' indices, whose rows hang together, percentiles
    and shares read those that are independent. A grid drives the same robots once for each of its values: ask for
    those of one (`by`, `where`).

    Attributes:
        index: (N,) of each trial in its study.
        drawn: what varied, by its name: (N,) numbers or strings.
        figures: what was kept, by its name: (N,) or (N, ...); not a number where the outcome is not "ok".
        outcome: (N,) "ok", "fell", "diverged" or "refused".
        why: (N,) what happened, in a line; empty where the outcome is "ok".

    Example:
        >>> off = {"final_position": np.array([0.012, np.nan])}
        >>> trials = Trials(np.arange(2), {}, off, np.array(["ok", "fell"]), np.array(["", "it tipped over"]))
        >>> trials
        Trials(2: 1 ok, 1 fell)
        >>> print(trials.exceedance("final_position", 0.040).text("%", 100))
        50 % (1.26 to 98.7 %)
    """

    index: NDArray[np.int64]
    drawn: Mapping[str, NDArray[Any]]
    figures: Mapping[str, Array]
    outcome: NDArray[Any]
    why: NDArray[Any]

    def __len__(self) -> int:
        return len(self.index)

    def __repr__(self) -> str:
        counted = ", ".join(f"{count} {name}" for name, count in self.counted.items())
        return f"Trials({len(self)}: {counted})"

    def __str__(self) -> str:
        return text.printed(self)

    def _repr_html_(self) -> str:
        return html_table(text.rows(self), text.HEADER, text.title(self)) + "".join(
            f"<p>{line}</p>" for line in text.escaped(text.notes(self))
        )

    @property
    def ok(self) -> NDArray[np.bool_]:
        """Which trials were driven to their end (N,)."""
        return self.outcome == "ok"

    @property
    def counted(self) -> dict[str, int]:
        """How many trials ended in each way, those that happened."""
        counts = {outcome: int((self.outcome == outcome).sum()) for outcome in OUTCOMES}
        return {outcome: count for outcome, count in counts.items() if count}

    def where(self, which: ArrayLike) -> Trials:
        """Return some of the trials, such as those of one value of a grid, to say the same of them.

        Args:
            which: (N,), whether each is taken.

        Raises:
            InvalidValue: not a yes or no for each, or none at all.

        Example:
            >>> ends = np.array(["ok", "fell", "ok"])
            >>> trials = Trials(np.arange(3), {"world.friction": np.array([0.6, 0.1, 0.6])}, {}, ends, ends)
            >>> trials.where(trials.drawn["world.friction"] == 0.6)
            Trials(2: 2 ok)
        """
        taken = checks.flags("which", which, len(self))
        if not taken.any():
            raise InvalidValue(f"{self!r}: none of them is taken")
        drawn = {name: values[taken] for name, values in self.drawn.items()}
        figures = {name: values[taken] for name, values in self.figures.items()}
        return Trials(self.index[taken], drawn, figures, self.outcome[taken], self.why[taken])

    def by(self, *names: str) -> dict[tuple[Any, ...], Trials]:
        """Return the trials apart by the values of what varied in them, as those of a grid.

        Args:
            names: of what varied.

        Returns:
            By the values of those names, in the order in which the trials have them.

        Raises:
            UnknownName: nothing of that name varied.

        Example:
            >>> ends = np.array(["ok", "fell", "ok"])
            >>> trials = Trials(np.arange(3), {"world.friction": np.array([0.6, 0.1, 0.6])}, {}, ends, ends)
            >>> trials.by("world.friction")
            {(0.6,): Trials(2: 2 ok), (0.1,): Trials(1: 1 fell)}
        """
        columns = [checks.one_of("name of what varied", name, self.drawn).tolist() for name in names]
        values = list(zip(*columns, strict=True)) if names else [()] * len(self)
        places: dict[tuple[Any, ...], list[int]] = {}
        for place, value in enumerate(values):
            places.setdefault(value, []).append(place)
        if len(places) == 1:
            return dict.fromkeys(places, self)
        return {value: self.where(np.isin(np.arange(len(self)), some)) for value, some in places.items()}

    def sizes(self, figure: str) -> Array:
        """Return how far off each robot was that can be built.

        Args:
            figure: by its name.

        Returns:
            (M,) or (M, ...), the size of the figure, infinite where the robot fell or the physics broke down. Of a
            design for Sobol' indices only the trials that are independent of each other.

        Raises:
            UnknownName: a figure that was not kept.
            InvalidValue: all the robots were refused.

        Example:
            >>> off = {"final_heading": np.array([-0.1, np.nan])}
            >>> ends = np.array(["ok", "fell"])
            >>> Trials(np.arange(2), {}, off, ends, np.array(["", "it tipped over"])).sizes("final_heading").tolist()
            [0.1, inf]
        """
        values = checks.one_of("figure", figure, self.figures)
        sizes = np.abs(values)
        sizes[~self.ok] = np.inf
        kept: Array = sizes[independent(self.drawn, len(self)) & (self.outcome != "refused")]
        if not len(kept):
            raise InvalidValue(f"{self!r}: no robot of the study can be built; the first: {self.why[0]}")
        return kept

    def percentile(self, figure: str, share: float, confidence: float = CONFIDENCE) -> Estimate:
        """Estimate below which size of a figure a share of the robots stays.

        Args:
            figure: by its name.
            share: of the robots, as 0.99.
            confidence: of the limits.

        Returns:
            The percentile in SI units, with limits that hold for any distribution (`percentiles.percentile`).

        Raises:
            UnknownName: a figure that was not kept.
            InvalidValue: a share or a confidence that is not between zero and one.

        Example:
            >>> off, ends = {"final_position": np.arange(1000) / 1e5}, np.full(1000, "ok")
            >>> print(Trials(np.arange(1000), {}, off, ends, ends).percentile("final_position", 0.99).text("mm", 1e3))
            9.89 mm (9.82 to 9.96 mm)
        """
        found = percentile(self.sizes(figure), share, confidence)
        return Estimate(found.value, np.maximum(found.low, 0.0), found.high, found.confidence)

    def exceedance(self, figure: str, limit: float, confidence: float = CONFIDENCE) -> Estimate:
        """Estimate which share of the robots is farther off than a limit.

        Args:
            figure: by its name, a single number a trial.
            limit: for the size of the figure, in SI units.
            confidence: of the limits of the share.

        Returns:
            The share, from zero to one, with its limits (`percentiles.share_of`).

        Raises:
            UnknownName: a figure that was not kept.
            InvalidValue: a figure of several numbers, or a negative limit.

        Example:
            >>> off, ends = {"final_position": np.arange(1000) / 1e5}, np.full(1000, "ok")
            >>> print(Trials(np.arange(1000), {}, off, ends, ends).exceedance("final_position", 0.009).text("%", 100))
            9.9 % (8.12 to 11.9 %)
        """
        limit, sizes = checks.not_negative("limit", limit), self.sizes(figure)
        if sizes.ndim > 1:
            raise InvalidValue(f"figure {figure!r} has {sizes[0].size} numbers a trial: must be a single one")
        return share_of(int((sizes > limit).sum()), len(sizes), confidence)

    def to_csv(self, path: str | Path) -> None:
        """Write a row a trial: what was drawn, the figures that are single numbers, how it ended and why.

        Args:
            path: of the file, which is written whole or not at all.

        Raises:
            InvalidValue: it cannot be written.

        Example:
            >>> from tempfile import TemporaryDirectory
            >>> with TemporaryDirectory() as folder:
            ...     file = Path(folder, "trials.csv")
            ...     Trials(np.arange(1), {}, {"distance": np.ones(1)}, np.array(["ok"]), np.array([""])).to_csv(file)
            ...     print(file.read_text(), end="")
            index,outcome,distance,why
            0,ok,1.0,
        """
        write_whole(path, text.csv_lines(self))


def joined(parts: Sequence[Trials]) -> Trials:
    """Put the trials of several chunks into one, in the order of their indices.

    Args:
        parts: at least one, of the same study.

    Example:
        >>> part = Trials(np.arange(2), {}, {}, np.array(["ok", "ok"]), np.array(["", ""]))
        >>> joined([part])
        Trials(2: 2 ok)
    """
    parts = checks.instances("parts", parts, Trials)
    if not parts:
        raise InvalidValue("parts is empty: must hold the trials of at least one chunk")
    order = np.argsort(np.concatenate([part.index for part in parts]))

    def of(pick: str) -> NDArray[Any]:
        return np.concatenate([getattr(part, pick) for part in parts])[order]

    return Trials(
        np.concatenate([part.index for part in parts])[order],
        {name: np.concatenate([part.drawn[name] for part in parts])[order] for name in parts[0].drawn},
        {name: np.concatenate([part.figures[name] for part in parts])[order] for name in parts[0].figures},
        of("outcome"),
        np.concatenate([part.why.astype(object) for part in parts])[order],  # one long line would make all of them long
    )
