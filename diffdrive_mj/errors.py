"""One family of errors, each also the builtin that a caller would catch."""

from __future__ import annotations

import difflib
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager


class DiffdriveError(Exception):
    """Base of every error that the package raises on purpose."""


class InvalidValue(DiffdriveError, ValueError):
    """A value, a shape or a file's content that cannot be used."""


class InvalidType(DiffdriveError, TypeError):
    """A value of the wrong kind, such as a word where a number belongs."""


class UnknownName(DiffdriveError, KeyError, ValueError):
    """A name that is not among the valid ones; the message lists them and the nearest."""

    def __init__(self, kind: str, name: object, valid: Iterable[str]) -> None:
        """Args: kind: what is named, such as "method"; name: what was given; valid: what may be."""
        super().__init__(kind, name, tuple(sorted(valid)))

    def __str__(self) -> str:
        """The message; KeyError would show the repr of its arguments."""
        kind, name, names = self.args
        close = difflib.get_close_matches(str(name), names, n=1)
        hint = f"; did you mean {close[0]!r}?" if close else ""
        return f"unknown {kind} {name!r}: choose from {', '.join(names)}{hint}"


class MissingFile(DiffdriveError, FileNotFoundError):
    """A file that is not there."""


class RobotFell(DiffdriveError, RuntimeError):
    """A robot that tipped over, came to lie on its chassis, or left the floor for good."""


class SimulationDiverged(DiffdriveError, RuntimeError):
    """The physics broke down: an engine warning or a state that is not finite."""


class PhysicsWarning(UserWarning):
    """What wheel odometry cannot see: wheels that slip or leave the floor, or time steps that are too coarse."""


@contextmanager
def exit_on_error(program: str) -> Iterator[None]:
    """End a program on bad input: the error's message on stderr, exit status 2."""
    try:
        yield
    except DiffdriveError as error:
        print(f"{program}: {error}", file=sys.stderr)
        sys.exit(2)
