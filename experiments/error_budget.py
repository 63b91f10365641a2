"""Which tolerance of the robot matters most?

Robots whose radii and track are off their drawing drive with odometry that believes the drawing. From one sweep come
the share of each tolerance in the scatter, and what it buys to halve it. A sweep of tighter robots, some robots in
physics, and theory say whether that is right.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Literal

import numpy as np
from matplotlib.figure import Figure

import diffdrive_mj as dd
from diffdrive_mj import _checks as checks
from diffdrive_mj import report
from diffdrive_mj._checks import Array
from diffdrive_mj._text import quantity
from diffdrive_mj.estimation.sensitivities import within
from diffdrive_mj.report import Bound, Report, plots, sweeps
from diffdrive_mj.report.chance import SIGMAS
from diffdrive_mj.sweeps import Budget, Maneuver, Study, Trials, budget
from diffdrive_mj.sweeps._units import varied_in_words
from diffdrive_mj.sweeps.indices import indices_of
from diffdrive_mj.sweeps.linear import first_order
from diffdrive_mj.sweeps.percentiles import Estimate
from diffdrive_mj.sweeps.prices import tightened

KEPT = ("final_position", "final_heading", "distance")
HALF = 0.5
IN_PHYSICS = 40  # robots that are driven both in physics and without
LIMIT = 1.96  # standard errors from a figure to its limits
# What of the percentile, and what of the distance, no robot's error changes by more than in physics, where servos lag.
OF_PERCENTILE, OF_DISTANCE = 5e-4, 2e-6


def run(
    robot: str = "matched",
    rows: int = 512,
    side: float = 1.0,
    tolerance: float | None = None,
    share: float = 0.99,
    truth: Literal["kinematics", "physics"] = "kinematics",
    seed: int = 0,
) -> Report:
    """Sweep a square and other drives, and split the errors.

    Args:
        robot: a preset's name, or a TOML file, with its tolerances as standard deviations.
        rows: of each of the five blocks of a design for Sobol' indices; there are five times as many trials a drive.
        side: of the square [m]; the other drives are about as long.
        tolerance: relative, in place of the robot's own, for mean radius, radius ratio and track.
        share: of the robots that shall stay under a limit.
        truth: kinematics drives without slip, and a few robots in MuJoCo to compare; physics drives all in MuJoCo.
        seed: of the robots.
    """
    designed = dd.Robot.load(robot)
    known = designed.replace(tolerances=within(designed, tolerance))
    side = checks.positive("side", side)
    drives = {
        "square": Maneuver("square", {"side": side}),
        "straight": Maneuver("straight", {"speed": 0.3, "distance": 4 * side}),
        "figure eight": Maneuver("figure_eight", {"radius": side / math.pi, "speed": 0.3}),
        "slalom": Maneuver("slalom", {"wavelength": 4 / 3 * side, "speed": 0.3}),
    }
    studies = {}
    for name, drive in drives.items():
        study = Study.of_tolerances(known, drive, truth=truth, seed=seed, figures=KEPT, name=name)
        trials = checks.whole("rows", rows) * (len(study.vary) + 2)
        studies[name] = study.replace(design="saltelli", trials=trials)
    swept = {name: dd.sweep(study) for name, study in studies.items()}
    found = {name: budget(studies[name], trials, share=share, factor=HALF) for name, trials in swept.items()}
    square = found["square"]
    text = finding(found)
    return Report(
        question=__doc__,
        finding=text,
        table=table(found),
        bounds=claims(studies["square"], swept["square"], square),
        metrics={name: each.as_dict() for name, each in found.items()},
        pictures={
            "error_budget": sweeps.budgeted(square),
            "error_budget_drives": by_drive(text.splitlines()[1].rstrip("."), found),
        },
    )


def claims(study: Study, trials: Trials, found: Budget) -> list[Bound]:
    """The price is what tighter robots show, the shares are those of theory, and physics agrees."""
    name, fall = found.dearest, found.prices.fall[found.order[0]]
    truly = 1 - quantile(dd.sweep(tightened(study, name, HALF)), found) / quantile(trials, found)
    theory, heading = first_order(study), indices_of(trials, "final_heading")
    # Beside chance, the next order of a heading that is far off.
    allowed = SIGMAS * errors(heading.first) + 1e-3 + theory.heading_sigma**2 / 8
    off = np.abs(heading.first.value - theory.heading_shares) / allowed
    some = study.replace(design="random", trials=IN_PHYSICS)
    limit = OF_PERCENTILE * float(found.percentile.value) + OF_DISTANCE * float(np.median(trials.figures["distance"]))
    return [
        Bound(
            "price of the dearest against tighter robots",
            abs(float(fall.value) - truly) / float(errors(fall)),
            SIGMAS,
            "standard errors",
        ),
        Bound("shares of the heading's variance against theory, of what is allowed", float(off.max()), 1.0),
        Bound("physics against kinematics, the worst robot", 1e3 * apart(some), 1e3 * limit, "mm"),
    ]


def quantile(trials: Trials, found: Budget) -> float:
    """The percentile of a budget over all trials [m], also those that hang together."""
    sizes = np.where(trials.ok, np.abs(trials.figures[found.figure]), np.inf)[trials.outcome != "refused"]
    return float(np.quantile(sizes, found.prices.share, method="inverted_cdf"))


def errors(found: Estimate) -> Array:
    """Standard errors, from the limits."""
    return (found.high - found.low) / (2 * LIMIT)


def apart(study: Study) -> float:
    """How far the final errors of robots are apart in physics and without, the worst [m]."""
    one, other = (dd.sweep(study.replace(truth=truth)) for truth in ("physics", "kinematics"))
    both = one.ok & other.ok
    return float(np.abs(one.figures["final_position"] - other.figures["final_position"])[both].max(initial=0.0))


def table(found: Mapping[str, Budget]) -> str:
    """The budget of the square, and what each tolerance buys on every drive."""
    square, *_ = found.values()
    share = f"{100 * square.prices.share:g} % under [mm]"
    rows = [
        [name, 1e3 * float(each.percentile.value), *(falls(each, tolerance) for tolerance in square.prices.names)]
        for name, each in found.items()
    ]
    halved = [f"{varied_in_words(tolerance)} halved" for tolerance in square.prices.names]
    return f"{square}\n\n{report.table(['drive', share, *halved], rows)}"


def falls(found: Budget, tolerance: str) -> str:
    """By what part a percentile falls, with its limits."""
    return found.prices.fall[found.prices.names.index(tolerance)].text("%", 100, digits=2)


def finding(found: Mapping[str, Budget]) -> str:
    """The answer; its lines are the pictures' titles."""
    dearest = {name: varied_in_words(each.dearest) for name, each in found.items()}
    differ = len(set(dearest.values())) > 1
    what = "What to halve depends on the drive" if differ else "What to halve is the same on every drive"
    falls_by = {name: float(each.prices.fall.value.max()) for name, each in found.items()}
    best = [f"on the {name} the {of} ({100 * falls_by[name]:.2g} %)" for name, of in dearest.items()]
    return f"{found['square'].finding}\n{what}: {', '.join(best[1:])}."


