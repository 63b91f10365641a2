"""`diffdrive suite`: drives with exact poses as CSV files, for odometry in any language to test itself."""

from __future__ import annotations

import shlex
from typing import Annotated

import tyro


def command(
    folder: Annotated[str, tyro.conf.Positional, tyro.conf.arg(metavar="FOLDER", help_behavior_hint="(required)")], /
) -> None:
    """Write the conformance suite: drives with exact poses, for odometry in any language to test itself.

      diffdrive suite cases

    A CSV file a drive: the robot's numbers, what its wheels read, the exact poses and how far one may be off them.
    README.md, beside them, says in a page how a runner reads and compares; examples/ in the source archive has runners
    in Python, C, C++, JavaScript, Java and Rust. index.json lists the drives. What an earlier run has written is
    replaced, nothing else.

    Exit status: 0, or 2 for bad input, of which one line on stderr says what is wrong.

    Args:
        folder: where to write the files; made if it is not there.

    Raises:
        DiffdriveError: the folder cannot be written, or a file in it is not the suite's.

    Example:
        >>> from diffdrive_mj.cli import main
        >>> from tempfile import TemporaryDirectory
        >>> with TemporaryDirectory() as folder:
        ...     main(["suite", folder])
        written: ...
    """
    from diffdrive_mj.judging.suite import write  # loads mpmath

    files = write(folder)
    print(f"written: {len(files)} drives as CSV files into {shlex.quote(folder)}; README.md there has the rules")
