"""Drive wheels slip: do passive wheels see it, how many does it take, and how well must they be mounted?

Passive wheels (dead wheels, odometry pods) roll along without a motor. Two that point ahead take the axle for one that
does not slide; one ahead and one across need a gyro; three see every motion by themselves. Their lever arms come from a
spin and a straight, with a tracker, or with whole turns and a tape measure.
"""

from __future__ import annotations

import functools
import math
import warnings
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

import diffdrive_mj as dd
from diffdrive_mj import _checks as checks
from diffdrive_mj import report
from diffdrive_mj._checks import Array
from diffdrive_mj.errors import PhysicsWarning
from diffdrive_mj.judging.passive_trials import ArmTrials, arm_trials, told, tracked
from diffdrive_mj.judging.rolling import simulate_rolling
from diffdrive_mj.judging.standards import STANDARD_MANEUVERS
from diffdrive_mj.physics.limits import largest_acceleration
from diffdrive_mj.physics.mechanics import contact_forces
from diffdrive_mj.report import Bound, Replay, Report, chance, marks, plots
from diffdrive_mj.report.chance import Expected

DRIVEN, TWO, GYRO, THREE, ALL = "drive wheels", "two ahead", "two, gyro", "three", "three, gyro"
GENTLE, HARD, BOTH, ONE = "gentle square", "hard square, friction 0.2", "both wheels on ice", "left wheel on ice"
# As in `optical_flow`: where the floor is slippery, x and y [m], and its share of the friction that the wheels ask for.
FLOORS = {BOTH: ((-1.0, 1.0), (-2.0, 2.0)), ONE: ((0.05, 0.25), (0.0, 1.0))}
SHARE, ACCELERATION, SPEED, DISTANCE = 0.25, 0.5, np.sqrt(0.2), 2.0
# The hard square: speeding up so many times as fast as its friction lets it.
FRICTION, TOO_FAST, SIDE = 0.2, 3.0, 1.0
# Ticks of a drive wheel's encoder, as many as the passive ones have; rates of readings and of the physics [Hz].
TICKS, RATE, RECORDED = 2000.0, 100.0, 500.0
# A gyro: angle random walk [rad/sqrt(s)], scale, and the bias [rad/s] that averaging while standing has left.
WALK, SCALE, BIAS = math.radians(0.005), 1e-3, math.radians(0.01)
TURNED = 1e-3  # of the tracker's headings, and of whole turns against a wall [rad]
# A ruler puts a wheel so far off its place [m]. A calibration is to find it to this [m], or to so many of its stated
# deviations where it is told less.
RULER, ARMS, RARE = 1e-3, 1e-4, 4.5
TRACKER, TAPE, TAPE_GYRO = "tracker", "tape, whole turns", "tape, gyro's turn"


@dataclass(frozen=True)
class Drive:
    """A drive, and what each odometry makes of it.

    Attributes:
        recording: at the rate of the readings.
        paths: what each believes (T, 3), from whole ticks and calibrated wheels.
        off: largest position errors [mm].
        allowed: for three wheels, by their miscalibration and their ticks to first order [mm].
        slide: how far the axle slides to the side [mm].
        unseen: before counting, by how much three are off the truth, and two off what they miss by that slide [ppm].
    """

    recording: dd.Recording[dd.Robot, dd.Commands]
    paths: Mapping[str, Array]
    off: Mapping[str, float]
    allowed: float
    slide: float
    unseen: tuple[float, float]


