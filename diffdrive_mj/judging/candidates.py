"""Whose odometry is judged: a robot, a function, a class, or a program in any language; each answers with poses."""

from __future__ import annotations

import inspect
import re
import shlex
import shutil
import sys
import traceback
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from diffdrive_mj import _checks as checks
from diffdrive_mj import se2
from diffdrive_mj._checks import Array
from diffdrive_mj._text import one_line, shown
from diffdrive_mj.errors import CandidateFailed, InvalidType, MissingFile
from diffdrive_mj.judging._pipe import Talk
from diffdrive_mj.judging.tasks import Task, Unit
from diffdrive_mj.robot import Robot

# A Robot with the package's own odometry; a function from (wheel angles (T, 2), times (T,), robot) to poses (T, 3); a
# class with `update((left, right), t)`; a program's command line.
# A path of a shared library stands for the program that answers for it.
Candidate = Robot | Callable[..., Any] | Sequence[str] | Path
_LIBRARY = re.compile(r"\.(so(\.\d+)*|dylib|dll)$")
_NUMBERS = ("left_radius", "right_radius", "track_width")


def name_of(candidate: Candidate) -> str:
    """What to call a candidate.

    Raises:
        InvalidType: no candidate.

    Example:
        >>> name_of(["./my_odometry", "--fast"])
        './my_odometry --fast'
    """
    if isinstance(candidate, Robot):
        return candidate.name
    if callable(candidate):
        return getattr(candidate, "__name__", type(candidate).__name__)
    return one_line(str(candidate) if _is_library(candidate) else shlex.join(_command(candidate)))


def of_command_line(parts: Sequence[str]) -> Candidate:
    """Take a command line for a candidate: a program with its arguments, or a shared library.

    Args:
        parts: at least one.

    Raises:
        MissingFile: there is no such program or library, or it may not be executed.

    Example:
        >>> of_command_line(["python3", "my_odometry.py"])
        ['python3', 'my_odometry.py']
    """
    name, is_library = parts[0], len(parts) == 1 and _is_library(parts[0])
    if is_library and not Path(name).is_file():
        raise MissingFile(f"{one_line(name)}: no such library")
    if not is_library and shutil.which(name) is None:
        there = bool(name) and Path(name).is_file()
        what = "may not be executed; chmod +x cures it" if there else "no such program"
        raise MissingFile(f"{one_line(name) or shown(name)}: {what}")
    return Path(name) if is_library else list(parts)


def poses_of(candidate: Candidate, task: Task, *, unit: Unit = "rad", seconds: float = 10.0) -> Array:
    """Let a candidate solve a task.

    Args:
        candidate: a robot; a function or a class that takes the wheel angles in radians; or a program's command line,
            which is run anew for each task.
        task: to be solved.
        unit: of a program's readings.
        seconds: that a program may take.

    Returns:
        (T, 3) [m, m, rad].

    Raises:
        InvalidType: no candidate.
        CandidateFailed: it raises, hangs or dies, answers too few lines, or something other than finite poses.

    Example:
        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> task = Task("ahead", robot, [0.0, 1.0], [(0, 0), (10, 10)])
        >>> poses_of(robot, task)[-1].tolist()
        [1.0, 0.0, 0.0]
    """
    if isinstance(candidate, Robot):
        return task.odometry(candidate)
    if isinstance(candidate, type):
        return _called(candidate, task, unit, _streamed)
    if callable(candidate):
        return _called(candidate, task, unit, _at_once)
    return _by_program(name_of(candidate), _command(candidate), task, unit, checks.positive("seconds", seconds))


def _command(candidate: object) -> list[str]:
    """The command line of a program."""
    if _is_library(candidate):
        # Its own folder is not where the system looks for libraries.
        return [sys.executable, "-m", "diffdrive_mj.judging._library", str(Path(str(candidate)).absolute())]
    if isinstance(candidate, (list, tuple)) and candidate and all(isinstance(part, (str, Path)) for part in candidate):
        return [str(part) for part in candidate]
    raise InvalidType(
        f"candidate = {shown(candidate)}: must be a Robot, a function, a class, a shared library, or a program as a "
        "list of its command line, such as ['./my_odometry']"
    )


def _is_library(candidate: object) -> bool:
    return isinstance(candidate, (str, Path)) and _LIBRARY.search(str(candidate)) is not None


def _called(candidate: Callable[..., Any], task: Task, unit: Unit, call: Callable[..., Any]) -> Array:
    """The poses by a function or a class; an error of its own is named with its place."""
    name, asked_for = name_of(candidate), set(_parameters(candidate))
    answered: list[Any] = []  # by a class, as far as it came
    try:
        answer = call(candidate, task, unit, asked_for, answered)
    except (Exception, SystemExit) as error:  # whatever the candidate raises; it shall not end its judge
        at = len(answered) if isinstance(candidate, type) else None
        raise CandidateFailed(name, task.name, f"raised {_told_of(error)}", at) from error
    try:
        poses = checks.array("the answer", answer, len(task.t), 3)
    except (ValueError, TypeError) as error:
        raise CandidateFailed(name, task.name, f"answered no poses: {error}", _first_not_finite(answer)) from None
    if poses.ndim != 2:
        raise CandidateFailed(name, task.name, f"answered no poses: the answer has shape {poses.shape}")
    # What knows nothing of a start begins at the origin.
    return poses if asked_for & {"start", "header"} else se2.compose(task.start, poses)


