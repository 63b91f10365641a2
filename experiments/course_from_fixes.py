"""How far to drive between two fixes to know the heading?"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import chndtr

import diffdrive_mj as dd
from diffdrive_mj import report
from diffdrive_mj.estimation import course, straightness
from diffdrive_mj.estimation.course_noise import best_baseline, direction_std, end_std, first_order_std
from diffdrive_mj.estimation.course_tracker import CourseTracker
from diffdrive_mj.maneuvers import Segment
from diffdrive_mj.report import Bound, Report, plots

NOISES = np.array([0.001, 0.01, 0.03])
BY_NOISE = NOISES[:, None]
LABELS = [f"{1e3 * noise:g} mm fixes" for noise in NOISES]
BASELINES = np.array([0.05, 0.07, 0.1, 0.14, 0.2, 0.3, 0.4, 0.5, 0.7, 1, 1.4, 2, 2.5, 3, 3.5, 4, 5])
BENDS = np.radians([3, 5, 10, 20, 30, 45, 60, 90, 120])
METRE = 1.0  # 001's guess
START = (1.0, 2.0, 2.2)


@dataclass(frozen=True)
class Spread:
    """The standard deviation of simulated errors, and what it was predicted to be, both (noises, baselines) [rad].

    Args:
        predicted, simulated: as they say.
        standard_error: of the simulated one, from the errors' fourth moment.
    """

    predicted: np.ndarray
    simulated: np.ndarray
    standard_error: np.ndarray

    @property
    def off(self) -> float:
        """The largest deviation from the prediction, in standard errors."""
        return float((np.abs(self.simulated - self.predicted) / self.standard_error).max())


def run(runs: int = 10_000, seed: int = 1, wander_deg: float = 1.0) -> Report:
    """How far to drive between two fixes to know the heading?

    Args:
        runs: simulated fixes at each point.
        seed: of their noise; a few in a hundred break a bound of three standard errors by chance, as they must.
        wander_deg: what the heading wanders by along a metre [deg], as a random walk.
    """
    robot, q = dd.Robot.load("matched"), np.radians(wander_deg) ** 2
    fixes_rng, bends_rng, wander_rng, goal_rng = map(np.random.default_rng, np.random.SeedSequence(seed).spawn(4))
    along, truth = straight_drive(robot)
    still = fixes_alone(along, truth, fixes_rng.normal(size=(2, runs, 2)))
    bends = bent_drives(robot, bends_rng.normal(size=(2, runs, 2)))
    wandering = wandering_drives(along, q, runs, wander_rng)
    goal = to_goals(robot, goal_rng, runs)

    first_order = first_order_std(BY_NOISE, along)
    low, fine = 100 * np.abs(first_order / still.predicted - 1), BY_NOISE / along <= 0.1
    best, fitted = best_baseline(NOISES, q), fitted_best(along, wandering)
    bounds = [
        Bound("fixes alone: simulated off the exact prediction by", still.off, 3, "standard errors"),
        Bound("first order off the exact, noise under baseline / 10, by", low[fine].max(), 1.05, "%"),
        Bound("first order off the exact, 30 mm after 50 mm, by", low[-1, 0], 10, "%", at_least=True),
        Bound("bends: epsilon off its law by", 1e3 * bends["epsilon_off"], 0.05, "mm"),
        Bound("bends: course off half the bend by", np.degrees(bends["course_off"]), 0.02, "deg"),
        Bound("bends: share flagged off its prediction by", bends["flagged_off"], 3, "standard errors"),
        Bound("wander: simulated off the prediction by", wandering.off, 3, "standard errors"),
        Bound("wander: best baseline, simulated, off by", 100 * np.abs(fitted / best - 1).max(), 5, "%"),
        Bound("goal: end of the drive off the geometry by", 1e3 * goal["geometry_off"], 0.2, "mm"),
        Bound("goal: miss off its prediction by", goal["miss_off"], 3, "standard errors"),
        Bound("goal: course after the second drive off its prediction by", goal["course_off"], 3, "standard errors"),
    ]

    known = np.degrees(direction_std(NOISES, METRE))
    visible = np.degrees(straightness.smallest_visible_bend(NOISES, METRE))
    hidden = np.degrees(straightness.hidden_course_error(NOISES, METRE))
    metre = end_std(NOISES, METRE, q) / end_std(NOISES, best, q) - 1
    metre_best = np.degrees(np.sqrt(12) * NOISES[1] / METRE)
    finding = (
        f"With fixes of 10 mm a straight metre tells the course to {known[1]:.2f} degrees, but epsilon is blind to a "
        f"bend of up to {visible[1]:.0f} degrees in it, which puts the course {hidden[1]:.0f} degrees off.\n"
        f"Where the heading wanders by {wander_deg:g} deg along a metre, {several(best, '.2f')} m are best for "
        f"1, 10 and 30 mm, and a metre is {several(100 * metre, '.0f')} % worse: a good guess for 10 mm, the best "
        f"where it wanders by {metre_best:.1f} deg.\n"
        f"After a metre and the missing turn a goal {goal['away']:g} m away is missed by {1e3 * goal['miss']:.0f} mm "
        f"({1e3 * goal['miss_predicted']:.0f} predicted), and with that drive the course is known to "
        f"{np.degrees(goal['course_std']):.2f} degrees."
    )
    title = (
        f"Fixes of 1, 10 and 30 mm tell the heading best after {several(best, '.2g')} m; "
        f"over a metre epsilon is blind to bends of {several(visible, '.0f')} degrees"
    )
    made, axes = plots.figure(title, columns=3, size=(17, 5.6))
    draw_fixes(axes[0], along, still, first_order)
    draw_bends(axes[1], bends, visible, hidden)
    draw_wander(axes[2], along, wandering, best, end_std(NOISES, best, q), wander_deg)
    metrics = {
        "fix_noise_m": NOISES,
        "baselines_m": along,
        "fixes_alone_rad": vars(still) | {"first_order": first_order},
        "wander_rad2_per_m": q,
        "wandering_rad": vars(wandering),
        "best_baseline_m": {"predicted": best, "simulated": fitted, "metre_worse_by": metre},
        "bends": {"bend_rad": BENDS, "smallest_visible_deg": visible, "hidden_course_error_deg": hidden, **bends},
        "goal": goal,
    }
    tables = f"{baseline_table(along, still, wandering, best)}\n\n{bend_table(bends)}"
    question = run.__doc__.splitlines()[0]
    return Report(question, finding, tables, bounds, metrics, {"course_from_fixes": made})


def straight_drive(robot: dd.Robot) -> tuple[np.ndarray, np.ndarray]:
    """Drive over the longest baseline, once.

    Returns:
        At every baseline, the distance by odometer (B,) and the true pose (B + 1, 3), the true start pose first.
    """
    commands = dd.maneuvers.straight(robot, speed=0.5, distance=BASELINES[-1])
    recording = dd.simulate(robot, commands, start=START)
    along = odometer(recording, robot)
    places = [int(np.argmin(np.abs(along - w))) for w in BASELINES]
    return along[places], np.concatenate([recording.truth[:1], recording.truth[places]])


def odometer(recording: dd.Recording, robot: dd.Robot) -> np.ndarray:
    """The distance driven (..., T) [m], as the wheels tell it."""
    return dd.kinematics.body_twist(recording.wheel_angles, robot)[..., 0]


def seen(draws: np.ndarray, first: np.ndarray, last: np.ndarray, driven: np.ndarray) -> course.Course:
    """The courses (noises, drives, runs) that noisy fixes of drives tell.

    The same draws serve every point of a sweep: what chance does to one it does to most, so that three standard
    errors are not exceeded somewhere merely because there are many points.

    Args:
        draws: of the fixes' noise (2, runs, 2).
        first: where the drives truly start, broadcasting to (drives, runs, 2) [m].
        last: where they truly end, likewise.
        driven: how far (drives,) [m].
    """
    noise = NOISES[:, None, None]
    before, after = (place + noise[..., None] * draw for place, draw in zip((first, last), draws, strict=True))
    return course.from_fixes(before, after, driven[:, None], fix_noise=noise)


def spread(predicted: np.ndarray, error: np.ndarray) -> Spread:
    """Predictions (noises, baselines) beside the standard deviations about zero of errors (..., runs) [rad]."""
    error = dd.se2.wrap_angle(error)
    square, fourth = (np.mean(error**power, axis=-1) for power in (2, 4))
    return Spread(predicted, np.sqrt(square), np.sqrt((fourth - square**2) / error.shape[-1] / (4 * square)))


def fixes_alone(along: np.ndarray, truth: np.ndarray, draws: np.ndarray) -> Spread:
    """The course's error on the straight drive."""
    last = truth[1:, None]
    error = seen(draws, truth[0, :2], last[..., :2], along).yaw - last[..., 2]
    return spread(direction_std(BY_NOISE, along), error)