def run(
    robot: str = "matched", turns: float = 12.0, distance: float = 6.0, noise: float = 5e-4,
    calibrations: int = 200, seed: int = 0,
) -> Report:  # fmt: skip
    """Drive on good and on slippery floors, with odometry of the drive wheels beside that of passive wheels.

    Args:
        robot: a preset's name, or a TOML file.
        turns: of the spin that calibrates the lever arms.
        distance: of the straight that calibrates the radii [m].
        noise: of the tracker's positions, and of the tape measure [m]; headings and whole turns are off by 1 mrad.
        calibrations: with noise of their own, of each kind.
        seed: of noise, phases and gyro.
    """
    true, rng = dd.Robot.load(robot), np.random.default_rng(checks.whole("seed", seed, least=0))
    checks.whole("calibrations", calibrations, least=1)
    checks.positive("noise", noise)
    pods = mounted(true)
    ruled = off_by_a_ruler(pods)
    ideal = in_the_ideal_world(true, pods)
    found = calibrated(true, pods, ruled, turns, distance, noise, calibrations, rng)
    chosen = found[TRACKER].first.calibrated
    drives = measure(true, pods, chosen, rng)
    by_ruler = judged(drives[GENTLE].recording, pods, ruled, rng).off[THREE]
    slid, gentle = drives[ONE], drives[GENTLE]
    title = (
        f"The left wheel slips: the drive wheels are off by {slid.off[DRIVEN]:.0f} mm, two passive wheels by "
        f"{slid.off[TWO]:.1f} mm, three by {slid.off[THREE]:.1f} mm"
    )
    finding = (
        f"{title}. Two that point ahead miss the slide of {slid.slide:.3g} mm to the side. In the ideal world three "
        f"are within {max(max(pair) for pair in ideal[THREE].values()):.1g} ppm. With a tracker a spin of {turns:g} "
        f"turns and a straight of {distance:g} m find lever arms to {1e6 * found[TRACKER].stated.max():.0f} um. "
        f"Mounted by a ruler, each 1 mm too far out, three lose {by_ruler:.3g} mm on a gentle square of "
        f"{SIDE:g} m, calibrated {gentle.off[THREE]:.2g} mm; with a gyro for the third {gentle.off[GYRO]:.2g} mm."
    )
    metrics = {
        "ideal_ppm": {who: dict(rows) for who, rows in ideal.items()},
        "drives_mm": {name: {**drive.off, "slide": drive.slide} for name, drive in drives.items()},
        "lever_arm_std_um": {how: (1e6 * some.stated).tolist() for how, some in found.items()},
        "by_ruler_mm": by_ruler,
    }
    bounds = claims(ideal, drives, found)
    replays = [Replay(name, d.recording.t, d.recording.truth, d.paths, true) for name, d in drives.items()]
    pictures = {"passive_wheels": figure(title, drives)}
    return Report(__doc__, finding, table(drives, found), bounds, metrics, pictures, replays)


def mounted(robot: dd.Robot) -> dd.PassiveWheels:
    """Two wheels that point ahead between the drive wheels, one across behind the axle."""
    half = robot.track_width / 2
    left, right = dd.PassiveWheel(y=0.7 * half), dd.PassiveWheel(y=-0.7 * half)
    return dd.PassiveWheels(wheels=(left, right, dd.PassiveWheel(x=-0.5 * half, angle=math.pi / 2)))


def off_by_a_ruler(pods: dd.PassiveWheels) -> dd.PassiveWheels:
    """The wheels as a ruler has them: each a little too far from the axle's midpoint."""
    arms = [wheel.lever_arm for wheel in pods.wheels]
    return dd.PassiveWheels(
        wheels=tuple(w.moved(arm + math.copysign(RULER, arm)) for w, arm in zip(pods.wheels, arms, strict=True))
    )


def steps_of(pods: dd.PassiveWheels, angles: Array, turn: Array) -> dict[str, Array]:
    """The motion that each choice of the three wheels shows, with and without a gyro's turns."""
    ahead, crossed = dd.PassiveWheels(wheels=pods.wheels[:2]), dd.PassiveWheels(wheels=pods.wheels[1:])
    return {
        TWO: ahead.from_angles(angles[:, :2], slides=False),
        GYRO: crossed.from_angles(angles[:, 1:], turn=turn),
        THREE: pods.from_angles(angles),
        ALL: pods.from_angles(angles, turn=turn),
    }


def in_the_ideal_world(robot: dd.Robot, pods: dd.PassiveWheels) -> dict[str, dict[str, tuple[float, float]]]:
    """Largest errors on the standard maneuvers before counting: position by way, heading by turn [ppm]."""
    found: dict[str, dict[str, tuple[float, float]]] = {who: {} for who in (TWO, GYRO, THREE, ALL)}
    for name, maneuver in STANDARD_MANEUVERS.items():
        commands = maneuver(dd.tilt.level_twin(robot))
        rolled = simulate_rolling(robot, commands, sample_rate=RECORDED, passive_wheels=pods)
        turn = np.diff(rolled.truth[:, 2])
        turned = float(np.abs(turn).sum())
        for who, steps in steps_of(pods, np.asarray(rolled.passive_angles), turn).items():
            drift = dd.metrics.drift(rolled.truth, dd.odometry.accumulate(steps))
            way = max(float(drift.distance), turned * robot.track_width / 2)
            found[who][name] = (1e6 * float(drift.max_position) / way, 1e6 * float(drift.max_heading) / max(turned, 1))
    return found


def gyro_turns(recording: dd.Recording, rng: np.random.Generator) -> Array:
    """The turn of each step as a gyro gives it (T - 1,) [rad]."""
    gyro = dd.Gyro(sample_rate=RATE, bias=BIAS, scale_error=SCALE, angle_random_walk=WALK)
    return gyro.read(recording.t, recording.truth, rng).turns(recording.t)[0]


