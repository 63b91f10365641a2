"""Pictures of verdicts and evaluations: which drives are drawn, their titles, and the errors in them."""

import numpy as np
import pytest

import diffdrive_mj as dd
from diffdrive_mj.judging.bounds import Bounds
from diffdrive_mj.judging.verdict import Row, Verdict
from diffdrive_mj.report.verdicts import _finding, evaluated, judged, reported

ROBOT = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
T = np.array([0.0, 1.0, 2.0])
EXACT = np.array([(0.0, 0, 0), (1.0, 0, 0), (2.0, 0, 0)])
OFF = np.array([(0, 0, 0), (0, 0.1, 0), (0, 0.2, np.pi / 6)])


def row(name="ahead", off=0.2, *, truth=None, broken=("off",), reasons=(), answered=True):
    """A metre a second straight ahead."""
    task = dd.Task(name, ROBOT, T, np.stack([10 * T, 10 * T], axis=-1), truth=truth)
    drift = None if truth is None else dd.metrics.drift(truth, EXACT + OFF)
    return Row(task, EXACT + OFF if answered else None, off, 0.1, drift, broken, reasons)


def lines(ax):
    """The lines by their labels, errors along the drive."""
    return {line.get_label(): line.get_xydata() for line in ax.lines}


def test_the_worst_broken_drives_are_drawn_and_three_at_most():
    verdict = Verdict("mine", (*(row(name, k) for k, name in enumerate("abcd", 1)), row("e", 9, broken=())))
    assert list(judged(verdict)) == ["d", "c", "b"]
    assert list(judged(verdict, most=1)) == ["d"]


def test_the_worst_drive_is_drawn_where_all_bounds_hold_and_none_without_answers():
    assert list(judged(Verdict("mine", (row("near", 1, broken=()), row("far", 2, broken=()))))) == ["far"]
    silent = row(off=np.inf, answered=False)
    assert judged(Verdict("mine", (silent,))) == {}
    assert list(judged(Verdict("mine", (silent, row("other"))))) == ["other"]


def test_a_title_says_what_is_broken_and_why_or_how_near_it_is():
    assert _finding("mine", row(broken=("far off", "and more"), reasons=("late", "early")), "x") == (
        "mine on ahead: far off; late"
    )
    assert _finding("mine", row(broken=("far off",)), "x") == "mine on ahead: far off"
    assert _finding("mine", row(off=0.25, broken=()), "track") == "mine on ahead: within 250 mm of the track"
    near = row(off=0.25, broken=(), truth=EXACT)
    assert _finding("mine", near, "track") == "mine on ahead: within 200 mm of the track"


def test_errors_are_those_from_the_exact_odometry_or_from_the_truth():
    (made,) = judged(Verdict("mine", (row(),))).values()
    _, upper, lower = made.axes
    assert made.get_suptitle() == "mine on ahead: off"
    assert lines(upper)["mine"] == pytest.approx(np.array([(0, 0), (1, 100), (2, 200)]))
    assert lines(lower)["mine"][:, 1] == pytest.approx([0, 0, 30])
    assert "exact odometry" not in lines(upper)
    # The truth lies to the right of what exact odometry believes.
    (made,) = judged(Verdict("mine", (row(truth=EXACT - (0, 0.3, 0)),))).values()
    upper = made.axes[1]
    assert lines(upper)["exact odometry"][:, 1] == pytest.approx([300] * 3)
    assert lines(upper)["mine"][:, 1] == pytest.approx([300, 400, 500])


def test_an_evaluation_is_drawn_with_its_errors_along_the_way():
    found = dd.evaluate(dd.PoseLog(T, EXACT), dd.PoseLog(T, EXACT + OFF, "odom"))
    report = evaluated(found)
    made = report.pictures["path"]
    upper, lower = (ax for ax in made.axes if ax.get_xlabel() == "distance driven [m]")
    assert (upper.get_ylabel(), lower.get_ylabel()) == ("position error [mm]", "heading error [deg]")
    assert upper.lines[0].get_xydata() == pytest.approx(np.array([(0, 0), (1, 100), (2, 200)]))
    assert lower.lines[0].get_xydata() == pytest.approx(np.array([(0, 0), (1, 0), (2, 30)]))
    assert made.get_suptitle() == "odom: at most 200 mm off in 2.00 m"
    assert report.finding == made.get_suptitle()
    assert report.bounds == []


def test_an_evaluation_is_reported_with_the_bounds_that_it_was_given():
    found = dd.evaluate(dd.PoseLog(T, EXACT), dd.PoseLog(T, EXACT + OFF, "odom"))
    report = evaluated(found, Bounds(position=0.3, heading=0.25, position_per_metre=0.1))
    assert [str(bound) for bound in report.bounds] == [
        "ok     position off by: 0.2 <= 0.3 m",
        "BROKEN heading off by: 0.5236 <= 0.25 rad",
        "ok     position per metre off by: 0.1 <= 0.1 m",
    ]


def test_a_report_has_a_bound_for_each_drive():
    report = reported(Verdict("mine", (row("good", broken=()), row("bad"))))
    assert [(bound.name, bound.value, bound.limit) for bound in report.bounds] == [
        ("good: bounds broken", 0, 0), ("bad: bounds broken", 1, 0),
    ]  # fmt: skip
    assert report.finding == "mine: holds on 1 of 2 drives"
