"""Wheels slip: does the mouse sensor see it?"""

from __future__ import annotations

import functools
import warnings
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

import diffdrive_mj as dd
from diffdrive_mj import _checks as checks
from diffdrive_mj import report
from diffdrive_mj._checks import Array
from diffdrive_mj.errors import InvalidValue, PhysicsWarning
from diffdrive_mj.judging.rolling import simulate_rolling
from diffdrive_mj.kinematics import body_twist
from diffdrive_mj.physics.mechanics import contact_forces
from diffdrive_mj.report import Bound, Replay, Report, chance, marks, plots
from diffdrive_mj.report.chance import Expected
from diffdrive_mj.sensors.counting import Counter, end_error, even_phases
from diffdrive_mj.sensors.optical_flow import COUNTS_PER_INCH, FlowSensor, lever_arm

WHEELS, MOUSE = "wheel odometry", "mouse sensor"
IDEAL = ("straight", "square", "spin", "arc")
BOTH, ONE, LIFTED = "both wheels slip", "one wheel slips", "sensor lifted for 1 s"
# Slippery floors, x and y [m]: the robot starts on the one, and its left wheel crosses the other while it speeds up.
FLOORS = {BOTH: ((-1.0, 1.0), (-2.0, 2.0)), ONE: ((0.05, 0.25), (0.0, 1.0))}
# Their share of the friction that the wheels ask for. Speeding up [m/s^2] to this speed [m/s] the robot slips for
# speed^2 / (2 SHARE ACCELERATION) = 0.8 m.
SHARE, ACCELERATION, SPEED, DISTANCE = 0.25, 0.5, np.sqrt(0.2), 2.0


@dataclass(frozen=True)
class Seen:
    """A drive, and what the wheels and the mouse sensor make of it.

    Attributes:
        recording: at every step of the physics.
        paths: what each of the two believes (T, 3), and the drifts of these.
        sizes: their largest position errors, and how far the axle slides to the side [mm].
        ideal: errors of the sensor before it counts: position by way, heading by turn [ppm].
        law_off: how far the sensor's heading is off what slide / mounting and missed turns explain [counts].
    """

    recording: dd.Recording
    paths: Mapping[str, Array]
    drifts: Mapping[str, dd.metrics.Drift]
    sizes: Mapping[str, float]
    ideal: tuple[float, float]
    law_off: float


def see(recording: dd.Recording, sensor: FlowSensor, phase: Array, lost: NDArray[np.bool_]) -> Seen:
    """Judge both odometries on a drive on which the sensor lost the floor before some samples (T,)."""
    truth, flow, accumulate = recording.truth, np.asarray(recording.flow), dd.odometry.accumulate
    counts = sensor.counts(flow, phase=phase, lifted=lost)
    wheels = recording.odometry(dd.tilt.level_twin(recording.robot))
    paths = {WHEELS: wheels, MOUSE: accumulate(sensor.from_counts(counts))}
    drifts = {who: dd.metrics.drift(truth, path) for who, path in paths.items()}
    steps = dd.se2.log(dd.se2.between(truth[:-1], truth[1:]))
    turned = float(np.abs(steps[:, 2]).sum())
    before = dd.metrics.drift(truth, accumulate(sensor.from_flow(flow)))
    way = max(float(before.distance), turned * recording.robot.track_width / 2)
    ideal = (1e6 * float(before.max_position) / way, 1e6 * float(before.max_heading) / max(turned, 1.0))
    wrong = np.where(lost[1:], -steps[:, 2], steps[:, 1] / sensor.x)
    off = dd.se2.wrap_angle(drifts[MOUSE].heading_error[1:] - np.cumsum(wrong))
    sizes = {who: 1e3 * float(drift.max_position) for who, drift in drifts.items()}
    sizes["slide"] = 1e3 * float(np.abs(np.cumsum(steps[:, 1])).max())
    law_off = float(np.abs(off).max() * abs(sensor.x) * sensor.counts_per_metre)
    return Seen(recording, paths, drifts, sizes, ideal, law_off)


