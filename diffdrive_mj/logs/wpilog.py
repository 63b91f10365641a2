"""Drives and poses from WPILib's data logs (`.wpilog`)."""

from __future__ import annotations

from array import array
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from struct import Struct
from typing import TYPE_CHECKING, Any, get_args

import numpy as np

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj._extras import extra
from diffdrive_mj._progress import progress
from diffdrive_mj._text import listed
from diffdrive_mj.errors import InvalidValue, UnknownName
from diffdrive_mj.logs import _clocks
from diffdrive_mj.logs._format import Contents, Format, Wheels
from diffdrive_mj.logs._wheels import WheelUnit, check_gear, wheel_angles, wrapped
from diffdrive_mj.pose_log import PoseLog
from diffdrive_mj.robot import Robot

if TYPE_CHECKING:
    from wpiutil.log import DataLogReader

_POSE = "struct:Pose2d"
_NUMBERS = ("double", "float", "int64")
# x, y [m] and the heading [rad].
_POSE2D = Struct("<3d")
_STEP = 4096


@dataclass(frozen=True, kw_only=True)
class Entries:
    """Says what in a `.wpilog` is what. Where a name is not given, the only candidate is taken.

    Args:
        left: entry of the left wheel's position, a double, float or int64; by default the one with "left" in its name.
        right: entry of the right wheel's, likewise.
        pose: entry of the poses, a struct:Pose2d.
        wheel_unit: of the wheels; ticks need ticks_per_revolution, metres the robot whose radii made them.
        ticks_per_revolution: encoder ticks per turn of a wheel, gears included; the robot's if not given.
        gear: turns of the motor's shaft for one of the wheel, if radians, degrees or rotations are of the shaft.
        reverse_left: count the left wheel's turning with the other sign.
        reverse_right: count the right wheel's turning with the other sign.

    Raises:
        InvalidType: a field of the wrong type; the message names it.
        UnknownName: an unknown unit.
        InvalidValue: a field that is out of its range, or fields that do not fit together.

    Example:
        >>> dd.logs.Entries(left="/drive/left", right="/drive/right", wheel_unit="rotations", gear=10.71).pose is None
        True
    """

    left: str | None = None
    right: str | None = None
    pose: str | None = None
    wheel_unit: WheelUnit = "radians"
    ticks_per_revolution: float | None = None
    gear: float | None = None
    reverse_left: bool = False
    reverse_right: bool = False

    def __post_init__(self) -> None:
        for field in ("left", "right", "pose"):
            value = getattr(self, field)
            if value is not None and not checks.string(f"Entries.{field}", value):
                raise InvalidValue(f"Entries.{field} = '': must name something, or not be given")
        if self.left is not None and self.left == self.right:
            raise InvalidValue(f"Entries.left and Entries.right are both {self.left!r}: must differ")
        checks.member("Entries.wheel_unit", self.wheel_unit, get_args(WheelUnit))
        check_gear(self)


def _load(path: Path, options: Entries | None, robot: Robot | None, wheels: bool, poses: bool) -> Contents:
    names = options or Entries()
    reader = _opened(path)
    there = _started(path, reader)
    wanted: dict[str, str] = {}
    for field in (*(("left", "right") if wheels else ()), *(("pose",) if poses else ())):
        wanted[field] = _entry(field, getattr(names, field), there, path)
    kept, lost = _values(path, reader, {name: there[name] for name in wanted.values()})
    # A wheel that never turns has one value.
    found = {field: _clocked(path, name, *kept[name], 2 if field == "pose" else 1) for field, name in wanted.items()}
    log = None
    if poses:
        t, values, warnings = found["pose"]
        log = PoseLog(t, values, str(path), (*lost, *warnings))
        lost = ()
    return Contents(_wheels(found["left"], found["right"], names, robot, path, lost) if wheels else None, log)


def _opened(path: Path) -> DataLogReader:
    with extra("wpilog", "wpiutil", f"{path}: a WPILib data log"):
        from wpiutil.log import DataLogReader
    reader = DataLogReader(str(path))
    if not reader.isValid():
        raise InvalidValue(f"{path}: cannot be read as a WPILib data log (its header is damaged)")
    return reader


def _started(path: Path, reader: DataLogReader) -> dict[str, str]:
    """The types of the entries, by name."""
    try:
        starts = [record.getStartData() for record in reader if record.isStart()]
        return {start.name: start.type for start in starts}
    except (TypeError, ValueError):
        raise InvalidValue(f"{path}: cannot be read as a WPILib data log (the start of an entry is damaged)") from None


def _entry(field: str, name: str | None, there: dict[str, str], path: Path) -> str:
    """The entry that was named, or the only candidate."""
    kinds = (_POSE,) if field == "pose" else _NUMBERS
    if name is not None:
        if name not in there:
            raise UnknownName(f"entry of {path}", name, there)
        if there[name] not in kinds:
            raise InvalidValue(f"{path}: {name} is of type {there[name]}: must be {' or '.join(kinds)}")
        return name
    fit = [entry for entry, kind in there.items() if kind in kinds and (field == "pose" or field in entry.lower())]
    if len(fit) == 1:
        return fit[0]
    if fit:
        raise InvalidValue(f"{path}: {listed(fit)} may be {field}: name one, as in Entries({field}={fit[0]!r})")
    of_kind = [entry for entry, kind in there.items() if kind in kinds]
    what = "" if field == "pose" else f" has {field!r} in its name"
    there_are = f"name one of {listed(of_kind)}, as in Entries({field}={of_kind[0]!r})" if of_kind else "there is none"
    raise InvalidValue(f"{path}: no entry of type {' or '.join(kinds)}{what}: {there_are}")