def measure(
    robot: dd.Robot, pods: dd.PassiveWheels, believed: dd.PassiveWheels, rng: np.random.Generator
) -> dict[str, Drive]:
    """A square driven gently and one driven hard, and a start on two slippery floors."""
    twin = dd.tilt.level_twin(robot)
    square = functools.partial(dd.maneuvers.square, twin, side=SIDE, speed=SPEED)
    start = dd.maneuvers.straight(twin, distance=DISTANCE, speed=SPEED, ramp=SPEED / ACCELERATION)
    hard = square(ramp=SPEED / (TOO_FAST * largest_acceleration(robot, dd.World(friction=FRICTION))))
    ice = SHARE * float(contact_forces(robot, acceleration=(ACCELERATION, 0.0)).friction_need.max())
    tried = {GENTLE: (square(), dd.World()), HARD: (hard, dd.World(friction=FRICTION))}
    for name, (x, y) in FLOORS.items():
        tried[name] = (start, dd.World(patches=(dd.Patch(x=x, y=y, friction=ice),)))
    found = {}
    for name, (commands, world) in tried.items():
        physics = dd.Physics() if name == GENTLE else dd.Physics.sliding()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", PhysicsWarning)  # wheels are meant to slip
            driven = dd.simulate(
                robot, commands, world=world, physics=physics, sample_rate=RECORDED, passive_wheels=pods
            )
        found[name] = judged(driven, pods, believed, rng)
    return found


def judged(
    recording: dd.Recording[dd.Robot, dd.Commands], pods: dd.PassiveWheels, believed: dd.PassiveWheels,
    rng: np.random.Generator,
) -> Drive:  # fmt: skip
    """What each odometry makes of a drive, recorded finely and read slowly."""
    slow = recording.at_rate(RATE)
    truth, own, turn = slow.truth, dd.Encoder(ticks_per_revolution=TICKS, sample_rate=RATE), gyro_turns(slow, rng)
    wheels = own.to_angles(own.read(slow.t, slow.wheel_angles, rng, phase="random").counts)
    ticks = pods.ticks(np.asarray(slow.passive_angles), phase=rng.random(len(pods.wheels)))
    read = steps_of(believed, pods.from_ticks(ticks), turn)
    paths = {who: dd.odometry.accumulate(steps, start=truth[0]) for who, steps in read.items()}
    paths = {DRIVEN: dd.odometry.integrate(wheels, dd.tilt.level_twin(slow.robot), start=truth[0]), **paths}
    off = {who: 1e3 * float(dd.metrics.drift(truth, path).max_position) for who, path in paths.items()}
    return Drive(slow, paths, off, *by_law(recording, pods, believed))


def by_law(
    recording: dd.Recording, pods: dd.PassiveWheels, believed: dd.PassiveWheels
) -> tuple[float, float, tuple[float, float]]:
    """What miscalibrated wheels and ticks allow [mm], the slide [mm], and what is off the laws of sight [ppm]."""
    truth, angles = recording.truth, np.asarray(recording.passive_angles)
    steps = dd.se2.log(dd.se2.between(truth[:-1], truth[1:]))
    seen = steps_of(pods, angles, steps[:, 2])
    three, two = (dd.odometry.accumulate(seen[who], start=truth[0]) for who in (THREE, TWO))
    # A slide adds to the path what it is, along the mean heading of its step.
    aside = np.stack([np.zeros(len(steps)), steps[:, 1] * dd.se2.sinc(steps[:, 2] / 2)], axis=-1)
    missed = np.cumsum(dd.se2.rotate(aside, truth[:-1, 2] + steps[:, 2] / 2), axis=0)
    way = max(
        float(np.hypot(*steps[:, :2].T).sum()), float(np.abs(steps[:, 2]).sum()) * recording.robot.track_width / 2
    )
    laws = (three[:, :2] - truth[:, :2], truth[1:, :2] - two[1:, :2] - missed)
    wrong = believed.from_angles(angles) - steps
    tick = np.abs(np.linalg.pinv(believed.matrix)) @ (believed.radii * believed.tick_angles)
    allowed = np.hypot(*wrong[:, :2].T).sum() + way * np.abs(np.cumsum(wrong[:, 2])).max()
    allowed += 2 * (np.hypot(*tick[:2]) + way * tick[2])
    off_three, off_two = (1e6 * float(np.hypot(*law.T).max()) / way for law in laws)
    return 1e3 * float(allowed), 1e3 * float(np.abs(np.cumsum(steps[:, 1])).max()), (off_three, off_two)


