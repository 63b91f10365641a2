"""How far to drive between two fixes to know the heading?"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

import diffdrive_mj as dd
from diffdrive_mj import _checks as checks
from diffdrive_mj import report
from diffdrive_mj._checks import Array
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.estimation import course
from diffdrive_mj.estimation.course_noise import best_baseline, direction_std, end_std, first_order_std
from diffdrive_mj.estimation.straightness import SIGMAS, chord_shortening, share_noticed, smallest_visible_bend
from diffdrive_mj.judging.rolling import simulate_rolling
from diffdrive_mj.report import Bound, Report, chance, figures, marks, plots

NOISES = np.array([0.001, 0.01, 0.03])
BY_NOISE, LABELS = NOISES[:, None], [f"{1e3 * noise:g} mm fixes" for noise in NOISES]
BASELINES = np.array([0.05, 0.07, 0.1, 0.14, 0.2, 0.3, 0.4, 0.5, 0.7, 1, 1.4, 2, 2.5, 3, 3.5, 4, 5])
BENDS = np.radians([3, 5, 10, 20, 30, 45, 60, 90, 120])
METRE, START, MOST_WANDER = 1.0, (1.0, 2.0, 2.2), 20.0
# What the physics leaves, of the way driven; the largest kurtosis of courses, where the noise is 0.3 of the baseline.
FLOOR, KURTOSIS = 1e-6, 6.1


@dataclass(frozen=True)
class Bent:
    """Metres that bend: bend [rad], length and epsilon [m], course error [rad], and how often they are noticed."""

    bend: Array
    driven: Array
    epsilon: Array
    course_error: Array
    noticed: Array
    noticed_law: Array


def run(robot: str = "matched", runs: int = 10_000, seed: int = 1, wander_deg: float = 1.0) -> Report:
    """Drive between two noisy position fixes, straight, bent and with a heading that wanders ([Petersen 2013]).

    Args:
        robot: a preset's name, or a TOML file.
        runs: simulated fixes at each point.
        seed: of their noise.
        wander_deg: what the heading wanders by along a metre [deg], as a random walk; 0 for one that holds.
    """
    true, runs = dd.Robot.load(robot), checks.whole("runs", runs, least=1)
    if checks.not_negative("wander_deg", wander_deg) > MOST_WANDER:
        raise InvalidValue(f"wander_deg = {wander_deg:g}: must be at most {MOST_WANDER:g}, or there is no heading")
    streams = np.random.default_rng(checks.whole("seed", seed, least=0)).spawn(3)
    q = math.radians(wander_deg) ** 2
    along, truth = straight_drive(true)
    still = fixes_alone(along, truth, streams[0].normal(size=(2, runs, 2)))
    bent = bent_drives(true, streams[1].normal(size=(2, runs, 2)))
    wandering = wandering_drives(along, q, runs, streams[2])
    best = best_baseline(NOISES, q) if q else np.full(3, math.inf)
    hidden = np.degrees(smallest_visible_bend(NOISES, METRE))
    bounds = fix_claims(along, still) + bend_claims(true, bent, runs) + wander_claims(along, wandering, q, best)
    answer = f"drive {best[1]:.2g} m" if q else "the longer the drive, the better"
    title = (
        f"Fixes of 10 mm, and a heading that wanders by {wander_deg:g} deg along a metre: {answer}.\n"
        f"Over a metre epsilon does not see bends of up to {hidden[1]:.0f} degrees"
    )
    metre = 100 * (end_std(NOISES, METRE, q) / end_std(NOISES, best, q) - 1) if q else np.zeros(3)
    finding = f"{title}, which put the course {hidden[1] / 2:.0f} degrees off."
    if q:
        worse = "{:.0f}, {:.0f} and {:.0f} % worse than the best of {:.2f}, {:.2f} and {:.2f} m".format(*metre, *best)
        finding += f"\nA metre is {worse} for fixes of 1, 10 and 30 mm."
    metrics = {
        "fix_noise_m": NOISES,
        "baselines_m": along,
        "fixes_alone_std_deg": std_deg(still),
        "wandering_std_deg": std_deg(wandering),
        "wander_rad2_per_m": q,
        "best_baseline_m": {"predicted": best, "metre_worse_by_percent": metre},
        "smallest_visible_bend_deg": hidden,
        "bends": vars(bent),
    }
    picture = {"course_from_fixes": figure(title, along, wandering, q, best, bent, hidden)}
    return Report(__doc__, finding, table(along, still, wandering, bent), bounds, metrics, picture)


def straight_drive(robot: dd.Robot) -> tuple[Array, Array]:
    """The distance by odometer at every baseline (B,), and true poses (B + 1, 3), the first of all before these.

    There is a metre before and after, where robots whose servos differ do not drive straight.
    """
    commands = dd.maneuvers.straight(dd.tilt.level_twin(robot), speed=0.5, distance=BASELINES[-1] + 2 * METRE)
    recording = simulate_rolling(robot, commands, start=START)
    along = odometer(recording, robot)
    along -= METRE
    first, *places = (int(np.argmin(np.abs(along - w))) for w in (0.0, *BASELINES))
    return along[places] - along[first], recording.truth[[first, *places]]


def odometer(recording: dd.Recording, robot: dd.Robot) -> Array:
    """The distance driven (..., T) [m], as the wheels tell it."""
    return np.asarray(dd.kinematics.body_twist(recording.wheel_angles, dd.tilt.level_twin(robot))[..., 0])


def seen(draws: Array, first: Array, last: Array, driven: Array) -> course.Course:
    """The courses (noises, drives, runs) that noisy fixes of drives tell; the same draws serve every point of a sweep.

    Args:
        draws: of the fixes' noise (2, runs, 2).
        first: where the drives truly start, broadcasting to (drives, runs, 2) [m].
        last: where they truly end, likewise.
        driven: how far (drives,) [m].
    """
    noise = BY_NOISE[..., None]
    before, after = (place + noise[..., None] * draw for place, draw in zip((first, last), draws, strict=True))
    return course.from_fixes(before, after, driven[:, None], fix_noise=noise)


def fixes_alone(along: Array, truth: Array, draws: Array) -> Array:
    """The course's errors on the straight drive (noises, baselines, runs) [rad]."""
    last = truth[1:, None]
    return dd.se2.wrap_angle(seen(draws, truth[0, :2], last[..., :2], along).yaw - last[..., 2])


