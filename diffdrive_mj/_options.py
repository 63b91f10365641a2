"""A function's parameters as the options of a program, whose refusals are one line."""

from __future__ import annotations

import contextlib
import functools
import io
import re
from collections.abc import Callable, Sequence
from typing import Any, TypeVar

from diffdrive_mj.errors import InvalidValue

R = TypeVar("R")

# What a refusal says beside what is wrong.
_NEEDLESS = ("For full helptext", "Argument helptext")


def parsed(function: Callable[..., R], program: str, arguments: Sequence[str] | None = None) -> Callable[[], R]:
    """The function with what a command line gives it, ready to be called.

    Args:
        function: its parameters are the options, its docstring is the help.
        program: what the user typed before the options.
        arguments: of the command line; by default those that the program was started with.

    Raises:
        InvalidValue: options that make no sense, in one line.
        SystemExit: 0 after the help.
    """
    import tyro

    # Only the parsing is watched: what the function itself prints is its own business.
    @functools.wraps(function)
    def prepared(*positional: Any, **options: Any) -> Callable[[], R]:
        return functools.partial(function, *positional, **options)

    refusal = io.StringIO()
    try:
        with contextlib.redirect_stderr(refusal):
            return tyro.cli(prepared, prog=program, args=arguments)
    except SystemExit as end:
        if not end.code:
            raise
    raise InvalidValue(f"{_in_one_line(refusal.getvalue())}; see {program} --help")


def _in_one_line(box: str) -> str:
    """What a box of tyro's says, without its frame, the options' help and the way to the help."""
    plain = re.sub(r"\x1b\[[0-9;]*m", "", box)  # a terminal gets colours
    lines = [line.strip("│|").rstrip()[1:] for line in plain.splitlines()[1:-1]]
    parts: list[list[str]] = [[]]
    for line in lines:
        if set(line.strip()) <= set("─-"):
            parts.append([])
        elif not line.startswith(" " * 8):
            parts[-1].append(line.strip())
    said = [" ".join(part) for part in parts if part and not part[0].startswith(_NEEDLESS)]
    line = re.sub(r"Error parsing \S+: ", "", "; ".join(said)).rstrip(".")
    return re.sub(r"Missing value for argument '(?:\w+\.)?(\w+)'\. Expected 1 values", _by_place, line)


def _by_place(found: re.Match[str]) -> str:
    """What to say where an argument without a name is missing, most often since it was given one."""
    return f"Missing: {found[1].upper()}, which is given by its place, without --{found[1].replace('_', '-')}"
