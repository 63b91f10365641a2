"""Left wheel slow: where does the robot drift, does r_r = k r_l take it out, for every k?

[Behnke]: the left wheel turns k times as fast as the right one. With equal radii the robot drives the arc about the ICC
that forward kinematics gives; with r_l = v / (k rate_r) and r_r = k r_l it drives straight, at the speed v. This is
kinematics: how far the wheels lag behind their commands while they speed up is dynamics, and taken from their angles.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import diffdrive_mj as dd
from diffdrive_mj import _checks as checks
from diffdrive_mj import report
from diffdrive_mj._text import quantity
from diffdrive_mj.errors import InvalidValue, PhysicsWarning
from diffdrive_mj.judging.full_speed import SteadyArc, steady_arc
from diffdrive_mj.judging.rolling import gentle_ramp, simulate_rolling
from diffdrive_mj.judging.sampled import SampledOdometry, sampled_odometry
from diffdrive_mj.judging.standards import ANY_FLOOR, residual
from diffdrive_mj.kinematics import body_twist, constraint_residuals, turning_center, turning_radius
from diffdrive_mj.physics.tilt import level_twin
from diffdrive_mj.report import Bound, Replay, Report, marks, plots

EQUAL, COMPENSATED = "equal radii", "r_r = k r_l"
EVERY_STEP, SWEPT = 1 / dd.Physics().timestep, 20  # [Hz], and how many ratios beside 1
SLIP = 1.0  # how fast a contact may creep over the floor at any moment [ppm of the speed]
Run = dd.Recording[dd.Robot, dd.Commands]


@dataclass(frozen=True)
class Driven:
    """One of the two robots at the chosen k, recorded at every step."""

    recording: Run
    arc: SteadyArc
    odometry: SampledOdometry

    @classmethod
    def of(cls, run: Run, odometry_rate: float) -> Driven:
        """Judge a recorded drive."""
        twin = level_twin(run.robot)
        return cls(run, steady_arc(run, twin), sampled_odometry(run, twin, odometry_rate))


@dataclass(frozen=True)
class Point:
    """Both robots at one k.

    Attributes:
        ratio: k.
        turn: of the path with equal radii, as predicted, and of the compensated robot's [deg/m].
        off: how far the path with equal radii ends off its prediction, and how much of it is lag of the wheels [m].
        line: how far the compensated robot leaves the line, and how much of it is lag of the wheels [m].
    """

    ratio: float
    turn: tuple[float, float, float]
    off: tuple[float, float]
    line: tuple[float, float]


def run(
    robot: str = "matched",
    speed_ratio: float = 0.91,
    speed: float = 1.5,
    seconds: float = 10.0,
    odometry_rate: float = 10.0,
) -> Report:
    """Drive both robots, at the chosen k and at every other.

    Args:
        robot: a preset's name, or a TOML file; its right wheel follows from the ratio.
        speed_ratio: k = left rate / right rate.
        speed: of the compensated robot [m/s].
        seconds: at full speed, half of the ramps included.
        odometry_rate: [Hz], any.
    """
    base = dd.Robot.load(robot)
    commands = constant(base, speed, speed_ratio, seconds)
    right_rate = float(commands.wheel_rates[:, 1].max())
    left, right = dd.kinematics.radii_for_speed(speed, right_rate, speed_ratio)
    equal = base.replace(name=EQUAL, left_radius=left, right_radius=left)
    robots = [equal, equal.replace(name=COMPENSATED, right_radius=right)]
    runs = simulate_rolling(robots, commands, sample_rate=EVERY_STEP).runs
    driven = {run.robot.name: Driven.of(run, odometry_rate) for run in runs}
    swept = sweep(equal, speed_ratio, speed, seconds)
    answer = finding(driven, swept, speed_ratio)
    return Report(
        question=__doc__,
        finding=answer,
        table=table(swept, speed_ratio),
        bounds=claims(driven, swept, speed, seconds),
        metrics={
            "speed_ratio": speed_ratio,
            "left_radius_m": left,
            "right_radius_m": right,
            "turning_radius_m": float(turning_radius(driven[EQUAL].arc.twist)),
            "strays_to_the_side_m": strays(driven[EQUAL].recording),
            "sweep": [vars(point) for point in swept],
        },
        pictures={"radius_compensation": figure(answer.splitlines()[0], driven, swept, speed_ratio)},
        replays=replays(driven),
    )


def constant(base: dd.Robot, speed: float, speed_ratio: float, seconds: float) -> dd.Commands:
    """The wheel rates at which the compensated robot drives at a speed [m/s]."""
    k = checks.positive("speed_ratio", speed_ratio)
    right_rate = checks.positive("speed", speed) / (k * base.left_radius)
    ramp = gentle_ramp(base, speed * max(1.0, 1 / k), least=2.0)
    if checks.positive("seconds", seconds) <= ramp:
        raise InvalidValue(f"seconds = {seconds:g}: must be more than the {ramp:.3g} s in which the robot speeds up")
    return dd.maneuvers.constant_rates((k * right_rate, right_rate), seconds, ramp=ramp)


def sweep(equal: dd.Robot, speed_ratio: float, speed: float, seconds: float) -> list[Point]:
    """Both robots for many k from 1 to the chosen one, or a fifth away; those whose wheels slip are left out."""
    span = max(0.2, abs(1 - speed_ratio)) * (1 if speed_ratio > 1 else -1)
    ratios = np.unique(np.round([*(1 + span * np.linspace(0, 1, SWEPT + 1)), speed_ratio], 9)).tolist()
    radii = [dd.kinematics.compensated_right_radius(equal.left_radius, k) for k in ratios]
    compensated = [equal.replace(right_radius=radius) for radius in radii]
    drives = [constant(equal, speed, k, seconds) for k in ratios]
    commands = [drive.extended(max(drive.duration for drive in drives)) for drive in drives]
    with warnings.catch_warnings(action="ignore", category=PhysicsWarning):
        runs = dd.simulate([equal] * len(ratios) + compensated, commands * 2, on_fall="record").runs
    pairs = zip(ratios, runs[: len(ratios)], runs[len(ratios) :], strict=True)
    return [point(k, arc, line) for k, arc, line in pairs if not (arc.events or line.events)]


def point(ratio: float, arc: Run, line: Run) -> Point:
    """Compare both drives with kinematics, as commanded and as the wheels turned."""
    twin = level_twin(arc.robot)
    distance, angle = body_twist(arc.commands.wheel_rates.sum(axis=0) * arc.commands.period, twin)
    predicted = dd.se2.exp((distance, 0.0, angle))
    off, lag = (float(np.hypot(*(path[-1] - predicted)[:2])) for path in (arc.truth, arc.odometry(twin)))
    uneven = float(np.abs(line.odometry(level_twin(line.robot))[:, 1]).max())
    turns = (arc.truth[-1, 2] / distance, angle / distance, line.truth[-1, 2] / line.truth[-1, 0])
    seen, computed, compensated = np.degrees(turns).tolist()
    return Point(ratio, (seen, computed, compensated), (off, lag), (strays(line), uneven))


def claims(driven: dict[str, Driven], swept: list[Point], speed: float, seconds: float) -> list[Bound]:
    """What the formulas promise, to the floor of the physics and to what the wheels and a tilted axle explain."""
    equal, straight, ppm = driven[EQUAL].arc, driven[COMPENSATED].arc, 1e6 / (speed * seconds)
    faster, robot = 1e6 * abs(straight.speed / speed - 1), driven[COMPENSATED].recording.robot
    rates = driven[COMPENSATED].recording.commands.wheel_rates.max(axis=0)
    tilt = 1e6 * abs(body_twist(rates, level_twin(robot))[0] / body_twist(rates, robot)[0] - 1)
    ends, lines = max(p.off[0] - p.off[1] for p in swept), max(p.line[0] - p.line[1] for p in swept)
    bounds = [
        Bound(f"{EQUAL}: off the arc about the ICC", equal.off, ANY_FLOOR + equal.unsteady, "ppm of its length"),
        Bound(f"{COMPENSATED}: speed off by", faster, ANY_FLOOR + 2 * straight.unsteady + tilt, "ppm"),
        Bound(f"{EQUAL}, any k: end off its prediction, beside lag", ppm * ends, ANY_FLOOR, "ppm of the distance"),
        Bound(f"{COMPENSATED}, any k: off the line, beside lag", ppm * lines, ANY_FLOOR, "ppm of the distance"),
    ]
    if robot.servo.gains == "matched" and robot.axle == "independent" and not robot.payload.mass * robot.payload.y:
        uneven = ppm * max(p.line[1] for p in swept)
        bounds.append(Bound(f"{COMPENSATED}, any k: off the line by lag", uneven, ANY_FLOOR, "ppm of the distance"))
    for label, drive in driven.items():
        left = residual(drive.recording, level_twin(drive.recording.robot)).position
        at_rate, lost = (ppm * float(x) for x in (drive.odometry.drift.max_position, drive.odometry.loss))
        bounds += [
            Bound(f"{label}: contacts slip at most", 1e6 * slip(drive.recording) / speed, SLIP, "ppm of the speed"),
            Bound(f"{label}: odometry at every step off by", left, ANY_FLOOR, "ppm of the distance"),
            Bound(f"{label}: odometry at its rate off by", at_rate, ANY_FLOOR + lost, "ppm of the distance"),
        ]
    return bounds


def slip(recording: Run) -> float:
    """What [Behnke]'s constraints leave over from step to step: the largest speed of a contact over the floor [m/s]."""
    velocity = dd.se2.log(dd.se2.between(recording.truth[:-1], recording.truth[1:])) * EVERY_STEP
    rates = np.diff(recording.wheel_angles, axis=0) * EVERY_STEP
    return float(np.abs(constraint_residuals(velocity, rates, level_twin(recording.robot))).max())


