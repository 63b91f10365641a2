"""How far to drive between two fixes to know the heading?"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from scipy.special import chndtr

import diffdrive_mj as dd
from diffdrive_mj import _checks as checks
from diffdrive_mj import report
from diffdrive_mj._checks import Array
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.estimation import course
from diffdrive_mj.estimation.course_noise import best_baseline, direction_std, end_std, first_order_std
from diffdrive_mj.estimation.course_tracker import CourseTracker
from diffdrive_mj.maneuvers import Segment
from diffdrive_mj.report import Bound, Report, chance, options, plots
from diffdrive_mj.report.chance import Expected

NOISES = np.array([0.001, 0.01, 0.03])
LABELS = [f"{1e3 * noise:g} mm fixes" for noise in NOISES]
BASELINES = np.array([0.05, 0.07, 0.1, 0.14, 0.2, 0.3, 0.4, 0.5, 0.7, 1, 1.4, 2, 2.5, 3, 3.5, 4, 5])
BENDS = np.radians([3, 5, 10, 20, 30, 45, 60, 90, 120])
METRE, START, MOST_WANDER = 1.0, (1.0, 2.0, 2.2), 20.0
# How many goals are driven to in the physics, how far away they are [m], and the fixes' noise there [m].
DRIVEN, AWAY, NOISE = 32, 3.0, 0.01
# What the physics leaves, of the way driven; the largest kurtosis of a course from noisy fixes, which are a third of
# the baseline then.
FLOOR, KURTOSIS = 1e-6, 6.1


@dataclass(frozen=True)
class Bent:
    """Metres that bend: by how much in truth [rad], what that does, and how often epsilon flags them."""

    bend: Array
    driven: Array
    epsilon: Array
    course_error: Array
    flagged: Array
    predicted: Array


@dataclass(frozen=True)
class Goals:
    """How far the drives end off the geometry at most [m]; what the goals are missed by, and the law of that (N,) [m];
    the errors of the courses at the goals, by their standard deviations.
    """

    off: float
    misses: Array
    law: Array
    course_errors: Array


def run(robot: str = "matched", runs: int = 10_000, seed: int = 1, wander_deg: float = 1.0) -> Report:
    """Drive between two noisy position fixes, straight, bent and with a heading that wanders ([Petersen 2013]).

    Args:
        robot: a preset's name, or a TOML file.
        runs: simulated fixes at each point.
        seed: of their noise.
        wander_deg: what the heading wanders by along a metre [deg], as a random walk; 0 for one that holds.
    """
    true, count = dd.Robot.load(robot), options.whole("runs", runs)
    if checks.not_negative("wander_deg", wander_deg) > MOST_WANDER:
        raise InvalidValue(
            f"wander_deg = {wander_deg:g}: must be at most {MOST_WANDER:g}, or no heading is left to know"
        )
    still_rng, bend_rng, wander_rng, goal_rng = options.seeded(seed).spawn(4)
    q = math.radians(wander_deg) ** 2
    along, truth = straight_drive(true)
    still = fixes_alone(along, truth, still_rng.normal(size=(2, count, 2)))
    bent = bent_drives(true, bend_rng.normal(size=(2, count, 2)))
    wandering = wandering_drives(along, q, count, wander_rng)
    goals = to_goals(true, goal_rng, count)
    best = best_baseline(NOISES, q) if q else np.full(3, math.inf)
    hidden = np.degrees(course.smallest_visible_bend(NOISES, METRE))
    bounds = claims(true, along, still, bent, wandering, q, best, goals)
    answer = f"drive {best[1]:.2g} m" if q else "the longer the drive, the better"
    title = (
        f"Fixes of 10 mm, a heading that wanders by {wander_deg:g} deg along a metre: {answer}.\n"
        f"Over a metre epsilon does not see bends of up to {hidden[1]:.0f} degrees"
    )
    metre = 100 * (end_std(NOISES, METRE, q) / end_std(NOISES, best, q) - 1) if q else None
    finding = (
        f"With fixes of 10 mm a straight metre tells the course to {np.degrees(direction_std(NOISE, METRE)):.2f} degrees, "
        f"but epsilon is blind to a bend of up to {hidden[1]:.0f} degrees in\nit, which puts the course "
        f"{hidden[1] / 2:.0f} degrees off. "
    )
    finding += (
        ""
        if metre is None
        else (
            f"Where the heading wanders by {wander_deg:g} deg along a metre, {several(best, '.2f')} m are best for\n1, 10 "
            f"and 30 mm, and a metre is {several(metre, '.0f')} % worse. "
        )
    )
    finding += (
        f"After a metre and the missing turn a goal {AWAY:g} m away is missed by\n{1e3 * chance.rms(goals.misses):.0f} mm RMS, "
        f"{1e3 * chance.rms(goals.law):.0f} predicted."
    )
    metrics = {
        "fix_noise_m": NOISES,
        "baselines_m": along,
        "fixes_alone_std_deg": std_deg(still),
        "wandering_std_deg": std_deg(wandering),
        "wander_rad2_per_m": q,
        "best_baseline_m": best,
        "metre_worse_by_percent": metre,
        "smallest_visible_bend_deg": hidden,
        "bends": vars(bent),
        "goal_miss_rms_m": {"simulated": chance.rms(goals.misses), "predicted": chance.rms(goals.law)},
    }
    picture = {"course_from_fixes": figure(title, along, wandering, q, best, bent, hidden)}
    return Report(__doc__, finding, table(along, still, wandering, best, bent), bounds, metrics, picture)


def straight_drive(robot: dd.Robot) -> tuple[Array, Array]:
    """One drive over the longest baseline: the distance by odometer (B,) and the true pose (B, 3) at every baseline,
    the true start pose before them.
    """
    commands = dd.maneuvers.straight(dd.tilt.level_twin(robot), speed=0.5, distance=BASELINES[-1])
    recording = dd.simulate(robot, commands, start=START)
    along = odometer(recording, robot)
    places = [int(np.argmin(np.abs(along - w))) for w in BASELINES]
    return along[places], np.concatenate([recording.truth[:1], recording.truth[places]])


def odometer(recording: dd.Recording, robot: dd.Robot) -> Array:
    """The distance driven (..., T) [m], as the wheels tell it."""
    return np.asarray(dd.kinematics.body_twist(recording.wheel_angles, dd.tilt.level_twin(robot))[..., 0])


def seen(draws: Array, first: Array, last: Array, driven: Array) -> course.Course:
    """The courses (noises, drives, runs) that noisy fixes of drives tell; the same draws serve every point of a sweep.

    Args:
        draws: of the fixes' noise (2, runs, 2).
        first, last: where the drives truly start and end, broadcasting to (drives, runs, 2) [m].
        driven: how far (drives,) [m].
    """
    noise = NOISES[:, None, None]
    before, after = (place + noise[..., None] * draw for place, draw in zip((first, last), draws, strict=True))
    return course.from_fixes(before, after, driven[:, None], fix_noise=noise)


def fixes_alone(along: Array, truth: Array, draws: Array) -> Array:
    """The course's errors on the straight drive (noises, baselines, runs) [rad]."""
    last = truth[1:, None]
    return dd.se2.wrap_angle(seen(draws, truth[0, :2], last[..., :2], along).yaw - last[..., 2])


