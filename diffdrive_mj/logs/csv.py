"""Drives and poses from CSV files, and back into them."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, get_args

import numpy as np

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj._files import write_whole
from diffdrive_mj._text import shown
from diffdrive_mj.drive import Drive
from diffdrive_mj.errors import InvalidType, InvalidValue
from diffdrive_mj.logs import _clocks
from diffdrive_mj.logs._clocks import Mask
from diffdrive_mj.logs._format import Contents, Format, Wheels
from diffdrive_mj.logs._rows import is_text
from diffdrive_mj.logs._table import Table, open_table
from diffdrive_mj.logs._wheels import WheelUnit, check_gear, wheel_angles, wrapped
from diffdrive_mj.pose_log import PoseLog
from diffdrive_mj.robot import Robot
from diffdrive_mj.sensors._counters import check_bits, unwrap_counts

Counting = Literal["counters", "increments"]
TimeUnit = Literal["s", "ms", "us", "ns"]
PositionUnit = Literal["m", "cm", "mm"]
AngleUnit = Literal["rad", "deg"]

# How many of a unit make one of the SI's.
_PARTS = {"s": 1, "ms": 1e3, "us": 1e6, "ns": 1e9, "m": 1, "cm": 1e2, "mm": 1e3, "rad": 1, "deg": 180 / np.pi}
_CHOICES = {
    "wheels": Counting, "wheel_unit": WheelUnit, "time_unit": TimeUnit, "position_unit": PositionUnit,
    "angle_unit": AngleUnit,
}  # fmt: skip
_WHEELS, _POSE = ("left", "right"), ("x", "y", "theta")
# That are written at a time.
_ROWS = 1 << 12
_FIELDS = ("time", *_POSE, *_WHEELS)


@dataclass(frozen=True, kw_only=True)
class Columns:
    """Says which column of a CSV file holds what, and in which units; by default as `write_csv` writes.

    A column is the name in the header, or a number that counts from 1. A row may leave the three cells of the
    true pose empty, or the two of the wheels.

    Args:
        time: column of the time.
        x: column of the true x.
        y: column of the true y.
        theta: column of the true heading, counter-clockwise from x; it may wrap.
        left: column of the left wheel.
        right: column of the right wheel.
        wheels: "counters" hold how far a wheel has turned since the start, "increments" since the row before.
        wheel_unit: of the wheels' columns; ticks need ticks_per_revolution, metres the robot whose radii made them.
        ticks_per_revolution: encoder ticks per turn of a wheel, gears included; the robot's if not given.
        gear: turns of the motor's shaft for one of the wheel, if columns of radians, degrees or rotations are of the
            shaft.
        counter_bits: of a counter of ticks that wraps around, signed or unsigned; the wrapping is undone.
        reverse_left: count the left wheel's turning with the other sign.
        reverse_right: count the right wheel's turning with the other sign.
        time_unit: of the time.
        position_unit: of x and y.
        angle_unit: of theta.
        delimiter: between cells; detected if not given. A blank stands for any white space.
        header: whether the first line names the columns; detected if not given.

    Raises:
        InvalidType: a field of the wrong type; the message names it.
        UnknownName: an unknown unit, or an unknown kind of wheels.
        InvalidValue: a field that is out of its range, or fields that do not fit together.

    Example:
        >>> dd.logs.Columns(time="stamp", time_unit="ms", left=2, right=3, wheel_unit="ticks", counter_bits=16).left
        2
    """

    time: int | str = "t"
    x: int | str = "x"
    y: int | str = "y"
    theta: int | str = "theta"
    left: int | str = "left"
    right: int | str = "right"
    wheels: Counting = "counters"
    wheel_unit: WheelUnit = "radians"
    ticks_per_revolution: float | None = None
    gear: float | None = None
    counter_bits: Literal[16, 32] | None = None
    reverse_left: bool = False
    reverse_right: bool = False
    time_unit: TimeUnit = "s"
    position_unit: PositionUnit = "m"
    angle_unit: AngleUnit = "rad"
    delimiter: str | None = None
    header: bool | None = None

    def __post_init__(self) -> None:
        for field in _FIELDS:
            column = getattr(self, field)
            if isinstance(column, bool) or not isinstance(column, (int, str)):
                raise InvalidType(f"Columns.{field} = {shown(column)}: must be a name or a number")
            if isinstance(column, int) and column < 1:
                raise InvalidValue(f"Columns.{field} = {shown(column)}: columns count from 1")
        if self.header is not None:
            checks.boolean("Columns.header", self.header)
        for field, kind in _CHOICES.items():
            checks.member(f"Columns.{field}", getattr(self, field), get_args(kind))
        check_gear(self)
        check_bits("Columns.counter_bits", self.counter_bits)
        if self.counter_bits and (self.wheels, self.wheel_unit) != ("counters", "ticks"):
            raise InvalidValue(f"Columns.counter_bits = {self.counter_bits}: only counters of ticks wrap around")
        if self.delimiter is not None and (not isinstance(self.delimiter, str) or len(self.delimiter) != 1):
            raise InvalidValue(f"Columns.delimiter = {shown(self.delimiter)}: must be one character")


def read_csv(path: str | Path, columns: Columns = Columns(), robot: Robot | None = None) -> Drive:
    r"""Read the drive in a CSV file.

    Args:
        path: of the file; the drive is named after it.
        columns: which column holds what, and in which unit.
        robot: whose encoder's ticks count, if the columns do not say how many a wheel has; whose radii make turns of
            metres.

    Returns:
        The wheel angles and the true poses, each at the times at which the file has them.

    Raises:
        InvalidType: not a path, not columns, not a robot.
        MissingFile: no such file.
        UnknownName: a column that the file does not have.
        InvalidValue: anything else that is wrong with the file; the message names the line and the column.

    Example:
        >>> from tempfile import TemporaryDirectory
        >>> rows = "ms,left,right,x,y,theta\n0,0,0,0,0,0\n10,1,2,,,\n20,2,4,0.3,0,0.1\n"
        >>> with TemporaryDirectory() as folder:
        ...     path = Path(folder, "log.csv")
        ...     size = path.write_text(rows)
        ...     drive = dd.logs.read_csv(path, dd.logs.Columns(time="ms", time_unit="ms"))
        >>> drive.t, drive.clock
        (array([0.  , 0.01, 0.02]), array([0.  , 0.02]))
    """
    checks.instance("columns", columns, Columns)
    if robot is not None:
        checks.instance("robot", robot, Robot)
    contents = _load(path, columns, robot, wheels=True, poses=True)
    return contents.drive(str(path))


def write_csv(path: str | Path, drive: Drive) -> None:
    """Write a drive so that `read_csv` reads it back bit for bit, whole or not at all.

    Args:
        path: of the file; an earlier one is replaced.
        drive: to be written. `sensors.measure` makes drives of a recording.

    Raises:
        InvalidType: not a path, not a drive.
        InvalidValue: the file cannot be written.

    Example:
        >>> from tempfile import TemporaryDirectory
        >>> drive = dd.Drive([0.0, 0.1], [[0.0, 0.0], [1.0, 2.0]], [[0.0, 0.0, 0.0], [0.1, 0.0, 0.2]])
        >>> with TemporaryDirectory() as folder:
        ...     dd.logs.write_csv(Path(folder, "log.csv"), drive)
        ...     print(Path(folder, "log.csv").read_text(), end="")
        t,left,right,x,y,theta
        0.0,0.0,0.0,0.0,0.0,0.0
        0.1,1.0,2.0,0.1,0.0,0.2
    """
    checks.instance("drive", drive, Drive)
    _save(path, Contents(Wheels(drive.t, drive.wheel_angles), PoseLog(drive.clock, drive.truth)), None)


def _load(path: str | Path, options: Columns | None, robot: Robot | None, wheels: bool, poses: bool) -> Contents:
    columns = options or Columns()
    groups = {"wheels": _WHEELS if wheels else (), "poses": _POSE if poses else ()}
    fields = [field for field in _FIELDS if field in ("time", *groups["wheels"], *groups["poses"])]
    with open_table(path, columns.delimiter, columns.header) as table:
        where = {field: table.index(field, getattr(columns, field)) for field in fields}
        for field, other in itertools.combinations(fields, 2):
            if where[field] == where[other]:
                raise InvalidValue(f"{table.path}: {field} and {other} are both in {table.label(where[field])}")
        time, *read = table.read((where["time"],), *([where[f] for f in group] for group in groups.values() if group))
    (times, timed), index = time, where["time"]
    if not timed.all():
        raise InvalidValue(f"{table.at(int(np.argmin(timed)), index)}: the cell is empty")
    t = times[:, 0] / _PARTS[columns.time_unit]
    if (kept := _clocks.kept(t, read, lambda k: table.at(k, index))) is None:
        kept = np.ones(len(t), dtype=np.bool_)
    parts = dict(zip((name for name, group in groups.items() if group), read, strict=True))
    return Contents(
        _wheels(table, columns, robot, t, *parts["wheels"], kept, where) if wheels else None,
        _poses(table, columns, t, *parts["poses"], kept) if poses else None,
    )


def _wheels(
    table: Table,
    columns: Columns,
    robot: Robot | None,
    t: Array,
    turned: Array,
    sampled: Mask,
    kept: Mask,
    where: dict[str, int],
) -> Wheels:
    """The wheels of a table, from the rows that have them."""
    _refuse_few(table, "samples of the wheels", sampled)
    if columns.counter_bits:

        def named(cell: tuple[int, ...]) -> str:
            return table.at(int(np.flatnonzero(sampled)[cell[0]]), where[_WHEELS[cell[1]]])

        turned = unwrap_counts(turned, columns.counter_bits, name=named).astype(np.float64)
    if columns.wheels == "increments":
        # A repeated row repeats what was counted before: nothing was counted twice.
        turned = np.cumsum(np.where(kept[sampled][:, None], turned, 0.0), axis=0)
    clock, turned, dropped = _without_repeats(t, turned, sampled, kept)
    known = (*_clocks.remarks("wheels", clock, dropped), *wrapped(turned.T, columns.wheel_unit))
    return Wheels(clock, wheel_angles(turned, columns, robot, table.path), known)


def _poses(table: Table, columns: Columns, t: Array, poses: Array, seen: Mask, kept: Mask) -> PoseLog:
    """The poses of a table, from the rows that have them."""
    _refuse_few(table, "true poses", seen)
    clock, poses, dropped = _without_repeats(t, poses, seen, kept)
    poses = poses / [_PARTS[columns.position_unit], _PARTS[columns.position_unit], _PARTS[columns.angle_unit]]
    return PoseLog(clock, poses, str(table.path), _clocks.remarks("poses", clock, dropped))


def _without_repeats(t: Array, values: Array, there: Mask, kept: Mask) -> tuple[Array, Array, int]:
    """The times and values of rows that count, and how many do not."""
    return t[there & kept], values[kept[there]], int(np.count_nonzero(there & ~kept))


def _refuse_few(table: Table, what: str, rows: Mask) -> None:
    if np.count_nonzero(rows) < 2:
        raise InvalidValue(f"{table.path}: {np.count_nonzero(rows)} {what}: must be at least two")


def _save(path: str | Path, contents: Contents, options: Columns | None) -> None:
    """Write with the default columns, which are the only ones: options are refused before."""
    parts: list[tuple[Sequence[str], Array, Array]] = []
    if contents.wheels is not None:
        parts.append((_WHEELS, contents.wheels.t, contents.wheels.angles))
    if contents.poses is not None:
        parts.append((_POSE, contents.poses.t, contents.poses.poses))
    names = itertools.chain(["t"], *(columns for columns, _, _ in parts))
    write_whole(path, itertools.chain([",".join(names) + "\n"], _rows([part[1:] for part in parts])))


def _rows(parts: Sequence[tuple[Array, Array]]) -> Iterator[str]:
    """The rows of several clocks and what they have (M, K), some thousand at a time."""
    times = parts[0][0]
    for t, _ in parts[1:]:
        times = np.union1d(times, t)
    width = sum(values.shape[1] for _, values in parts)
    for first in range(0, len(times), _ROWS):
        block = times[first : first + _ROWS]
        cells = {t: [""] * width for t in block.tolist()}
        column = 0
        for at, values in parts:
            here = slice(np.searchsorted(at, block[0]), np.searchsorted(at, block[-1], side="right"))
            for t, row in zip(at[here].tolist(), values[here].tolist(), strict=True):
                cells[t][column : column + len(row)] = map(repr, row)
            column += values.shape[1]
        yield "".join(f"{t!r},{','.join(row)}\n" for t, row in cells.items())


def _looks(path: Path, head: bytes) -> bool:
    return is_text(head)


FORMAT = Format(
    name="a CSV file", endings=(".csv", ".txt", ".tsv"), options=Columns, looks=_looks, load=_load, save=_save
)
