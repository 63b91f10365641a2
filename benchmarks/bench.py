"""Speed, as ratios taken in one run: machines differ and are shared, ratios of work done side by side do not."""

from __future__ import annotations

import copy
import dataclasses
import functools
import importlib
import os
import subprocess
import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

import mujoco
import numpy as np
import sweeps
from mujoco.batch import Batch
from steps import HEADER, accuracy_and_cost
from timing import best

import diffdrive_mj as dd
from diffdrive_mj import report
from diffdrive_mj.errors import PhysicsWarning
from diffdrive_mj.physics.model import compile_model
from diffdrive_mj.report.filming._cameras import view
from diffdrive_mj.report.filming._renderer import pictures
from diffdrive_mj.report.filming._scene import Job, moving
from diffdrive_mj.report.filming._take import Take

FINE = dd.Physics()


def simulation() -> list[list[object]]:
    """`simulate` against the bare engine on the same models and controls, and two threads against one."""
    robot = dd.Robot.load("mismatched")
    runs = 8
    robots = [robot.replace(right_radius=0.091 + 0.001 * i) for i in range(runs)]
    drive = dd.maneuvers.square(robot, side=0.5)
    steps = round(drive.duration / dd.Physics().timestep)
    control = np.tile(np.repeat(drive.wheel_rates, steps // len(drive.wheel_rates), axis=0), 2)
    models = [compile_model(robot) for robot in robots]
    blind = [without_probes(model) for model in models]

    def bare(threads: int, models: list[mujoco.MjModel], record: tuple[str, ...] = ("qpos",)) -> None:
        batch = Batch(models[0], nsim=runs, nthread=threads)
        batch.set_models(models)
        batch.rollout(steps, control=np.broadcast_to(control, (runs, *control.shape)), record=record)

    def ours(threads: int, physics: dd.Physics = FINE) -> None:
        dd.simulate(robots, drive, physics=physics, threads=threads)

    bare_one, sensed, ours_one, bare_two, ours_two, fast = best(
        lambda: bare(1, blind),
        lambda: bare(1, models, ("qpos", "sensordata")),
        lambda: ours(1),
        lambda: bare(2, blind),
        lambda: ours(2),
        lambda: ours(1, dd.Physics.fast()),
    )
    seconds = runs * drive.duration
    return [
        ["bare engine, steps per second: with the contacts' forces / without", bare_one / sensed, ">= 0.92"],
        ["simulate / bare engine with the contacts' forces, 1 thread", sensed / ours_one, ">= 0.9"],
        ["simulate, 2 threads / 1 thread", ours_one / ours_two, ">= 1.7"],
        ["bare engine, 2 threads / 1 thread", bare_one / bare_two, ""],
        ["simulate, Physics.fast() / Physics()", ours_one / fast, ">= 2"],
        ["simulated seconds per second, 1 thread (this machine, now)", seconds / ours_one, ""],
        ["physics steps per second, 1 thread (this machine, now)", runs * steps / ours_one, ""],
    ]


def without_probes(model: mujoco.MjModel) -> mujoco.MjModel:
    """The same physics without sensors."""
    blind = copy.copy(model)
    blind.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_SENSOR)
    return blind


def loops_and_floors() -> list[list[object]]:
    """Closed loops and patchy floors against the open loop on an even floor."""
    robot = dd.Robot.load("mismatched")
    drive = dd.maneuvers.straight(robot, speed=1.0, distance=3.0, period=0.02)
    generator = np.random.default_rng(0)
    patches = tuple(
        dd.Patch(x=(x, x + width), y=(y, y + height), friction=friction)
        for x, y, width, height, friction in generator.uniform(
            (-1, -1.5, 0.05, 0.05, 0.5), (3.5, 1.5, 0.5, 0.5, 1.5), (200, 5)
        ).tolist()
    )
    return [
        row
        for count, of_loop, of_patches in ((50, "<= 1.3", ""), (20, "", "<= 3"), (1, "<= 2", "<= 4"))
        for row in against_the_open_loop(robot, drive, patches, count, of_loop, of_patches)
    ]


def against_the_open_loop(
    robot: dd.Robot, drive: dd.Commands, patches: tuple[dd.Patch, ...], count: int, of_loop: str, of_patches: str
) -> list[list[object]]:
    """What a closed loop and patches cost some robots, as multiples of the open loop's time."""
    starts = np.stack([np.zeros(count), np.linspace(-1, 1, count), np.zeros(count)], axis=-1)
    robots = [robot] * count

    def follow(t: float, _: np.ndarray) -> np.ndarray:
        return np.broadcast_to(drive.wheel_rates[round(t / drive.period)], (count, 2))

    opened, closed, patchy = best(
        lambda: dd.simulate(robots, drive, threads=1),
        lambda: dd.simulate(robots, dd.ClosedLoop(follow, drive.period, drive.duration), threads=1),
        lambda: dd.simulate(robots, drive, start=starts, world=dd.World(patches=patches), threads=1),
    )
    rows: list[list[object]] = []
    if of_loop:
        rows.append([f"closed loop at 50 Hz / open loop, time, {count} robots", closed / opened, of_loop])
    if of_patches:
        rows.append([f"200 patches / none, time, {count} robots", patchy / opened, of_patches])
    return rows


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


def encoder() -> list[list[object]]:
    """`Encoder` against the plainest numpy that reads between samples, counts ticks and makes angles of them again."""
    count, robot = 1_000_000, dd.Robot.load("mismatched")
    angles = np.cumsum(np.random.default_rng(0).uniform(0, 0.02, (count, 2)), axis=0)
    t, read = 0.01 * np.arange(count), dd.Encoder(robot, sample_rate=100.0)

    def plain() -> np.ndarray:
        due = np.stack([np.interp(t, t, wheel) for wheel in angles.T], axis=-1)
        return np.floor(due / read.tick_angle + 0.5) * read.tick_angle

    counted, ours = best(plain, lambda: read.to_angles(read.read(t, angles).counts), rounds=5)
    return [
        ["encoder, read and turned into angles / interp and floor, time for a million samples", ours / counted, "<= 10"]
    ]


def covariances() -> list[list[object]]:
    """`covariance` against `integrate` on the same samples, and both as they run on a robot."""
    robot, noise = dd.Robot.load("mismatched"), dd.WheelNoise(left=0.002, right=0.002)
    one = np.cumsum(np.random.default_rng(0).uniform(0, 0.2, (1_000_000, 2)), axis=0)
    many = np.cumsum(np.random.default_rng(0).uniform(0, 0.2, (1000, 1000, 2)), axis=1)
    drives = []
    for angles in (one, many):
        plain, exact = best(
            lambda: dd.odometry.integrate(angles, robot),  # noqa: B023
            lambda: dd.covariance(angles, robot, noise=noise),  # noqa: B023
            rounds=5,
        )
        drives.append(exact / plain)

    def run(odometer: dd.odometry.Odometer | dd.MomentOdometer) -> None:
        for sample in one[:1000].tolist():
            odometer.update(sample)

    plain, sure = best(lambda: run(dd.odometry.Odometer(robot)), lambda: run(dd.MomentOdometer(robot, noise)))
    return [
        ["covariance / integrate, time, one drive of a million samples", drives[0], "<= 20"],
        ["covariance / integrate, time, 1000 drives of 1000 samples", drives[1], "<= 20"],
        ["MomentOdometer.update / Odometer.update, time", sure / plain, "<= 1"],
        ["MomentOdometer.update [us] (this machine, now)", 1e3 * sure, "< 30"],
    ]


def trajectory_errors() -> list[list[object]]:
    """`ate` and `rpe` against evo's `process_data`, its objects built and its caches filled beforehand."""
    try:
        evo = importlib.import_module("evo.core.metrics")
        paths = importlib.import_module("evo.core.trajectory")
    except ModuleNotFoundError:
        return [["ate and rpe / evo: needs evo, `pip install .[oracle]`", "", ""]]
    count, generator = 100_000, np.random.default_rng(0)
    truth = dd.odometry.accumulate(generator.uniform((0.005, -0.01), (0.02, 0.012), (count - 1, 2)))
    estimate = truth + generator.normal(0, 0.01, truth.shape)
    t = 0.01 * np.arange(count)

    def path(poses: np.ndarray) -> object:
        half, zero = poses[:, 2] / 2, np.zeros(count)
        positions = np.stack([poses[:, 0], poses[:, 1], zero], axis=-1)
        quaternions = np.stack([np.cos(half), zero, zero, np.sin(half)], axis=-1)
        result = paths.PoseTrajectory3D(positions, quaternions, t)
        assert len(result.poses_se3) == len(result.distances) == count
        return result

    def plain() -> np.ndarray:
        off = estimate - truth
        return np.stack([np.hypot(off[:, 0], off[:, 1]), np.remainder(off[:, 2] + np.pi, 2 * np.pi) - np.pi])

    numpy_alone, drift = best(plain, lambda: dd.metrics.drift(truth, estimate), rounds=5)
    pair, part = (path(truth), path(estimate)), evo.PoseRelation.translation_part
    theirs, ours, aligned = best(
        lambda: evo.APE(part).process_data(pair),
        lambda: dd.metrics.ate(truth, estimate),
        lambda: dd.metrics.ate(truth, estimate, align="se2"),
        rounds=5,
    )
    relative, lasting, long = best(
        lambda: evo.RPE(part, delta=100, delta_unit=evo.Unit.frames, all_pairs=True).process_data(pair),
        lambda: dd.metrics.rpe(truth, estimate, duration=1.0, t=t),
        lambda: dd.metrics.rpe(truth, estimate, distance=1.0),
        rounds=3,
    )
    return [
        ["drift / hypot and remainder in numpy, time for 100 000 poses", drift / numpy_alone, "<= 10"],
        ["evo's APE / ate, time for 100 000 poses", theirs / ours, ">= 50"],
        ["evo's APE / ate with align='se2'", theirs / aligned, ">= 50"],
        ["evo's RPE over 100 frames / rpe over a duration", relative / lasting, ">= 150"],
        ["evo's RPE over 100 frames / rpe over a distance", relative / long, ">= 150"],
    ]


def logs() -> list[list[object]]:
    """`logs.read_csv` of what `logs.write_csv` writes."""
    count, generator = 50_000, np.random.default_rng(0)
    angles = np.cumsum(generator.uniform(0, 0.02, (count, 2)), axis=0)
    t, truth = 0.01 * np.arange(count), np.cumsum(generator.normal(0, 0.01, (count, 3)), axis=0)
    drives = {"every row": dd.Drive(t, angles, truth), "one row in 50": dd.Drive(t, angles, truth[::50], t[::50])}
    with TemporaryDirectory() as folder:
        paths = [Path(folder, f"{k}.csv") for k in range(len(drives))]
        for path, drive in zip(paths, drives.values(), strict=True):
            dd.logs.write_csv(path, drive)
        megabytes = [path.stat().st_size / 1e6 for path in paths]
        seconds = best(*(functools.partial(dd.logs.read_csv, path) for path in paths), rounds=5)
    return [
        [f"read_csv, a true pose in {which} [MB/s] (this machine, now)", size / time, ">= 10"]
        for which, size, time in zip(drives, megabytes, seconds, strict=True)
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
    (seconds,) = best(lambda: dd.calibration.least_squares([drive], believed))
    return [["least squares, 100 000 samples and true poses [s] (this machine, now)", seconds, "< 2"]]


def processor_time(work: Callable[[], object]) -> float:
    """What a piece of work costs all processors [s], its child processes included."""
    before = os.times()
    work()
    return sum(os.times()[:4]) - sum(before[:4])


def films() -> list[list[object]]:
    """A film against drawing its frames without trails, and then compressing them with Pillow; a strobe picture."""
    robot = dd.Robot.load("matched")
    believed = robot.replace(right_radius=0.99 * robot.right_radius)
    recording = dd.simulate(robot, dd.maneuvers.square(robot, side=0.5)).during(0.0, 6.0)
    take = Take.of(recording, believed)
    seen = take.at(np.arange(0.0, 6.0, 0.04))
    scene = moving(take, seen, view("follow", [take], seen, 4 / 3), (640, 480))
    bare = dataclasses.replace(scene, trails=(), links=())
    with TemporaryDirectory() as folder:
        path = Path(folder, "film.webp")

        def plain() -> None:
            frames = list(pictures(Job((bare,))))
            frames[0].save(path, save_all=True, append_images=frames[1:], duration=40)

        works = (plain, lambda: dd.film(recording, believed, path))
        plain_cost, film_cost = (min(processor_time(work) for _ in range(2)) for work in works)
        drawn, filmed, strobe = best(
            *works,
            lambda: dd.strobe(recording, believed, path.with_suffix(".png")),
            rounds=3,
        )
    return [
        ["film / its frames drawn, then compressed: processor time, 150 frames", film_cost / plain_cost, "<= 1.5"],
        ["film / its frames drawn, then compressed: time, with a core to spare", filmed / drawn, "<= 1.5"],
        ["film, time for a frame of 640 x 480 [s] (this machine, now)", filmed / len(seen.t), ""],
        ["strobe picture of 1600 x 1000 [s] (this machine, now)", strobe, "< 5"],
    ]


def starts() -> list[list[object]]:
    """What `import diffdrive_mj` adds to `import numpy`, and how long the program takes with Python's own start."""

    def python(*arguments: str) -> Callable[[], object]:
        return lambda: subprocess.run([sys.executable, *arguments], stdout=subprocess.DEVNULL, check=True)

    numpy_alone, ours, helped, explained = best(
        python("-c", "import numpy"),
        python("-c", "import numpy, diffdrive_mj"),
        python("-m", "diffdrive_mj", "--help"),
        python("-m", "diffdrive_mj", "explain", "matched"),
    )
    return [
        ["import diffdrive_mj beyond import numpy [s]", ours - numpy_alone, "< 0.1"],
        ["diffdrive --help [s] (this machine, now)", helped, "< 0.4"],
        ["diffdrive explain [s] (this machine, now)", explained, "< 1"],
    ]


if __name__ == "__main__":
    warnings.simplefilter("ignore", PhysicsWarning)  # wheels slip where patches begin
    rows = [
        *simulation(),
        *loops_and_floors(),
        *sweeps.rows(best),
        *odometry(),
        *encoder(),
        *covariances(),
        *trajectory_errors(),
        *logs(),
        *calibration(),
        *films(),
        *starts(),
    ]
    print(report.table(["what", "measured", "aim"], rows))
    print()
    print(report.table(HEADER, accuracy_and_cost()))
