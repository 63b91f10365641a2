"""What an experiment produces: an answer, its bounds, metrics and pictures, written whole or not at all."""

from __future__ import annotations

import base64
import html
import inspect
import io
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from diffdrive_mj import _checks as checks
from diffdrive_mj._files import as_path, own_files, replace_all
from diffdrive_mj._text import html_table
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.report import replays
from diffdrive_mj.report._provenance import provenance
from diffdrive_mj.report.replays import Replay

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# What a report itself writes into `metrics.json`, beside its metrics.
OWN = ("question", "finding", "table", "bounds", "provenance", "pictures", "replays")


@dataclass(frozen=True)
class Bound:
    """States a figure and the limit that it must keep.

    Args:
        name: what is bounded.
        value: as measured.
        limit: the largest allowed value, or the smallest with `at_least`.
        unit: of both.
        at_least: whether the limit is a lower one.

    Example:
        >>> print(dd.report.Bound("position error", 0.31, 1.0, "ppm"))
        ok     position error: 0.31 <= 1 ppm
        >>> dd.report.Bound("position error", float("nan"), 1.0, "ppm").holds
        False
    """

    name: str
    value: float
    limit: float
    unit: str = ""
    at_least: bool = False

    @property
    def holds(self) -> bool:
        """Whether the value keeps the limit; a value that is not a number never does."""
        return bool(self.value >= self.limit if self.at_least else self.value <= self.limit)

    def __str__(self) -> str:
        relation = ">=" if self.at_least else "<="
        verdict = "ok    " if self.holds else "BROKEN"
        return f"{verdict} {self.name}: {self.value:.4g} {relation} {self.limit:.4g} {self.unit}".rstrip()


@dataclass(frozen=True, eq=False)
class Report:
    """Holds the outcome of an experiment, and prints as its report.

    Args:
        question: that was asked; of a script's docstring (`__doc__`) the first paragraph.
        finding: one or two sentences that answer it, with numbers.
        table: to print.
        bounds: that the experiment declares.
        metrics: numbers, lists and strings for `metrics.json`.
        pictures: figures by file name, without the ending.
        replays: drives that the report page replays (`report.page`).

    Raises:
        InvalidType: metrics that are no mapping, or replays of another kind.
        InvalidValue: a metric by a name that the report itself writes.

    Example:
        >>> bound = dd.report.Bound("error", 0.2, 1.0, "mm")
        >>> print(dd.report.Report("How far off?", "Hardly.", "error  0.2 mm", [bound]))
        How far off?
        <BLANKLINE>
        error  0.2 mm
        <BLANKLINE>
        Hardly.
        ok     error: 0.2 <= 1 mm
    """

    question: str | None
    finding: str
    table: str
    bounds: Sequence[Bound]
    metrics: Mapping[str, Any] = field(default_factory=dict)
    pictures: Mapping[str, Figure] = field(default_factory=dict)
    replays: Sequence[Replay] = ()

    def __post_init__(self) -> None:
        if taken := [name for name in OWN if name in self.metrics]:
            raise InvalidValue(f"Report.metrics: {taken[0]!r} is what the report itself writes; choose another name")
        object.__setattr__(self, "replays", checks.instances("Report.replays", self.replays, Replay))
        paragraph = inspect.cleandoc(self.question or "").partition("\n\n")[0]
        object.__setattr__(self, "question", " ".join(paragraph.split()))

    @property
    def holds(self) -> bool:
        """Whether every bound holds."""
        return all(bound.holds for bound in self.bounds)

    def __str__(self) -> str:
        return "\n".join([self.question or "", "", self.table, "", self.finding, *map(str, self.bounds)])

    def _repr_html_(self) -> str:
        bounds = [
            (b.name, b.value, f"{'≥' if b.at_least else '≤'} {b.limit:.4g} {b.unit}", b.holds) for b in self.bounds
        ]
        parts = [
            f"<h4>{html.escape(self.question or '')}</h4>",
            f"<pre>{html.escape(self.table)}</pre>",
            f"<p>{html.escape(self.finding)}</p>",
            html_table(bounds, ("bound", "value", "limit", "holds")),
        ]
        return "\n".join([*parts, *map(_image, self.pictures.values())])

    def write(self, folder: Path, *, command: str = "", options: Mapping[str, Any] | None = None) -> None:
        """Write the pictures, the replays and `metrics.json` into a folder, each file whole or not at all.

        What an earlier run left there, which its `metrics.json` lists, is replaced, and removed if it is no longer
        made; anything else in the folder stays. Links are followed, and files keep their permissions.

        Args:
            folder: of this experiment's results; it and its parents are made.
            command: that runs it again, as one types it; the report page shows it.
            options: of the experiment by name, those by default among them.

        Raises:
            InvalidValue: the folder cannot be written, or a file is in the way that no earlier run has written.

        Example:
            >>> from pathlib import Path
            >>> from tempfile import TemporaryDirectory
            >>> with TemporaryDirectory() as results:
            ...     dd.report.Report("How far off?", "Hardly.", "", []).write(Path(results, "mine"))
            ...     print([path.name for path in Path(results, "mine").iterdir()])
            ['metrics.json']
        """
        folder = as_path("folder", folder)
        content = {
            "question": self.question,
            "finding": self.finding,
            "table": self.table,
            "bounds": [{**vars(bound), "holds": bound.holds} for bound in self.bounds],
            "provenance": provenance(command, options or {}),
            **self.metrics,
            "pictures": [f"{name}.png" for name in self.pictures],
        }
        files: dict[str, str | bytes] = {}
        if self.replays:
            content["replays"], files[replays.FILE] = replays.FILE, replays.to_json(self.replays)
        text = json.dumps(_plain(content), indent=1, allow_nan=False) + "\n"
        try:
            files |= {f"{name}.png": _png(figure, dpi=150) for name, figure in self.pictures.items()}
        except OSError as error:
            raise InvalidValue(f"{folder}: cannot be written ({error.strerror})") from None
        earlier = left_by_earlier_run(folder, ["metrics.json", *files])
        replace_all(folder, {"metrics.json": text, **files}, {"metrics.json", *earlier})


