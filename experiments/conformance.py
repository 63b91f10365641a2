"""Which odometry is right, and where do the others fail: the package's own, and those that PyPI has?

Each takes a step of known distance and turn its own way: Euler, the midpoint of [Greek notes], the exact arc of
[ct-Sim], [Behnke] and [Odometrie wiki 2016], and the exponential maps of packages, in which a step is a twist.
Readings, wraps and clocks are handled alike for all, so that the arithmetic alone is compared: on the conformance
suite, and on drives in physics, where the encoder's ticks are there as well.
"""

from __future__ import annotations

import importlib
import math
from dataclasses import dataclass
from importlib.metadata import version

import numpy as np
from matplotlib.figure import Figure

import diffdrive_mj as dd
from diffdrive_mj import _checks as checks
from diffdrive_mj import report
from diffdrive_mj.judging.by_name import simulated
from diffdrive_mj.judging.right import Right
from diffdrive_mj.judging.suite import cases
from diffdrive_mj.judging.verdict import Verdict
from diffdrive_mj.report import Bound, Report, plots

DRIVES = ("square", "figure_eight", "slalom")


class Euler(Right):
    """Along the heading before the step."""

    def move(self, distance: float, turn: float) -> None:  # noqa: D102
        self.shift(distance, self.theta)
        self.theta += turn


class Midpoint(Right):
    """Along the heading half-way, the arc's length for its chord."""

    def move(self, distance: float, turn: float) -> None:  # noqa: D102
        self.shift(distance, self.theta + turn / 2)
        self.theta += turn


class Wpilib(Right):
    """The exponential of WPILib's Twist2d."""

    def move(self, distance: float, turn: float) -> None:  # noqa: D102
        geometry = importlib.import_module("wpimath.geometry")
        pose = geometry.Pose2d(self.x, self.y, geometry.Rotation2d(self.theta))
        twist = geometry.Twist2d(distance, 0.0, turn)
        end = pose.exp(twist) if hasattr(pose, "exp") else pose + twist.exp()
        self.x, self.y, self.theta = end.X(), end.Y(), end.rotation().radians()


class Spatialmath(Right):
    """The exponential of Corke's spatialmath."""

    def move(self, distance: float, turn: float) -> None:  # noqa: D102
        step = importlib.import_module("spatialmath.base").trexp2([distance, 0.0, turn])
        c, s = math.cos(self.theta), math.sin(self.theta)
        self.x, self.y = self.x + c * step[0, 2] - s * step[1, 2], self.y + s * step[0, 2] + c * step[1, 2]
        self.theta += math.atan2(step[1, 0], step[0, 0])


class ModernRobotics(Right):
    """The exponential of Lynch and Park's modern_robotics, of a twist in space: turns below 1e-6 rad are dropped."""

    def move(self, distance: float, turn: float) -> None:  # noqa: D102
        package = importlib.import_module("modern_robotics")
        step = package.MatrixExp6(package.VecTose3(np.array([0.0, 0.0, turn, distance, 0.0, 0.0])))
        c, s = math.cos(self.theta), math.sin(self.theta)
        self.x, self.y = self.x + c * step[0, 3] - s * step[1, 3], self.y + s * step[0, 3] + c * step[1, 3]
        self.theta += math.atan2(step[1, 0], step[0, 0])


# What is compared: its name, its class, and the package that it needs, as PyPI calls it.
LEAGUE: dict[str, tuple[type[Right], str]] = {
    "arc (this package)": (Right, "diffdrive_mj"),
    "midpoint": (Midpoint, "diffdrive_mj"),
    "Euler": (Euler, "diffdrive_mj"),
    "WPILib": (Wpilib, "robotpy-wpimath"),
    "spatialmath": (Spatialmath, "spatialmath-python"),
    "modern_robotics": (ModernRobotics, "modern_robotics"),
}


@dataclass(frozen=True)
class Member:
    """One odometry, and what came of it.

    Attributes:
        version: of its package.
        suite: the verdict on the conformance suite.
        drives: that on drives in physics.
    """

    version: str
    suite: Verdict
    drives: Verdict

    @property
    def failed(self) -> list[str]:
        """The cases that it fails, the worst first."""
        return [row.task.name for row in self.suite.ranked if not row.holds]

    @property
    def worst(self) -> float:
        """Its largest error as a multiple of what the case allows."""
        return max(row.arithmetic / row.allowed for row in self.suite.rows)


