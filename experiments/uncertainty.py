"""Is the predicted covariance honest?

A robot whose wheels' ways are random walks drives a straight line many times. Where it ends is a banana, whose mean
falls short of the line. The exact mean and covariance are compared with the cloud, and with a linearised filter's.
Then it drives squares in physics: what is stated along them, exactly, linearised and as a constant diagonal, meets the
errors.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from scipy.stats import chi2

import diffdrive_mj as dd
from diffdrive_mj import _checks as checks
from diffdrive_mj import report
from diffdrive_mj._checks import Array
from diffdrive_mj.estimation.covariance_export import diagonals
from diffdrive_mj.estimation.moments import PoseMoments
from diffdrive_mj.judging.consistency import Consistency, nees
from diffdrive_mj.report import Bound, Report, chance, plots, regions

STEP, LIKELY = 0.1, 0.95
CHUNK, DRAWN = 500, 2000  # drives computed at once, and drawn
# How many standard errors chance may take.
CHANCE = 4.5
EXACT, LINEAR, CONSTANT = "exact mean and covariance", "linearised", "constant diagonal"
# The drive in physics: commands and readings follow each other after so many seconds.
PERIOD, SPEED = 0.05, 0.5


@dataclass(frozen=True, eq=False)
class Prediction:
    """What is stated of the end of the line, and how that fits where the drives ended.

    Attributes:
        mean: (3,) [m, m, rad].
        covariance: (3, 3).
        off: (N, 3), where the drives ended, less the mean.
    """

    mean: Array
    covariance: Array
    off: Array

    @property
    def squares(self) -> Array:
        """The squared errors over the stated covariance (N,), three in the mean if it is honest."""
        found: Array = np.einsum("ni,ij,nj->n", self.off, np.linalg.inv(self.covariance), self.off)
        return found

    @property
    def covered(self) -> float:
        """The share of the drives inside of the stated region."""
        return float((self.squares < chi2.ppf(LIKELY, 3)).mean())


def run(
    robot: str = "matched",
    distance: float = 50.0,
    noise: float = 0.002,
    drives: int = 20_000,
    side: float = 4.0,
    squares: int = 40,
    seed: int = 0,
) -> Report:
    """Drive the line and the square many times, and compare where that leads with what is predicted.

    Args:
        robot: a preset's name, or a TOML file.
        distance: of the line [m].
        noise: of each wheel's way, a random walk [m / sqrt(m)].
        drives: of the cloud.
        side: of the square that is driven in physics [m].
        squares: that are driven there.
        seed: of the noise.
    """
    true = dd.Robot.load(robot)
    distance, noise = checks.positive("distance", distance), checks.positive("noise", noise)
    checks.whole("drives", drives, least=100)
    checks.whole("squares", squares, least=2)
    rng = np.random.default_rng(seed)
    ends = cloud(true, distance, noise, drives, rng)
    of_wheels = dd.WheelNoise(left=noise, right=noise)
    exact, linear, bent = (
        dd.covariance(line(true, distance), true, noise=of_wheels, method=method)
        for method in ("exact", "first_order", "exponential")
    )
    told = {EXACT: exact, LINEAR: linear}
    found = {name: Prediction(one.mean[-1], one.covariance[-1], ends - one.mean[-1]) for name, one in told.items()}
    along, driven = in_physics(true, checks.positive("side", side), of_wheels, squares, rng)
    text = finding(found, driven)
    return Report(
        question=__doc__,
        finding=text,
        table="\n\n".join([table(found), table_along(driven)]),
        bounds=[*claims(found[EXACT], true, distance, noise), *claims_along(driven)],
        metrics={
            **{name: {"covered": one.covered, "nees": float(one.squares.mean() / 3)} for name, one in found.items()},
            "in physics": {name: {"nees": one.mean, "covered": one.inside(LIKELY)} for name, one in driven.items()},
        },
        pictures={"uncertainty": figure(text.splitlines()[0], ends, found, bent, along, driven)},
    )


def line(robot: dd.Robot, distance: float) -> Array:
    """The wheel angles of a straight line (T, 2) [rad], a sample every ten centimetres."""
    samples = max(2, round(distance / STEP) + 1)
    return np.linspace(0, distance, samples)[:, None] / (robot.left_radius, robot.right_radius)


def cloud(robot: dd.Robot, distance: float, noise: float, drives: int, rng: np.random.Generator) -> Array:
    """Where the drives end (N, 3) [m, m, rad]."""
    angles, radii = line(robot, distance), np.array([robot.left_radius, robot.right_radius])
    sigma = noise * np.sqrt(np.diff(angles, axis=0) * radii) / radii
    ends = []
    for first in range(0, drives, CHUNK):
        count = min(CHUNK, drives - first)
        wander = np.cumsum(sigma * rng.normal(size=(count, *sigma.shape)), axis=1)
        noisy = angles + np.concatenate([np.zeros((count, 1, 2)), wander], axis=1)
        ends.append(dd.odometry.integrate(noisy, robot)[:, -1])
    return np.concatenate(ends)


def in_physics(
    robot: dd.Robot, side: float, noise: dd.WheelNoise, count: int, rng: np.random.Generator
) -> tuple[Array, dict[str, Consistency]]:
    """Squares in physics whose wheels roll further than is counted, or less far, by the noise.

    Returns:
        The distance along the drive (T,) [m], and how what is stated there compares with the errors.
    """
    nominal = dd.maneuvers.square(robot, side=side, speed=SPEED, period=PERIOD)
    radii = np.array([robot.left_radius, robot.right_radius])
    k = np.array([noise.left, noise.right])
    # Noise goes by the way that the wheels make, which follow what is commanded a little later.
    planned = dd.simulate(robot, nominal, physics=dd.Physics.fast(), sample_rate=1 / PERIOD)
    step = np.abs(np.diff(planned.wheel_angles, axis=0)) * radii
    wander = k * np.sqrt(step) / radii * rng.normal(size=(count, *step.shape))
    driven = [dd.Commands(PERIOD, nominal.wheel_rates + one / PERIOD) for one in wander]
    recording = dd.simulate([robot] * count, driven, physics=dd.Physics.fast(), sample_rate=1 / PERIOD)
    uncounted = np.concatenate([np.zeros((count, 1, 2)), np.cumsum(wander, axis=1)], axis=1)
    read, start = recording.wheel_angles - uncounted, recording.truth[:, 0]
    exact, linear = (
        dd.covariance(read, robot, noise=noise, start=start, method=method) for method in ("exact", "first_order")
    )
    constant = diagonals(recording.t, read[0], robot, noise).pose[[0, 1, 5]]
    told = {
        EXACT: exact,
        LINEAR: linear,
        CONSTANT: PoseMoments(linear.mean, np.diag(constant)),
    }
    found = {
        name: nees(recording.truth, stated.mean, stated.covariance, confidence=1 - chance.ODDS)
        for name, stated in told.items()
    }
    return dd.metrics.travelled(recording.truth[0]), found


def claims(exact: Prediction, robot: dd.Robot, distance: float, noise: float) -> list[Bound]:
    """The exact prediction is that of theory and of the cloud."""
    count = len(exact.off)
    rate = noise**2 / robot.track_width**2
    theory = -math.expm1(-rate * distance) / rate
    away = np.abs(exact.off.mean(axis=0)) / np.sqrt(np.diag(exact.covariance) / count)
    products = np.einsum("ni,nj->nij", exact.off, exact.off)
    spread = np.abs(products.mean(axis=0) - exact.covariance) / (products.std(axis=0) / math.sqrt(count))
    squares = exact.squares / 3
    return [
        # Along a step the noise turns the robot evenly: theory's random walk bends its end by a sixth of this.
        Bound(
            "mean along the line against theory, share of the way", abs(exact.mean[0] - theory) / distance, rate * STEP
        ),
        Bound("mean against the cloud", float(away.max()), CHANCE, "standard errors"),
        Bound("covariance against the cloud", float(spread.max()), CHANCE, "standard errors"),
        Bound(
            "NEES against 1", abs(squares.mean() - 1) / (squares.std() / math.sqrt(count)), CHANCE, "standard errors"
        ),
    ]


def claims_along(driven: dict[str, Consistency]) -> list[Bound]:
    """The exact prediction is that of physics, along the whole drive; a constant one is that nowhere."""
    exact = driven[EXACT]
    low, high = exact.interval
    least, most = exact.band
    along = exact.along[np.isfinite(exact.along)]
    return [
        Bound("NEES in physics against 1", abs(exact.mean - 1), max(high - 1, 1 - low)),
        Bound("largest NEES along the square", float(along.max()), most),
        Bound("least NEES along the square, inverse", float(1 / along.min()), 1 / least),
    ]


def table(found: dict[str, Prediction]) -> str:
    """Where the line is said to end, and what share of the drives is in the stated region."""
    rows = [
        [name, f"{one.mean[0]:.4f}", f"{one.covariance[0, 0] ** 0.5:.3g}", f"{one.covariance[1, 1] ** 0.5:.3g}",
         f"{one.squares.mean() / 3:.3g}", f"{100 * one.covered:.1f} %"]
        for name, one in found.items()
    ]  # fmt: skip
    return report.table(["line", "x [m]", "sigma x [m]", "sigma y [m]", "NEES / 3", "inside 95 %"], rows)


def table_along(driven: dict[str, Consistency]) -> str:
    """What share of the errors along the squares is in the stated regions."""
    rows = [
        [name, f"{one.mean:.3g}", f"{np.nanmin(one.along):.3g} to {np.nanmax(one.along):.3g}",
         f"{100 * one.inside(LIKELY):.1f} %"]
        for name, one in driven.items()
    ]  # fmt: skip
    return report.table(["square in physics", "NEES / 3", "along the drive", "inside 95 %"], rows)


def finding(found: dict[str, Prediction], driven: dict[str, Consistency]) -> str:
    """The answer; its first line is the picture's title."""
    exact, linear, constant = found[EXACT], found[LINEAR], driven[CONSTANT].along
    return (
        f"The 95 % region of a linearised filter holds {100 * linear.covered:.0f} % of the drives, the exact one "
        f"{100 * exact.covered:.0f} %; a constant one is rarely right\n"
        f"The drives end {1e3 * (linear.mean[0] - exact.mean[0]):.3g} mm short of the line in the mean, as predicted. "
        f"Along a square in physics NEES / 3 is {driven[EXACT].mean:.3g} with the exact covariance, and goes from "
        f"{np.nanmin(constant):.2g} to {np.nanmax(constant):.2g} with the constant diagonal that fits best."
    )