def bent_drives(robot: dd.Robot, draws: Array) -> Bent:
    """A metre that bends: what it does to the chord and to the course, and how often epsilon flags it."""
    twin = dd.tilt.level_twin(robot)
    arcs = [dd.maneuvers.arc(twin, radius=METRE / bend, distance=METRE, speed=0.25) for bend in BENDS]
    recording = dd.simulate(robot, arcs, start=START)
    first, last = recording.truth[:, 0], recording.truth[:, -1]
    driven = odometer(recording, robot)[:, -1]
    exact = course.from_fixes(first[:, :2], last[:, :2], driven, fix_noise=0)
    flagged = np.mean(~seen(draws, first[:, None, :2], last[:, None, :2], driven).straight, axis=-1)
    off = dd.se2.wrap_angle(last[:, 2] - exact.yaw)
    return Bent(last[:, 2] - first[:, 2], driven, exact.epsilon, off, flagged, flagging(exact.baseline, driven))


def flagging(chord: Array, driven: Array) -> Array:
    """How often epsilon passes its threshold: the distance between two noisy fixes is Rice distributed."""
    sigma = np.sqrt(2) * NOISES[:, None]
    below, above = (
        chndtr((np.maximum(driven + side * course.SIGMAS * sigma, 0) / sigma) ** 2, 2, (chord / sigma) ** 2)
        for side in (-1, 1)
    )
    return np.asarray(1 - (above - below))


