"""What a time step costs and what it gives: speed against the error that the physics leaves to exact odometry."""

from __future__ import annotations

import functools
import warnings

import numpy as np
from timing import best

import diffdrive_mj as dd
from diffdrive_mj import report
from diffdrive_mj.errors import PhysicsWarning
from diffdrive_mj.judging.standards import standard_residuals

STEPS = (0.0005, 0.001, 0.002, 0.005, 0.01)
HEADER = [
    "time step [ms]", "simulated s per s, 1 thread", "speed / that of 2 ms", "largest error [ppm of the way]", "on",
]  # fmt: skip


def accuracy_and_cost(preset: str = "mismatched", rounds: int = 5) -> list[list[object]]:
    """A row for each time step: how fast, how much faster than by default, and how exact on the standard maneuvers."""
    robot = dd.Robot.load(preset)
    drive = dd.maneuvers.square(robot, side=0.5)
    choices = [dd.Physics(timestep=step) for step in STEPS]

    def driven(physics: dd.Physics) -> object:
        return dd.simulate([robot] * 8, drive, physics=physics, sample_rate=50.0, threads=1)

    seconds = best(*(functools.partial(driven, physics) for physics in choices), rounds=rounds)
    default = seconds[STEPS.index(dd.Physics().timestep)]
    rows: list[list[object]] = []
    for physics, spent in zip(choices, seconds, strict=True):
        found = standard_residuals(robot, physics)
        worst = max(found, key=lambda name: found[name].position)
        speed = 8 * drive.duration / spent
        rows.append([1e3 * physics.timestep, round(speed), default / spent, found[worst].position, worst])
    return rows


if __name__ == "__main__":
    warnings.simplefilter("ignore", PhysicsWarning)  # coarse steps say so
    np.set_printoptions(precision=3)
    print(report.table(HEADER, accuracy_and_cost()))