def figure(
    title: str,
    ends: Array,
    found: dict[str, Prediction],
    bent: PoseMoments,
    along: Array,
    driven: dict[str, Consistency],
) -> Figure:
    """Where the drives end, with the stated regions of x and y; NEES along the squares in physics."""
    made, (left, right) = plots.figure(title, columns=2, size=(plots.WIDTH, 4.6))
    left.plot(*ends[:DRAWN, :2].T, ".", color="0.7", markersize=2, zorder=1, label="where drives end")
    for index, (name, one) in enumerate(found.items()):
        look = {key: plots.style(index)[key] for key in ("color", "linestyle")}
        regions.ellipses(left, one.mean, one.covariance, LIKELY, label=name, **look)
    look = {key: plots.style(2)[key] for key in ("color", "linestyle")}
    regions.banana(left, bent.mean[-1], bent.covariance[-1], LIKELY, label="exponential coordinates", **look)
    left.set(xlabel="along the line [m]", ylabel="to the left [m]")
    plots.panel(left, "Ends of a line, and regions said to hold 95 %")
    for index, (name, stated) in zip((0, 1, 3), driven.items(), strict=True):
        right.plot(along, stated.along, label=name, markevery=(0.1, 0.2), **plots.style(index))
    low, high = driven[EXACT].band
    right.axhspan(low, high, color="0.9", zorder=0, label="honest, within chance")
    right.set(xlabel="distance driven [m]", ylabel="squared error over stated", yscale="log", ylim=(1e-2, 10))
    plots.panel(right, "NEES / 3 along a square in physics")
    for ax in (left, right):
        plots.tidy(ax)
    plots.legend_below(made, left, right)
    return made


if __name__ == "__main__":
    report.main(run)