def run(
    robot: str = "matched", mounting: float = 0.015, counts_per_inch: float = 400.0, drives: int = 600, seed: int = 0
) -> Report:
    """Drive on good and on slippery floors, with the wheels' odometry beside that of a mouse sensor.

    Args:
        robot: a preset's name, or a TOML file.
        mounting: of the sensor, ahead of the axle [m].
        counts_per_inch: its resolution.
        drives: around a square, with random phases of the counters.
        seed: of the phases.
    """
    true, rng, count = (
        dd.Robot.load(robot),
        np.random.default_rng(checks.whole("seed", seed, least=0)),
        checks.whole("drives", drives, least=1),
    )
    resolution = checks.positive("counts_per_inch", counts_per_inch) * COUNTS_PER_INCH
    sensor = FlowSensor(x=mounting, counts_per_metre=resolution)
    if abs(mounting) * resolution < 5:
        raise InvalidValue(f"counts_per_inch = {counts_per_inch:g}: a count must stand for less than 0.2 rad of turn")
    seen = measure(true, sensor, rng)
    position, heading = quantisation(seen["square"].recording.at_rate(20.0), sensor, count, rng)
    both, one = seen[BOTH].sizes, seen[ONE]
    title = (
        f"Both wheels slip: they count {both[WHEELS]:.0f} mm too much, the mouse sensor is {both[MOUSE]:.2g} mm off.\n"
        f"One wheel slips: the sensor takes a slide of {one.sizes['slide']:.2g} mm to the side for a turn of "
        f"{np.degrees(one.drifts[MOUSE].max_heading):.2g} degrees"
    )
    finding = (
        f"{title}.\nLifted it misses all turns. {counts_per_inch:g} counts per inch leave {1e3 * position.rms:.2g} mm "
        f"RMS after a square of 1 m, {1e3 * position.law:.2g} predicted."
    )
    metrics = {
        "drives": {name: drive.sizes for name, drive in seen.items()},
        "counting_rms": {"measured": (position.rms, heading.rms), "predicted": (position.law, heading.law)},
    }
    bounds = claims(seen, sensor, position, heading)
    replays = [
        Replay(name[0].upper() + name[1:], seen[name].recording.t, seen[name].recording.truth, seen[name].paths, true)
        for name in (ONE, BOTH, LIFTED)
    ]
    return Report(__doc__, finding, table(seen), bounds, metrics, {"optical_flow": figure(title, seen)}, replays)


def measure(robot: dd.Robot, sensor: FlowSensor, rng: np.random.Generator) -> dict[str, Seen]:
    """The standard maneuvers on a good floor, one with the sensor lifted, and a start on slippery floors."""
    rate, twin, found = 1 / dd.Physics().timestep, dd.tilt.level_twin(robot), {}
    drives = {name: getattr(dd.maneuvers, name) for name in IDEAL}
    drives |= {"square": functools.partial(dd.maneuvers.square, side=1.0), LIFTED: dd.maneuvers.figure_eight}
    for name, maneuver in drives.items():
        rolled = simulate_rolling(robot, maneuver(twin), sample_rate=rate, flow_sensor=sensor)
        lost = (rolled.t > 5.0) & (rolled.t < 6.0) & (name == LIFTED)
        found[name] = see(rolled, sensor, rng.random(2), lost)
    start = dd.maneuvers.straight(twin, distance=DISTANCE, speed=SPEED, ramp=SPEED / ACCELERATION)
    friction = SHARE * float(contact_forces(robot, acceleration=(ACCELERATION, 0.0)).friction_need.max())
    for name, (x, y) in FLOORS.items():
        world = dd.World(patches=(dd.Patch(x=x, y=y, friction=friction),))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", PhysicsWarning)  # here wheels are meant to slip
            slid = dd.simulate(
                robot, start, world=world, physics=dd.Physics.sliding(), sample_rate=rate, flow_sensor=sensor
            )
        found[name] = see(slid, sensor, rng.random(2), np.zeros(len(slid.t), dtype=bool))
    return found


def quantisation(square: dd.Recording, sensor: FlowSensor, drives: int, rng: np.random.Generator) -> list[Expected]:
    """Errors of position [m] and heading [rad] at the end over random phases, and what is predicted of them."""
    flow, count = np.asarray(square.flow), 1 / sensor.counts_per_metre
    counts = sensor.counts(np.broadcast_to(flow, (drives, *flow.shape)), phase=even_phases(drives, rng))
    exact = dd.odometry.accumulate(sensor.from_flow(flow))[-1]
    x, y, turn = (dd.odometry.accumulate(sensor.from_counts(counts))[:, -1] - exact).T
    forward, left = flow.T / count
    law = end_error(square.truth, [Counter(forward, count, 0.0), Counter(left, 0.0, count / sensor.x)])
    position = Expected(np.hypot(x, y), law.position, law.position_kurtosis)
    return [position, Expected(turn, law.heading, law.heading_kurtosis)]