def by_drive(title: str, found: Mapping[str, Budget]) -> Figure:
    """What each tolerance buys on every drive, side by side."""
    made, ax = plots.figure(title, size=(plots.WIDTH, 4.4))
    names = next(iter(found.values())).prices.names
    places, width = np.arange(len(found)), 0.8 / len(names)
    for k, name in enumerate(names):
        prices = [each.prices.fall[each.prices.names.index(name)] for each in found.values()]
        value, low, high = (
            100 * np.array([getattr(each, part) for each in prices]) for part in ("value", "low", "high")
        )
        ax.bar(
            places + (k - (len(names) - 1) / 2) * width, value, 0.9 * width, label=f"{varied_in_words(name)} halved",
            yerr=np.maximum([value - low, high - value], 0), color=plots.style(k)["color"],
            error_kw={"ecolor": "0.2", "capsize": 3, "elinewidth": 1.1}, linewidth=0, edgecolor="white",
            hatch=("", "//", "..")[k % 3],
        )  # fmt: skip
    share = 100 * next(iter(found.values())).prices.share
    limits = [f"{name}\n{quantity(float(each.percentile.value), 'm')}" for name, each in found.items()]
    ax.set(xticks=places, xticklabels=limits, ylabel=f"fall of the {share:g}th percentile [%]")
    ax.axhline(0, color="0.4", linewidth=0.8)
    plots.tidy(ax).grid(visible=False, axis="x")
    ax.legend()
    plots.legend_below(made, ax)
    return made


if __name__ == "__main__":
    report.main(run)
