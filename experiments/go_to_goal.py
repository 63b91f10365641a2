"""A simple controller that steers by its own odometry: where does it think it is, where is it?"""

from __future__ import annotations

import numpy as np

import diffdrive_mj as dd
from diffdrive_mj import report
from diffdrive_mj.controller import GoToPose
from diffdrive_mj.report import Bound, Report, plots

COMPENSATED, EQUAL = "true radii", "believed equal"
SQUARE = ((2.0, 0.0), (2.0, 2.0), (0.0, 2.0))


def run(robots: int = 24, seconds: float = 16.0, seed: int = 0) -> Report:
    """A simple controller that steers by its own odometry: where does it think it is, where is it?

    Args:
        robots: that start from random poses within 2 m of the goal.
        seconds: of each drive.
        seed: of the poses.
    """
    true = dd.Robot.load("mismatched")
    beliefs = {COMPENSATED: true, EQUAL: true.replace(right_radius=true.left_radius)}
    rng = np.random.default_rng(seed)
    starts = np.concatenate([rng.uniform(-2, 2, (robots, 2)), rng.uniform(-np.pi, np.pi, (robots, 1))], axis=1)
    goals = {label: drive(true, belief, starts, seconds) for label, belief in beliefs.items()}
    rounds = {label: drive(true, belief, (0.0, 0.0, 0.0), 2 * seconds, SQUARE) for label, belief in beliefs.items()}

    places = {label: np.hypot(*truth[:, -1, :2].T) for label, (truth, _) in goals.items()}
    turns = {label: np.abs(dd.se2.wrap_angle(truth[:, -1, 2])) for label, (truth, _) in goals.items()}
    arrived = {label: np.hypot(*belief[:, -1, :2].T) for label, (_, belief) in goals.items()}
    bounds = [
        Bound("true radii: furthest from the goal", 1e3 * float(places[COMPENSATED].max()), 5, "mm"),
        Bound("true radii: largest heading error", float(np.degrees(turns[COMPENSATED].max())), 0.5, "degrees"),
        *(
            Bound(f"{name}: says that it is from the goal", 1e3 * float(d.max()), 5, "mm")
            for name, d in arrived.items()
        ),
        Bound("believed equal: nearest to the goal", 1e3 * float(places[EQUAL].min()), 5, "mm", at_least=True),
        Bound("believed equal: typically from the goal", float(np.median(places[EQUAL])), 0.1, "m", at_least=True),
    ]
    rows = [
        [
            label,
            1e3 * float(np.median(arrived[label])),
            1e3 * float(np.median(places[label])),
            1e3 * float(places[label].max()),
            float(np.degrees(turns[label].max())),
        ]
        for label in beliefs
    ]
    header = [f"{robots} starts", "says [mm]", "is, median [mm]", "is, largest [mm]", "heading [deg]"]
    typical = float(np.median(places[EQUAL]))
    finding = (
        f"The robot that takes its wheels for equal says that it has arrived, and is {1e3 * typical:.0f} mm from the "
        f"goal in the median,\n{1e3 * places[EQUAL].max():.0f} mm at worst. With its true radii the same controller "
        f"ends within {1e3 * places[COMPENSATED].max():.1f} mm and {np.degrees(turns[COMPENSATED].max()):.2g} degrees."
    )
    title = f"Believing equal wheels it says it arrived, {1e3 * typical:.0f} mm off; with the true radii it is there"
    made, axes = plots.figure(title, columns=3, size=(16, 5.4))
    for ax, label in zip(axes, (EQUAL, COMPENSATED), strict=False):
        draw_arrivals(ax, *goals[label])
        ax.set_title(f"{label}: where the robots are", loc="left", fontsize=11)
    truth, belief = rounds[EQUAL]
    plots.paths(axes[2], truth, {"believed, wheels taken for equal": belief})
    axes[2].plot(*np.transpose([*SQUARE, (0, 0)]), "x", color="black", markersize=9, label="waypoints")
    axes[2].legend(fontsize=8, loc="center")
    axes[2].set_title("Following waypoints around a square", loc="left", fontsize=11)
    metrics = {
        label: {"place_m": places[label], "heading_rad": turns[label], "believed_place_m": arrived[label]}
        for label in beliefs
    }
    question = "A simple controller that steers by its own odometry: where does it think it is, where is it?"
    return Report(question, finding, report.table(header, rows), bounds, metrics, {"go_to_goal": made})


def drive(true: dd.Robot, belief: dd.Robot, start, seconds: float, waypoints=None) -> tuple[np.ndarray, np.ndarray]:
    """True and believed paths of robots driven to the origin, heading along x, in one batch."""
    driver = GoToPose(belief, goal=(0.0, 0.0, 0.0), start=start, waypoints=waypoints)
    robots = true if np.ndim(start) == 1 else [true] * len(start)
    loop = dd.ClosedLoop(driver, period=0.05, duration=seconds)
    recording = dd.simulate(robots, loop, start=start, sample_rate=20.0)
    return recording.truth, recording.odometry(belief)


def draw_arrivals(ax, truth: np.ndarray, belief: np.ndarray) -> None:
    for i, (path, thought) in enumerate(zip(truth, belief, strict=True)):
        ax.plot(*path[:, :2].T, color="0.75", linewidth=1.5, label=None if i else "true path")
        ax.plot(*path[0, :2], "o", color="0.5", markersize=4, markerfacecolor="white", label=None if i else "start")
        look = plots.style(1) | {"linestyle": "none", "markersize": 7, "markerfacecolor": "none"}
        ax.plot(*thought[-1, :2], label=None if i else "says that it is", **look)
        look = plots.style(0) | {"linestyle": "none", "markersize": 6}
        ax.plot(*path[-1, :2], label=None if i else "is", **look)
    ax.plot(0, 0, "+", color="black", markersize=16, label="goal")
    ax.set_aspect("equal")
    ax.set(xlabel="x [m]", ylabel="y [m]", xlim=(-2.6, 2.6), ylim=(-2.6, 2.6))
    ax.grid(visible=True, color="0.92")
    ax.legend(fontsize=9, loc="upper left")


if __name__ == "__main__":
    report.main(run)
