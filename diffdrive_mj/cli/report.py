"""`diffdrive report`: the page of a folder's results."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import tyro


def command(
    folder: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="[FOLDER]")] = Path("results"),
    /,
) -> None:
    """Write the page of a folder's results: one file, to be opened in a browser or sent to somebody.

      diffdrive report results

    A card an experiment: question, answer, pictures, drives to replay, bounds, and the command that runs it again. What
    is missing or cannot be read, the card says.

    Exit status: 0, or 2 for bad input, of which one line on stderr says what is wrong.

    Args:
        folder: of the results, a folder an experiment.

    Raises:
        DiffdriveError: no such folder, no results in it, or a page that cannot be written.

    Example:
        >>> from diffdrive_mj.cli import main
        >>> main(["report", "nowhere"])
        Traceback (most recent call last):
        ...
        SystemExit: 2
    """
    from diffdrive_mj.report.pages import page  # loads SciPy and Pillow

    print(f"page: {page(folder)}")