def bent_drives(robot: dd.Robot, draws: np.ndarray) -> dict:
    """A metre that bends: what it does to the chord and to the course, and how often epsilon flags it."""
    arcs = [dd.maneuvers.arc(robot, radius=METRE / bend, distance=METRE, speed=0.25) for bend in BENDS]
    recording = dd.simulate(robot, arcs, start=START)
    first, last = recording.truth[:, 0], recording.truth[:, -1]
    driven = odometer(recording, robot)[:, -1]
    exact = course.from_fixes(first[:, :2], last[:, :2], driven, fix_noise=0)
    course_error = dd.se2.wrap_angle(last[:, 2] - exact.yaw)
    flagged = np.mean(~seen(draws, first[:, None, :2], last[:, None, :2], driven).straight, axis=-1)
    predicted = flagging(exact.baseline, driven)
    # A share near 0 or 1 is as good as sure: one run more or less is within its error.
    error = np.sqrt(predicted * (1 - predicted) / draws.shape[1]) + 1 / draws.shape[1]
    return {
        "epsilon": exact.epsilon,
        "epsilon_off": np.abs(exact.epsilon - straightness.chord_shortening(BENDS, driven)).max(),
        "course_error": course_error,
        "course_off": np.abs(course_error - BENDS / 2).max(),
        "flagged": flagged,
        "flagged_predicted": predicted,
        "flagged_off": (np.abs(flagged - predicted) / error).max(),
    }


