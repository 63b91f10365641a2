"""The conformance suite: drives whose poses are known exactly, in Python and as files for any language."""

from __future__ import annotations

import functools
import json
import math
from pathlib import Path
from typing import Any

from diffdrive_mj._files import as_path, own_files, replace_all
from diffdrive_mj.errors import InvalidValue, MissingFile
from diffdrive_mj.judging._suite_drives import drives
from diffdrive_mj.judging._suite_page import PAGE
from diffdrive_mj.judging.cases import COLUMNS, Case, exact_case
from diffdrive_mj.parts import WheelEncoder
from diffdrive_mj.robot import Robot

INDEX, README = "index.json", "README.md"
_MARK = "diffdrive suite"
_ROBOT = ("left_radius", "right_radius", "track_width")


@functools.cache
def cases() -> tuple[Case, ...]:
    """Compute the cases of the suite, for `judge`: about a second at first, nothing from then on.

    Returns:
        The cases; each has its readings, the exact poses and the tolerance.

    Example:
        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> def euler(wheel_angles, t, robot):
        ...     return dd.odometry.integrate(wheel_angles, robot, "euler")
        >>> verdict = dd.judge(euler, [case for case in cases() if case.name in ("straight", "ten_hertz")])
        >>> [row.task.name for row in verdict.rows if not row.holds]
        ['ten_hertz']
    """
    return tuple(drives())


def write(folder: str | Path) -> list[Path]:
    """Write the suite into a folder: a CSV file a case, `index.json`, and a page that says how they are used.

    What an earlier run left there, which its `index.json` lists, is replaced; anything else in the folder stays.

    Args:
        folder: it and its parents are made.

    Returns:
        The files of the cases.

    Raises:
        InvalidValue: the folder cannot be written, or a file is in the way that no earlier run has written.
        InvalidType: not a path.

    Example:
        >>> from tempfile import TemporaryDirectory
        >>> with TemporaryDirectory() as folder:
        ...     print(len(write(folder)) == len(cases()))
        True
    """
    folder = as_path("folder", folder)
    content = {f"{case.name}.csv": "\n".join([*case.rows(), ""]) for case in cases()}
    names = [INDEX, README, *content]
    index = {"what": _MARK, "version": 1, "files": names, "cases": [_indexed(case) for case in cases()]}
    files = {INDEX: json.dumps(index, indent=1, allow_nan=False) + "\n", README: PAGE, **content}
    earlier = own_files(folder, names, _listed, "was not written by diffdrive suite: move it, or choose another folder")
    replace_all(folder, files, earlier)
    return [folder / name for name in content]


def _indexed(case: Case) -> dict[str, Any]:
    told = {name: value for name, value in case.told().items() if name != "counter_bits"}
    return {
        "file": f"{case.name}.csv", "name": case.name, "about": case.about, "readings": len(case.t),
        "counter_bits": case.counter_bits, **told,
    }  # fmt: skip


def _listed(folder: Path) -> set[str]:
    """The files that an earlier run says it has left."""
    try:
        content = json.loads((folder / INDEX).read_text(encoding="utf-8"))
        names = [name for name in content["files"] if Path(name).name == name and Path(name).suffix in (".csv", ".md")]
        return {INDEX, *names} if content["what"] == _MARK else set()
    except (OSError, ValueError, TypeError, KeyError, RecursionError):
        return set()


def read(path: str | Path) -> Case:
    """Read a case from its file, one of the suite's or one's own.

    Args:
        path: of the CSV file.

    Returns:
        The case, with the poses and the tolerance that the file states.

    Raises:
        MissingFile: no such file.
        InvalidValue: it is no such file; the message names the line.
        InvalidType: not a path.

    Example:
        >>> from tempfile import TemporaryDirectory
        >>> with TemporaryDirectory() as folder:
        ...     case = read(write(folder)[0])
        >>> case.name, case.poses.shape
        ('straight', (121, 3))
    """
    path = as_path("path", path)
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except FileNotFoundError:
        raise MissingFile(f"{path}: no such file") from None
    except (OSError, UnicodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "not a text file in UTF-8"
        raise InvalidValue(f"{path}: cannot be read ({reason})") from None
    told = _told(path, lines[0] if lines else "")
    if lines[1:2] != [COLUMNS]:
        raise InvalidValue(f"{path}, line 2: must name the columns, {COLUMNS}")
    rows = [_row(path, number, line) for number, line in enumerate(lines[2:], start=3) if line.strip()]
    if not rows:
        raise InvalidValue(f"{path}: there is a header and nothing below it")
    ticks = WheelEncoder(ticks_per_revolution=told.pop("ticks_per_revolution"))
    robot = Robot(**{name: told[name] for name in _ROBOT}, encoder=ticks)
    try:
        return exact_case(
            path.stem, "", robot, [row[0] for row in rows], [row[1:3] for row in rows],
            [told[name] for name in ("x", "y", "theta")], unit=told["unit"], counter_bits=told.get("counter_bits"),
            poses=[row[3:] for row in rows], tolerance=told["tolerance"],
        )  # fmt: skip
    except InvalidValue as error:
        raise InvalidValue(f"{path}: {error}") from None


def _told(path: Path, header: str) -> dict[str, Any]:
    """What the header says: words for the unit, numbers for the rest."""
    words = header.split()
    pairs = dict(word.partition("=")[::2] for word in words[3:])
    needed = {"unit", *_ROBOT, "ticks_per_revolution", "x", "y", "theta", "tolerance"}
    if words[:3] != ["#", "diffdrive", "1"]:
        raise InvalidValue(f"{path}, line 1: must begin with '# diffdrive 1'")
    if missing := sorted(needed - pairs.keys()):
        raise InvalidValue(f"{path}, line 1: {missing[0]} is missing")
    if pairs["unit"] not in ("rad", "ticks"):
        raise InvalidValue(f"{path}, line 1: unit={pairs['unit']}: must be rad or ticks")
    told: dict[str, Any] = {"unit": pairs.pop("unit")}
    for name, text in pairs.items():
        try:
            told[name] = int(text) if name == "counter_bits" else float(text)
        except ValueError:
            raise InvalidValue(f"{path}, line 1: {name}={text}: must be a number") from None
    if not 2 <= told.get("counter_bits", 16) <= 53:
        raise InvalidValue(f"{path}, line 1: counter_bits={told['counter_bits']}: must be 2 to 53")
    return told


def _row(path: Path, number: int, line: str) -> list[float]:
    """The numbers of a line, of which the pose must be finite."""
    try:
        row = [float(cell) for cell in line.split(",")]
    except ValueError:
        row = []
    if len(row) != 6 or not all(map(math.isfinite, row[3:])):
        raise InvalidValue(
            f"{path}, line {number}: must be {COLUMNS}, six numbers of which t, left and right may be NaN"
        )
    return row
