"""What an experiment produces: an answer, its bounds, metrics and pictures, written whole or not at all."""

from __future__ import annotations

import inspect
import json
import math
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from diffdrive_mj.errors import DiffdriveError, exit_on_error

if TYPE_CHECKING:
    from matplotlib.figure import Figure


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
        question: that was asked.
        finding: one or two sentences that answer it, with numbers.
        table: to print.
        bounds: that the experiment declares.
        metrics: numbers, lists and strings for `metrics.json`.
        pictures: figures by file name, without the ending.

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

    question: str
    finding: str
    table: str
    bounds: Sequence[Bound]
    metrics: Mapping[str, Any] = field(default_factory=dict)
    pictures: Mapping[str, Figure] = field(default_factory=dict)

    @property
    def holds(self) -> bool:
        """Whether every bound holds."""
        return all(bound.holds for bound in self.bounds)

    def __str__(self) -> str:
        return "\n".join([self.question, "", self.table, "", self.finding, *map(str, self.bounds)])

    def write(self, folder: Path) -> None:
        """Write the pictures and `metrics.json` into a folder, replacing what an earlier run left there.

        Args:
            folder: of this experiment's results alone; its parents are made.

        Raises:
            OSError: the folder cannot be written; an earlier one stays.

        Example:
            >>> from pathlib import Path
            >>> from tempfile import TemporaryDirectory
            >>> with TemporaryDirectory() as results:
            ...     dd.report.Report("How far off?", "Hardly.", "", []).write(Path(results, "mine"))
            ...     print([path.name for path in Path(results, "mine").iterdir()])
            ['metrics.json']
        """
        folder = Path(folder)
        folder.parent.mkdir(parents=True, exist_ok=True)
        bounds = [{**vars(bound), "holds": bound.holds} for bound in self.bounds]
        content = {"question": self.question, "finding": self.finding, "bounds": bounds, **self.metrics}
        text = json.dumps(_plain(content), indent=1, allow_nan=False) + "\n"
        with tempfile.TemporaryDirectory(dir=folder.parent, prefix=f".{folder.name}-") as temporary:
            new = Path(temporary) / "new"
            new.mkdir()
            (new / "metrics.json").write_text(text, encoding="utf-8")
            for name, figure in self.pictures.items():
                figure.savefig(new / f"{name}.png", dpi=150)
            if folder.exists():
                folder.rename(Path(temporary) / "old")
            new.rename(folder)


def main(run: Callable[..., Report]) -> None:
    """Run an experiment as a program whose options are the function's parameters, and `--output`.

    The results go into a folder named after the function's file, inside that of `--output`. The program ends with exit
    status 0 when every bound holds, 1 when one is broken, 2 for bad input.

    Args:
        run: makes the report; its docstring is the program's help.

    Raises:
        SystemExit: always, with the exit status.

    Example:
        A script ends with

        >>> if __name__ == "__main__":
        ...     dd.report.main(run)
    """
    import tyro

    name = Path(inspect.getfile(run)).stem

    def program(output: Path = Path("results"), **settings: Any) -> int:
        report = run(**settings)
        folder = output / name
        try:
            report.write(folder)
        except OSError as error:
            raise DiffdriveError(f"{folder}: cannot be written ({error.strerror})") from None
        print(report)
        print(f"written: {folder}{'/*.png and ' if report.pictures else '/'}metrics.json\n")
        return 0 if report.holds else 1

    parameters = inspect.signature(run, eval_str=True).parameters.values()
    options = [p.replace(kind=inspect.Parameter.KEYWORD_ONLY) for p in parameters]
    first = inspect.Parameter("output", inspect.Parameter.KEYWORD_ONLY, default=Path("results"), annotation=Path)
    program.__signature__ = inspect.Signature([first, *options])  # type: ignore[attr-defined]
    program.__annotations__ = {p.name: p.annotation for p in (first, *options)}
    description = inspect.getdoc(run) or ""
    with exit_on_error(name):
        sys.exit(tyro.cli(program, prog=f"{name}.py", description=description))


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
