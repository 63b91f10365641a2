"""The program `diffdrive`: one file a command."""

from __future__ import annotations

from collections.abc import Sequence

import tyro

from diffdrive_mj.cli import calibrate, robots
from diffdrive_mj.errors import exit_on_error

_DESCRIPTION = "How wrong a differential-drive robot's odometry is, and why."


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the program.

    Args:
        arguments: of the command line; by default those that the program was started with.

    Raises:
        SystemExit: 2 for bad input, of which one line on stderr says what is wrong; 0 after the help.

    Example:
        >>> from diffdrive_mj.cli import main
        >>> main(["--help"])
        Traceback (most recent call last):
        SystemExit: 0
    """
    with exit_on_error("diffdrive"):
        tyro.extras.subcommand_cli_from_dict(
            {"calibrate": calibrate.command, "robots": robots.command},
            prog="diffdrive",
            description=_DESCRIPTION,
            args=arguments,
        )