def flagging(chord: np.ndarray, driven: np.ndarray) -> np.ndarray:
    """How often epsilon passes its threshold: the distance between two noisy fixes is Rice distributed."""
    sigma = np.sqrt(2) * BY_NOISE
    below, above = (
        chndtr((np.maximum(driven + side * straightness.SIGMAS * sigma, 0) / sigma) ** 2, 2, (chord / sigma) ** 2)
        for side in (-1, 1)
    )
    return 1 - (above - below)


def wandering_drives(along: np.ndarray, q: float, runs: int, rng: np.random.Generator, steps: int = 50) -> Spread:
    """A model without physics: the heading is a random walk of variance q s, the path follows it, the fixes are noisy.

    The error is that of the course taken for the heading at the end.
    """
    turns = rng.normal(size=(runs, steps)) / np.sqrt(steps)
    # A step's heading is half-way through its turn.
    walk = np.cumsum(turns, axis=1) - turns / 2
    draws = rng.normal(size=(2, runs, 2))
    size = np.sqrt(q * along)
    ends = np.stack([w * unit(s * walk).mean(axis=1) for w, s in zip(along, size, strict=True)])
    error = seen(draws, np.zeros(2), ends, along).yaw - size[:, None] * turns.sum(axis=1)
    return spread(np.hypot(direction_std(BY_NOISE, along), size / np.sqrt(3)), error)


def fitted_best(along: np.ndarray, wandering: Spread) -> np.ndarray:
    """The minimum of A / w^2 + B w fitted to the simulated variances, (2 A / B)^(1/3) [m], by noise."""
    result = []
    for noise, std, error in zip(NOISES, wandering.simulated, wandering.standard_error, strict=True):
        used = noise / along <= 0.1
        w, weight = along[used], 1 / (2 * std * error)[used]
        terms = np.stack([1 / w**2, w], axis=-1)
        a, b = np.linalg.lstsq(weight[:, None] * terms, weight * std[used] ** 2, rcond=None)[0]
        result.append(np.cbrt(2 * a / b))
    return np.array(result)


