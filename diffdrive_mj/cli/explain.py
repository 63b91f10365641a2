"""`diffdrive explain`: which error of a robot costs its odometry most."""

from __future__ import annotations

import inspect
import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from diffdrive_mj import _checks as checks
from diffdrive_mj.cli._left_out import Name, Number, WorldName, floor
from diffdrive_mj.cli._outcome import AsJson, drawn, tell
from diffdrive_mj.errors import InvalidValue, UnknownName
from diffdrive_mj.estimation.sensitivities import ErrorBudget, error_budget, misjudged, within
from diffdrive_mj.judging.by_name import MANEUVERS
from diffdrive_mj.robot import Robot
from diffdrive_mj.world import World

if TYPE_CHECKING:
    from diffdrive_mj.estimation.attribution import Attribution


def command(
    robot: Annotated[str, tyro.conf.Positional, tyro.conf.arg(metavar="ROBOT", help_behavior_hint="(required)")],
    /,
    maneuver: Name = None,
    world: WorldName = None,
    tolerance: Number = None,
    rate: float = 10.0,
    latency: float = 0.01,
    speed: Number = None,
    yaw_rate: Number = None,
    output: Path = Path("results"),
    pictures: bool = True,
    as_json: AsJson = False,
) -> None:
    """Explain which error of a robot costs its odometry most.

      diffdrive explain turtlebot3_burger --tolerance 0.005 --rate 50

    From the robot's numbers alone, without physics: how far off odometry is at the end of a straight line of 10 m, a
    square of 4 m, three turns on the spot and an arc of 10 m, if the radii, the radius ratio or the track width are
    wrong by the robot's tolerances, if an encoder counts a tick too many, if the wheels are read slowly, or if the pose
    is late; the worst comes first.

      diffdrive explain turtlebot3_burger --maneuver square

    With a maneuver the robot drives in physics, with all of that wrong at once, and the final error is split among its
    causes: the parts add up to it. Beside each part stands what its cause does alone, and by how much its part depends
    on the others; below, what the tyres' slip does, read where they touch the floor. A picture is drawn.

    Exit status: 0, or 2 for bad input, of which one line on stderr says what is wrong.

    Args:
        robot: the name of a preset, or a TOML file (left_radius, right_radius, track_width [m]).
        maneuver: to drive in physics: straight, square, figure_eight, spin or slalom.
        world: in which it drives: the name of a preset, or a TOML file; ideal if not given.
        tolerance: by what part the radii, the radius ratio and the track width are believed too large; if not given,
            what the robot's file says under [tolerances], or 0.01.
        rate: at which odometry reads the wheels [Hz].
        latency: of the pose [s].
        speed: along lines and arcs [m/s]; 0.5 if not given, or the maneuver's own.
        yaw_rate: of turns on the spot [rad/s]; 1 if not given, or the maneuver's own.
        output: folder in which that of the picture, explain, is made.
        pictures: whether to draw it.
        as_json: print JSON, in metres and radians.

    Raises:
        DiffdriveError: bad input.

    Example:
        >>> from diffdrive_mj.cli import main
        >>> main(["explain", "turtlebot3_burger"])
        turtlebot3_burger: how far odometry is off at the end of a drive
        ...
        The worst is radius ratio, 1 %: it puts the end of the straight 3076 mm and 35.6 degrees off.
    """
    true = Robot.load(robot)
    given = {name: value for name, value in (("speed", speed), ("yaw_rate", yaw_rate)) if value is not None}
    if maneuver is not None:
        found = _driven(true, maneuver, floor(world), tolerance, rate, latency, given)
        written = _drawn(found, output / "explain") if pictures else []
        tell(str(found), "", found.as_dict(), written, as_json, as_markdown=False)
        return
    if world is not None:
        raise InvalidValue(f"--world {world}: is driven in with --maneuver; without one there is no physics")
    budget = error_budget(true, tolerance=tolerance, rate=rate, latency=latency, **given)
    print(_json(budget) if as_json else budget)


def _driven(
    true: Robot,
    maneuver: str,
    world: World,
    tolerance: float | None,
    rate: float,
    latency: float,
    speeds: dict[str, float],
) -> Attribution:
    """The maneuver in physics, and its final error split among the robot's tolerances and sensors."""
    if maneuver not in MANEUVERS:
        raise UnknownName("maneuver", maneuver, MANEUVERS)
    known = inspect.signature(MANEUVERS[maneuver]).parameters
    if foreign := [f"--{name.replace('_', '-')}" for name in speeds if name not in known]:
        raise InvalidValue(f"{foreign[0]}: the maneuver {maneuver} has none; leave it out")
    off = within(true, tolerance)
    from diffdrive_mj.estimation.attribution import attribute
    from diffdrive_mj.physics.simulation import simulate  # loads MuJoCo
    from diffdrive_mj.sensors import Encoder

    encoder = Encoder(true, sample_rate=checks.positive("rate", rate), latency=latency)
    believed = misjudged(true, scale=1 + off.radius, ratio=1 + off.radius_ratio, track=1 + off.track_width)
    recording = simulate(true, MANEUVERS[maneuver](true, **speeds), world=world, sample_rate=500.0, slip=True)
    return attribute(recording, believed, encoder=encoder)


def _drawn(found: Attribution, folder: Path) -> list[Path]:
    """Write the picture, which takes the place of an earlier one."""
    from diffdrive_mj.report.attributions import reported

    return drawn(reported(found), folder)


def _json(budget: ErrorBudget) -> str:
    errors = [
        {
            "cause": cause,
            "drive": drive,
            "position_error_m": float(budget.position_error[k, i]),
            "heading_error_rad": float(budget.heading_error[k, i]),
        }
        for k, cause in enumerate(budget.causes)
        for i, drive in enumerate(budget.drives)
    ]
    return json.dumps({"robot": budget.robot, "drives": dict(budget.drives), "errors": errors}, indent=1)
