"""What a sweep costs beyond the bare engine, what a second process brings, and that its memory does not grow."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from mujoco.batch import Batch

import diffdrive_mj as dd
from diffdrive_mj.physics.model import _compiled, compile_model
from diffdrive_mj.sweeps.runner import CHUNK

# Takes pieces of work in turns and gives the shortest time of each [s].
Best = Callable[..., list[float]]

MEMORY = r"""
import re, sys
from pathlib import Path
import diffdrive_mj as dd
robot = dd.Robot.load("matched")
vary = {"robot.left_radius": dd.sweeps.Normal(mean=robot.left_radius, sigma=0.0005)}
drive = dd.sweeps.Maneuver("straight", {"speed": 0.5, "distance": 0.1, "ramp": 0.2, "rest": 0.1})
study = dd.sweeps.Study(robot=robot, maneuver=drive, vary=vary, trials=int(sys.argv[1]), truth=sys.argv[2])
assert dd.sweep(study, workers=1).ok.all()
# Not getrusage, which remembers what the process that started this one had.
print(int(re.search(r"VmHWM:\s+(\d+) kB", Path("/proc/self/status").read_text())[1]) / 2**20)
"""


def squares(trials: int) -> dd.sweeps.Study:
    """Squares of 16 m by robots whose wheels and track are off, with the fast setting."""
    robot = dd.Robot.load("matched")
    vary = {
        "robot.left_radius": dd.sweeps.Normal(mean=robot.left_radius, sigma=0.0005),
        "robot.right_radius": dd.sweeps.Normal(mean=robot.right_radius, sigma=0.0005),
        "robot.track_width": dd.sweeps.Normal(mean=robot.track_width, sigma=0.002),
    }
    maneuver = dd.sweeps.Maneuver("square", {"side": 4.0})
    return dd.sweeps.Study(name="squares of 16 m", robot=robot, maneuver=maneuver, vary=vary, trials=trials)


def bare(
    study: dd.sweeps.Study, trials: Sequence[int], threads: int = 1, clock: Callable[[], float] = time.perf_counter
) -> float:
    """Drive some trials in MuJoCo's batch engine and read nothing; how long that takes with the models at hand [s]."""
    made = [study.trial(index) for index in trials]
    models = [compile_model(trial.robot, study.physics, trial.world) for trial in made]
    rates, period = made[0].commands.wheel_rates, made[0].commands.period
    control = np.tile(np.repeat(rates, round(period / study.physics.timestep), axis=0), 2)
    begin = clock()
    batch = Batch(models[0], nsim=len(models), nthread=threads)
    batch.set_models(models)
    batch.qpos[:] = np.stack([model.qpos0 for model in models])
    for piece in np.array_split(control, 8):
        asked = np.broadcast_to(piece, (len(models), *piece.shape))
        batch.rollout(len(piece), control=asked, record=("qpos", "sensordata"))
    return clock() - begin


def overhead(study: dd.sweeps.Study, rounds: int) -> float:
    """What a sweep on one processor takes of it, by what the bare engine takes, with the models of both at hand.

    Time on a clock would be that of whatever else runs on the machine, too.
    """
    clock, engine, swept = time.process_time, [], []
    for _ in range(rounds):
        engine.append(bare(study, range(study.trials), clock=clock))
        begin = clock()
        dd.sweep(study, workers=1, chunk=study.trials)
        swept.append(clock() - begin)
    return min(swept) / min(engine)


def rows(best: Best, rounds: int = 4) -> list[list[object]]:
    """The rows of the table."""
    one, two = squares(CHUNK), squares(16 * CHUNK)

    def anew() -> None:
        _compiled.cache_clear()
        dd.sweep(one, workers=1)

    def models() -> None:
        _compiled.cache_clear()
        for index in range(CHUNK):
            trial = one.trial(index)
            compile_model(trial.robot, one.physics, trial.world)

    engine = float("inf")
    made, fresh = np.inf, np.inf
    for _ in range(rounds):
        made, fresh = np.minimum((made, fresh), best(models, anew, rounds=1))
        engine = min(engine, bare(one, range(CHUNK)))
    alone, together = best(lambda: dd.sweep(two, workers=1), lambda: dd.sweep(two, workers=2), rounds=2)
    gib = {}
    if Path("/proc/self/status").exists():
        gib = {kind: [memory(trials, kind) for trials in (1_000, 10_000)] for kind in ("physics", "kinematics")}
    return [
        [
            "sweep / bare engine with the contacts' forces, models at hand, processor time",
            overhead(one, 2 * rounds),
            "<= 1.05",
        ],
        ["sweep / bare engine, the sweep makes its models", fresh / engine, ""],
        ["sweep, share of the time that goes into making trials and models", made / fresh, "< 0.1"],
        ["sweep, 2 processes / 1 process (16 m squares)", alone / together, ">= 1.7"],
        ["sweep, a 16 m square with Physics.fast() [ms] (this machine, now)", 1e3 * fresh / CHUNK, ""],
        *(
            [f"sweep, memory of 10 000 runs / 1 000 runs, {kind}", many / few, "<= 1.1"]
            for kind, (few, many) in gib.items()
        ),
        *([f"sweep, memory of 10 000 runs [GiB], {kind}", many, "< 1"] for kind, (_, many) in gib.items()),
    ]


def memory(trials: int, truth: str) -> float:
    """The most that a sweep of short drives has needed [GiB]."""
    said = subprocess.run(
        [sys.executable, "-c", MEMORY, str(trials), truth], stdout=subprocess.PIPE, text=True, check=True
    )
    return float(said.stdout)