def to_goals(
    robot: dd.Robot, rng: np.random.Generator, runs: int, noise: float = 0.01, away: float = 3.0, driven_runs: int = 32
) -> dict:
    """Drive a metre, turn by the missing angle, drive to the goal: goals all around, a few of the runs in physics.

    At the goal the second straight drive updates the course; its fixes are taken anew.
    """
    first = dd.simulate(robot, dd.maneuvers.straight(robot, speed=0.5, distance=METRE), start=START)
    stop, driven = first.truth[-1], odometer(first, robot)[-1]
    fixes = np.array([START[:2], stop[:2]])[:, None] + noise * rng.normal(size=(2, runs, 2))
    later = noise * rng.normal(size=(2, runs, 2))
    told = course.from_fixes(*fixes, driven, fix_noise=noise)
    # Three standard deviations flag one straight drive in 400; who cannot trust a course does not go on.
    (there, here), later, yaw = fixes[:, told.straight], later[:, told.straight], told.yaw[told.straight]
    around = 2 * np.pi * np.arange(len(here)) / driven_runs
    goals = stop[:2] + away * unit(around)
    turns, lengths = course.missing_angle(yaw, here, goals), np.hypot(*(goals - here).T)
    ends = stop[:2] + lengths[:, None] * unit(stop[2] + turns)
    squares = ((ends - goals) ** 2).sum(axis=-1)
    # The second fix errs in the position as in the course: where the robot goes on ahead, the two add up.
    predicted = noise**2 * (2 + 2 * (away / METRE) ** 2 + 2 * away / METRE * np.cos(around - stop[2]))

    commands = [
        dd.maneuvers.sequence(robot, [[Segment(0, turn, abs(turn))], [Segment(length, 0, length)]])
        for turn, length in zip(turns[:driven_runs], lengths[:driven_runs], strict=True)
    ]
    longest = max(command.duration for command in commands)
    second = dd.simulate(robot, [command.extended(longest) for command in commands], sample_rate=10.0, start=stop)
    arrived, gone = second.truth[:, -1], odometer(second, robot)[:, -1]
    square_of_one, stds = [], []
    for n, pose in enumerate(arrived):
        tracker = CourseTracker()
        tracker.update(course.from_fixes(there[n], here[n], driven, fix_noise=noise))
        tracker.turn(tracker.missing_angle(here[n], goals[n]))
        again = course.from_fixes(stop[:2] + later[0, n], pose[:2] + later[1, n], gone[n], fix_noise=noise)
        if again.straight:
            tracker.update(again)
        square_of_one.append((float(dd.se2.wrap_angle(tracker.yaw - pose[2])) / tracker.std) ** 2)
        stds.append(tracker.std)
    return {
        "away": away,
        "geometry_off": np.hypot(*(arrived[:, :2] - ends[:driven_runs]).T).max(),
        "miss": np.sqrt(squares.mean()),
        "miss_predicted": np.sqrt(predicted.mean()),
        "miss_off": abs((squares - predicted).mean()) / ((squares - predicted).std() / np.sqrt(len(here))),
        "course_std": np.mean(stds),
        "course_off": abs(np.mean(square_of_one) - 1) / np.sqrt(2 / driven_runs),
    }


def unit(angle: np.ndarray) -> np.ndarray:
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def several(values: np.ndarray, form: str) -> str:
    *first, last = (f"{value:{form}}" for value in values)
    return f"{', '.join(first)} and {last}"


def baseline_table(along: np.ndarray, still: Spread, wandering: Spread, best: np.ndarray) -> str:
    places = [int(np.argmin(np.abs(along - w))) for w in (0.05, 0.2, 0.5, 1.0, 2.0, 5.0)]
    header = ["course off by [deg] after", *(f"{along[i]:.2g} m" for i in places), "best baseline [m]"]
    parts = {"simulated": still.simulated, "predicted": still.predicted, "wandering": wandering.simulated}
    rows = [
        [f"{label}: {name}", *np.degrees(part[n, places]), best[n] if name == "wandering" else "-"]
        for n, label in enumerate(LABELS)
        for name, part in parts.items()
    ]
    return report.table(header, rows)