def wandering_drives(along: Array, q: float, runs: int, rng: np.random.Generator, steps: int = 50) -> Array:
    """A model without physics: the heading is a random walk of variance q s, the path follows it, the fixes are noisy.

    Returns:
        The errors (noises, baselines, runs) of the course taken for the heading at the end [rad].
    """
    turns = rng.normal(size=(runs, steps)) / np.sqrt(steps)
    # A step's heading is half-way through its turn.
    walk = np.cumsum(turns, axis=1) - turns / 2
    draws = rng.normal(size=(2, runs, 2))
    size = np.sqrt(q * along)
    ends = np.stack([w * unit(s * walk).mean(axis=1) for w, s in zip(along, size, strict=True)])
    return dd.se2.wrap_angle(seen(draws, np.zeros(2), ends, along).yaw - size[:, None] * turns.sum(axis=1))


def to_goals(robot: dd.Robot, rng: np.random.Generator, runs: int) -> Goals:
    """Drive a metre, turn by the missing angle, drive to the goal: goals all around, the first of them in physics.

    At the goal the second straight drive updates the course; its fixes are taken anew.
    """
    twin = dd.tilt.level_twin(robot)
    first = dd.simulate(robot, dd.maneuvers.straight(twin, speed=0.5, distance=METRE), start=START)
    stop, driven = first.truth[-1], odometer(first, robot)[-1]
    fixes = np.array([START[:2], stop[:2]])[:, None] + NOISE * rng.normal(size=(2, runs + 2 * DRIVEN, 2))
    # Three standard deviations flag one straight drive in 400; who cannot trust a course does not go on.
    straight = course.from_fixes(*fixes, driven, fix_noise=NOISE).straight
    there, here = fixes[:, straight]
    yaw = course.from_fixes(there, here, driven, fix_noise=NOISE).yaw
    around = 2 * np.pi * np.arange(len(here)) / DRIVEN
    goals = stop[:2] + AWAY * unit(around)
    turns, lengths = course.missing_angle(yaw, here, goals), np.hypot(*(goals - here).T)
    ends = stop[:2] + lengths[:, None] * unit(stop[2] + turns)
    # The second fix errs in the position as in the course: where the robot goes on ahead, the two add up.
    law = NOISE * np.sqrt(2 + 2 * (AWAY / METRE) ** 2 + 2 * AWAY / METRE * np.cos(around - stop[2]))

    commands = [
        dd.maneuvers.sequence(twin, [[Segment(0, turn, abs(turn))], [Segment(length, 0, length)]])
        for turn, length in zip(turns[:DRIVEN], lengths[:DRIVEN], strict=True)
    ]
    longest = max(command.duration for command in commands)
    second = dd.simulate(robot, [command.extended(longest) for command in commands], sample_rate=10.0, start=stop)
    arrived, gone = second.truth[:, -1], odometer(second, robot)[:, -1]
    again = NOISE * rng.normal(size=(2, DRIVEN, 2)) + np.stack([np.broadcast_to(stop[:2], (DRIVEN, 2)), arrived[:, :2]])
    course_errors = []
    for n, pose in enumerate(arrived):
        tracker = CourseTracker()
        tracker.update(course.from_fixes(there[n], here[n], driven, fix_noise=NOISE))
        tracker.turn(tracker.missing_angle(here[n], goals[n]))
        if (seen_again := course.from_fixes(*again[:, n], gone[n], fix_noise=NOISE)).straight:
            tracker.update(seen_again)
        course_errors.append(float(dd.se2.wrap_angle(tracker.yaw - pose[2])) / tracker.std)
    misses = np.hypot(*(ends - goals).T)
    off = float(np.hypot(*(arrived[:, :2] - ends[:DRIVEN]).T).max())
    return Goals(off, misses, law, np.array(course_errors))


