"""An experiment as a program: its options, its exit status, and one line for each refusal."""

from __future__ import annotations

import inspect
import os
import shlex
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from diffdrive_mj._files import as_path
from diffdrive_mj._options import parsed
from diffdrive_mj._resources import EXPERIMENTS
from diffdrive_mj.errors import InvalidValue, exit_on_error
from diffdrive_mj.report.experiment import Report, left_by_earlier_run
from diffdrive_mj.report.pages import page, refuse_foreign


def main(run: Callable[..., Report]) -> None:
    """Run an experiment as a program whose options are the function's parameters, and `--output`.

    The results go into a folder named after the function's file, inside that of `--output`, whose page
    (`report.page`) is made anew. The program ends with exit
    status 0 when every bound holds, 1 when one is broken, 2 for bad input, of which one line on stderr says what is
    wrong.

    Args:
        run: makes the report; its docstring says what the options are, that of its file what is asked.

    Raises:
        SystemExit: always, with the exit status.

    Example:
        A script ends with

        >>> if __name__ == "__main__":
        ...     dd.report.main(run)
    """
    name = Path(inspect.getfile(run)).stem
    with exit_on_error(name):
        report = parsed(_program(run, name), f"{name}.py")()
        sys.exit(0 if report.holds else 1)


def _program(run: Callable[..., Report], name: str) -> Callable[..., Report]:
    """The experiment with one option more, the folder in which its results get one of their own."""

    def program(output: Path, **settings: Any) -> Report:
        folder = output / name
        _refuse_unwritable(folder)
        report = run(**settings)
        report.write(folder, command=_command(run, name), options=settings)
        written = page(output)
        print(report)
        print(f"written: {folder}{'/*.png and ' if report.pictures else '/'}metrics.json\npage: {written}\n")
        return report

    first = inspect.Parameter("output", inspect.Parameter.KEYWORD_ONLY, default=Path("results"), annotation=Path)
    parameters = inspect.signature(run, eval_str=True).parameters.values()
    every = [first, *(p.replace(kind=inspect.Parameter.KEYWORD_ONLY) for p in parameters)]
    program.__signature__ = inspect.Signature(every)  # type: ignore[attr-defined]
    program.__annotations__ = {p.name: p.annotation for p in every}
    question = (inspect.getdoc(inspect.getmodule(run)) or "").partition("\n\n")[0]
    arguments = (inspect.getdoc(run) or "").partition("\nArgs:\n")[2]
    program.__doc__ = f"{question}\n\nArgs:\n    output: folder in which that of the results is made.\n{arguments}"
    return program


def _command(run: Callable[..., Report], name: str) -> str:
    """What to type to run the experiment again: its options are those that the program was started with."""
    own = Path(inspect.getfile(run)).resolve().parent == EXPERIMENTS
    return shlex.join([*(["diffdrive", "experiment", name] if own else ["python", sys.argv[0]]), *sys.argv[1:]])


def _refuse_unwritable(folder: Path) -> None:
    """Say before the work that its results will have no place."""
    folder = as_path("output", folder)
    nearest = next(path for path in (folder, *folder.parents) if path.exists())
    if not nearest.is_dir():
        raise InvalidValue(f"{folder}: cannot be written ({nearest} is a file)")
    if not os.access(nearest, os.W_OK | os.X_OK):
        raise InvalidValue(f"{folder}: cannot be written ({nearest} is read-only)")
    left_by_earlier_run(folder, ["metrics.json"])
    refuse_foreign(folder.parent)