def strays(recording: Run) -> float:
    """How far a robot gets to the side of the line that it starts along [m]."""
    return float(np.abs(recording.truth[:, 1]).max())


def finding(driven: dict[str, Driven], swept: list[Point], speed_ratio: float) -> str:
    """The answer; its first line is the picture's title."""
    aside, ahead = strays(driven[EQUAL].recording), float(driven[COMPENSATED].recording.truth[-1, 0])
    slow, share = ("left", 1 - speed_ratio) if speed_ratio <= 1 else ("right", 1 - 1 / speed_ratio)
    ratios, kept = [p.ratio for p in swept], quantity(max(p.line[0] for p in swept), "m")
    return (
        f"A {slow} wheel {100 * share:.3g} % slow strays {quantity(aside, 'm')} to its side; with r_r = k r_l it "
        f"drives straight\nWith equal radii the robot circles at {abs(turning_radius(driven[EQUAL].arc.twist)):.3f} m. "
        f"Compensated it runs {ahead:.2f} m straight,\nand leaves the line by {kept} at most for {len(ratios)} k from "
        f"{min(ratios):.2f} to {max(ratios):.2f}."
    )


def replays(driven: dict[str, Driven]) -> list[Replay]:
    """Both drives, each as both robots would believe it: taken for the other one, it is as far off as the other is."""
    runs = {label: drive.recording for label, drive in driven.items()}
    beliefs = {f"believed: {label}": level_twin(runs[label].robot) for label in (COMPENSATED, EQUAL)}
    return [Replay.of(f"{label}, as driven", run, beliefs, level_twin(run.robot)) for label, run in runs.items()]


