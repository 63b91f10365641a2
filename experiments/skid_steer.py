"""Four wheels that skid: how wide is the robot to its odometry, and what does that depend on?

Turns of a skid-steer robot in physics, against the balance of the friction under its four wheels and against a closed
form: wheelbases, places of the weight, speeds and floors, time steps.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

import diffdrive_mj as dd
from diffdrive_mj import _checks as checks
from diffdrive_mj import report
from diffdrive_mj._checks import Array
from diffdrive_mj.errors import InvalidValue, PhysicsWarning
from diffdrive_mj.physics.skidding import measured_turn, skid_turn
from diffdrive_mj.report import Bound, Report, figures, marks, plots

# Clearpath Husky A200, after docs/howto/skid-steer.md; what its makers multiply its track by.
HUSKY = dd.Robot(
    name="husky",
    left_radius=0.1651,
    right_radius=0.1651,
    track_width=0.5708,
    body_mass=46.034,
    center_of_mass_height=0.194,
    tyres=dd.Tyres(width=0.1143, mass=2.637),
    skid_steer=dd.SkidSteer(wheelbase=0.512),
)
MAKERS = 1.875
SHAPES = np.array([0.4, 0.6, 0.8, 0.9, 1.0, 1.2])  # wheelbase over track
AHEAD = np.array([0.0, 0.04, 0.08, 0.12, 0.16, 0.2, 0.26, 0.32])  # the weight, over the wheelbase
SPEEDS = np.array([0.2, 0.5, 0.8, 1.1, 1.4])  # on a bend [m/s]
BEND = 2.0  # [m]
STEPS = (0.0005, 0.001, 0.002)  # [s]
SPIN = (-0.9, 0.9)  # rates of a slow turn on the spot [rad/s]
CLOSED, BALANCE, STICKING = 0.1, 0.6, 1.0  # allowed [%]


@dataclass(frozen=True)
class Curve:
    """Effective tracks over something, in physics and by the balance of forces (N,) [m]."""

    at: Array
    physics: Array
    balance: Array

    @property
    def off(self) -> float:
        """The largest difference [%]."""
        return float(100 * np.abs(self.physics / self.balance - 1).max())


def run(wheelbase: float = 0.512, track_width: float = 0.5708, friction: float = 0.4, start: float = 3.0) -> Report:
    """Turn on the spot and drive bends.

    Args:
        wheelbase: of the robot, front axle to rear axle [m].
        track_width: between its left and right wheels [m].
        friction: of the more slippery floor of two; the other has twice as much.
        start: after which a turn counts as steady [s].
    """
    mu, wheelbase = checks.positive("friction", friction), checks.positive("wheelbase", wheelbase)
    robot = HUSKY.replace(track_width=track_width, skid_steer={"wheelbase": wheelbase})
    if checks.number("start", start) < 2:
        raise InvalidValue(f"start = {start:g} s: must be at least 2 s, when all wheels have come up to speed")
    shapes = [robot.replace(skid_steer={"wheelbase": float(share * robot.track_width)}) for share in SHAPES]
    loads = [robot.replace(center_of_mass_x=float(share * wheelbase)) for share in AHEAD * robot.mass / robot.body_mass]
    bends = [_bend(robot, speed) for speed in SPEEDS]
    by_shape = _curve(SHAPES, shapes, [SPIN] * len(shapes), mu, start)
    by_load = _curve(AHEAD, loads, [SPIN] * len(loads), mu, start)
    by_speed = [_curve(SPEEDS, [robot] * len(bends), bends, floor, start) for floor in (mu, 2 * mu)]
    by_step = np.array([turns([robot], [SPIN], mu, start, step)[0] for step in STEPS])
    share = robot.effective_track / robot.track_width
    title = (
        f"To its odometry the robot is {share:.2f} times as wide as to a tape: wheelbase and load decide,\n"
        "the floor only where bends are fast"
    )
    sticks = _sticks(robot)
    return Report(
        question=__doc__,
        finding=(
            f"{title}.\nWith its weight {100 * sticks:.0f} % of the wheelbase or more off the middle, the heavier "
            f"wheels stop sliding, and the tape is right. Physics is at most {by_shape.off:.3f} % off the closed form."
        ),
        table=table(by_shape, by_load, by_speed, mu, by_step),
        bounds=[
            Bound("on the spot: physics against the closed form", by_shape.off, CLOSED, "%"),
            Bound("weight ahead: physics against the balance of forces", by_load.off, STICKING, "%"),
            *(Bound(f"bends, friction {f:g}: physics against the balance", c.off, BALANCE, "%")
              for f, c in zip((mu, 2 * mu), by_speed, strict=True)),
            Bound("over time steps from 0.5 to 2 ms", float(100 * np.ptp(by_step) / by_step.mean()), CLOSED, "%"),
        ],
        metrics={
            "effective_track_m": robot.effective_track,
            "wheelbase_over_track": vars(by_shape),
            "weight_ahead_over_wheelbase": vars(by_load),
            "bends": [vars(curve) for curve in by_speed],
            "sticks_from": sticks,
            "time_steps_s": STEPS,
            "by_time_step_m": by_step,
        },
        pictures={"skid_steer": figure(title, robot, by_shape, by_load, by_speed, mu)},
    )  # fmt: skip


def turns(robots: Sequence[dd.Robot], rates: Sequence[Sequence[float]], mu: float, start: float, step: float) -> Array:
    """The effective tracks (N,) [m] of steady turns in physics, each robot at its own rates."""
    after = np.minimum(np.arange(1, round(100 * (start + 6)) + 1) / 100, 1.0)  # up to speed in a second
    commands = [dd.Commands(0.01, after[:, None] * np.array(pair)) for pair in rates]
    with warnings.catch_warnings():
        warnings.simplefilter("error", PhysicsWarning)  # a wheel off the floor is no turn to measure
        recording = dd.simulate(
            robots, commands, world=dd.World(friction=mu), physics=dd.Physics.skidding(step), sample_rate=50.0
        )
    return np.array([measured_turn(run.during(start, start + 6)).effective_track for run in recording.runs])


def _curve(at: Array, robots: list[dd.Robot], rates: list[tuple[float, float]], mu: float, start: float) -> Curve:
    balance = [skid_turn(one, pair, friction=mu).effective_track for one, pair in zip(robots, rates, strict=True)]
    return Curve(at, turns(robots, rates, mu, start, 0.002), np.array(balance))


def _bend(robot: dd.Robot, speed: float) -> tuple[float, float]:
    """The wheel rates [rad/s] of a bend to the left."""
    half = speed * robot.effective_track / (2 * BEND)
    return (speed - half) / robot.left_radius, (speed + half) / robot.right_radius


def _sticks(robot: dd.Robot) -> float:
    """How far ahead of the middle the weight must be, over the wheelbase, for the front wheels to stop sliding."""
    ratio = float(np.sqrt(1 + 4 * (robot.skid_steer.wheelbase / robot.track_width) ** 2))  # N_front / N_rear
    return ratio / (1 + ratio) - 0.5


def table(by_shape: Curve, by_load: Curve, by_speed: list[Curve], mu: float, by_step: Array) -> str:
    """All the effective tracks."""
    parts = [("wheelbase / track", by_shape), ("weight ahead / wheelbase", by_load)]
    parts += [
        (f"m/s on a bend, friction {floor:g}", curve) for floor, curve in zip((mu, 2 * mu), by_speed, strict=True)
    ]
    rows = [[name, *row] for name, curve in parts for row in zip(curve.at, curve.physics, curve.balance, strict=True)]
    rows += [["time step [ms]", 1e3 * step, track, ""] for step, track in zip(STEPS, by_step, strict=True)]
    return report.table(["effective track [m] over", "", "physics", "balance of forces"], rows)


def figure(title: str, robot: dd.Robot, by_shape: Curve, by_load: Curve, by_speed: list[Curve], mu: float) -> Figure:
    """Shape, load and speed beside each other, as multiples of the track."""
    made, (left, middle, right) = plots.figure(title, columns=3, size=(figures.WIDTH, 4.4))
    width, law = robot.track_width, plots.PREDICTION | {"label": "balance of forces"}
    fine = np.linspace(0.0, 1.3, 100)
    left.plot(fine, 1 + fine**2, **law)
    left.plot(by_shape.at, by_shape.physics / width, "o", label="physics", color=plots.style(0)["color"])
    shape = HUSKY.skid_steer.wheelbase / HUSKY.track_width
    left.plot(shape, MAKERS, "*", color="black", markersize=12)
    marks.note(left, "Husky, by\nits makers", (shape, MAKERS), (-12, 4), horizontalalignment="right")
    shifts = np.linspace(0.0, AHEAD[-1], 33)
    tracks = [
        skid_turn(
            robot.replace(center_of_mass_x=float(x * robot.skid_steer.wheelbase)), SPIN, friction=mu
        ).effective_track
        for x in shifts * robot.mass / robot.body_mass
    ]
    middle.plot(shifts, np.array(tracks) / width, **law)
    middle.plot(by_load.at, by_load.physics / width, "o", label="physics", color=plots.style(0)["color"])
    for floor, curve, beside in zip((mu, 2 * mu), by_speed, ((-12, -4), (-7, -13)), strict=True):
        right.plot(curve.at, curve.balance / width, **law)
        right.plot(curve.at, curve.physics / width, "o", color=plots.style(0)["color"], label="physics")
        place = (SPEEDS[-1], curve.balance[-1] / width)
        marks.note(right, f"{floor:g}", place, beside, horizontalalignment="right")
    left.set(xlabel="wheelbase / track")
    middle.set(xlabel="weight ahead / wheelbase")
    right.set(xlabel=f"speed on a bend of {BEND:g} m [m/s]")
    for ax, name in (
        (left, "Long robots"),
        (middle, "Loaded at one end"),
        (right, f"Fast: friction {mu:g} and {2 * mu:g}"),
    ):
        ax.set(ylabel="effective track / track")
        plots.panel(ax, name)
        plots.tidy(ax)
    plots.legend_below(made, left, middle, right)
    return made


if __name__ == "__main__":
    report.main(run)