def run(robot: str = "ct_bot", rate: float = 10.0) -> Report:
    """Judge every odometry of which the package is installed.

    Args:
        robot: that drives in physics: a preset's name, or a TOML file.
        rate: of its encoder's readings there [Hz].
    """
    rate = checks.positive("rate", rate)
    tasks = [simulated(name, robot, rate=rate) for name in DRIVES]
    found = {
        name: Member(version(package), dd.judge(kind, cases()), dd.judge(kind, tasks))
        for name, (kind, package) in LEAGUE.items()
        if installed(package)
    }
    missing = [package for _, package in LEAGUE.values() if not installed(package)]
    answer = finding(found)
    return Report(
        question=__doc__,
        finding="\n".join([answer, *(f"{package} is not installed: pip install {package}" for package in missing)]),
        table=table(found),
        bounds=claims(found),
        metrics={
            name: {"version": member.version, "failed": member.failed, "worst_error_over_tolerance": member.worst}
            for name, member in found.items()
        },
        pictures={"conformance": figure(answer.splitlines()[0], found)},
    )


def installed(package: str) -> bool:
    """Whether a package is there."""
    try:
        version(package)
    except importlib.metadata.PackageNotFoundError:
        return False
    return True


def claims(found: dict[str, Member]) -> list[Bound]:
    """The arc is right; what takes another way than the arc is not."""
    turning = sum(map(turns_while_driving, cases()))
    return [
        Bound("arc (this package), cases failed", float(len(found["arc (this package)"].failed)), 0.0),
        *(
            Bound(f"{name}, cases failed", float(len(found[name].failed)), float(turning), at_least=True)
            for name in ("midpoint", "Euler")
        ),
    ]


def turns_while_driving(case: dd.Task) -> bool:
    """Whether a chord of a case is shorter than its arc by far more than what is allowed."""
    steps = np.diff(case.expected, axis=0)
    shorter = np.hypot(steps[:, 0], steps[:, 1]) * steps[:, 2] ** 2 / 24
    return bool(shorter.max() > 100 * case.allowed)


def finding(found: dict[str, Member]) -> str:
    """The answer; its first line is the picture's title."""
    count = len(cases())
    right = [name for name, member in found.items() if not member.failed]
    euler, midpoint = (len(found[name].failed) for name in ("Euler", "midpoint"))
    lines = [f"Of {count} cases Euler fails {euler} and the midpoint {midpoint}; {listed(right)} pass{_es(right)} all"]
    for name, member in found.items():
        if member.failed and name not in ("Euler", "midpoint"):
            reason = member.suite.reason
            lines.append(
                f"{name} fails {len(member.failed)}, the worst {member.failed[0]}{f': {reason}' * bool(reason)}."
            )
    return "\n".join(lines)


def listed(names: list[str]) -> str:
    """Names in a sentence."""
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def _es(names: list[str]) -> str:
    return "es" if len(names) == 1 else ""


def table(found: dict[str, Member]) -> str:
    """How many cases each passes, and how far it drifts in physics."""
    header = ["odometry", "version", "passes", "of", "worst error / tolerance", *(f"{name} [mm]" for name in DRIVES)]
    return report.table(
        header,
        [
            [
                name,
                member.version,
                len(cases()) - len(member.failed),
                len(cases()),
                f"{member.worst:.2g}",
                *(1e3 * float(row.drift.max_position) for row in member.drives.rows if row.drift),
            ]
            for name, member in found.items()
        ],
    )


def figure(title: str, found: dict[str, Member]) -> Figure:
    """The cases that each fails, and what it costs in physics beside the encoder's ticks."""
    made, (left, right) = plots.figure(title, columns=2, size=(plots.WIDTH, 4.2))
    names = list(found)[::-1]
    rows = np.arange(len(names))
    failed = [len(found[name].failed) for name in names]
    left.barh(rows, failed, color=[plots.style(0 if count else 2)["color"] for count in failed], height=0.6)
    for row, count in zip(rows, failed, strict=True):
        left.annotate(str(count), (count, row), xytext=(4, 0), textcoords="offset points", va="center", fontsize=9.5)
    left.set(yticks=rows, yticklabels=names, xlabel="cases failed [number of]", xlim=(0, 1.15 * max(failed)))
    plots.panel(left, f"On the suite of {len(cases())} cases")
    for k, drive in enumerate(DRIVES):
        drifts = [1e3 * float(found[name].drives.rows[k].drift.max_position) for name in names]  # type: ignore[union-attr]
        right.plot(drifts, rows, label=drive, **{**plots.style(k), "linestyle": "none"})
    right.set(yticks=rows, yticklabels=[], ylim=left.get_ylim(), xlabel="largest position error [mm]")
    plots.panel(right, "In physics, ticks of the encoder included")
    for ax in (left, right):
        plots.tidy(ax)
    plots.legend_below(made, right)
    return made


if __name__ == "__main__":
    report.main(run)
