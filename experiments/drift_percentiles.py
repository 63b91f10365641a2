"""How far off are most of a thousand robots, along their way?

Robots as they are built, off their drawing by their tolerances, drive a square while odometry believes the drawing.
Half of them stay under one curve, 99 % under another. Theory to first order and the same robots without physics agree.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from matplotlib.figure import Figure

import diffdrive_mj as dd
from diffdrive_mj import _checks as checks
from diffdrive_mj import report
from diffdrive_mj._text import quantity
from diffdrive_mj.estimation.sensitivities import within
from diffdrive_mj.report import Bound, Report, sweeps
from diffdrive_mj.report.chance import Expected, rms_bound
from diffdrive_mj.sweeps import Maneuver, Study, Trials
from diffdrive_mj.sweeps.linear import FirstOrder, first_order

KEPT = ("final_position", "final_heading", "distance", "position_along")
SHARES = (0.5, 0.9, 0.95, 0.99)
# Of the robots of a sweep without physics, those that are driven in physics to compare.
COMPARED = 50
# Servos lag, so that wheels make a little less of the way: what of the 99th percentile, and what of the distance, no
# robot's error changes by more than.
OF_PERCENTILE, OF_DISTANCE = 5e-4, 2e-6


def run(
    robot: str = "matched",
    trials: int = 400,
    side: float = 1.0,
    tolerance: float | None = None,
    truth: Literal["physics", "kinematics"] = "physics",
    seed: int = 0,
) -> Report:
    """Drive the robots, and compare their errors with theory and with each other.

    Args:
        robot: a preset's name, or a TOML file, with its tolerances as standard deviations.
        trials: how many robots; 10 000 for the full size.
        side: of the square [m].
        tolerance: relative, in place of the robot's own, for mean radius, radius ratio and track.
        truth: physics drives all of them in MuJoCo; kinematics all without slip, and some in MuJoCo to compare.
        seed: of the robots.
    """
    designed = dd.Robot.load(robot)
    known = replace_tolerances(designed, tolerance)
    checks.whole("trials", trials, least=20)
    study = Study.of_tolerances(
        known, Maneuver("square", {"side": side}), trials=trials, truth=truth, seed=seed, figures=KEPT,
        name="drift_percentiles",
    )  # fmt: skip
    driven = dd.sweep(study)
    other = study.replace(
        truth="physics" if truth == "kinematics" else "kinematics",
        trials=min(trials, COMPARED) if truth == "kinematics" else trials,
    )
    apart = worst_apart(driven, dd.sweep(other))
    theory = first_order(study)
    text = finding(driven, side)
    return Report(
        question=__doc__,
        finding=text,
        table=table(driven, side),
        bounds=claims(driven, theory, apart),
        metrics={
            "counted": driven.counted,
            "percentiles_m": {str(share): limits(driven, share) for share in SHARES},
            "theory_rms_m": float(theory.position_rms),
            "physics_against_kinematics_m": apart,
        },
        pictures={"drift_percentiles": figure(title(text), driven)},
    )


def replace_tolerances(robot: dd.Robot, tolerance: float | None) -> dd.Robot:
    """The robot with a tolerance in place of its own."""
    return robot.replace(tolerances=within(robot, tolerance))


def limits(trials: Trials, share: float) -> list[float]:
    """A percentile of the final position error with its limits [m]."""
    found = trials.percentile("final_position", share)
    return [float(found.value), float(found.low), float(found.high)]


def worst_apart(some: Trials, others: Trials) -> float:
    """How far the final errors of the same robots are apart in physics and without, the worst [m].

    No percentile of the two differs by more.
    """
    count = min(len(some), len(others))
    both = some.ok[:count] & others.ok[:count]
    apart = some.figures["final_position"][:count] - others.figures["final_position"][:count]
    return float(np.abs(apart[both]).max(initial=0.0))


def claims(driven: Trials, theory: FirstOrder, apart: float) -> list[Bound]:
    """Errors scatter as theory says, and physics adds nothing to what the tolerances do."""
    position, heading = (driven.figures[name][driven.ok] for name in ("final_position", "final_heading"))
    # The next order of the chord of a turn a is a^2 / 24 of it, and three times that in the root mean square.
    beyond = theory.heading_sigma**2 / 8
    allowed = OF_PERCENTILE * limits(driven, 0.99)[0] + OF_DISTANCE * float(np.median(driven.figures["distance"]))
    return [
        rms_bound("heading", Expected(heading, theory.heading_sigma), beyond=beyond),
        rms_bound("position", Expected(position, theory.position_rms, kurtosis=4.0), beyond=beyond),
        Bound("physics against kinematics, the worst robot", 1e3 * apart, 1e3 * allowed, "mm"),
        Bound("robots that fell, diverged or were refused", int((~driven.ok).sum()), 0.01 * len(driven)),
    ]


def table(driven: Trials, side: float) -> str:
    """Percentiles of the position error after each side of the square."""
    rows = []
    for corner in (1, 2, 3, 4):
        place = corner * (driven.figures["position_along"].shape[1] - 1) // 4
        found = [driven.percentile("position_along", share) for share in SHARES]
        low, high = (1e3 * float(each[place]) for each in (found[-1].low, found[-1].high))
        rows.append([
            f"{corner * side:g} m", *(1e3 * float(each.value[place]) for each in found),
            f"{low:.4g} to {high:.4g}" if np.isfinite(high) else f"{low:.4g} or more",
        ])  # fmt: skip
    header = ["after", *(f"{100 * share:g} % under [mm]" for share in SHARES), "95 % limits of the last"]
    return report.table(header, rows)


def finding(driven: Trials, side: float) -> str:
    """The answer; its first line is the picture's title."""
    half, most = (quantity(limits(driven, share)[0], "m") for share in (0.5, 0.99))
    _, low, high = limits(driven, 0.99)
    sure = (
        f"between {quantity(low, 'm')} and {quantity(high, 'm')}"
        if np.isfinite(high)
        else f"above {quantity(low, 'm')}"
    )
    return (
        f"After a square of {4 * side:g} m half of the robots are off by less than {half}, 99 % by less than {most}\n"
        f"From {len(driven)} robots the 99th percentile is known to lie {sure} (95 % confidence)."
    )


def title(text: str) -> str:
    """The first line of the finding, in two."""
    return text.splitlines()[0].replace(", 99 %", ",\n99 %")


def figure(title: str, driven: Trials) -> Figure:
    """The fan, and the share that ends beyond any limit."""
    return sweeps.swept(title, driven, limit=limits(driven, 0.9)[0])


if __name__ == "__main__":
    report.main(run)
