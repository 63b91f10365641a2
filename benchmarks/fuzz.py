"""Rubbish for files, for the command line and for every public function: what is refused, is refused in one line.

    python benchmarks/fuzz.py --cases 200000

A case passes where it is accepted or ends in an error of the package's family (on the command line in exit status 2)
whose message is one line, with nothing written and no other warning than the package's own. A fault is printed with its
case's number when its kind is first seen, and `--first NUMBER --cases 1` repeats it. Physics does not run: it is slow,
and what reaches it has been accepted.
"""

from __future__ import annotations

import argparse
import contextlib
import inspect
import io
import os
import random
import shutil
import sys
import tempfile
import traceback
import types
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Protocol
from unittest import mock

from rubbish import COMMAND_LINES, DRIVE, FILES, OBJECTS, ROBOT, USUAL, damaged, some_value

import diffdrive_mj as dd
from diffdrive_mj import cli
from diffdrive_mj._text import shown
from diffdrive_mj.errors import DiffdriveError, PhysicsWarning


class Enough(BaseException):
    """The inputs have been accepted; what follows is work."""


class Fault(Exception):
    """What no case may do."""


def some_file(rng: random.Random) -> None:
    """Read a file that was damaged, byte by byte or word by word."""
    name = rng.choice(list(FILES))
    if rng.random() < 0.5:
        data = FILES[name].encode()
        for _ in range(rng.choice((1, 1, 2, 5))):
            at = rng.randrange(len(data) + 1)
            new = rng.choice((rng.randbytes, lambda k: bytes(rng.choices(FILES[name].encode(), k=k))))
            data = data[:at] + new(rng.choice((0, 1, 1, 9))) + data[at + rng.choice((0, 1, 1, 40)) :]
    else:
        words = FILES[name].replace(",", " , ").replace("\n", " \n ").split(" ")
        data = "".join(damaged(rng, words)).encode()
    path = Path(name)
    path.write_bytes(data)
    if name.startswith("7_"):
        dd.logs.read_optiodom(path.parent)
    elif name == "r.toml":
        dd.Robot.load(path).to_toml()
    else:
        columns = dd.logs.Columns(**rng.choice(({}, {}, {"counter_bits": 16, "wheel_unit": "ticks"}, {"time": 1})))
        drive = dd.logs.read_csv(path, columns, ROBOT)
        dd.diagnosis.suspicions(drive, ROBOT)
        if rng.random() < 0.1:
            dd.calibration.least_squares([drive, DRIVE], ROBOT, anyway=rng.random() < 0.5)


def some_command(rng: random.Random) -> None:
    """Run a command whose arguments are not as they should be."""
    arguments = damaged(rng, rng.choice(COMMAND_LINES).split())
    before, status, said = everything(), 0, io.StringIO()
    try:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(said):
            cli.main(arguments)
    except SystemExit as end:
        status = end.code or 0
    lines = said.getvalue().count("\n")
    if status not in (0, 1, 2) or lines != (status == 2) or (status == 2 and before != everything()):
        raise Fault(f"{arguments}: status {status}, {said.getvalue()!r}, {everything().keys() ^ before.keys()} written")
    if status == 2:
        raise DiffdriveError


def some_call(rng: random.Random) -> None:
    """Call a public function, a class or a method with some values that it should not get."""
    function = rng.choice(CALLABLES)
    arguments: list[Any] = []
    options: dict[str, Any] = {}
    for name, parameter in inspect.signature(function).parameters.items():
        needed = parameter.default is parameter.empty and parameter.kind is not parameter.VAR_KEYWORD
        if name.startswith("_") or not (needed or rng.random() < 0.4):
            continue
        usual = USUAL.get(f"{function.__name__}.{name}", USUAL.get(name, USUAL.get(str(parameter.annotation))))
        value = some_value(rng, usual)
        if needed and parameter.kind is not parameter.KEYWORD_ONLY:
            arguments.append(value)
        else:
            options[name] = value
    try:
        function(*arguments, **options)
    except DiffdriveError:
        raise
    except Exception as error:
        values = [*map(shown, arguments), *(f"{name}={shown(value)}" for name, value in options.items())]
        raise Fault(f"{function.__qualname__}({', '.join(values)})") from error


