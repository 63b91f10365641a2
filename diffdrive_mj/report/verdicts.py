"""Pictures of verdicts and evaluations: where an odometry went, and where it should have gone."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from diffdrive_mj import metrics
from diffdrive_mj._text import quantity
from diffdrive_mj.report import plots
from diffdrive_mj.report.experiment import Bound, Report
from diffdrive_mj.report.figures import legend_below, map_beside_two

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from diffdrive_mj.judging.bounds import Bounds
    from diffdrive_mj.judging.evaluation import Evaluation
    from diffdrive_mj.judging.verdict import Row, Verdict


def judged(verdict: Verdict, most: int = 3) -> dict[str, Figure]:
    """Draw the drives whose bounds are broken, the worst first; the worst drive if all bounds hold.

    Args:
        verdict: of `judge`.
        most: so many drives at most.

    Returns:
        A figure for each, by the drive's name; none of drives on which nothing was answered.

    Example:
        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.091, track_width=0.4)
        >>> t = np.arange(0.0, 5.0, 0.1)
        >>> task = dd.Task("bend", robot, t, np.stack([5 * t, 6 * t], axis=-1))
        >>> list(judged(dd.judge(robot.replace(left_radius=0.091), [task])))
        ['bend']
    """
    drawn = [row for row in verdict.ranked if row.poses is not None]
    broken = [row for row in drawn if not row.holds][:most]
    return {row.task.name: _picture(verdict.candidate, row) for row in broken or drawn[:1]}


def reported(verdict: Verdict) -> Report:
    """Make a verdict a report, which writes its figures and its pictures into a folder.

    Args:
        verdict: of `judge`.

    Example:
        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> ahead = dd.Task("ahead", robot, [0.0, 1.0], [(0, 0), (10, 10)])
        >>> reported(dd.judge(robot, [ahead])).finding
        'robot: holds on 1 of 1 drives'
    """
    finding, _, rest = str(verdict).partition("\n")
    bounds = [Bound(f"{row.task.name}: bounds broken", float(len(row.broken)), 0.0) for row in verdict.rows]
    return Report("Is the odometry right, and how far does it drift?", finding, rest, bounds, pictures=judged(verdict))


def evaluated(found: Evaluation, bounds: Bounds | None = None) -> Report:
    """Make an evaluation a report, with a picture of the path coloured by its error.

    Args:
        found: of `evaluate`.
        bounds: that its drift must keep; none by default.

    Example:
        >>> truth = dd.PoseLog([0.0, 1.0], [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0)])
        >>> list(evaluated(dd.evaluate(truth, truth)).pictures)
        ['path']
    """
    drift = found.drift
    worst, distance = quantity(float(drift.max_position), "m"), quantity(float(drift.distance), "m")
    finding = f"{found.name}: at most {worst} off in {distance}"
    figures = () if bounds is None else bounds.figures(drift)
    kept = [Bound(f"{words} off by", value, limit, unit) for words, unit, value, limit in figures]
    pictures = {"path": _coloured(found, finding)}
    return Report("How far is the estimate off the truth?", finding, str(found), kept, pictures=pictures)


def _coloured(found: Evaluation, finding: str) -> Figure:
    drift = found.drift
    made, left, upper, lower = map_beside_two(finding)
    plots.coloured_path(left, found.truth, found.estimate, drift.position_error)
    for ax, off, label, scale in (
        (upper, drift.position_error, "position error [mm]", 1e3),
        (lower, drift.heading_error, "heading error [deg]", 180 / np.pi),
    ):
        ax.plot(drift.travelled, scale * off, color=plots.style(0)["color"], linewidth=1.5)
        ax.set(xlabel="distance driven [m]", ylabel=label)
        plots.tidy(ax)
    return made


def _picture(candidate: str, row: Row) -> Figure:
    """The paths, and the errors along the drive: against the truth, or against exact odometry where none is known."""
    task, poses = row.task, row.poses
    assert poses is not None
    exact = task.expected
    truth = exact if task.truth is None else task.truth
    reference = "exact odometry" if task.truth is None else "ground truth"
    estimates = {candidate: poses} if task.truth is None else {candidate: poses, "exact odometry": exact}
    off = {label: metrics.drift(truth, estimate) for label, estimate in estimates.items()}
    made, left, upper, lower = map_beside_two(_finding(candidate, row, reference))
    plots.paths(left, truth, estimates, truth_label=reference)
    along = metrics.travelled(truth)
    plots.errors(upper, along, {label: drift.position_error for label, drift in off.items()})
    headings = {label: drift.heading_error for label, drift in off.items()}
    plots.errors(lower, along, headings, ylabel="heading error [deg]", scale=180 / np.pi)
    legend_below(made, left, upper, lower)
    return made


def _finding(candidate: str, row: Row, reference: str) -> str:
    if row.broken:
        return f"{candidate} on {row.task.name}: {row.broken[0]}" + (f"; {row.reason}" if row.reason else "")
    off = row.arithmetic if row.drift is None else float(row.drift.max_position)
    return f"{candidate} on {row.task.name}: within {quantity(off, 'm')} of the {reference}"
