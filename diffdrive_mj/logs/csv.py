"""Drives from CSV files, and back into them."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj._files import write_whole
from diffdrive_mj._text import shown
from diffdrive_mj.drive import Drive
from diffdrive_mj.errors import InvalidType, InvalidValue
from diffdrive_mj.logs._table import Table, open_table
from diffdrive_mj.robot import Robot
from diffdrive_mj.sensors._counters import check_bits, unwrap_counts

Wheels = Literal["counters", "increments"]
WheelUnit = Literal["radians", "ticks"]
TimeUnit = Literal["s", "ms", "us", "ns"]
PositionUnit = Literal["m", "cm", "mm"]
AngleUnit = Literal["rad", "deg"]

# How many of a unit make one of the SI's.
_PARTS = {"s": 1, "ms": 1e3, "us": 1e6, "ns": 1e9, "m": 1, "cm": 1e2, "mm": 1e3, "rad": 1, "deg": 180 / np.pi}
_CHOICES = {
    "wheels": Wheels, "wheel_unit": WheelUnit, "time_unit": TimeUnit, "position_unit": PositionUnit,
    "angle_unit": AngleUnit,
}  # fmt: skip
_POSE = ("x", "y", "theta")
# That are written at a time.
_ROWS = 1 << 12
_FIELDS = ("time", *_POSE, "left", "right")


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
        wheel_unit: of the wheels' columns; ticks need ticks_per_revolution.
        ticks_per_revolution: encoder ticks per turn of a wheel, gears included; the robot's if not given.
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
    wheels: Wheels = "counters"
    wheel_unit: WheelUnit = "radians"
    ticks_per_revolution: float | None = None
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
        for field in ("reverse_left", "reverse_right", *(("header",) if self.header is not None else ())):
            checks.boolean(f"Columns.{field}", getattr(self, field))
        for field, kind in _CHOICES.items():
            checks.member(f"Columns.{field}", getattr(self, field), get_args(kind))
        if self.ticks_per_revolution is not None:
            ticks = checks.positive("Columns.ticks_per_revolution", self.ticks_per_revolution)
            if self.wheel_unit != "ticks":
                raise InvalidValue(f"Columns.ticks_per_revolution = {ticks:g}: but wheel_unit is {self.wheel_unit!r}")
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
        robot: whose encoder's ticks count, if the columns do not say how many a wheel has.

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
    with open_table(path, columns.delimiter, columns.header) as table:
        where = {field: table.index(field, getattr(columns, field)) for field in _FIELDS}
        for field, other in itertools.combinations(_FIELDS, 2):
            if where[field] == where[other]:
                raise InvalidValue(f"{table.path}: {field} and {other} are both in {table.label(where[field])}")
        wheels = (where["left"], where["right"])
        time, wheel, pose = table.read((where["time"],), wheels, [where[field] for field in _POSE])
    t = _times(table, time, where["time"], columns)
    (turned, sampled), (truth, seen) = wheel, pose
    for rows, what in ((sampled, "samples of the wheels"), (seen, "true poses")):
        if np.count_nonzero(rows) < 2:
            raise InvalidValue(f"{table.path}: {np.count_nonzero(rows)} {what}: must be at least two")
    if columns.counter_bits:

        def named(cell: tuple[int, ...]) -> str:
            return table.at(int(np.flatnonzero(sampled)[cell[0]]), wheels[cell[1]])

        turned = unwrap_counts(turned, columns.counter_bits, name=named).astype(np.float64)
    return Drive(
        t[sampled],
        _angles(turned, columns, robot, table.path),
        truth / [_PARTS[columns.position_unit], _PARTS[columns.position_unit], _PARTS[columns.angle_unit]],
        t[seen],
        name=str(table.path),
    )


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
    write_whole(path, itertools.chain(["t,left,right,x,y,theta\n"], _written(drive)))


def _written(drive: Drive) -> Iterator[str]:
    """The rows of a drive, some thousand at a time."""
    times = np.union1d(drive.t, drive.clock)
    for first in range(0, len(times), _ROWS):
        block = times[first : first + _ROWS]
        cells = {t: [""] * 5 for t in block.tolist()}
        for at, values, columns in (
            (drive.t, drive.wheel_angles, slice(0, 2)),
            (drive.clock, drive.truth, slice(2, 5)),
        ):
            here = slice(np.searchsorted(at, block[0]), np.searchsorted(at, block[-1], side="right"))
            for t, row in zip(at[here].tolist(), values[here].tolist(), strict=True):
                cells[t][columns] = map(repr, row)
        yield "".join(f"{t!r},{','.join(row)}\n" for t, row in cells.items())


def _times(table: Table, read: tuple[Array, NDArray[np.bool_]], index: int, columns: Columns) -> Array:
    """The times of all rows (N,) [s], which must increase."""
    times, there = read
    if not there.all():
        raise InvalidValue(f"{table.at(int(np.argmin(there)), index)}: the cell is empty")
    t = times[:, 0] / _PARTS[columns.time_unit]
    back = np.flatnonzero(np.diff(t) <= 0)
    if back.size:
        k = int(back[0])
        raise InvalidValue(f"{table.at(k + 1, index)}: {t[k + 1]:.10g} s after {t[k]:.10g} s: times must increase")
    return t


def _angles(turned: Array, columns: Columns, robot: Robot | None, path: Path) -> Array:
    """Wheel angles (T, 2) [rad] from the cells of the wheels."""
    if columns.wheels == "increments":
        turned = np.cumsum(turned, axis=0)
    if columns.wheel_unit == "ticks":
        ticks = columns.ticks_per_revolution or (robot and robot.encoder.ticks_per_wheel_turn)
        if not ticks:
            raise InvalidValue(f"{path}: wheels in ticks need Columns.ticks_per_revolution or a robot")
        turned = turned * (2 * np.pi / ticks)
    signs = np.where([columns.reverse_left, columns.reverse_right], -1.0, 1.0)
    return turned * signs
