"""`diffdrive calibrate`: a robot's parameters from its logs."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Annotated, Literal

import tyro

from diffdrive_mj.calibration import export
from diffdrive_mj.calibration.result import Calibration
from diffdrive_mj.diagnosis.drives import suspicions
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.logs import Columns, read_csv
from diffdrive_mj.robot import Robot

Method = Literal["least_squares"]
ExportTo = Literal["none", export.Target]

# Imported when asked for: they load scipy.
_METHODS: dict[Method, str] = {"least_squares": "diffdrive_mj.calibration.paths"}


def command(
    logs: Annotated[
        tuple[Path, ...],
        tyro.conf.Positional,
        tyro.conf.arg(metavar="LOG.csv [LOG.csv ...]", help_behavior_hint="(required)"),
    ],
    /,
    robot: Annotated[str, tyro.conf.arg(metavar="ROBOT")],
    columns: tyro.conf.OmitArgPrefixes[Columns] = Columns(),  # noqa: B008
    method: Method = "least_squares",
    start: Literal["estimated", "truth"] = "estimated",
    headings: bool = True,
    export_to: Annotated[ExportTo, tyro.conf.arg(name="export")] = "none",
    output: Annotated[Path | None, tyro.conf.arg(metavar="ROBOT.toml")] = None,
) -> None:
    """Calibrate a robot from logs of its wheels and its true poses.

    Finds the wheels' radii and the track width with which odometry fits the logs best, and prints them with their
    uncertainty, beside how far the odometry was off before and is off after. What looks wrong with a log, such as
    encoders that are swapped, is printed first. Turns in both directions and some straight driving show all of the
    robot.

    A log has a line for each sample: time, left and right wheel, and the true pose (from motion capture, markers on
    the floor, a tape measure) where it is known; its cells stay empty elsewhere. For example

      diffdrive calibrate lab.csv --robot robot.toml --time stamp --time-unit ms --left enc_l --right enc_r
      --wheel-unit ticks --export ros2

    Exit status: 0, or 2 for bad input, of which one line on stderr says what is wrong.

    Args:
        logs: CSV files, each one drive of the robot; all of them with the same columns.
        robot: the nominal robot, with which its odometry computes now: a TOML file (left_radius, right_radius,
            track_width [m]; ticks_per_revolution in the table [encoder]) or the name of a preset.
        columns: of the logs.
        method: of calibration.
        start: how each drive starts: at a pose that is estimated too, or at its first true pose, for a truth as good
            as motion capture, compared with which the odometry is what errs.
        headings: whether the true headings count; without them only the positions do.
        export_to: print the calibrated robot in another stack's configuration format too: ros2 (diff_drive_controller),
            wpilib or duckietown, for which no turning gain is estimated, or toml, the testbed's own.
        output: file for the calibrated robot; --robot reads it.

    Raises:
        DiffdriveError: bad input; nothing is written then.

    Example:
        >>> from diffdrive_mj.cli import main
        >>> main(["calibrate", "--help"])
        Traceback (most recent call last):
        SystemExit: 0
    """
    if not logs:
        raise InvalidValue("no logs given; see diffdrive calibrate --help")
    if repeated := [log for k, log in enumerate(logs) if log in logs[:k]]:
        raise InvalidValue(f"{repeated[0]}: given twice, and one drive does not count as two")
    nominal = Robot.load(robot)
    drives = [read_csv(log, columns, nominal) for log in logs]
    for drive in drives:
        for suspicion in suspicions(drive, nominal):
            print(f"{drive.name}: {suspicion}")
    fit = getattr(importlib.import_module(_METHODS[method]), method)
    gain = False if export_to in export.WITHOUT_GAIN else None
    calibration: Calibration = fit(drives, nominal, start=start, headings=headings, turning_gain=gain)
    exported = "" if export_to == "none" else export.text(export_to, nominal, calibration.calibrated)
    if output is not None:
        calibration.calibrated.save(output)
    print(calibration)
    if exported:
        print(f"\n{exported}", end="")
    if output is not None:
        print(f"\nwritten: {output}")
