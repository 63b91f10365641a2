"""How far can odometry drift at most, if the robot is known within tolerances?

`dd.guarantee` bounds it for every robot within them. Robots drawn at random, those at the corners of the tolerances,
and those to which an optimiser climbs from the worst of them say how much of the bound is used.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from scipy.optimize import minimize

import diffdrive_mj as dd
from diffdrive_mj import _checks as checks
from diffdrive_mj import maneuvers, report
from diffdrive_mj._checks import Array
from diffdrive_mj._text import quantity
from diffdrive_mj.estimation.sensitivities import within
from diffdrive_mj.report import Bound, Report, plots

SPEED, SAMPLES = 0.5, 400  # [m/s], and about how many samples a drive has
RADIUS = 0.25  # of the circles [m]
ON_AND_ON = np.arange(0.5, 10.1, 0.5)  # how far they are driven on, in distances of the other drives
CHUNK, CLIMBS = 500, 10  # robots at once, and starts of the optimiser
# How far a guarantee may lie above the worst robot: a part of its drift, or a length [m].
LOOSE, LEAST = 0.05, 1e-3


@dataclass(frozen=True, eq=False)
class Found:
    """What is known of the drift at the end of one drive.

    Attributes:
        bound: that no robot exceeds.
        drawn: the drifts of robots drawn at random (N,) [m].
        worst: the largest drift found, by whatever means [m].
    """

    bound: dd.estimation.set_membership.GuaranteedDrift
    drawn: Array
    worst: float

    @property
    def likely(self) -> float:
        """What 99 % of the robots keep below [m]."""
        return float(np.quantile(self.drawn, 0.99))


def run(
    robot: str = "turtlebot3_burger",
    tolerance: float = 0.005,
    distance: float = 10.0,
    robots: int = 20_000,
    seed: int = 0,
) -> Report:
    """Bound the drift on six drives and on circles driven on and on, and look for robots that come close.

    Args:
        robot: a preset's name, or a TOML file.
        tolerance: of the mean radius, of the radius ratio and of the track width, relative.
        distance: of each drive but the spin [m]; the circles go on to ten times that.
        robots: drawn at random for each drive; a tenth of them for each length of the circles.
        seed: of them.
    """
    believed = dd.Robot.load(robot).replace(turning_gain=0.0)
    tolerances = within(believed, tolerance)
    checks.positive("distance", distance)
    checks.whole("robots", robots, least=1000)
    generator = np.random.default_rng(seed)
    found = {
        name: looked_at(commands, believed, tolerances, generator.uniform(-1, 1, (robots, 3)))
        for name, commands in drives(believed, distance).items()
    }
    at = generator.uniform(-1, 1, (robots // 10, 3))
    circles = {
        float(part * distance): looked_at(circled(believed, part * distance, 60), believed, tolerances, at)
        for part in ON_AND_ON
    }
    text = finding(found, circles, believed, tolerance, distance)
    return Report(
        question=__doc__,
        finding=text,
        table=table(found),
        bounds=claims({**found, "circles on and on": loosest(circles)}, [*found.values(), *circles.values()]),
        metrics={
            "drives": {name: numbers(one) for name, one in found.items()},
            "circles": {f"{length:g} m": numbers(one) for length, one in circles.items()},
        },
        pictures={"guaranteed_drift": figure(text.splitlines()[0], found, circles)},
    )


def drives(robot: dd.Robot, distance: float) -> dict[str, dd.Commands]:
    """What is driven, by name."""
    period = distance / SPEED / SAMPLES
    return {
        "straight": maneuvers.straight(robot, distance=distance, speed=SPEED, period=period),
        "circles": circled(robot, distance, SAMPLES),
        "square": maneuvers.square(robot, side=distance / 4, speed=SPEED, period=period),
        "figure eight": maneuvers.figure_eight(robot, radius=distance / 4 / np.pi, speed=SPEED, period=period),
        "slalom": maneuvers.slalom(robot, wavelength=distance / 3, speed=SPEED, period=period),
        "spin": maneuvers.spin(robot, turns=10.0, period=period),
    }


def circled(robot: dd.Robot, distance: float, samples: int) -> dd.Commands:
    """Circles on and on."""
    return maneuvers.arc(robot, radius=RADIUS, distance=distance, speed=SPEED, period=distance / SPEED / samples)


def looked_at(commands: dd.Commands, believed: dd.Robot, tolerances: dd.Tolerances, at: Array) -> Found:
    """The guarantee for one drive, and robots at parts (N, 3) of the tolerances, at their corners, and beyond these."""
    parts = np.array([tolerances.radius, tolerances.radius_ratio, tolerances.track_width])
    at = np.concatenate([list(itertools.product((-1.0, 1.0), repeat=3)), at])
    angles = commands.wheel_angles
    drifts = drifts_of(angles, believed, parts * at)
    worst = climbed(angles, believed, parts, at, drifts)
    return Found(dd.guarantee(commands, believed, tolerances), drifts[8:], worst)


def numbers(one: Found) -> dict[str, float]:
    """What is found of one drive, for `metrics.json`."""
    return {
        "guaranteed_m": one.bound.position, "worst_m": one.worst, "corners_m": one.bound.at_corners,
        "percentile_99_m": one.likely, "boxes": one.bound.boxes,
    }  # fmt: skip


def drifts_of(angles: Array, believed: dd.Robot, off: Array) -> Array:
    """How far robots end from where odometry is (N,) [m], whose scale, ratio and track are off by parts (N, 3)."""
    estimate = dd.odometry.integrate(angles, believed)[-1, :2]
    steps = np.diff(angles, axis=0)
    drifts = []
    for first in range(0, len(off), CHUNK):
        scale, ratio, track = 1 + off[first : first + CHUNK, :, None].transpose(1, 0, 2)
        # As `sensitivities.misjudged` makes them, for many at once.
        left = 2 * scale * believed.mean_radius / (1 + ratio * believed.radius_ratio)
        ways = np.stack([left * steps[:, 0], ratio * believed.radius_ratio * left * steps[:, 1]], axis=-1)
        turn = (ways[..., 1] - ways[..., 0]) / (track * believed.track_width)
        ends = dd.odometry.accumulate(np.stack([ways.mean(axis=-1), turn], axis=-1))[:, -1, :2]
        drifts.append(np.hypot(*(ends - estimate).T))
    return np.concatenate(drifts)


def climbed(angles: Array, believed: dd.Robot, parts: Array, at: Array, drifts: Array) -> float:
    """The largest drift found [m], by climbing from the worst of some robots too."""
    best = float(drifts.max())
    for start in at[np.argsort(-drifts)[:CLIMBS]]:
        top = minimize(
            lambda x: -drifts_of(angles, believed, parts * np.clip(x, -1, 1)[None])[0], start,
            bounds=[(-1, 1)] * 3, method="Nelder-Mead", options={"maxfev": 200},
        )  # fmt: skip
        best = max(best, -float(top.fun))
    return best


def loosest(circles: dict[float, Found]) -> Found:
    """The length of circles whose guarantee is farthest above the worst robot, as a part of its drift."""
    return max(circles.values(), key=lambda one: one.bound.position / one.worst)


def claims(found: dict[str, Found], every: list[Found]) -> list[Bound]:
    """No robot exceeds a guarantee, and some come close to it."""
    exceeding = sum(int((one.drawn > one.bound.position).sum()) for one in every)
    most = max(one.worst / one.bound.position for one in every)
    above = [
        Bound(
            f"{name}: the guarantee above the worst robot",
            1e3 * (one.bound.position - one.worst),
            1e3 * max(LOOSE * one.worst, LEAST),
            "mm",
        )
        for name, one in found.items()
    ]
    return [
        Bound("robots that exceed their guarantee", exceeding, 0),
        Bound("the worst robot of any drive over its guarantee", most, 1.0),
        *above,
    ]


def table(found: dict[str, Found]) -> str:
    """The drifts of each drive [mm]."""
    rows = [
        [name, *(f"{1e3 * x:.4g}" for x in (float(np.median(one.drawn)), one.likely, float(one.drawn.max()),
         one.bound.at_corners, one.worst, one.bound.position)), one.bound.boxes]
        for name, one in found.items()
    ]  # fmt: skip
    header = ["end of drive [mm]", "median", "99 %", "most drawn", "corners", "worst found", "guaranteed", "boxes"]
    return report.table(header, rows)


def finding(
    found: dict[str, Found], circles: dict[float, Found], robot: dd.Robot, tolerance: float, distance: float
) -> str:
    """The answer; its first line is the picture's title."""
    square = found["square"]
    # Where the corners tell least of the worst robot.
    length = min(circles, key=lambda each: circles[each].bound.at_corners / circles[each].worst)
    one = circles[length]
    every = [*found.values(), *circles.values()]
    tight = max(each.bound.position / each.worst - 1 for each in every if each.worst > LEAST / LOOSE)
    drawn = sum(len(each.drawn) for each in every)
    return (
        f"No {robot.name} within {100 * tolerance:g} % ends a square of {distance:g} m more than "
        f"{quantity(square.bound.position, 'm')} off; 99 % end within {quantity(square.likely, 'm')}\n"
        f"Of {drawn} robots none exceeds its guarantee, which is at most {100 * tight:.2g} % above the worst one "
        f"found.\nThe corners of the tolerances are no bound: after {length:g} m of circles they say "
        f"{quantity(one.bound.at_corners, 'm')} where a robot ends {quantity(one.worst, 'm')} off."
    )


