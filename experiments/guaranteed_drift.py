"""How far can odometry drift at most, if the robot is known within tolerances?

`dd.guarantee` bounds it for every robot within them. Robots drawn at random, those at the corners of the tolerances,
and those to which an optimiser climbs from the worst of them say how much of the bound is used.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
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
    robot: str = "ct_bot", tolerance: float = 0.02, distance: float = 30.0, robots: int = 20_000, seed: int = 0
) -> Report:
    """Bound the drift on six drives, and look for robots that come close.

    Args:
        robot: a preset's name, or a TOML file.
        tolerance: of the mean radius, of the radius ratio and of the track width, relative.
        distance: of each drive but the spin [m].
        robots: drawn at random for each drive.
        seed: of them.
    """
    believed = dd.Robot.load(robot).replace(turning_gain=0.0)
    tolerances = within(believed, tolerance)
    checks.positive("distance", distance)
    checks.whole("robots", robots, least=100)
    parts = np.array([tolerances.radius, tolerances.radius_ratio, tolerances.track_width])
    generator = np.random.default_rng(seed)
    at = np.concatenate([list(itertools.product((-1.0, 1.0), repeat=3)), generator.uniform(-1, 1, (robots, 3))])
    found = {}
    for name, commands in drives(believed, distance).items():
        angles = commands.wheel_angles
        drifts = drifts_of(angles, believed, parts * at)
        found[name] = Found(
            dd.guarantee(commands, believed, tolerances), drifts[8:], climbed(angles, believed, parts, at, drifts)
        )
    text = finding(found, believed, tolerance)
    return Report(
        question=__doc__,
        finding=text,
        table=table(found),
        bounds=claims(found),
        metrics={
            name: {
                "guaranteed_m": one.bound.position, "worst_m": one.worst, "corners_m": one.bound.at_corners,
                "percentile_99_m": one.likely, "boxes": one.bound.boxes,
            }
            for name, one in found.items()
        },
        pictures={"guaranteed_drift": figure(text.splitlines()[0], found)},
    )  # fmt: skip


def drives(robot: dd.Robot, distance: float) -> dict[str, dd.Commands]:
    """What is driven, by name."""
    period = distance / SPEED / SAMPLES
    return {
        "straight": maneuvers.straight(robot, distance=distance, speed=SPEED, period=period),
        "circles": maneuvers.arc(robot, radius=1.0, distance=distance, speed=SPEED, period=period),
        "square": maneuvers.square(robot, side=distance / 4, speed=SPEED, period=period),
        "figure eight": maneuvers.figure_eight(robot, radius=distance / 4 / np.pi, speed=SPEED, period=period),
        "slalom": maneuvers.slalom(robot, wavelength=distance / 3, speed=SPEED, period=period),
        "spin": maneuvers.spin(robot, turns=10.0, period=period),
    }


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


def claims(found: dict[str, Found]) -> list[Bound]:
    """No robot exceeds a guarantee, and some come close to it; the worst that `guarantee` names drifts that far."""
    over = {name: one.bound.position - one.worst for name, one in found.items()}
    return [
        Bound(
            "robots that exceed their guarantee",
            sum(int((o.drawn > o.bound.position).sum()) for o in found.values()),
            0,
        ),
        *(
            Bound(f"{name}: the worst robot over the guarantee", one.worst / one.bound.position, 1.0)
            for name, one in found.items()
        ),
        *(
            Bound(
                f"{name}: the guarantee above the worst robot",
                1e3 * over[name],
                1e3 * max(LOOSE * one.worst, LEAST),
                "mm",
            )
            for name, one in found.items()
        ),
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


def finding(found: dict[str, Found], robot: dd.Robot, tolerance: float) -> str:
    """The answer; its first line is the picture's title."""
    # Where the corners tell least of the worst robot.
    name = min(found, key=lambda each: found[each].bound.at_corners / found[each].worst)
    one = found[name]
    most, corners = quantity(one.bound.position, "m"), quantity(one.bound.at_corners, "m")
    tight = max(each.bound.position / each.worst - 1 for each in found.values() if each.worst > LEAST / LOOSE)
    drawn = sum(len(each.drawn) for each in found.values())
    return (
        f"{name.capitalize()}: no {robot.name} within {100 * tolerance:g} % ends more than {most} off; the corners "
        f"alone say {corners}\n"
        f"Of {drawn} robots none exceeds its guarantee, which is at most {100 * tight:.2g} % above the worst one found."
    )


def figure(title: str, found: dict[str, Found]) -> Figure:
    """How the drifts of robots drawn at random are distributed below the guarantee, for each drive."""
    made, axes = plots.figure(title, columns=3, rows=2, size=(plots.WIDTH, 6.4))
    for ax, (name, one) in zip(axes.flat, found.items(), strict=True):
        draw(ax, one)
        plots.panel(ax, f"{name.capitalize()}: at most {quantity(one.bound.position, 'm')}")
    plots.legend_below(made, *axes.flat)
    return made


def draw(ax: Axes, one: Found) -> None:
    """One drive."""
    most = one.bound.position
    weights = np.full(len(one.drawn), 100 / len(one.drawn))
    ax.hist(
        one.drawn / most,
        bins=np.linspace(0, 1, 41).tolist(),
        weights=weights,
        color="0.75",
        label="robots drawn at random",
    )
    marks = {"99 % of them": one.likely, "worst corner": one.bound.at_corners, "guaranteed": most}
    for index, (label, value) in enumerate(marks.items()):
        look = plots.style(2 - index)
        ax.axvline(value / most, color=look["color"], linestyle=look["linestyle"], label=label)
    ax.set(xlim=(0, 1.05), xlabel="drift / guaranteed drift", ylabel="robots [%]")
    plots.tidy(ax)


if __name__ == "__main__":
    report.main(run)
