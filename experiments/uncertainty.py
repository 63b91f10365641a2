"""Is the predicted covariance honest?

A robot whose wheels' ways are random walks drives a straight line many times. Where it ends is a banana, whose mean
falls short of the line. The exact mean and covariance are compared with the cloud, and with a linearised filter's.
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
from diffdrive_mj.report import Bound, Report, plots

STEP, LIKELY = 0.1, 0.95
CHUNK, DRAWN = 500, 2000  # drives computed at once, and drawn
# How many standard errors chance may take.
CHANCE = 4.5
EXACT, LINEAR = "exact mean and covariance", "linearised"


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
    robot: str = "matched", distance: float = 50.0, noise: float = 0.002, drives: int = 20_000, seed: int = 0
) -> Report:
    """Drive the line many times, and compare where that ends with what is predicted.

    Args:
        robot: a preset's name, or a TOML file.
        distance: of the line [m].
        noise: of each wheel's way, a random walk [m / sqrt(m)].
        drives: of the cloud.
        seed: of it.
    """
    true = dd.Robot.load(robot)
    distance, noise = checks.positive("distance", distance), checks.positive("noise", noise)
    checks.whole("drives", drives, least=100)
    ends = cloud(true, distance, noise, drives, np.random.default_rng(seed))
    angles = line(true, distance)
    stated = dd.covariance(angles, true, noise=dd.WheelNoise(left=noise, right=noise))
    told = {
        EXACT: (stated.mean[-1], stated.covariance[-1]),
        LINEAR: (np.array([distance, 0.0, 0.0]), linearised(true, distance, noise)),
    }
    found = {name: Prediction(mean, covariance, ends - mean) for name, (mean, covariance) in told.items()}
    text = finding(found)
    return Report(
        question=__doc__,
        finding=text,
        table=table(found),
        bounds=claims(found[EXACT], true, distance, noise),
        metrics={name: {"covered": one.covered, "nees": float(one.squares.mean() / 3)} for name, one in found.items()},
        pictures={"uncertainty": figure(text.splitlines()[0], ends, found)},
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


def linearised(robot: dd.Robot, distance: float, noise: float) -> Array:
    """The covariance to first order along a straight line (3, 3): the heading is a random walk, y its integral."""
    rate = 2 * noise**2 / robot.track_width**2
    y, y_theta, theta = rate * distance**3 / 3, rate * distance**2 / 2, rate * distance
    return np.array([[noise**2 * distance / 2, 0, 0], [0, y, y_theta], [0, y_theta, theta]])


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


def table(found: dict[str, Prediction]) -> str:
    """Where the line is said to end, and what share of the drives is in the stated region."""
    rows = [
        [name, f"{one.mean[0]:.4f}", f"{one.covariance[0, 0] ** 0.5:.3g}", f"{one.covariance[1, 1] ** 0.5:.3g}",
         f"{one.squares.mean() / 3:.3g}", f"{100 * one.covered:.1f} %"]
        for name, one in found.items()
    ]  # fmt: skip
    return report.table(["", "x [m]", "sigma x [m]", "sigma y [m]", "NEES / 3", "inside 95 %"], rows)


def finding(found: dict[str, Prediction]) -> str:
    """The answer; its first line is the picture's title."""
    exact, linear = found[EXACT], found[LINEAR]
    return (
        f"The 95 % region of a linearised filter holds {100 * linear.covered:.0f} % of the drives, the exact one "
        f"{100 * exact.covered:.0f} %\n"
        f"The drives end {1e3 * (linear.mean[0] - exact.mean[0]):.3g} mm short of the line in the mean, as predicted."
    )


def figure(title: str, ends: Array, found: dict[str, Prediction]) -> Figure:
    """Where the drives end, and the stated regions of x and y."""
    made, ax = plots.figure(title, size=(9.6, 4.6))
    ax.plot(*ends[:DRAWN, 1::-1].T, ".", color="0.7", markersize=2, zorder=1, label="where drives end")
    circle = math.sqrt(chi2.ppf(LIKELY, 2)) * np.array(
        [(math.cos(a), math.sin(a)) for a in np.linspace(0, math.tau, 181)]
    )
    for index, (name, one) in enumerate(found.items()):
        look = plots.style(index)
        ring = one.mean[:2] + circle @ np.linalg.cholesky(one.covariance[:2, :2]).T
        ax.plot(ring[:, 1], ring[:, 0], color=look["color"], linestyle=look["linestyle"], label=f"95 %, {name}")
        ax.plot(one.mean[1], one.mean[0], look["marker"], color=look["color"], markersize=6)
    ax.invert_xaxis()  # left is on the left, seen along the line
    ax.set(xlabel="to the left of the line [m]", ylabel="along the line [m]")
    plots.tidy(ax)
    plots.legend_below(made, ax)
    return made


if __name__ == "__main__":
    report.main(run)
