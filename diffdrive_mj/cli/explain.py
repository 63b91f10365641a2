"""`diffdrive explain`: which error of a robot costs its odometry most."""

from __future__ import annotations

import json
from typing import Annotated

import tyro

from diffdrive_mj.cli._outcome import AsJson
from diffdrive_mj.estimation.sensitivities import ErrorBudget, error_budget
from diffdrive_mj.robot import Robot


def command(
    robot: Annotated[str, tyro.conf.Positional, tyro.conf.arg(metavar="ROBOT", help_behavior_hint="(required)")],
    /,
    tolerance: float = 0.01,
    rate: float = 10.0,
    latency: float = 0.01,
    speed: float = 0.5,
    yaw_rate: float = 1.0,
    as_json: AsJson = False,
) -> None:
    """Explain which error of a robot costs its odometry most.

      diffdrive explain turtlebot3_burger --tolerance 0.005 --rate 50

    From the robot's numbers alone, without physics: how far off odometry is at the end of a straight line of 10 m, a
    square of 4 m, three turns on the spot and an arc of 10 m, if a wheel radius, the radius ratio or the track width is
    wrong, if an encoder counts a tick too many, if the wheels are read slowly, or if the pose is late; the worst comes
    first.

    Exit status: 0, or 2 for bad input, of which one line on stderr says what is wrong.

    Args:
        robot: the name of a preset, or a TOML file (left_radius, right_radius, track_width [m]).
        tolerance: by what part the radii, the radius ratio and the track width are believed too large.
        rate: at which odometry reads the wheels [Hz].
        latency: of the pose [s].
        speed: along lines and arcs [m/s].
        yaw_rate: of turns on the spot [rad/s].
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
    budget = error_budget(
        Robot.load(robot), tolerance=tolerance, rate=rate, latency=latency, speed=speed, yaw_rate=yaw_rate
    )
    print(_json(budget) if as_json else budget)


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
