"""`diffdrive judge`: whether a program's odometry is right, and how far it drifts."""

from __future__ import annotations

import json
import sys
from typing import Annotated, Any

import tyro

from diffdrive_mj import _checks as checks
from diffdrive_mj import maneuvers
from diffdrive_mj.errors import InvalidValue, UnknownName
from diffdrive_mj.judging.tasks import Task, Unit
from diffdrive_mj.judging.verdict import Verdict, judge
from diffdrive_mj.physics.simulation import simulate
from diffdrive_mj.robot import Robot
from diffdrive_mj.se2 import compose
from diffdrive_mj.sensors import Encoder, Tracker, measure

DRIVES = {
    "straight": maneuvers.straight,
    "square": maneuvers.square,
    "figure_eight": maneuvers.figure_eight,
    "spin": maneuvers.spin,
    "slalom": maneuvers.slalom,
}
# Not at the origin: a start pose is forgotten more often than anything else.
START = (2.0, -1.0, 0.5)


def command(
    program: Annotated[
        tuple[str, ...], tyro.conf.Positional, tyro.conf.arg(metavar="-- PROGRAM", help_behavior_hint="(required)")
    ],
    /,
    robot: str,
    drives: tuple[str, ...] = tuple(DRIVES),
    rate: float = 50.0,
    unit: Unit = "rad",
    position: float | None = None,
    heading: float | None = None,
    position_per_metre: float | None = None,
    seconds: float = 10.0,
    seed: int = 0,
    as_json: Annotated[bool, tyro.conf.arg(name="json"), tyro.conf.FlagCreatePairsOff] = False,
) -> None:
    """Judge a program's odometry on simulated drives.

      diffdrive judge --robot ct_bot -- ./my_odometry

    The program is started anew for each drive. It reads a header with the robot's numbers and the start pose, then a
    line t,left,right for each reading of the wheels, and answers each with a line x,y,theta [m, m, rad]. Without bounds
    it passes where it is within 1e-9 m per metre of exact arc odometry; with bounds where it drifts less than they say
    from the true pose. The readings are those of the robot's encoder, whole ticks.

    Exit status: 0 if every bound holds, 1 if one is broken, 2 for bad input, of which one line on stderr says what is
    wrong.

    Args:
        program: the program and its arguments, after --.
        robot: the name of a preset, or a TOML file.
        drives: straight, square, figure_eight, spin, slalom.
        rate: of the readings [Hz].
        unit: of the readings, rad or ticks.
        position: largest position error along a drive [m].
        heading: largest heading error along a drive [rad].
        position_per_metre: largest position error over the distance driven [m/m].
        seconds: that the program may take for a drive.
        seed: of the phase of the encoder's counters.
        as_json: print JSON, in metres and radians.

    Raises:
        DiffdriveError: bad input.
        SystemExit: 1 where a bound is broken.

    Example:
        >>> from diffdrive_mj.cli import main
        >>> main(["judge", "--robot", "mached", "--", "./my_odometry"])
        Traceback (most recent call last):
        ...
        SystemExit: 2
    """
    if not program:
        raise InvalidValue("a program is missing: diffdrive judge --robot ROBOT -- PROGRAM")
    true, rate, seconds = Robot.load(robot), checks.positive("rate", rate), checks.positive("seconds", seconds)
    verdict = judge(
        list(program), [_task(name, true, rate, seed) for name in drives], position=position, heading=heading,
        position_per_metre=position_per_metre, unit=unit, seconds=seconds,
    )  # fmt: skip
    print(json.dumps(_content(verdict), indent=1) if as_json else verdict)
    sys.exit(0 if verdict.holds else 1)


def _task(name: str, robot: Robot, rate: float, seed: int) -> Task:
    """A simulated drive, read by the robot's encoder, from a start away from the origin."""
    if name not in DRIVES:
        raise UnknownName("drive", name, DRIVES)
    recording = simulate(robot, DRIVES[name](robot))  # type: ignore[operator]
    encoder, tracker = Encoder(robot, sample_rate=rate), Tracker(sample_rate=rate)
    drive = measure(recording, encoder=encoder, tracker=tracker, seed=seed)
    task = Task.of(drive, robot)
    start, truth = compose(START, task.start), compose(START, drive.truth)
    return Task(name, robot, task.t, task.wheel_angles, start, truth)


def _content(verdict: Verdict) -> dict[str, Any]:
    rows = [
        {
            "drive": row.task.name,
            "holds": row.holds,
            "arithmetic_m": None if row.poses is None else row.arithmetic,
            "position_error_m": None if row.drift is None else float(row.drift.max_position),
            "heading_error_rad": None if row.drift is None else float(row.drift.max_heading),
            "distance_m": None if row.drift is None else float(row.drift.distance),
            "broken": list(row.broken),
            "reason": row.reason,
        }
        for row in verdict.rows
    ]
    return {"candidate": verdict.candidate, "holds": verdict.holds, "drives": rows}
