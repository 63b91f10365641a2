"""A simple controller steers by its own odometry: where does it think it is, where is it?

[Greek notes] has such a controller in its title only; here is one, `controller.GoToPose`. It turns towards the goal,
drives, and turns to the goal's heading. It drives the path that it believes in; the path that the robot takes follows
from that through the belief matrix.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

import diffdrive_mj as dd
from diffdrive_mj import _checks as checks
from diffdrive_mj import report
from diffdrive_mj._checks import Array
from diffdrive_mj.controller import GoToPose
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.judging.beliefs import believed_path
from diffdrive_mj.judging.rolling import simulate_rolling
from diffdrive_mj.metrics import travelled
from diffdrive_mj.report import Bound, Replay, Report, plots

KNOWN, WRONG, ROUND = "true radii", "wrong radii", "wrong radii, round a square"
SQUARE = ((2.0, 0.0), (2.0, 2.0), (0.0, 2.0))
CONTROL = 20.0  # [Hz]
# A robot that moves by less in the last half second stands [m, rad]; the controller stops this close to the goal.
STANDS, ARRIVED = 1e-4, 1e-3
# The physics is off by less than this on any drive on which the wheels roll, of the way driven.
FLOOR = 1e-6


@dataclass(frozen=True)
class Driven:
    """What robots did under one belief.

    Attributes:
        truth: where they are when the controller decides (N, T, 3) [m, m, rad].
        thought: where they think they are then (N, T, 3) [m, m, rad].
        law_off: how far the path is off the one that follows from the belief, at most, of the way driven (N,).
    """

    truth: Array
    thought: Array
    law_off: Array

    def replay(self, title: str, run: int, true: dd.Robot) -> Replay:
        """One of the drives, for the report page."""
        t = np.arange(self.truth.shape[1]) / CONTROL
        return Replay(title, t, self.truth[run], {"where it thinks it is": self.thought[run]}, true)

    @property
    def says(self) -> Array:
        """How far from the goal the robots think they are at the end (N,) [m]."""
        return np.hypot(*self.thought[:, -1, :2].T)

    @property
    def misses(self) -> Array:
        """How far from the goal they are at the end (N,) [m]."""
        return np.hypot(*self.truth[:, -1, :2].T)

    @property
    def turned_away(self) -> Array:
        """How far their headings are off that of the goal at the end (N,) [degrees]."""
        return np.degrees(np.abs(dd.se2.wrap_angle(self.truth[:, -1, 2])))


def run(
    robot: str = "mismatched",
    believed_ratio: float = 1.0,
    robots: int = 24,
    speed: float = 0.5,
    seconds: float = 16.0,
    seed: int = 0,
) -> Report:
    """Drive robots to a goal, once with the true radii and once with a wrong one.

    Args:
        robot: a preset's name, or a TOML file.
        believed_ratio: right radius over left radius, as the wrong belief has it.
        robots: number of starts, 1 to 2 m from the goal.
        speed: largest [m/s]; a slower robot also speeds up and turns more gently.
        seconds: of each drive, to the next twentieth.
        seed: of the starts.
    """
    true = dd.Robot.load(robot)
    rng = np.random.default_rng(checks.whole("seed", seed, least=0))
    count = checks.whole("robots", robots, least=1)
    driven = measure(true, checks.positive("believed_ratio", believed_ratio), starts(count, rng), speed, seconds)
    known, wrong = driven[KNOWN], driven[WRONG]
    belief = "its wheels equal" if believed_ratio == 1 else f"its radius ratio {believed_ratio:.4g}"
    title = (
        f"Believing {belief}, it says that it has arrived, and is {mm(np.median(wrong.misses))} mm off (median).\n"
        f"Knowing its radii it ends within {mm(known.misses.max())} mm"
    )
    finding = (
        f"{title}. It always says that it is within {mm(max(known.says.max(), wrong.says.max()))} mm of the goal;\n"
        f"at worst it is {mm(wrong.misses.max())} mm and {wrong.turned_away.max():.2g} degrees off."
    )
    metrics = {
        label: {"miss_m": done.misses, "heading_deg": done.turned_away, "says_m": done.says, "law_off": done.law_off}
        for label, done in driven.items()
    }
    pictures = {"go_to_goal": figure(title, driven)}
    replays = [
        driven[ROUND].replay("Round a square, the radii wrong", 0, true),
        wrong.replay(
            "To the goal, the radii wrong: the start from which it misses most", int(wrong.misses.argmax()), true
        ),
    ]
    return Report(__doc__, finding, table(driven), claims(driven), metrics, pictures, replays)


def mm(metres: float) -> str:
    """A length in millimetres, with two digits or all before the point."""
    return f"{1e3 * metres:.0f}" if metres >= 0.01 else f"{1e3 * metres:.2g}"


def starts(count: int, rng: np.random.Generator) -> Array:
    """Random poses (N, 3), 1 to 2 m from the goal."""
    distance, angle, heading = rng.uniform([1.0, -np.pi, -np.pi], [2.0, np.pi, np.pi], (count, 3)).T
    return np.stack([distance * np.cos(angle), distance * np.sin(angle), heading], axis=-1)


def measure(true: dd.Robot, believed_ratio: float, start: Array, speed: float, seconds: float) -> dict[str, Driven]:
    """Drive under both beliefs, and for twice as long round a square under the wrong one."""
    twin = dd.tilt.level_twin(true)
    wrong = twin.replace(right_radius=believed_ratio * twin.left_radius)
    return {
        KNOWN: drive(true, twin, start, speed, seconds),
        WRONG: drive(true, wrong, start, speed, seconds),
        ROUND: drive(true, wrong, np.zeros((1, 3)), speed, seconds, SQUARE),
    }


def drive(
    true: dd.Robot, belief: dd.Robot, start: Array, speed: float, seconds: float, waypoints: ArrayLike | None = None
) -> Driven:
    """Drive robots from their starts (N, 3) to the origin, heading along x."""
    driver = GoToPose(
        belief, goal=(0.0, 0.0, 0.0), waypoints=waypoints, start=start,
        speed=speed, yaw_rate=3 * speed, acceleration=speed, yaw_acceleration=6 * speed,
    )  # fmt: skip
    lasts = checks.positive("seconds", seconds) * (1 if waypoints is None else 2)
    periods = np.ceil(CONTROL * lasts - 1e-9)
    loop = dd.ClosedLoop(driver, period=1 / CONTROL, duration=periods / CONTROL)
    recording = simulate_rolling([true] * len(start), loop, start=start, sample_rate=1 / dd.Physics().timestep)
    expected = believed_path(recording.odometry(belief), dd.tilt.level_twin(true), belief)
    off = np.hypot(*np.moveaxis(expected - recording.truth, -1, 0)[:2]).max(axis=-1)
    seen = recording.at_rate(CONTROL)
    thought = seen.odometry(belief)
    moved = np.abs(thought[:, -1] - thought[:, -1 - round(CONTROL / 2)]).max(axis=-1)
    if moving := np.count_nonzero(moved > STANDS):
        where = "to the goal" if waypoints is None else "round the square"
        raise InvalidValue(
            f"seconds = {seconds:g}: {moving} of {len(start)} robots {where} still move after {lasts:g} s; give more"
        )
    return Driven(seen.truth, thought, off / travelled(recording.truth)[:, -1])


def claims(driven: Mapping[str, Driven]) -> list[Bound]:
    """The controller arrives where it believes; where that is follows from its belief."""
    known = driven[KNOWN]
    return [
        *(
            Bound(f"{label}: says that it is from the goal", 1e3 * float(done.says.max()), 1e3 * ARRIVED, "mm")
            for label, done in driven.items()
        ),
        *(
            Bound(f"{label}: path off the law of its belief", 1e6 * float(done.law_off.max()), 1e6 * FLOOR, "ppm")
            for label, done in driven.items()
        ),
        Bound(f"{KNOWN}: furthest from the goal", 1e3 * float(known.misses.max()), 1e3 * ARRIVED, "mm"),
        Bound(f"{KNOWN}: largest heading error", float(known.turned_away.max()), 0.1, "degrees"),
    ]


def table(driven: Mapping[str, Driven]) -> str:
    rows = [
        [
            label,
            1e3 * float(np.median(done.says)),
            *(1e3 * float(of(done.misses)) for of in (np.median, np.max)),
            float(done.turned_away.max()),
        ]
        for label, done in driven.items()
    ]
    header = [f"{len(driven[KNOWN].truth)} starts", "says [mm]", "is, median [mm]", "is, at most [mm]", "heading [deg]"]
    return report.table(header, rows)


def figure(title: str, driven: Mapping[str, Driven]) -> Figure:
    """Where the robots are that say they are at the goal, and what a square becomes."""
    made, (left, right) = plots.figure(title, columns=2, size=(plots.WIDTH, 5.4))
    draw_arrivals(left, driven[WRONG], driven[KNOWN])
    plots.panel(left, "To the goal from many starts")
    rounds = driven[ROUND]
    plots.paths(right, rounds.truth[0], {"where it thinks it is": rounds.thought[0]}, truth_label="where it is")
    right.plot(*np.transpose([*SQUARE, (0, 0)]), "x", color="black", markersize=9, label="waypoint")
    plots.panel(right, "Through waypoints round a square")
    plots.legend_below(made, left, right)
    return made


def draw_arrivals(ax: Axes, wrong: Driven, known: Driven) -> None:
    """The paths, and a line from where each robot thinks it is to where it is."""
    is_look, says_look, known_look = (
        plots.style(k) | {"linestyle": "none", "markersize": size, "markerfacecolor": face}
        for k, size, face in ((0, 5, None), (1, 10, "none"), (2, 6, "none"))
    )
    for path in wrong.truth:
        ax.plot(*path[:, :2].T, color="0.78", linewidth=1.3)
        ax.plot(*path[0, :2], "o", color="0.5", markersize=4, markerfacecolor="white")
        ax.plot([0, path[-1, 0]], [0, path[-1, 1]], color=is_look["color"], linewidth=0.9)
    ax.plot(*wrong.truth[:, -1, :2].T, label="where they are", **is_look)
    ax.plot(*wrong.thought[:, -1, :2].T, label="where they say they are", **says_look)
    ax.plot(*known.truth[:, -1, :2].T, label="where they are, radii known", **known_look)
    ax.set_aspect("equal")
    ax.set(xlabel="x [m]", ylabel="y [m]", xlim=(-2.1, 2.1), ylim=(-2.1, 2.1))
    ax.grid(visible=True, color="0.92")


if __name__ == "__main__":
    report.main(run)
