"""An experiment as a program: its options, its exit status, and one line for each refusal."""

from __future__ import annotations

import argparse
import inspect
import os
import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn

from diffdrive_mj.errors import InvalidValue, exit_on_error
from diffdrive_mj.report.experiment import Report


def main(run: Callable[..., Report]) -> None:
    """Run an experiment as a program whose options are the function's parameters, and `--output`.

    The results go into a folder named after the function's file, inside that of `--output`. The program ends with exit
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
    file = Path(inspect.getfile(run))
    with exit_on_error(file.stem):
        settings = _options(run, f"{file.stem}.py")
        folder = settings.pop("output") / file.stem
        _refuse_unwritable(folder)
        report = run(**settings)
        report.write(folder)
        print(report)
        print(f"written: {folder}{'/*.png and ' if report.pictures else '/'}metrics.json\n")
        sys.exit(0 if report.holds else 1)


class _Parser(argparse.ArgumentParser):
    """Refuses in one line."""

    def error(self, message: str) -> NoReturn:
        """End on a bad option."""
        raise InvalidValue(f"{message}; --help lists the options")


def _options(run: Callable[..., Report], prog: str) -> dict[str, Any]:
    """The values of the function's parameters and of `output`, read from the command line."""
    question = (inspect.getdoc(inspect.getmodule(run)) or "").partition("\n\n")[0]
    parser = _Parser(
        prog=prog, description=question, allow_abbrev=False, formatter_class=argparse.ArgumentDefaultsHelpFormatter
    )
    parser.add_argument(
        "--output",
        type=Path,
        default=Path("results"),
        metavar="PATH",
        help="folder in which that of the results is made",
    )
    described = dict(re.findall(r"^    (\w+): (.*(?:\n {8,}.*)*)", inspect.getdoc(run) or "", re.MULTILINE))
    for name, parameter in inspect.signature(run, eval_str=True).parameters.items():
        explained = " ".join(described.get(name, "").split()).rstrip(".").replace("%", "%%")
        kind = parameter.annotation  # float, int, str or Path
        option, metavar = f"--{name.replace('_', '-')}", kind.__name__.upper()
        parser.add_argument(option, type=kind, default=parameter.default, metavar=metavar, help=explained)
    return vars(parser.parse_args())


def _refuse_unwritable(folder: Path) -> None:
    """Say before the work that its results will have no place."""
    try:
        nearest = next(path for path in (folder, *folder.parents) if path.exists())
    except OSError as error:
        raise InvalidValue(f"{folder}: cannot be written ({error.strerror})") from None
    if not nearest.is_dir():
        raise InvalidValue(f"{folder}: cannot be written ({nearest} is a file)")
    if not os.access(nearest, os.W_OK | os.X_OK):
        raise InvalidValue(f"{folder}: cannot be written ({nearest} is read-only)")
