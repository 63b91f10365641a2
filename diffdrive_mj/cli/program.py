"""The program `diffdrive`: one file a command, loaded when it is used."""

from __future__ import annotations

import ast
import importlib
import inspect
import signal
import sys
import threading
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

_HELP = """\
usage: diffdrive COMMAND [options]

How wrong a differential-drive robot's odometry is, and why. For example

  diffdrive explain turtlebot3_burger

commands:
{commands}

Each says more with --help, as in diffdrive explain --help."""


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the program.

    Args:
        arguments: of the command line; by default those that the program was started with.

    Raises:
        SystemExit: 2 for bad input, of which one line on stderr says what is wrong; 0 after the help; 130 where the
            user interrupts it, 128 and the signal's number where a signal ends it.

    Example:
        >>> from diffdrive_mj.cli import main
        >>> main(["explain", "turtlebot3"])
        Traceback (most recent call last):
        ...
        SystemExit: 2
    """
    try:
        with _cleaning_up():
            given = list(sys.argv[1:] if arguments is None else arguments)
            with _typed(given), _warnings_in_a_line():
                _main(given)
    except KeyboardInterrupt:  # before that which ends programs has been imported
        sys.stderr.write("diffdrive: interrupted\n")
        sys.exit(130)


@contextmanager
def _typed(given: list[str]) -> Iterator[None]:
    """Let results record what has been typed, though the program may have been started from Python."""
    own, sys.argv = sys.argv, [sys.argv[0], *given]
    try:
        yield
    finally:
        sys.argv = own


@contextmanager
def _warnings_in_a_line() -> Iterator[None]:
    """Let what happened on a drive read as errors do, without the line of code that noticed it."""
    own = warnings.formatwarning

    def shown(message: Warning | str, category: type[Warning], *place: Any, **more: Any) -> str:
        from diffdrive_mj.errors import PhysicsWarning
        from diffdrive_mj.sweeps.failures import SweepWarning

        return (
            f"diffdrive: {message}\n"
            if issubclass(category, (PhysicsWarning, SweepWarning))
            else own(message, category, *place, **more)
        )

    warnings.formatwarning = shown
    try:
        yield
    finally:
        warnings.formatwarning = own


@contextmanager
def _cleaning_up() -> Iterator[None]:
    """Let signals that end programs end what this one has started, and take away what it has half written."""

    def end(number: int, _: object) -> None:
        sys.exit(128 + number)

    ending = [getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]
    if threading.current_thread() is not threading.main_thread():  # which alone is told of signals
        ending = []
    # What nohup has silenced stays so.
    earlier = {number: signal.signal(number, end) for number in ending if signal.getsignal(number) == signal.SIG_DFL}
    try:
        yield
    finally:
        for number, handler in earlier.items():
            signal.signal(number, handler)


def _main(given: list[str]) -> None:
    from diffdrive_mj.errors import InvalidValue, UnknownName, exit_on_error

    with exit_on_error("diffdrive"):
        if not given:
            raise InvalidValue(f"a command is missing: choose from {', '.join(commands())}; see diffdrive --help")
        if given[0] in ("-h", "--help"):
            print(_help())
        elif given[0] == "--version":
            from diffdrive_mj import __version__

            print(f"diffdrive {__version__}")
        elif given[0] in commands():
            run(*given)
        else:
            raise UnknownName("command", given[0], commands())


def commands() -> dict[str, Path]:
    """List the commands, each with its file.

    Example:
        >>> "judge" in commands()
        True
    """
    files = Path(__file__).parent.glob("*.py")
    return {file.stem: file for file in sorted(files) if file.stem[0] != "_" and file.stem != Path(__file__).stem}


def _help() -> str:
    # A file's first line is "`diffdrive NAME`: what it does."; nothing is imported to read it.
    said = {
        name: (ast.get_docstring(ast.parse(file.read_text(encoding="utf-8"))) or "").splitlines()[0].split(": ", 1)[-1]
        for name, file in commands().items()
    }
    return _HELP.format(commands="\n".join(f"  {name:<{max(map(len, said))}}  {line}" for name, line in said.items()))


def run(name: str, *options: str) -> None:
    """Run a command: options become its parameters, unless it takes them as they are, with `*options` alone.

    Args:
        name: of the command.
        options: as given on the command line.

    Example:
        >>> run("robots", "list")
        preset ...
    """
    command = importlib.import_module(f"{__package__}.{name}").command
    if [p.kind for p in inspect.signature(command).parameters.values()] == [inspect.Parameter.VAR_POSITIONAL]:
        command(*options)
    else:
        from diffdrive_mj._options import parsed

        parsed(command, f"diffdrive {name}", options)()