def table(swept: list[Point], speed_ratio: float) -> str:
    """Every fourth k and the chosen one."""
    shown = [p for k, p in enumerate(swept) if k % 4 == 0 or p.ratio == speed_ratio]
    rows = [[f"{p.ratio:.4g}", p.turn[1], p.turn[0], *(1e3 * x for x in (*p.off, *p.line))] for p in shown]
    lag = "by lag [mm]"
    header = ["k", "predicted [deg/m]", f"{EQUAL} [deg/m]", "end off [mm]", lag, f"{COMPENSATED}: off line [mm]", lag]
    return report.table(header, rows)


def figure(title: str, driven: dict[str, Driven], swept: list[Point], speed_ratio: float) -> Figure:
    """Both paths, and the turn of the path for every k."""
    made, (left, right) = plots.figure(title, columns=2, size=(plots.WIDTH, 4.7), widths=(1.5, 1))
    draw_paths(left, driven)
    draw_sweep(right, swept, speed_ratio)
    plots.legend_below(made, left, right, columns=4)
    return made


def draw_paths(ax: Axes, driven: dict[str, Driven]) -> None:
    """True paths with robots on them, what the odometry believes, and the ICC."""
    truths = {label: drive.recording.truth for label, drive in driven.items()}
    reach = float(np.ptp(np.concatenate(list(truths.values()))[:, :2], axis=0).max())
    for index, (label, truth) in enumerate(truths.items()):
        robot, look = driven[label].recording.robot, plots.style(index)
        ax.plot(*truth[:, :2].T, label=None if index else "truth", **plots.TRUTH)
        ax.plot(*driven[label].odometry.path[:, :2].T, label=f"{label}, odometry", **look | {"marker": None})
        for pose, color in ((truth[-1], look["color"]), (truth[0], "0.25")):
            marks.robot_from_above(ax, robot, pose, enlarged=0.06 * reach / robot.track_width, color=color)
    arc, aside = driven[EQUAL].arc, strays(driven[EQUAL].recording)
    center = turning_center(arc.recording.truth[0], arc.twist)
    if np.abs(center).max() < reach:
        ax.plot(*center, "+", color="black", markersize=11, markeredgewidth=1.5, linestyle="none", label="ICC")
    if aside > 0.1 * reach:
        beside = truths[EQUAL][:, 0].max() + 0.04 * reach
        marks.dimension(ax, (beside, 0), (beside, np.copysign(aside, center[1])), quantity(aside, "m"))
    plots.panel(plots.plane(ax), "Paths (robots drawn larger than they are)")


def draw_sweep(ax: Axes, swept: list[Point], speed_ratio: float) -> None:
    """How much the path turns in a metre, for every k."""
    ratios, (equal, computed, compensated) = [p.ratio for p in swept], np.array([p.turn for p in swept]).T
    marked = {"linestyle": "none", "markersize": 5.5}
    ax.plot(ratios, computed, label=f"{EQUAL}, predicted", **plots.PREDICTION)
    ax.plot(ratios, equal, label=f"{EQUAL}, truth", **plots.style(0) | marked)
    ax.plot(ratios, compensated, label=f"{COMPENSATED}, truth", **plots.style(1) | marked)
    ax.axvline(speed_ratio, color="0.6", linewidth=0.9, zorder=0)
    ax.set(xlabel="speed ratio k = left rate / right rate", ylabel="turn of the path [deg/m]")
    plots.panel(plots.tidy(ax), f"For every k the turn is gone (line: {speed_ratio:.3g})")


if __name__ == "__main__":
    report.main(run)
