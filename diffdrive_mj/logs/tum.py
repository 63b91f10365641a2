"""Poses in TUM's format: a line for each, `timestamp tx ty tz qx qy qz qw`, as evo reads and writes it."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from diffdrive_mj._files import write_whole
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.logs import _clocks
from diffdrive_mj.logs._format import Contents, Format
from diffdrive_mj.logs._planar import planar, spatial
from diffdrive_mj.logs._rows import is_text
from diffdrive_mj.logs._table import number_in, open_table
from diffdrive_mj.pose_log import PoseLog
from diffdrive_mj.robot import Robot

_COLUMNS = 8
# That are written at a time.
_ROWS = 1 << 12


def _load(path: Path, options: None, robot: Robot | None, wheels: bool, poses: bool) -> Contents:
    if wheels:
        raise InvalidValue(f"{path}: a TUM file has poses and no wheels: logs.read_poses reads it")
    with open_table(path, " ", header=False) as table:
        if table.width != _COLUMNS:
            raise InvalidValue(
                f"{table.row(0)}: {table.width} cells: a TUM file has {_COLUMNS}, timestamp tx ty tz qx qy qz qw, "
                "with blanks in between"
            )
        [(rows, there)] = table.read(range(_COLUMNS))
    assert there.all()  # white space leaves no cell empty
    found, lost = planar("poses", rows[:, 1:], table.row)
    t, found, warnings = _clocks.settled(str(path), "poses", rows[:, 0], found, table.row)
    return Contents(poses=PoseLog(t, found, str(path), (*warnings, *lost)))


def _save(path: Path, contents: Contents, options: None) -> None:
    """Write the poses alone: the format has no wheels."""
    assert contents.poses is not None
    write_whole(path, itertools.chain(["# timestamp tx ty tz qx qy qz qw\n"], _rows(contents.poses)))


def _rows(log: PoseLog) -> Iterator[str]:
    """The lines, some thousand at a time, each number with all its digits."""
    for first in range(0, len(log.t), _ROWS):
        part = slice(first, first + _ROWS)
        rows = np.column_stack([log.t[part], spatial(log.poses[part])]).tolist()
        yield "".join(" ".join(map(repr, row)) + "\n" for row in rows)


def _looks(path: Path, head: bytes) -> bool:
    """Any text by the name of one, whose faults reading names; another if its first line is one."""
    if not is_text(head):
        return False
    lines = head.decode("utf-8-sig", errors="ignore").splitlines()
    row = next((line for line in lines if line.strip() and not line.lstrip().startswith("#")), "").split()
    return path.suffix.lower() == ".tum" or (len(row) == _COLUMNS and all(number_in(cell) is not None for cell in row))


FORMAT = Format(name="a TUM file", endings=(".tum", ".txt"), options=None, looks=_looks, load=_load, save=_save)