def bend_table(bends: dict) -> str:
    header = ["a metre that bends by", *(f"{bend:.0f} deg" for bend in np.degrees(BENDS))]
    rows = [
        ["shortens the chord by [mm]", *(1e3 * bends["epsilon"])],
        ["puts the course off by [deg]", *np.degrees(bends["course_error"])],
        *([f"is seen by {label} [%]", *(100 * share)] for label, share in zip(LABELS, bends["flagged"], strict=True)),
    ]
    return report.table(header, rows)


def draw_spread(ax, along, spread) -> None:
    for n, label in enumerate(LABELS):
        look = plots.style(n)
        ax.plot(along, np.degrees(spread.predicted[n]), **look | {"marker": ""})
        ax.plot(along, np.degrees(spread.simulated[n]), label=f"{label}, simulated", **look | {"linestyle": "none"})
    ax.plot([], [], color="0.3", linewidth=1.7, label="predicted")


def draw_fixes(ax, along, still, first_order) -> None:
    draw_spread(ax, along, still)
    for n, std in enumerate(np.degrees(first_order)):
        ax.plot(along, std, label=None if n else "to first order", **plots.PREDICTION)
    finish(ax, "A straight drive: the longer, the better", "baseline [m]", "course off by, standard deviation [deg]")


def draw_bends(ax, bends, visible, hidden) -> None:
    bend = np.radians(np.geomspace(1, 200, 200))
    law = {"label": "predicted, about w beta^2 / 24"}
    ax.plot(np.degrees(bend), 1e3 * straightness.chord_shortening(bend, METRE), **plots.PREDICTION | law)
    ax.plot(np.degrees(BENDS), 1e3 * bends["epsilon"], "o", color="black", label="driven", markersize=5)
    for n, (label, noise) in enumerate(zip(LABELS, NOISES, strict=True)):
        look, threshold = plots.style(n), 1e3 * straightness.SIGMAS * np.sqrt(2) * noise
        ax.plot([1, visible[n]], [threshold] * 2, **look | {"marker": ""})
        ax.plot(visible[n], threshold, **look | {"markersize": 10, "zorder": 5})
        text = f"{label}: blind up to {visible[n]:.0f} deg,\nthe course then {hidden[n]:.0f} deg off"
        place = {"xytext": (0, 4), "textcoords": "offset points"}
        ax.annotate(text, (1.05, threshold), fontsize=9, color=look["color"], linespacing=1.1, **place)
    ax.set_ylim(0.01, 1000)
    finish(ax, "A metre that bends: what epsilon can see", "bend beta over 1 m [deg]", "chord shorter by [mm]")
    ax.legend(fontsize=9, loc="lower right")


def draw_wander(ax, along, wandering, best, least, wander_deg) -> None:
    draw_spread(ax, along, wandering)
    ax.plot(best, np.degrees(least), "*", color="black", markersize=13, zorder=6, label="best")
    for w, std in zip(best, np.degrees(least), strict=True):
        place = {"xytext": (0, 9), "textcoords": "offset points", "ha": "center"}
        ax.annotate(f"{w:.2g} m", (w, std), fontsize=11, fontweight="bold", **place)
    ax.axvline(METRE, color="0.6", linewidth=0.9)
    ax.annotate(" a metre (001)", (METRE, 0.02), xycoords=("data", "axes fraction"), color="0.35", fontsize=9)
    ax.set_ylim(0.25, 100)
    title = f"A heading that wanders by {wander_deg:g} deg along a metre: there is a best"
    finish(ax, title, "baseline [m]", "course off by, standard deviation [deg]")


def finish(ax, title, xlabel, ylabel) -> None:
    ax.set(xscale="log", yscale="log", xlabel=xlabel, ylabel=ylabel)
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_formatter("{x:g}")
    ax.set_title(title, loc="left", fontsize=11)
    ax.grid(visible=True, color="0.9")
    ax.set_axisbelow(True)
    ax.spines[["top", "right"]].set_visible(False)
    ax.legend(fontsize=9)


if __name__ == "__main__":
    report.main(run)