def claims(
    robot: dd.Robot, along: Array, still: Array, bent: Bent, wandering: Array, q: float, best: Array, goals: Goals
) -> list[Bound]:
    """The laws of straight drives, of bent ones, of a heading that wanders, and of what a goal is missed by."""
    noise, runs = NOISES[:, None], still.shape[-1]
    exact = direction_std(noise, along)
    low = 100 * np.abs(first_order_std(noise, along) / exact - 1)
    flagged = np.abs(bent.flagged - bent.predicted) / chance.share_tolerance(bent.predicted, runs)
    # The second drive starts while the servos still catch up with the turn.
    joint = 20 / robot.servo.bandwidth**4 + 10 * FLOOR
    bounds = [
        chance.worst_bound("fixes alone", still, exact, kurtosis=KURTOSIS),
        Bound("first order off the exact, noise under baseline / 10, by", low[noise / along <= 0.1].max(), 1.05, "%"),
        Bound("first order off the exact, 30 mm after 50 mm, by", low[-1, 0], 10, "%", at_least=True),
        Bound(
            "bends: epsilon off its law by",
            1e6 * float(np.abs(bent.epsilon - course.chord_shortening(bent.bend, bent.driven)).max()),
            1e6 * FLOOR * METRE,
            "um",
        ),
        Bound(
            "bends: course off half the bend by",
            1e6 * float(np.abs(bent.course_error - bent.bend / 2).max()),
            1e6 * FLOOR,
            "urad",
        ),
        Bound("bends: share flagged off its prediction by", float(flagged.max()), 1, "of what chance allows"),
        chance.worst_bound(
            "wander", wandering, np.hypot(exact, np.sqrt(q * along / 3)), kurtosis=KURTOSIS, beyond=q * along[-1]
        ),
        Bound("goal: end of the drive off the geometry by", 1e3 * goals.off, 1e3 * joint, "mm"),
        chance.rms_bound("goal: miss", Expected(goals.misses / goals.law, 1.0), beyond=0.01),
        chance.rms_bound("goal: course after the second drive", Expected(goals.course_errors, 1.0), beyond=0.01),
    ]
    shown = (best > 2 * along[0]) & (best < 0.8 * along[-1])
    if shown.any():
        off = 100 * np.abs(fitted_best(along, wandering, exact)[shown] / best[shown] - 1)
        allowed = 100 * (np.cbrt(1 + chance.ratio_tolerance(runs / 2)) - 1 + q * along[-1])
        bounds.append(Bound("wander: best baseline, simulated, off by", float(off.max()), float(allowed), "%"))
    return bounds


def fitted_best(along: Array, wandering: Array, exact: Array) -> Array:
    """The minimum of A / w^2 + B w fitted to the simulated variances, (2 A / B)^(1/3) [m], by noise."""
    result = []
    for noise, errors, std in zip(NOISES, wandering, exact, strict=True):
        used = noise / along <= 0.1
        w, variance = along[used], np.mean(errors[used] ** 2, axis=-1)
        terms = np.stack([1 / w**2, w], axis=-1)
        weight = 1 / (std[used] ** 2 + variance)
        a, b = np.linalg.lstsq(weight[:, None] * terms, weight * variance, rcond=None)[0]
        result.append(np.cbrt(2 * a / b))
    return np.array(result)


