"""OptiOdom's recordings (Sousa et al. 2022): wheel ticks of a real robot with motion-capture truth."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from diffdrive_mj.drive import Drive
from diffdrive_mj.errors import InvalidValue, MissingFile
from diffdrive_mj.logs._table import read_table
from diffdrive_mj.logs.csv import Columns, read_csv
from diffdrive_mj.parts import WheelEncoder
from diffdrive_mj.robot import Robot


def read_optiodom(folder: str | Path) -> list[Drive]:
    """The runs of one recording of the OptiOdom data set (Sousa et al. 2022), wheel ticks with motion-capture truth.

    Args:
        folder: of the recording, with `<id>_metadata.csv` and `<id>_run-NN.csv`.

    Raises:
        MissingFile, InvalidValue: no such folder, or files that are not as they should be.
    """
    identity, robot = _optiodom_metadata(folder)
    # Right before left in these files.
    columns = Columns(time=1, x=2, y=3, theta=4, right=5, left=6, wheels="increments", wheel_unit="ticks", header=False)
    runs = sorted(Path(folder).glob(f"{identity}_run-*.csv"))
    if not runs:
        raise MissingFile(f"{folder}: no {identity}_run-NN.csv in it")
    return [replace(read_csv(run, columns, robot), name=run.stem) for run in runs]


def optiodom_robot(folder: str | Path) -> Robot:
    """The nominal robot of an OptiOdom recording: wheels, track and encoder from its metadata, the rest the preset's.

    Raises:
        MissingFile, InvalidValue: as for `read_optiodom`.
    """
    return _optiodom_metadata(folder)[1]


def _optiodom_metadata(folder: str | Path) -> tuple[str, Robot]:
    paths = sorted(Path(folder).glob("*_metadata.csv"))
    if len(paths) != 1:
        raise MissingFile(f"{folder}: has {len(paths)} files <id>_metadata.csv: a recording's folder has one")
    table = read_table(paths[0], ",", header=False)
    keys = [row[0] for row in table.rows]
    numbers: dict[str, list[float]] = {}
    for key, count in (("Li", 1), ("Di", 2), ("ngear", 1), ("encRes", 1)):
        cells = [k for k, cell in enumerate(table.rows[keys.index(key)]) if cell][1:] if key in keys else []
        if len(cells) != count:
            raise InvalidValue(f"{paths[0]}: {key} has {len(cells)} values: must have {count}")
        numbers[key] = [table.number(keys.index(key), place) for place in cells]
    right, left = numbers["Di"]
    identity = paths[0].name.removesuffix("_metadata.csv")
    return identity, Robot.load("optiodom").replace(
        name=f"OptiOdom {identity}",
        left_radius=left / 2,
        right_radius=right / 2,
        track_width=numbers["Li"][0],
        encoder=WheelEncoder(ticks_per_revolution=numbers["encRes"][0], gear=numbers["ngear"][0]),
    )