def left_by_earlier_run(folder: Path, names: Iterable[str]) -> set[str]:
    """Return the files beside `metrics.json` that an earlier run of an experiment has left in a folder.

    Args:
        folder: of the results, which need not be there.
        names: of the files that shall be written into it.

    Raises:
        InvalidValue: one of these is there, and no earlier run has written it.

    Example:
        >>> from pathlib import Path
        >>> from tempfile import TemporaryDirectory
        >>> with TemporaryDirectory() as folder:
        ...     written = Path(folder, "metrics.json").write_text("my own")
        ...     left_by_earlier_run(Path(folder), ["metrics.json"])
        Traceback (most recent call last):
        diffdrive_mj.errors.InvalidValue: ...metrics.json: was not written by an experiment: move it, or choose ...
    """
    foreign = "was not written by an experiment: move it, or choose another folder (--output)"
    return own_files(folder, names, _listed, foreign) - {"metrics.json"}


def _listed(folder: Path) -> set[str]:
    """The files that an earlier run says it has left: none where there is no such list."""
    try:
        content = json.loads((folder / "metrics.json").read_text(encoding="utf-8"))
        pictures = [name for name in content["pictures"] if name.endswith(".png") and Path(name).name == name]
        others = {replays.FILE} if content.get("replays") == replays.FILE else set()
        return {"metrics.json", *pictures, *others} if {"question", "finding", "bounds"} <= content.keys() else set()
    except (OSError, ValueError, TypeError, KeyError, AttributeError, RecursionError):
        return set()


def _png(figure: Figure, dpi: int) -> bytes:
    written = io.BytesIO()
    figure.savefig(written, format="png", dpi=dpi)
    return written.getvalue()


def _image(figure: Figure) -> str:
    return f'<img src="data:image/png;base64,{base64.b64encode(_png(figure, dpi=100)).decode()}"/>'


def _plain(value: Any) -> Any:
    """A value as JSON has it; what is not finite becomes null."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray):
        return _plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, np.generic):
        return _plain(value.item())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
