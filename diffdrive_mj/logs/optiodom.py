"""OptiOdom's recordings: wheel ticks of a real robot, with its true poses from motion capture."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from diffdrive_mj._files import as_path
from diffdrive_mj.drive import Drive
from diffdrive_mj.errors import InvalidValue, MissingFile
from diffdrive_mj.logs._table import open_table
from diffdrive_mj.logs.csv import Columns, read_csv
from diffdrive_mj.parts import WheelEncoder
from diffdrive_mj.robot import Robot


def read_optiodom(folder: str | Path) -> list[Drive]:
    r"""Read the runs of one recording of the OptiOdom data set.

    Args:
        folder: of the recording, with `<id>_metadata.csv` and `<id>_run-NN.csv`.

    Returns:
        One drive a run, in the order of the files.

    Raises:
        InvalidType: not a path.
        MissingFile: no such folder, or a file that is missing in it.
        InvalidValue: files that are not as they should be; the message names the line.

    References:
        Sousa et al. 2022; the recordings are in the repository sousarbarb/optiodom.

    Example:
        >>> from tempfile import TemporaryDirectory
        >>> with TemporaryDirectory() as folder:
        ...     files = {"7_metadata": "Li,0.2,\nDi,0.084,0.084\nngear,43.7,\nencRes,64,\n"}
        ...     files["7_run-01"] = "0,0,0,0,0,0\n0.05,0.1,0.2,0.3,10,20\n"
        ...     for name, text in files.items():
        ...         size = Path(folder, f"{name}.csv").write_text(text)
        ...     print([drive.name for drive in dd.logs.read_optiodom(folder)])
        ['7_run-01']
    """
    folder = as_path("folder", folder)
    identity, robot = _metadata(folder)
    # Right before left in these files.
    columns = Columns(time=1, x=2, y=3, theta=4, right=5, left=6, wheels="increments", wheel_unit="ticks", header=False)
    runs = sorted(folder.glob(f"{identity}_run-*.csv"))
    if not runs:
        raise MissingFile(f"{folder}: no {identity}_run-NN.csv in it")
    return [replace(read_csv(run, columns, robot), name=run.stem) for run in runs]


def optiodom_robot(folder: str | Path) -> Robot:
    r"""Read the nominal robot of an OptiOdom recording: wheels, track and encoder; the rest is the preset's.

    Args:
        folder: of the recording, with `<id>_metadata.csv`.

    Returns:
        The robot, named after the recording.

    Raises:
        InvalidType: not a path.
        MissingFile: no such folder, or no metadata in it.
        InvalidValue: metadata that are not as they should be; the message names the line.

    References:
        Sousa et al. 2022.

    Example:
        >>> from tempfile import TemporaryDirectory
        >>> with TemporaryDirectory() as folder:
        ...     text = "Li,0.2,\nDi,0.084,0.080\nngear,43.7,\nencRes,64,\n"
        ...     size = Path(folder, "7_metadata.csv").write_text(text)
        ...     robot = dd.logs.optiodom_robot(folder)
        >>> robot.name, robot.left_radius, robot.right_radius
        ('OptiOdom 7', 0.04, 0.042)
    """
    return _metadata(as_path("folder", folder))[1]


def _metadata(folder: Path) -> tuple[str, Robot]:
    """A recording's name and its nominal robot."""
    paths = sorted(folder.glob("*_metadata.csv"))
    if len(paths) != 1:
        raise MissingFile(f"{folder}: has {len(paths)} files <id>_metadata.csv: a recording's folder has one")
    with open_table(paths[0], ",", header=False) as table:
        rows = table.texts()
    keys = [row[0] for row in rows]
    numbers: dict[str, list[float]] = {}
    for key, count in (("Li", 1), ("Di", 2), ("ngear", 1), ("encRes", 1)):
        cells = [k for k, cell in enumerate(rows[keys.index(key)]) if cell][1:] if key in keys else []
        if len(cells) != count:
            raise InvalidValue(f"{paths[0]}: {key} has {len(cells)} values: must have {count}")
        row = keys.index(key)
        numbers[key] = [table.number(rows[row][index], row, index) for index in cells]
    right, left = numbers["Di"]
    identity = paths[0].name.removesuffix("_metadata.csv")
    return identity, Robot.load("optiodom").replace(
        name=f"OptiOdom {identity}",
        left_radius=left / 2,
        right_radius=right / 2,
        track_width=numbers["Li"][0],
        encoder=WheelEncoder(ticks_per_revolution=numbers["encRes"][0], gear=numbers["ngear"][0]),
    )
