"""Drives by name: simulated, read by the robot's encoder, from a start away from the origin."""

from __future__ import annotations

from pathlib import Path

from diffdrive_mj import _checks as checks
from diffdrive_mj import maneuvers
from diffdrive_mj.errors import UnknownName
from diffdrive_mj.judging.tasks import Task
from diffdrive_mj.robot import Robot
from diffdrive_mj.se2 import compose
from diffdrive_mj.sensors import Encoder, Tracker, measure
from diffdrive_mj.world import World

# Those that an estimate is judged on unless others are named.
MANEUVERS = {name: maneuvers.BY_NAME[name] for name in ("straight", "square", "figure_eight", "spin", "slalom")}
# Not at the origin: a start pose is forgotten more often than anything else.
START = (2.0, -1.0, 0.5)


def simulated(
    maneuver: str,
    robot: Robot | str | Path,
    *,
    world: World | str | Path = World(),  # noqa: B008
    rate: float = 50.0,
    seed: int = 0,
) -> Task:
    """Drive a robot in physics, and read its wheels as its encoder does, in whole ticks.

    Args:
        maneuver: "straight", "square", "figure_eight", "spin" or "slalom".
        robot: what is driven; the name of a preset, or the path of a TOML file.
        world: in which it drives, from its origin; the name of a preset, or the path of a TOML file.
        rate: of the readings [Hz].
        seed: of the phase of the encoder's counters.

    Returns:
        What an odometry is given to solve, with the true poses.

    Raises:
        UnknownName: another maneuver, or a robot or a world that is no preset.
        MissingFile: no such file.
        InvalidValue: a rate that is not positive.

    Example:
        >>> task = simulated("spin", "ct_bot")
        >>> task.start.tolist()
        [2.0, -1.0, 0.5]
    """
    if maneuver not in MANEUVERS:
        raise UnknownName("drive", maneuver, MANEUVERS)
    from diffdrive_mj.physics.simulation import simulate  # loads MuJoCo

    robot = robot if isinstance(robot, Robot) else Robot.load(robot)
    world = world if isinstance(world, World) else World.load(world)
    rate = checks.positive("rate", rate)

    recording = simulate(robot, MANEUVERS[maneuver](robot), world=world)
    encoder, tracker = Encoder(robot, sample_rate=rate), Tracker(sample_rate=rate)
    task = Task.of(measure(recording, encoder=encoder, tracker=tracker, seed=seed), robot)
    assert task.truth is not None
    start, truth = compose(START, task.start), compose(START, task.truth)
    return Task(maneuver, robot, task.t, task.wheel_angles, start, truth)
