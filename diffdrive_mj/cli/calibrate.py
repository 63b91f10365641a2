"""`diffdrive calibrate`: a robot's parameters from its logs."""

from __future__ import annotations

import importlib
import inspect
import re
import shlex
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Annotated, Any, Literal

import tyro

from diffdrive_mj.calibration import export
from diffdrive_mj.calibration.result import Calibration
from diffdrive_mj.cli._left_out import Number
from diffdrive_mj.diagnosis.drives import mix_up, suspicions
from diffdrive_mj.errors import CalibrationRefused, InvalidValue
from diffdrive_mj.logs import Columns, read
from diffdrive_mj.robot import Robot

Method = Literal["least_squares", "from_fixes", "umbmark", "jung_chung", "speed_ratio"]
ExportTo = Literal["none", export.Target]

# Imported when asked for: they load scipy.
_METHODS: dict[Method, str] = {
    "least_squares": "paths", "from_fixes": "paths", "umbmark": "squares", "jung_chung": "squares",
    "speed_ratio": "straights",
}  # fmt: skip


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
    start: Literal["estimated", "position", "truth"] = "estimated",
    headings: bool = True,
    side: Number = None,
    anyway: bool = False,
    export_to: Annotated[ExportTo, tyro.conf.arg(name="export")] = "none",
    output: Annotated[Path | None, tyro.conf.arg(metavar="ROBOT.toml")] = None,
) -> None:
    """Calibrate a robot from logs of its wheels and its true poses.

    Finds the wheels' radii and the track width with which odometry fits the logs best, and prints them with their
    uncertainty, beside how far the odometry was off before and is off after. What looks wrong with a log, such as a
    push, is printed first; columns and units that look mixed up are refused, with the option that puts them right, and
    so is an outcome that is worse than nothing. Turns in both directions and some straight driving show all of the
    robot.

    A log has a line for each sample: time, left and right wheel, and the true pose (from motion capture, markers on
    the floor, a tape measure) where it is known; its cells stay empty elsewhere. For example

      diffdrive calibrate lab.csv --robot robot.toml --time stamp --time-unit ms --left enc_l --right enc_r
      --wheel-unit ticks --export ros2

    Exit status: 0, or 2 for bad input, of which one line on stderr says what is wrong.

    Args:
        logs: each one drive of the robot: CSV files, all of them with the same columns, or .mcap, .db3, rosbag2 folders
            and .wpilog.
        robot: the nominal robot, with which its odometry computes now: a TOML file (left_radius, right_radius,
            track_width [m]; ticks_per_revolution in the table [encoder]) or the name of a preset.
        columns: of the logs.
        method: least_squares from any paths; from_fixes from positions alone; umbmark or jung_chung from squares driven
            in both directions (--side); speed_ratio from straight lines, for the wheels to build.
        start: how each drive starts: at a pose that is estimated too, at its first true position with a heading that is
            estimated, or at its first true pose.
        headings: whether the true headings count; without them, as from a tape measure, only the positions do.
        side: of the squares [m].
        anyway: accept, with a warning, what would be refused: logs that look mixed up or are given twice, an outcome
            that is not plausible or worse than nothing.
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
    nominal = Robot.load(robot)
    # Columns are for tables; in a bag or a data log what is what is found by itself.
    drives = [read(log, None if columns == Columns() else columns, robot=nominal) for log in logs]
    for drive in drives:
        for warning in drive.warnings:
            print(f"{drive.name}: {warning}")
        mixed_up = mix_up(drive, nominal, headings=headings)
        for suspicion in suspicions(drive, nominal):
            # What the calibration itself refuses, or warns of, is said once.
            if suspicion != mixed_up:
                print(f"{drive.name}: {_with_options(suspicion, columns)}")
    fit = getattr(importlib.import_module(f"diffdrive_mj.calibration.{_METHODS[method]}"), method)
    gain = False if export_to in export.WITHOUT_GAIN else None
    given = {"start": start, "headings": headings, "turning_gain": gain, "side": side}
    try:
        found: Calibration = fit(drives, nominal, **_of(fit, given), anyway=anyway)
    except CalibrationRefused as refused:
        raise CalibrationRefused(
            _with_options(refused.reason, columns), "--anyway" if refused.args[1] else ""
        ) from None
    exported = "" if export_to == "none" else export.text(export_to, nominal, found.calibrated)
    if output is not None:
        found.calibrated.save(output)
    print(_with_options(str(found), columns))
    if exported:
        print(f"\n{exported}", end="")
    if output is not None:
        print(f"\nwritten: {output}")


def _of(fit: Callable[..., Calibration], given: dict[str, Any]) -> dict[str, Any]:
    """What of the options a method takes; others must have been left as they are."""
    taken, left_alone = inspect.signature(fit).parameters, {"start": "estimated", "headings": True, "side": None}
    method = fit.__name__
    for name, default in left_alone.items():
        if name not in taken and given[name] != default:
            option = "--no-headings" if name == "headings" else f"--{name}"
            raise InvalidValue(f"{option} says nothing to --method {method}: leave it out")
    if "side" in taken and given["side"] is None:
        raise InvalidValue(f"--method {method} needs --side, that of the squares [m]")
    return {name: value for name, value in given.items() if name in taken}


def _with_options(message: str, columns: Columns) -> str:
    """A message of the library with the command's options in place of the fields that it names."""
    left, right = (shlex.quote(str(column)) for column in (columns.left, columns.right))
    message = message.replace("exchange the columns left and right", f"use --left {right} --right {left}")
    options = {field.name: f"--{field.name.replace('_', '-')}" for field in fields(Columns) if "_" in field.name}
    options |= {
        f"reverse_{side}": f"--no-reverse-{side}" for side in ("left", "right") if getattr(columns, f"reverse_{side}")
    }
    named = re.compile(rf"\b({'|'.join(options)})\b( = )?")
    message = named.sub(lambda found: options[found[1]] + (" " if found[2] else ""), message)
    return message.replace("start = ", "--start ")