def bent_drives(robot: dd.Robot, draws: Array) -> Bent:
    """A metre that bends: what it does to the chord and to the course, and how often epsilon notices."""
    twin, rows = dd.tilt.level_twin(robot), np.arange(len(BENDS))
    arcs = [dd.maneuvers.arc(twin, radius=METRE / bend, distance=1.6 * METRE, speed=0.25) for bend in BENDS]
    recording = simulate_rolling([robot] * len(arcs), arcs, start=START)
    along = odometer(recording, robot)
    # Where the wheels turn evenly: their path is an arc.
    ends = [np.argmax(along >= start, axis=1) for start in (0.3 * METRE, 1.3 * METRE)]
    (first, last), driven = (recording.truth[rows, end] for end in ends), along[rows, ends[1]] - along[rows, ends[0]]
    exact = course.from_fixes(first[:, :2], last[:, :2], driven, fix_noise=0)
    noticed = np.mean(~seen(draws, first[:, None, :2], last[:, None, :2], driven).straight, axis=-1)
    law = share_noticed(exact.baseline, driven, BY_NOISE)
    off = dd.se2.wrap_angle(last[:, 2] - exact.yaw)
    return Bent(last[:, 2] - first[:, 2], driven, exact.epsilon, off, noticed, law)


def wandering_drives(along: Array, q: float, runs: int, rng: np.random.Generator, steps: int = 50) -> Array:
    """A model without physics: the heading is a random walk of variance q s, the path follows it, the fixes are noisy.

    Returns:
        The errors (noises, baselines, runs) of the course taken for the heading at the end [rad].
    """
    turns = rng.normal(size=(runs, steps)) / np.sqrt(steps)
    # A step's heading is half-way through its turn.
    walk = np.cumsum(turns, axis=1) - turns / 2
    draws, size = rng.normal(size=(2, runs, 2)), np.sqrt(q * along)
    ends = np.stack([w * dd.se2.rotate((1.0, 0.0), s * walk).mean(axis=1) for w, s in zip(along, size, strict=True)])
    return dd.se2.wrap_angle(seen(draws, np.zeros(2), ends, along).yaw - size[:, None] * turns.sum(axis=1))


def fix_claims(along: Array, still: Array) -> list[Bound]:
    """Courses of a straight drive in physics err as predicted; the first order is low where the noise is large."""
    exact, fine = direction_std(BY_NOISE, along), BY_NOISE / along <= 0.1
    low = 100 * np.abs(first_order_std(BY_NOISE, along) / exact - 1)
    return [
        chance.worst_bound("fixes alone", still, exact, kurtosis=KURTOSIS),
        Bound("first order off the exact, noise under baseline / 10, by", low[fine].max(), 1.05, "%"),
        Bound("first order off the exact, 30 mm after 50 mm, by", low[-1, 0], 10, "%", at_least=True),
    ]


def bend_claims(robot: dd.Robot, bent: Bent, runs: int) -> list[Bound]:
    """A bend shortens the chord and puts the course off as that of an arc; epsilon notices as often as predicted."""
    epsilon = np.abs(bent.epsilon - chord_shortening(bent.bend, bent.driven))
    half = np.abs(bent.course_error - bent.bend / 2)
    noticed = np.abs(bent.noticed - bent.noticed_law) / chance.share_tolerance(bent.noticed_law, runs)
    # What the physics leaves, and a servo that has not settled.
    allowed = 1e6 * (FLOOR * METRE + math.exp(-0.7 * robot.servo.bandwidth) / robot.servo.bandwidth)
    return [
        Bound("bends: epsilon off its law by", 1e6 * float(epsilon.max()), allowed, "um"),
        Bound("bends: course off half the bend by", 1e6 * float(half.max()), allowed, "urad"),
        Bound("bends: share noticed off its prediction by", float(noticed.max()), 1, "of what chance does"),
    ]