def calibrated(
    robot: dd.Robot, pods: dd.PassiveWheels, ruled: dd.PassiveWheels, turns: float, distance: float, noise: float,
    count: int, rng: np.random.Generator,
) -> dict[str, ArmTrials]:  # fmt: skip
    """Lever arms from a spin and a straight, many times, by what is known of the motion."""
    twin = dd.tilt.level_twin(robot)
    maneuvers = (dd.maneuvers.spin(twin, turns=turns), dd.maneuvers.straight(twin, distance=distance))
    drives = [simulate_rolling(robot, commands, passive_wheels=pods) for commands in maneuvers]
    ways = {TRACKER: tracked(noise, TURNED), TAPE: told(noise, TURNED), TAPE_GYRO: told(noise, TURNED, SCALE)}
    return {how: arm_trials(drives, pods, ruled, know, count=count, rng=rng) for how, know in ways.items()}


def claims(
    ideal: Mapping[str, Mapping[str, tuple[float, float]]], drives: Mapping[str, Drive], found: Mapping[str, ArmTrials]
) -> list[Bound]:
    """The floor of the ideal world, what passive wheels see where others slip, and what calibration is worth."""
    bounds = [
        Bound(f"ideal world, {who}: {what}", max(pair[k] for pair in rows.values()), 1.0, "ppm")
        for who, rows in ideal.items()
        for k, what in enumerate(("position / way", "heading / turn"))
    ]
    for name, drive in drives.items():
        three, two = drive.unseen
        bounds.append(Bound(f"{name}: three before counting / way", three, 1.0, "ppm"))
        bounds.append(Bound(f"{name}: two before counting, but for the slide / way", two, 1.0, "ppm"))
        bounds.append(Bound(f"{name}: three, calibrated", drive.off[THREE], drive.allowed, "mm"))
    # What the wheels count too much is what they gain on a robot that speeds up SHARE as fast.
    spun = 1e3 * (1 / SHARE - 1) * SPEED**2 / (2 * ACCELERATION)
    bounds.append(Bound(f"{BOTH}: drive wheels off by", drives[BOTH].off[DRIVEN], spun / 2, "mm", at_least=True))
    for how, some in found.items():
        bounds.append(chance.rms_bound(f"{how}: lever arms off, of what is stated", Expected(some.scores, 1.0)))
        if how != TAPE_GYRO:
            most = max(ARMS, RARE * float(some.stated.max()))
            bounds.append(Bound(f"{how}: lever arms off by at most", 1e3 * some.worst, 1e3 * most, "mm"))
    return bounds


def table(drives: Mapping[str, Drive], found: Mapping[str, ArmTrials]) -> str:
    who = [DRIVEN, TWO, GYRO, THREE, ALL]
    rows = [[name, *(drive.off[one] for one in who), drive.slide] for name, drive in drives.items()]
    sizes = {how: (some.stated.max(), some.errors.std(axis=0).max(), some.worst) for how, some in found.items()}
    arms = [[how, *(1e6 * float(value) for value in some)] for how, some in sizes.items()]
    errors = report.table(["largest error [mm]", *who, "slide"], rows)
    return f"{errors}\n\n{report.table(['lever arms [um]', 'stated', 'scatter', 'worst'], arms)}"


def figure(title: str, drives: Mapping[str, Drive]) -> Figure:
    """The largest errors on each drive, and the paths where the left wheel slips."""
    made, (left, right) = plots.figure(title, columns=2)
    shown = (DRIVEN, TWO, GYRO, THREE)
    for index, who in enumerate(shown):
        look = {**plots.style(index), "linestyle": "none", "markersize": 7}
        heights = np.arange(len(drives)) + 0.13 * (index - 1.5)
        left.plot([drive.off[who] for drive in drives.values()], heights, label=who, **look)
    left.set_yticks(range(len(drives)), [name.replace(", ", ",\n").replace("wheels ", "wheels\n") for name in drives])
    left.invert_yaxis()
    left.margins(y=0.15)
    left.set(xscale="log", xlabel="largest position error [mm]")
    plots.tidy(left)
    plots.panel(left, "Four drives")
    slid = drives[ONE]
    plots.paths(right, slid.recording.truth, {who: slid.paths[who] for who in shown})
    plots.panel(right, "The left wheel slips")
    marks.slippery(right, *FLOORS[ONE], "slippery for\nthe left wheel")
    plots.legend_below(made, left, right)
    return made


if __name__ == "__main__":
    report.main(run)