def claims(seen: Mapping[str, Seen], sensor: FlowSensor, position: Expected, heading: Expected) -> list[Bound]:
    """The law of the sensor's heading; what it sees and what it cannot see; what its counts leave."""
    both, spin = seen[BOTH].sizes, seen["spin"].recording
    arm, count = abs(sensor.x), 1e3 / sensor.counts_per_metre
    # Wheels that are not alike slide even where both slip.
    explained = 2 * count + (both["slide"] > 1e-6) * (both["slide"] + count) * DISTANCE / arm
    # The physics slides by less than 0.4 ppm of the way: 50 ppm of a turn at 15 mm from the axle.
    floor = 50 * max(1.0, 0.015 / arm)
    # Servos that are not matched drive a little forward while they spin.
    forward = float(body_twist(spin.wheel_angles[-1], dd.tilt.level_twin(spin.robot))[0])
    lever = lever_arm(np.asarray(spin.flow)[-1] - (forward, 0.0), spin.truth[-1, 2]) - (sensor.x, 0.0)
    ideal = [
        Bound(f"{name}: mouse sensor before it counts, {what}", value, floor, "ppm")
        for name in IDEAL
        for what, value in zip(("position / way", "heading / turn"), seen[name].ideal, strict=True)
    ]
    # What the wheels count too much is what they gain on a robot that speeds up SHARE as fast.
    spun = 1e3 * (1 / SHARE - 1) * SPEED**2 / (2 * ACCELERATION)
    lifted = 1e6 * float(seen[LIFTED].drifts[WHEELS].max_position_per_metre)
    return [
        *ideal,
        Bound("every drive: heading off slide / mounting by", max(s.law_off for s in seen.values()), 1.001, "counts"),
        Bound(f"{BOTH}: wheels count too much by", both[WHEELS], spun / 2, "mm", at_least=True),
        Bound(f"{BOTH}: mouse sensor / wheels", 100 * both[MOUSE] / both[WHEELS], 1 + 100 * explained / spun, "%"),
        Bound(f"{ONE}: slide to the side", seen[ONE].sizes["slide"], 0.5, "mm", at_least=True),
        Bound(f"{LIFTED}: wheel odometry / way", lifted, 1, "ppm"),
        Bound("lever arm from a spin off by", 1e6 * float(np.hypot(*lever)), 0.5 * spin.robot.track_width, "um"),
        # The laws are of first order in the heading's error.
        chance.rms_bound("counting, position", position, beyond=heading.law**2),
        chance.rms_bound("counting, heading", heading, beyond=heading.law**2),
    ]


def table(seen: Mapping[str, Seen]) -> str:
    header = ["mouse sensor before it counts", "position [ppm of way]", "heading [ppm of turn]"]
    ideal = report.table(header, [[name, *seen[name].ideal] for name in IDEAL])
    rows = [[name, *drive.sizes.values()] for name, drive in seen.items()]
    return f"{ideal}\n\n{report.table(['largest error [mm]', WHEELS, MOUSE, 'slide'], rows)}"


def figure(title: str, seen: Mapping[str, Seen]) -> Figure:
    """The errors where both wheels slip, and the paths where one does."""
    both, one = seen[BOTH], seen[ONE]
    made, (left, right) = plots.figure(title, columns=2)
    so_far = {who: np.maximum.accumulate(drift.position_error) for who, drift in both.drifts.items()}
    left.set_ylim(1e-3, 1e4)
    label = "largest position error so far [mm]"
    plots.errors(left, both.recording.t, so_far, xlabel="time [s]", ylabel=label, log=True)
    plots.panel(left, "Both wheels slip")
    plots.paths(right, one.recording.truth, one.paths)
    plots.panel(right, "The left wheel slips")
    marks.slippery(right, *FLOORS[ONE], "slippery for\nthe left wheel")
    plots.legend_below(made, left, right)
    return made


if __name__ == "__main__":
    report.main(run)