def wander_claims(along: Array, wandering: Array, q: float, best: Array) -> list[Bound]:
    """A heading that wanders is known as predicted, and best after the drive that the law says."""
    law, runs = np.hypot(direction_std(BY_NOISE, along), np.sqrt(q * along / 3)), wandering.shape[-1]
    bounds = [chance.worst_bound("wander", wandering, law, kurtosis=KURTOSIS, beyond=q * along[-1])]
    for noise, errors, one, where in zip(NOISES, wandering, law, best, strict=True):
        if 2 * along[0] < where < 0.8 * along[-1]:
            used = noise / along <= 0.1
            w, terms = along[used], np.stack([1 / along[used] ** 2, along[used]], axis=-1)
            # A / w^2 + B w, fitted to the simulated variances, is least at (2 A / B)^(1/3).
            scaled = terms / one[used, None] ** 2
            a, b = np.linalg.lstsq(scaled, np.mean((errors[used] / one[used, None]) ** 2, axis=-1), rcond=None)[0]
            allowed = np.cbrt(1 + chance.ratio_tolerance(runs / 2)) - 1 + q * w[-1]
            off = abs(float(np.cbrt(2 * a / b)) / where - 1)
            bounds.append(Bound(f"wander, {1e3 * noise:g} mm: best baseline off by", 100 * off, 100 * allowed, "%"))
    return bounds


def std_deg(errors: Array) -> Array:
    """Standard deviations about zero of errors (..., runs) [deg]."""
    return np.asarray(np.degrees(np.sqrt(np.mean(errors**2, axis=-1))))


def table(along: Array, still: Array, wandering: Array, bent: Bent) -> str:
    places = [0, 4, 7, 9, 11, 16]
    law = np.degrees(direction_std(BY_NOISE, along))
    parts = {"simulated": std_deg(still), "predicted": law, "wandering": std_deg(wandering)}
    rows = [[f"{label}: {name}", *part[n, places]] for n, label in enumerate(LABELS) for name, part in parts.items()]
    bends = [
        ["shortens the chord by [mm]", *(1e3 * bent.epsilon)],
        ["puts the course off by [deg]", *np.degrees(bent.course_error)],
        *([f"is noticed by {label} [%]", *(100 * share)] for label, share in zip(LABELS, bent.noticed, strict=True)),
    ]
    header = ["course off by [deg] after", *(f"{along[i]:.2g} m" for i in places)]
    bend_header = ["a metre that bends by", *(f"{bend:.0f} deg" for bend in np.degrees(BENDS))]
    return f"{report.table(header, rows)}\n\n{report.table(bend_header, bends)}"


def figure(title: str, along: Array, wandering: Array, q: float, best: Array, bent: Bent, hidden: Array) -> Figure:
    """How well the course is known after a drive, and what epsilon sees of a bend."""
    made, (left, right) = plots.figure(title, columns=2, size=(figures.WIDTH, 4.8))
    w, bend = np.geomspace(along[0], along[-1], 200), np.radians(np.geomspace(1, 200, 200))
    for n, (label, noise) in enumerate(zip(LABELS, NOISES, strict=True)):
        look, threshold = plots.style(n), 1e3 * SIGMAS * np.sqrt(2) * noise
        left.plot(w, np.degrees(end_std(noise, w, q)), **look | {"marker": ""})
        left.plot(along, std_deg(wandering[n]), label=label, **look | {"linestyle": "none"})
        right.plot([1, hidden[n]], [threshold] * 2, **look | {"marker": ""})
        right.plot(hidden[n], threshold, **look | {"markersize": 9, "zorder": 5})
        marks.note(right, f"blind up to {hidden[n]:.0f} deg", (1.1, threshold), (0, 5), color=look["color"])
    if q:
        left.plot(best, np.degrees(end_std(NOISES, best, q)), "*", color="black", markersize=13, zorder=6, label="best")
    left.axvline(METRE, color="0.6", linewidth=0.9)
    marks.note(left, "a metre:\n[Petersen 2013]", (METRE, 30), (4, 0))
    law = plots.PREDICTION | {"label": "arc, about w beta$^2$ / 24"}
    right.plot(np.degrees(bend), 1e3 * chord_shortening(bend, METRE), **law)
    right.plot(np.degrees(bent.bend), 1e3 * bent.epsilon, "o", color="black", label="driven", markersize=5)
    left.set(xlabel="baseline [m]", ylabel="course off by, standard deviation [deg]", ylim=(0.1, 100))
    right.set(xlabel="bend beta over a metre [deg]", ylabel="epsilon: chord shorter by [mm]", ylim=(0.01, 1000))
    plots.panel(left, "How well the heading at the end is known")
    plots.panel(right, "What epsilon sees of a bend")
    for ax in (left, right):
        ax.set(xscale="log", yscale="log")
        ax.xaxis.set_major_formatter("{x:g}")
        ax.yaxis.set_major_formatter("{x:g}")
        plots.tidy(ax)
    plots.legend_below(made, left, right, columns=6)
    return made


if __name__ == "__main__":
    report.main(run)