def _told_of(error: BaseException) -> str:
    """An error of a candidate's in one line, with its place in the candidate's own file."""
    own = [frame for frame in traceback.extract_tb(error.__traceback__)[1:] if frame.filename != __file__]
    lines = [frame.lineno for frame in own if frame.filename == own[0].filename]  # not those of what it calls
    place = f" ({Path(own[0].filename).name}, line {lines[-1]})" if own else ""
    text = one_line(str(error).partition("\n")[0])
    return f"{type(error).__name__}{': ' * bool(text)}{text}{place}"


def _told(task: Task, unit: Unit, asked_for: set[str]) -> dict[str, Any]:
    """What a candidate is told by name."""
    known = {"start": task.start.copy(), "header": task.told(unit)}
    return {name: value for name, value in known.items() if name in asked_for}


def _at_once(function: Callable[..., Any], task: Task, unit: Unit, asked_for: set[str], _: list[Any]) -> Any:
    told = _told(task, unit, asked_for)
    if "header" in told:
        return function(np.array(task.read(unit)), task.t.copy(), **told)
    return function(task.wheel_angles.copy(), task.t.copy(), task.robot, **told)


def _streamed(kind: Callable[..., Any], task: Task, unit: Unit, asked_for: set[str], answers: list[Any]) -> Any:
    told = _told(task, unit, asked_for)
    if "header" in told:
        own = kind(**told)
    elif asked_for.issuperset(_NUMBERS):
        own = kind(**{name: getattr(task.robot, name) for name in _NUMBERS}, **told)
    else:
        own = kind(task.robot, **told)
    readings = task.read(unit) if "header" in told else task.wheel_angles.tolist()
    for (left, right), t in zip(readings, task.t.tolist(), strict=True):
        answers.append(own.update((left, right), t))
    return answers


def _first_not_finite(answer: Any) -> int | None:
    """The index of the first answer that is not finite; None if all are, or answers are not arrays of numbers."""
    try:
        bad = ~np.isfinite(np.asarray(answer, dtype=np.float64)).all(axis=-1)
    except (ValueError, TypeError):
        return None
    return int(np.argmax(bad)) if bad.ndim == 1 and bad.any() else None


def _parameters(function: Callable[..., Any]) -> list[str]:
    try:
        return list(inspect.signature(function).parameters)
    except (ValueError, TypeError):  # built in
        return []


def _by_program(name: str, command: list[str], task: Task, unit: Unit, seconds: float) -> Array:
    count = len(task.t)
    text = "".join(f"{line}\n" for line in task.lines(unit))
    try:
        talk = Talk(command, text, count, seconds)
    except OSError as error:
        raise CandidateFailed(name, task.name, f"cannot be started ({error.strerror})") from None
    said = f"; it said: {one_line(talk.said.strip().splitlines()[-1])}" if talk.said.strip() else ""
    lines = [line for line in talk.answer.splitlines() if line.strip() and not line.lstrip().startswith(b"#")]

    def failed(what: str, reading: int | None = None) -> CandidateFailed:
        return CandidateFailed(name, task.name, f"{what}{said}", reading)

    if talk.endless:
        raise failed(f"answered more than {count} lines, without an end")
    if talk.late and talk.status is not None:
        raise failed(f"ended, and what it has started did not within {seconds:g} s, and keeps its output open")
    if talk.late:
        raise failed(f"did not end within {seconds:g} s of its input, after {len(lines)} of {count} answers")
    if talk.status:
        how = f"was ended by signal {-talk.status}" if talk.status < 0 else f"ended with exit status {talk.status}"
        raise failed(f"{how} after {len(lines)} of {count} answers")
    if len(lines) != count:
        bad = next((k for k, line in enumerate(lines) if not _is_pose(line)), None)
        among = "" if bad is None else f", line {bad + 1} of them {shown(lines[bad].decode(errors='replace'))}"
        raise failed(f"answered {len(lines)} lines{among}: must be {count}, one x,y,theta for each reading")
    return _parsed(lines, failed)


def _parsed(lines: list[bytes], failed: Callable[..., CandidateFailed]) -> Array:
    """Poses from lines x,y,theta; the first that is none is named."""
    try:
        poses = np.array([line.split(b",") for line in lines], dtype=np.float64)
        if poses.shape == (len(lines), 3) and (np.abs(poses) <= checks.LARGEST).all():
            return poses
    except ValueError:
        pass
    bad = next(k for k, line in enumerate(lines) if not _is_pose(line))
    said = shown(lines[bad].decode(errors="replace"))
    raise failed(f"answered {said} to line {bad + 1}: must be x,y,theta", bad)


def _is_pose(line: bytes) -> bool:
    """Whether a line is x,y,theta, three numbers that are not beyond all bounds."""
    try:
        cells = [abs(float(cell)) for cell in line.split(b",")]
    except ValueError:
        return False
    return len(cells) == 3 and all(cell <= checks.LARGEST for cell in cells)