def everything() -> dict[Path, bytes | None]:
    """What is in the folder."""
    return {path: path.read_bytes() if path.is_file() else None for path in Path().rglob("*")}


def callables() -> Iterator[Callable[..., Any]]:
    """What the package's list of names leads to: its functions, classes and their methods on an instance."""
    found = [getattr(dd, name) for name in dd.__all__ if name not in ("errors", "plots", "report")]
    for thing in found:
        if isinstance(thing, types.ModuleType) and thing.__name__.startswith("diffdrive_mj"):
            # Which modules a package without a list has depends on what was imported before.
            own = [name for name, value in vars(thing).items() if not isinstance(value, types.ModuleType)]
            found += [getattr(thing, name) for name in getattr(thing, "__all__", own) if name[0] != "_"]
        elif inspect.isclass(thing) or inspect.isfunction(thing):
            ours = thing.__module__.startswith("diffdrive_mj.") and "._" not in thing.__module__
            if ours and not (inspect.isclass(thing) and (issubclass(thing, Exception) or Protocol in thing.__bases__)):
                yield thing
    for thing in OBJECTS:
        methods = (types.FunctionType, classmethod, staticmethod)
        yield from (getattr(thing, n) for n, m in vars(type(thing)).items() if n[0] != "_" and isinstance(m, methods))


CALLABLES = sorted(set(callables()), key=lambda function: (function.__module__, function.__qualname__))


def outcome(rng: random.Random) -> tuple[str, str]:
    """What one case leads to: a word, and for a fault its kind."""
    tidy()
    work = rng.choices((some_file, some_command, some_call), (45, 8, 47))[0]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", PhysicsWarning)
        try:
            work(rng)
        except DiffdriveError as error:
            if len(str(error).splitlines()) <= 1:
                return f"{work.__name__}: refused", ""
            return f"{work.__name__}: FAULT", repr(error)
        except Enough:
            pass
        except Exception as error:
            cause = error.__cause__ or error
            frames = [frame for frame in traceback.extract_tb(cause.__traceback__) if "diffdrive_mj" in frame.filename]
            where = f" at {frames[-1].filename}:{frames[-1].lineno}" if frames else ""
            return f"{work.__name__}: FAULT", f"{type(cause).__name__}{where}"
    return f"{work.__name__}: accepted", ""


@contextlib.contextmanager
def workplace() -> Iterator[None]:
    """A folder of its own, no physics, and nothing drawn."""
    before, no_physics = Path.cwd(), mock.patch("diffdrive_mj.physics.simulation.Runs", side_effect=Enough)
    not_drawn = mock.patch("diffdrive_mj.report.filming._renderer._start", side_effect=Enough)
    with tempfile.TemporaryDirectory() as folder, no_physics, not_drawn:
        os.chdir(folder)
        try:
            yield
        finally:
            os.chdir(before)


def tidy() -> None:
    """Put the files back that the commands name, and nothing else."""
    for path in Path().iterdir():
        if path.is_dir():
            shutil.rmtree(path)
        elif path.name not in FILES:
            path.unlink()
    for name, text in FILES.items():
        Path(name).write_text(text)


def main() -> None:
    """Run the cases, print each new kind of fault, and count."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for option, default in (("--cases", 2000), ("--first", 0), ("--seed", 0)):
        parser.add_argument(option, type=int, default=default)
    asked = parser.parse_args()
    counts, kinds = Counter[str](), Counter[str]()
    with workplace():
        for case in range(asked.first, asked.first + asked.cases):
            word, kind = outcome(random.Random(f"{asked.seed} {case}"))
            counts[word] += 1
            kinds[kind] += 1
            if kind and kinds[kind] == 1:
                print(f"case {case}: {kind}", flush=True)
    print(*(f"{count:7} {word}" for word, count in sorted(counts.items())), sep="\n")
    sys.exit(any("FAULT" in word for word in counts))


if __name__ == "__main__":
    main()
