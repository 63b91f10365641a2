"""Speed, as ratios taken in one run: machines differ and are shared, ratios of work done side by side do not."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable

import numpy as np
from mujoco.batch import Batch

import diffdrive_mj as dd
from diffdrive_mj import report
from diffdrive_mj.physics.model import compile_model

ROUNDS = 7


def best(*works: Callable[[], object]) -> list[float]:
    """The shortest time of each piece of work [s], taken in turns so that all meet the same machine."""
    times = [np.inf] * len(works)
    for _ in range(ROUNDS):
        for i, work in enumerate(works):
            begin = time.perf_counter()
            work()
            times[i] = min(times[i], time.perf_counter() - begin)
    return times


def simulation() -> list[list[object]]:
    """`simulate` against the bare engine on the same models and controls, and two threads against one."""
    robot = dd.Robot.load("mismatched")
    runs = 8
    robots = [robot.replace(right_radius=0.091 + 0.001 * i) for i in range(runs)]
    drive = dd.maneuvers.square(robot, side=2.0)
    steps = round(drive.duration / dd.Physics().timestep)
    control = np.tile(np.repeat(drive.wheel_rates, steps // len(drive.wheel_rates), axis=0), 2)
    models = [compile_model(robot) for robot in robots]

    def bare(threads: int) -> None:
        batch = Batch(models[0], nsim=runs, nthread=threads)
        batch.set_models(models)
        batch.rollout(steps, control=np.broadcast_to(control, (runs, *control.shape)), record=("qpos",))

    def ours(threads: int) -> None:
        dd.simulate(robots, drive, threads=threads)

    def closed() -> None:
        dd.simulate(robots, dd.ClosedLoop(lambda t, angles: np.full((runs, 2), 5.0), 0.02, drive.duration), threads=1)

    bare_one, ours_one, bare_two, ours_two, loop = best(
        lambda: bare(1), lambda: ours(1), lambda: bare(2), lambda: ours(2), closed
    )
    seconds = runs * drive.duration
    return [
        ["simulate / bare Batch.rollout, steps per second, 1 thread", bare_one / ours_one, ">= 0.9"],
        ["simulate / bare Batch.rollout, steps per second, 2 threads", bare_two / ours_two, ">= 0.9"],
        ["simulate, 2 threads / 1 thread", ours_one / ours_two, ">= 1.7"],
        ["bare Batch.rollout, 2 threads / 1 thread", bare_one / bare_two, ""],
        ["closed loop at 50 Hz / open loop, steps per second", ours_one / loop, ""],
        ["simulated seconds per second, 1 thread (this machine, now)", seconds / ours_one, "about 300"],
        ["physics steps per second, 1 thread (this machine, now)", runs * steps / ours_one, ""],
    ]


def odometry() -> list[list[object]]:
    """`integrate` against the plainest numpy that does the same sums."""
    robot = dd.Robot.load("mismatched")
    angles = np.cumsum(np.random.default_rng(0).uniform(0, 0.02, (1_000_000, 2)), axis=0)

    def chain() -> np.ndarray:
        left, right = np.diff(angles[:, 0]) * robot.left_radius, np.diff(angles[:, 1]) * robot.right_radius
        turn = (right - left) / robot.track_width
        theta = np.cumsum(turn)
        middle = theta - turn / 2
        length = (left + right) / 2 * np.sinc(turn / (2 * np.pi))
        return np.stack([np.cumsum(length * np.cos(middle)), np.cumsum(length * np.sin(middle)), theta], axis=-1)

    plain, ours = best(chain, lambda: dd.odometry.integrate(angles, robot))
    return [
        ["integrate / plain cumsum chain, time for a million samples", ours / plain, "<= 3"],
        ["integrate, samples per second (this machine, now)", len(angles) / ours, ""],
    ]


def calibration() -> list[list[object]]:
    """A fit of whole trajectories."""
    robot = dd.Robot.load("mismatched")
    recording = dd.simulate(robot, dd.maneuvers.square(robot, side=2.0), sample_rate=50.0)
    t = np.linspace(0, recording.t[-1], 100_000)

    def often(rows: np.ndarray) -> np.ndarray:
        return np.stack([np.interp(t, recording.t, column) for column in rows.T], axis=-1)

    noise = 1e-3 * np.random.default_rng(0).normal(size=(len(t), 3))
    drive = dd.Drive(t=t, wheel_angles=often(recording.wheel_angles), truth=often(recording.truth) + noise)
    believed = robot.replace(right_radius=robot.left_radius)
    (seconds,) = best(lambda: dd.least_squares.least_squares([drive], believed))
    return [["least squares, 100 000 samples and true poses [s] (this machine, now)", seconds, "< 2"]]


def imports() -> list[list[object]]:
    """What `import diffdrive_mj` adds to `import numpy`."""

    def load(module: str) -> Callable[[], object]:
        return lambda: subprocess.run([sys.executable, "-c", f"import {module}"], check=True)

    numpy_alone, ours = best(load("numpy"), load("numpy, diffdrive_mj"))
    return [["import diffdrive_mj beyond import numpy [s]", ours - numpy_alone, "< 0.1"]]


if __name__ == "__main__":
    rows = [*simulation(), *odometry(), *calibration(), *imports()]
    print(report.table(["what", "measured", "aim"], rows))