def figure(title: str, found: dict[str, Found], circles: dict[float, Found]) -> Figure:
    """What robots use of their guarantee, drive by drive; and how it grows on circles, which corners do not see."""
    made, (left, right) = plots.figure(title, columns=2, size=(plots.WIDTH, 4.6))
    plots.panel(left, "Every drive has its guarantee")
    plots.panel(right, f"Circles of {RADIUS:g} m on and on: corners are no bound")
    guaranteed, corner = plots.style(0), plots.style(1)
    for row, one in enumerate(found.values()):
        most = one.bound.position
        label = {"label": "99 % of robots drawn at random"} if row == 0 else {}
        left.barh(row, one.likely / most, height=0.5, color="0.78", **label)
        label = {"label": "worst corner of the tolerances"} if row == 0 else {}
        left.plot(one.bound.at_corners / most, row, corner["marker"], color=corner["color"], markersize=7, **label)
    left.axvline(1.0, color=guaranteed["color"], linewidth=guaranteed["linewidth"], label="guaranteed")
    names = [f"{name}\n{quantity(one.bound.position, 'm')}" for name, one in found.items()]
    left.set_yticks(range(len(names)), names)
    left.invert_yaxis()
    left.set(xlim=(0, 1.05), xlabel="drift / guaranteed drift")
    lengths = list(circles)
    right.fill_between(lengths, [one.likely for one in circles.values()], color="0.78", linewidth=0)
    right.plot(lengths, [one.bound.at_corners for one in circles.values()], markevery=2, **corner)
    right.plot(lengths, [one.bound.position for one in circles.values()], **{**guaranteed, "marker": None})
    right.set(xlim=(0, None), ylim=(0, None), xlabel="driven [m]", ylabel="drift at the end [m]")
    for ax in (left, right):
        plots.tidy(ax)
    plots.legend_below(made, left, right)
    return made


if __name__ == "__main__":
    report.main(run)