def unit(angle: Array) -> Array:
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def std_deg(errors: Array) -> Array:
    """Standard deviations about zero of errors (..., runs) [deg]."""
    return np.degrees(np.sqrt(np.mean(errors**2, axis=-1)))


def several(values: Array, form: str) -> str:
    *first, last = (f"{value:{form}}" for value in values)
    return f"{', '.join(first)} and {last}"


def table(along: Array, still: Array, wandering: Array, best: Array, bent: Bent) -> str:
    places = [int(np.argmin(np.abs(along - w))) for w in (0.05, 0.2, 0.5, 1.0, 2.0, 5.0)]
    header = ["course off by [deg] after", *(f"{along[i]:.2g} m" for i in places), "best baseline [m]"]
    parts = {
        "simulated": std_deg(still),
        "predicted": np.degrees(direction_std(NOISES[:, None], along)),
        "wandering": std_deg(wandering),
    }
    rows = [
        [f"{label}: {name}", *part[n, places], best[n] if name == "wandering" else "-"]
        for n, label in enumerate(LABELS)
        for name, part in parts.items()
    ]
    bends = [
        ["shortens the chord by [mm]", *(1e3 * bent.epsilon)],
        ["puts the course off by [deg]", *np.degrees(bent.course_error)],
        *([f"is seen by {label} [%]", *(100 * share)] for label, share in zip(LABELS, bent.flagged, strict=True)),
    ]
    bend_header = ["a metre that bends by", *(f"{bend:.0f} deg" for bend in np.degrees(BENDS))]
    return f"{report.table(header, rows)}\n\n{report.table(bend_header, bends)}"


def figure(title: str, along: Array, wandering: Array, q: float, best: Array, bent: Bent, hidden: Array) -> Figure:
    """How well the course is known after a drive, and what epsilon sees of a bend."""
    made, (left, right) = plots.figure(title, columns=2, size=(10, 5))
    w, bend = np.geomspace(along[0], along[-1], 200), np.radians(np.geomspace(1, 200, 200))
    for n, (label, noise) in enumerate(zip(LABELS, NOISES, strict=True)):
        look, threshold = plots.style(n), 1e3 * course.SIGMAS * np.sqrt(2) * noise
        left.plot(w, np.degrees(end_std(noise, w, q)), **look | {"marker": ""})
        left.plot(along, std_deg(wandering[n]), label=label, **look | {"linestyle": "none"})
        right.plot([1, hidden[n]], [threshold] * 2, **look | {"marker": ""})
        right.plot(hidden[n], threshold, **look | {"markersize": 9, "zorder": 5})
        right.annotate(f"{label}: blind up to {hidden[n]:.0f} deg", (1.1, 1.2 * threshold), color=look["color"])
    if q:
        left.plot(best, np.degrees(end_std(NOISES, best, q)), "*", color="black", markersize=13, zorder=6, label="best")
    left.axvline(METRE, color="0.6", linewidth=0.9)
    left.annotate("a metre\n[Petersen 2013]", (1.05 * METRE, 40), color="0.35")
    right.plot(
        np.degrees(bend), 1e3 * course.chord_shortening(bend, METRE), label="w beta$^2$ / 24", **plots.PREDICTION
    )
    right.plot(np.degrees(bent.bend), 1e3 * bent.epsilon, "o", color="black", label="driven", markersize=5)
    left.set(xlabel="baseline [m]", ylabel="course off by, standard deviation [deg]", ylim=(0.1, 100))
    right.set(xlabel="bend beta over a metre [deg]", ylabel="epsilon: chord shorter by [mm]", ylim=(0.01, 1000))
    for ax in (left, right):
        ax.set(xscale="log", yscale="log")
        for axis in (ax.xaxis, ax.yaxis):
            axis.set_major_formatter("{x:g}")
        ax.grid(visible=True, color="0.9")
        ax.spines[["top", "right"]].set_visible(False)
        ax.legend(loc="lower left" if ax is left else "lower right")
    return made


if __name__ == "__main__":
    report.main(run)
