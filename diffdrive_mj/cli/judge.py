"""`diffdrive judge`: whether a program's odometry is right, and how far it drifts."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import tyro

from diffdrive_mj import _checks as checks
from diffdrive_mj.cli._left_out import Number, WorldName, floor
from diffdrive_mj.cli._outcome import AsJson, AsMarkdown, drawn, refuse_both, tell
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.judging.by_name import MANEUVERS, simulated
from diffdrive_mj.judging.candidates import of_command_line
from diffdrive_mj.judging.tasks import Task, Unit
from diffdrive_mj.judging.verdict import Verdict, judge
from diffdrive_mj.logs import read
from diffdrive_mj.robot import Robot


def command(
    program: Annotated[
        tuple[str, ...], tyro.conf.Positional, tyro.conf.arg(metavar="-- PROGRAM", help_behavior_hint="(required)")
    ],
    /,
    robot: Annotated[str | None, tyro.conf.arg(metavar="ROBOT")] = None,
    drives: tuple[str, ...] = tuple(MANEUVERS),
    world: WorldName = None,
    suite: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False,
    logs: tuple[Path, ...] = (),
    rate: float = 50.0,
    unit: Unit = "rad",
    position: Number = None,
    heading: Number = None,
    position_per_metre: Number = None,
    seconds: float = 10.0,
    seed: int = 0,
    output: Path = Path("results"),
    pictures: bool = True,
    as_json: AsJson = False,
    as_markdown: AsMarkdown = False,
) -> None:
    """Judge a program's odometry on simulated drives, or on drives whose poses are known exactly.

      diffdrive judge --robot ct_bot -- ./my_odometry

    The program is started anew for each drive. It reads a header with the robot's numbers and the start pose, then a
    line t,left,right for each reading of the wheels, and answers each with a line x,y,theta [m, m, rad]. Without bounds
    it passes where it is within 1e-9 m per metre of exact arc odometry; with bounds where it drifts less than they say
    from the true pose. The readings are those of the robot's encoder, whole ticks. Pictures of the drives whose bounds
    are broken are drawn, or of the worst one.

    Exit status: 0 if every bound holds, 1 if one is broken, 2 for bad input, of which one line on stderr says what is
    wrong.

    Args:
        program: the program and its arguments, after --; or a shared library (.so, .dylib, .dll) with the functions of
            examples/odometry.h in the source archive.
        robot: that is driven: the name of a preset, or a TOML file.
        drives: straight, square, figure_eight, spin, slalom.
        world: in which it is driven: the name of a preset, or a TOML file; ideal if not given.
        suite: judge on the conformance suite instead, as in diffdrive judge --suite -- ./my_odometry; its drives have
            robots and units of their own.
        logs: judge on logs of the robot instead, with wheels and true poses, as of diffdrive simulate.
        rate: of the readings [Hz].
        unit: of the readings, rad or ticks.
        position: largest position error along a drive [m].
        heading: largest heading error along a drive [rad].
        position_per_metre: largest position error over the distance driven [m/m].
        seconds: that the program may take for a drive.
        seed: of the phase of the encoder's counters.
        output: folder in which that of the pictures, judge, is made.
        pictures: whether to draw them.
        as_json: print JSON, in metres and radians.
        as_markdown: print Markdown, as for a comment on a pull request.

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
    refuse_both(as_json, as_markdown)
    if suite:
        own = {
            "--robot": robot is not None,
            "--drives": drives != tuple(MANEUVERS),
            "--world": world is not None,
            "--logs": logs,
            "--rate": rate != 50.0,
            "--unit": unit != "rad",
            "--seed": seed != 0,
            "--position": position is not None,
            "--heading": heading is not None,
            "--position-per-metre": position_per_metre is not None,
        }
        _refuse_beside_the_suite([name for name, given in own.items() if given])
    candidate = of_command_line(program)
    tasks = _suite() if suite else _tasks(robot, drives, world, logs, checks.positive("rate", rate), seed)
    verdict = judge(
        candidate, tasks, position=position, heading=heading, position_per_metre=position_per_metre,
        unit=unit, seconds=checks.positive("seconds", seconds),
    )  # fmt: skip
    written = _drawn(verdict, output / "judge") if pictures else []
    tell(str(verdict), verdict.markdown(), _content(verdict), written, as_json, as_markdown)
    sys.exit(0 if verdict.holds else 1)


def _refuse_beside_the_suite(given: Sequence[str]) -> None:
    if given:
        raise InvalidValue(
            f"{given[0]} beside --suite: its drives have robots, readings and tolerances of their own; leave one out"
        )


def _suite() -> Sequence[Task]:
    from diffdrive_mj.judging.suite import cases  # loads mpmath

    return cases()


def _tasks(
    robot: str | None, drives: tuple[str, ...], world: str | None, logs: tuple[Path, ...], rate: float, seed: int
) -> Sequence[Task]:
    if robot is None:
        raise InvalidValue("a robot is missing: --robot names a preset or a TOML file; --suite needs none")
    true = Robot.load(robot)
    if logs:
        if world is not None:
            raise InvalidValue(f"--world {world} beside --logs: a log has been driven; leave one out")
        return [Task.of(read(log, robot=true), true) for log in logs]
    place = floor(world)
    return [simulated(name, true, world=place, rate=rate, seed=seed) for name in drives]


def _drawn(verdict: Verdict, folder: Path) -> list[Path]:
    """Write the pictures, which take the place of those of an earlier verdict."""
    from diffdrive_mj.report.verdicts import reported

    return drawn(reported(verdict), folder)


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
