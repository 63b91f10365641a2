"""Trials as text: a table of percentiles with what must be known beside it, and rows for other programs."""

from __future__ import annotations

import csv
import html
import io
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from diffdrive_mj._text import one_line, table
from diffdrive_mj.sweeps._units import in_words, unit_of
from diffdrive_mj.sweeps.percentiles import Estimate, trials_needed

SHARES = (0.5, 0.9, 0.95, 0.99)
HEADER = ["size of", "half under", *(f"{100 * share:g} % under" for share in SHARES[1:]), "with 95 % confidence"]
_REASONS = 3


class Told(Protocol):
    """What is read of trials."""

    @property
    def index(self) -> NDArray[np.int64]: ...
    @property
    def drawn(self) -> Mapping[str, NDArray[Any]]: ...
    @property
    def figures(self) -> Mapping[str, NDArray[np.float64]]: ...
    @property
    def outcome(self) -> NDArray[np.str_]: ...
    @property
    def why(self) -> NDArray[np.str_]: ...
    @property
    def counted(self) -> Mapping[str, int]: ...
    def __len__(self) -> int: ...
    def percentile(self, figure: str, share: float) -> Estimate: ...


def printed(trials: Told) -> str:
    """The table, and what must be known beside it."""
    found = rows(trials)
    parts = [title(trials), table(HEADER, found) if found else "", "\n".join(notes(trials))]
    return "\n\n".join(part for part in parts if part)


def title(trials: Told) -> str:
    """How many there are, and how they ended."""
    ends = ", ".join(f"{count} {name}" for name, count in trials.counted.items())
    return f"{len(trials)} trials: {ends}"


def rows(trials: Told) -> list[list[object]]:
    """A row for each figure of a single number: percentiles, the last with its limits."""
    if not (trials.outcome != "refused").any():
        return []
    made: list[list[object]] = []
    for figure, values in trials.figures.items():
        if values.ndim == 1:
            unit, scale = unit_of(figure)
            shares = [trials.percentile(figure, share) for share in SHARES]
            name = in_words(figure) + (f" [{unit}]" if unit else "")
            last = shares[-1]
            high = scale * float(last.high)
            to = f"to {high:.4g}" if np.isfinite(high) else "or more"
            made.append(
                [name, *(scale * float(found.value) for found in shares), f"{scale * float(last.low):.4g} {to}"]
            )
    return made


def notes(trials: Told) -> list[str]:
    """Whom the figures count, and the first reasons why trials failed."""
    counts = trials.counted
    lost, refused = counts.get("fell", 0) + counts.get("diverged", 0), counts.get("refused", 0)
    lines = _claims(trials)
    if lost:
        lines.append(f"Fallen or diverged, and counted as farther off than any limit: {lost}.")
    if refused:
        lines.append(f"Refused, since they cannot be built or driven, and left out of the shares: {refused}.")
    for outcome in ("fell", "diverged", "refused"):
        which = np.flatnonzero(trials.outcome == outcome)
        lines += [f"{outcome}, trial {trials.index[k]}: {one_line(str(trials.why[k]))}" for k in which[:_REASONS]]
        lines += [f"{outcome}: {len(which) - _REASONS} more"] if len(which) > _REASONS else []
    return lines


def _claims(trials: Told) -> list[str]:
    """The 99th percentile of the first error, as a sentence."""
    errors = (name for name, values in trials.figures.items() if values.ndim == 1 and name != "distance")
    figure = next(errors, None)
    if figure is None or not (trials.outcome != "refused").any():
        return []
    found = trials.percentile(figure, SHARES[-1])
    if not np.isfinite(found.value):
        return [f"More than {100 - 100 * SHARES[-1]:g} % of the robots are lost: no limit holds for the others."]
    unit, scale = unit_of(figure)
    if not np.isfinite(found.high):
        least, needed = f"{scale * float(found.low):.3g} {unit}".strip(), trials_needed(SHARES[-1])
        return [
            f"The {100 * SHARES[-1]:g}th percentile of the {in_words(figure)} is {least} or more: an upper limit takes "
            f"{needed} trials."
        ]
    return [f"{100 * SHARES[-1]:g} % of the robots stay under {found.text(unit, scale)} of {in_words(figure)}."]


def escaped(lines: Sequence[str]) -> list[str]:
    """Lines as HTML shows them."""
    return [html.escape(line) for line in lines]


def csv_lines(trials: Told) -> Iterator[str]:
    """The lines of a CSV file, a header first."""
    figures = {name: values for name, values in trials.figures.items() if values.ndim == 1}
    yield _line(["index", "outcome", *trials.drawn, *figures, "why"])
    columns = (trials.index, trials.outcome, *trials.drawn.values(), *figures.values(), trials.why)
    for row in zip(*(column.tolist() for column in columns), strict=True):
        # Not a number is an empty cell.
        yield _line(["" if value != value else value for value in row])  # noqa: PLR0124


def _line(cells: Sequence[object]) -> str:
    written = io.StringIO()
    csv.writer(written, lineterminator="\n").writerow(cells)
    return written.getvalue()
