"""`diffdrive sweep`: thousands of robots before one is built, and how far off their odometry ends."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any, Literal

import tyro

from diffdrive_mj.cli._left_out import Name, Whole
from diffdrive_mj.cli._outcome import AsJson
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.robot import Robot
from diffdrive_mj.sweeps.budgets import Budget, budget
from diffdrive_mj.sweeps.choices import Grid
from diffdrive_mj.sweeps.named_maneuvers import Maneuver
from diffdrive_mj.sweeps.studies import Study
from diffdrive_mj.sweeps.trials import Trials

# Which percentiles the JSON has.
_SHARES = (0.5, 0.9, 0.95, 0.99)
Truth = Literal["kinematics", "physics"]


def command(
    study: Annotated[
        str | None,
        tyro.conf.Positional,
        tyro.conf.arg(metavar="[STUDY]", help_behavior_hint="(required without --robot)"),
    ] = None,
    /,
    *,
    output: Annotated[Path, tyro.conf.arg(metavar="FOLDER")],
    robot: Name = None,
    maneuver: Name = None,
    truth: Annotated[Truth | None, tyro.conf.arg(metavar="kinematics|physics")] = None,
    trials: Whole = None,
    prices: bool = False,
    workers: Whole = None,
    chunk: Whole = None,
    scheduler: Annotated[str | None, tyro.conf.arg(metavar="ADDRESS")] = None,
    as_json: AsJson = False,
) -> None:
    """Drive the trials of a study, and say how far off the robots' odometry ends.

      diffdrive sweep squares --output results/squares --trials 200

    What is done stays: the same command goes on where an interrupted one ended. At the end the folder has trials.csv, a
    row a trial.

      diffdrive sweep --robot mine.toml --maneuver square --output results/mine --prices

    Without a study a robot will do: 1000 like it are driven, with the tolerances of its file as standard deviations.
    Their wheels do not slip, unless --truth physics drives them in MuJoCo. --prices adds what it buys to halve each
    tolerance.

    Exit status: 0, or 2 for bad input, of which one line on stderr says what is wrong; 130 where it is interrupted.

    Args:
        study: the name of a preset, or a TOML file.
        output: the sweep's folder, which keeps every chunk of trials that is done.
        robot: in the place of a study: the name of a preset, or a TOML file, whose tolerances are 0.01 if it says none.
        maneuver: of that robot: straight, arc, spin, square, figure_eight or slalom; square if not given.
        truth: what drives them, physics or kinematics; what the study says if not given, kinematics with --robot.
        trials: how many; as many as the study says if not given.
        prices: print by how much the 99th percentile falls if a tolerance is halved, for each.
        workers: processes that drive; as many as the machine has cores if not given.
        chunk: how many trials are driven together; it changes no number.
        scheduler: the address of a Dask scheduler whose workers drive, such as tcp://10.0.0.1:8786.
        as_json: print the outcome as JSON.

    Raises:
        DiffdriveError: bad input.

    Example:
        >>> from diffdrive_mj.cli import main
        >>> main(["sweep", "sqares", "--output", "results"])
        Traceback (most recent call last):
        ...
        SystemExit: 2
    """
    from diffdrive_mj.sweeps.runner import sweep

    described = _study(study, robot, maneuver)
    described = described.replace(**_given(trials=trials, truth=truth))
    done = sweep(described, output, **_given(workers=workers, chunk=chunk, scheduler=scheduler))
    table = output / "trials.csv"
    done.to_csv(table)
    grids = [name for name, spread in described.vary.items() if isinstance(spread, Grid)]
    parts = [(dict(zip(grids, values, strict=True)), part) for values, part in done.by(*grids).items()]
    priced = [(values, part, budget(described, part) if prices else None) for values, part in parts]
    if as_json:
        said = [{**({"of": values} if grids else {}), **_as_dict(part, bought)} for values, part, bought in priced]
        found = {"study": described.name, "outcomes": done.counted, **({"grid": said} if grids else said[0])}
        print(json.dumps({**found, "table": str(table)}))
    else:
        print(*(_text(*each) for each in priced), f"written: {table}", sep="\n\n")


def _study(name: str | None, robot: str | None, maneuver: str | None) -> Study:
    """The study of a name or a file, or that of a robot's tolerances."""
    if robot is None:
        if name is None:
            raise InvalidValue("STUDY is missing: give a study's name or file, or --robot a robot's")
        if maneuver is not None:
            raise InvalidValue(f"--maneuver {maneuver}: goes with --robot; a study has its own")
        return Study.load(name)
    if name is not None:
        raise InvalidValue(f"{name}, --robot {robot}: only one of them can be given; a study has its own robot")
    designed = Robot.load(robot)
    return Study.of_tolerances(designed, Maneuver(maneuver or "square"), name=designed.name, truth="kinematics")


def _given(**options: Any) -> dict[str, Any]:
    """Those that are given."""
    return {name: value for name, value in options.items() if value is not None}


def _text(values: dict[str, Any], part: Trials, bought: Budget | None) -> str:
    """The table of the trials, under the values of their grids, and what tighter tolerances buy."""
    heading = [", ".join(f"{name} = {value}" for name, value in values.items())] if values else []
    return "\n\n".join([*heading, str(part), *([] if bought is None else [str(bought)])])


def _as_dict(part: Trials, bought: Budget | None) -> dict[str, Any]:
    """Percentiles by their figures, and the budget."""
    figures = {
        name: {f"{100 * share:g} %": part.percentile(name, share).value.item() for share in _SHARES}
        for name, values in part.figures.items()
        if values.ndim == 1
    }
    return {"figures": figures, **({} if bought is None else {"budget": bought.as_dict()})}