def _values(
    path: Path, reader: DataLogReader, types: dict[str, str]
) -> tuple[dict[str, tuple[Array, Array]], tuple[str, ...]]:
    """The times [us] and values of some entries, by name, and what to know of the log."""
    times = {name: array("q") for name in types}
    numbers = {name: array("d") for name in types}
    keep: dict[int, tuple[str, Callable[[Any], Sequence[float]]]] = {}
    before, last = None, None
    with progress(f"reading {path.name}", path.stat().st_size, "B") as advance:
        done = 0
        for k, record in enumerate(reader, 1):
            if record.isStart():
                start = record.getStartData()
                keep.pop(start.entry, None)
                if start.name in types:
                    keep[start.entry] = (start.name, _reader(types[start.name]))
            elif not record.isControl() and record.getEntry() in keep:
                name, value = keep[record.getEntry()]
                try:
                    numbers[name].extend(value(record))
                except (TypeError, ValueError):
                    which = f"{path}, {name}, value {len(times[name]) + 1}"
                    raise InvalidValue(f"{which}: its {record.getSize()} bytes are no {types[name]}") from None
                times[name].append(record.getTimestamp())
            before, last = last, (record.getEntry(), record.getTimestamp())
            done += record.getSize()
            if k % _STEP == 0:
                advance(done)
                done = 0
    lost: tuple[str, ...] = ()
    if last is not None and last == before:
        # The reader gives the last whole record again where the one after it is cut short.
        lost = (f"the log ends within a record, after {last[1] / 1e6:.10g} s: it was cut short",)
        if last[0] in keep:
            name, _ = keep[last[0]]
            times[name].pop()
            del numbers[name][-(3 if types[name] == _POSE else 1) :]
    return {name: (np.frombuffer(times[name], dtype=np.int64), np.frombuffer(numbers[name])) for name in types}, lost


def _reader(kind: str) -> Callable[[Any], Sequence[float]]:
    """What takes the numbers out of a record."""
    if kind == _POSE:
        return _pose
    method = {"double": "getDouble", "float": "getFloat", "int64": "getInteger"}[kind]
    return lambda record: (getattr(record, method)(),)


def _pose(record: Any) -> tuple[float, ...]:
    raw = record.getRaw()
    if len(raw) != _POSE2D.size:
        raise ValueError
    return _POSE2D.unpack(raw)


def _clocked(path: Path, name: str, stamps: Array, numbers: Array, least: int) -> tuple[Array, Array, tuple[str, ...]]:
    """Times [s] and values without repeats, and what to know of them."""

    def at(k: int) -> str:
        return f"{path}, {name}, value {k + 1}"

    values = numbers.reshape(len(stamps), -1) if len(stamps) else np.zeros((0, 1))
    finite = np.isfinite(values).all(axis=1)
    if not finite.all():
        raise InvalidValue(f"{at(int(np.argmin(finite)))}: must be finite")
    return _clocks.settled(f"{path}, {name}", name, stamps / 1e6, values, at, least)


def _wheels(
    left: tuple[Array, Array, tuple[str, ...]],
    right: tuple[Array, Array, tuple[str, ...]],
    names: Entries,
    robot: Robot | None,
    path: Path,
    lost: tuple[str, ...],
) -> Wheels:
    """Both wheels at the times of either, from the first at which both are known."""
    sides = [_held(times, values[:, 0]) for times, values, _ in (left, right)]
    first, latest = (max(times[k] for times, _ in sides) for k in (0, -1))
    if any(len(times) > 1 and times[-1] < first for times, _ in sides):
        raise InvalidValue(f"{path}: one of the wheels ends before the other begins, at {first:.10g} s")
    # A wheel that ended long before the other stands still; one that ended a moment before is not known any more.
    ended = [latest - times[-1] > _clocks.GAP * _typical(times) for times, _ in sides]
    until = min(times[-1] for (times, _), over in zip(sides, ended, strict=True) if not over)
    t = np.union1d(*(times for times, _ in sides))
    t = t[(t >= first) & (t <= until)]
    if len(t) < 2:
        raise InvalidValue(f"{path}: both wheels are known at {len(t)} times: must be two")
    turned = np.column_stack([np.interp(t, times, values) for times, values in sides])
    still = [
        f"the {side} wheel has no value after {times[-1]:.10g} s, and was taken to stand still until {until:.10g} s"
        for side, (times, _), over in zip(("left", "right"), sides, ended, strict=True)
        if over
    ]
    known = (*lost, *left[2], *right[2], *still, *wrapped((left[1][:, 0], right[1][:, 0]), names.wheel_unit))
    return Wheels(t, wheel_angles(turned, names, robot, path), known)


def _typical(times: Array) -> float:
    """The median interval [s]; zero where there is none."""
    return float(np.median(np.diff(times))) if len(times) > 1 else 0.0


def _held(times: Array, values: Array) -> tuple[Array, Array]:
    """A wheel's times and values, and one more at the end of each gap: it stood still, as logs keep changes only."""
    after = _clocks.gaps(times)
    return np.insert(times, after + 1, times[after + 1] - _typical(times)), np.insert(values, after + 1, values[after])


FORMAT = Format(
    name="a WPILib data log",
    endings=(".wpilog",),
    options=Entries,
    looks=lambda path, head: head.startswith(b"WPILOG"),
    load=_load,
    save=None,
)
