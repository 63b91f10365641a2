"""Verdicts: right odometry holds, wrong odometry does not, and the reason that is given is the one that was planted."""

import io
import math
import sys

import numpy as np
import pytest
from helpers import refused
from hypothesis import given
from strategies import numbers, robots

import diffdrive_mj as dd
from diffdrive_mj import _progress
from diffdrive_mj.judging.causes import distance_between
from diffdrive_mj.judging.tasks import Task
from diffdrive_mj.judging.verdict import Row, Verdict

ROBOT = dd.Robot(left_radius=0.1, right_radius=0.091, track_width=0.4)
START = (3.0, -2.0, 1.0)


def task(robot=ROBOT, start=START, period=0.05, truth=None):
    """A winding drive with turns both ways."""
    t = np.arange(0.0, 12.0, period)
    angles = np.stack([6 * t + 4 * np.sin(t), 6 * t - 4 * np.sin(t) + 2 * np.sin(2.3 * t)], axis=-1)
    return Task("winding", robot, t, angles, start, truth)


class Odometry:
    """A loop of its own, in which each mistake is one number or one line."""

    def __init__(self, robot, start, **mistakes):
        self.rl, self.rr, self.b = robot.left_radius, robot.right_radius, robot.track_width
        self.pose, self.last, self.m = list(start), None, mistakes

    def update(self, wheels, t):
        m = self.m
        left, right = wheels[::-1] if m.get("swapped") else wheels
        left, right = m.get("left", 1) * left, m.get("right", 1) * right
        if self.last is None:
            self.last = left, right
        rl, rr = m.get("radii", (self.rl, self.rr))
        dl, dr = rl * (left - self.last[0]), rr * (right - self.last[1])
        self.last = left, right
        distance, turn = m.get("far", 1) * (dl + dr) / 2, m.get("turn", 1) * (dr - dl) / self.b
        x, y, theta = self.pose
        ahead = m.get("ahead", 0.5) * turn
        half = turn / 2
        chord = distance * (math.sin(half) / half if half and not m.get("plain") else 1.0)
        answer = tuple(self.pose)
        self.pose = [x + chord * math.cos(theta + ahead), y + chord * math.sin(theta + ahead), theta + turn]
        if m.get("wrapped"):
            self.pose[2] = math.remainder(self.pose[2], 2 * math.pi)
        if not m.get("late"):
            answer = tuple(self.pose)
        return (*answer[:2], m.get("theta", 1) * answer[2])


def wrong(**mistakes):
    """A candidate with some mistakes."""

    class Mine(Odometry):
        def __init__(self, robot, start):
            others = {name: value for name, value in mistakes.items() if name != "start"}
            super().__init__(robot, mistakes.get("start", start), **others)

    return Mine


PLANTED = {
    "Euler": ({"ahead": 0.0, "plain": True}, "Euler"),
    "midpoint": ({"plain": True}, "midpoint"),
    "start": ({"start": (0.0, 0.0, 0.0)}, "the start pose is forgotten"),
    "start heading": ({"start": (3.0, -2.0, 0.0)}, "the heading at the start is forgotten"),
    "start position": ({"start": (0.0, 0.0, 1.0)}, "the position at the start is forgotten"),
    "swapped": ({"swapped": True}, "left and right are swapped"),
    "left reversed": ({"left": -1}, "the left wheel counts backwards"),
    "right reversed": ({"right": -1}, "the right wheel counts backwards"),
    "both reversed": ({"left": -1, "right": -1}, "both wheels count backwards"),
    "clockwise": ({"turn": -1}, "turns clockwise"),
    "left radius": ({"radii": (0.1, 0.1)}, "both wheels are taken for the left one"),
    "right radius": ({"radii": (0.091, 0.091)}, "both wheels are taken for the right one"),
    "mean radius": ({"radii": (0.0955, 0.0955)}, "both wheels are taken for the mean one"),
    "exchanged": ({"radii": (0.091, 0.1)}, "the radii of left and right are exchanged"),
    "late": ({"late": True}, "that of the reading before"),
    "degrees": ({"theta": 180 / math.pi}, "headings are in degrees"),
    "diameters": ({"radii": (0.2, 0.182)}, "wheels roll 2 times the right way (diameters for radii)"),
    "half track": ({"turn": 2}, "turns are 2 times the right ones (half of the track width for the whole)"),
    "no track": ({"turn": 0.4}, "the track width is missing"),
    "sum": ({"far": 2}, "a sum where the mean belongs"),
    "any factor": (
        {"far": 1.25, "turn": 0.9},
        "distances are 1.25 times the right ones and turns are 0.9 times the right ones",
    ),
}


@pytest.mark.parametrize("name", PLANTED)
@pytest.mark.parametrize("period", [0.05, 0.2])
def test_planted_mistakes_are_named(name, period):
    mistakes, said = PLANTED[name]
    verdict = dd.judge(wrong(**mistakes), [task(period=period)])
    assert not verdict.holds
    assert said in verdict.rows[0].reason
    assert said in str(verdict)


@given(robots, numbers(-100, 100), numbers(-100, 100), numbers(-3, 3))
def test_right_odometry_holds_whoever_wrote_it(robot, x, y, theta):
    for mistakes in ({}, {"wrapped": True}):
        verdict = dd.judge(wrong(**mistakes), [task(robot, (x, y, theta))])
        assert verdict.holds, str(verdict)
        assert verdict.rows[0].reason == ""


def test_single_precision_is_named():
    def single(wheel_angles, t, robot, start):
        poses = [np.array(start, dtype=np.float32)]
        for left, right in np.diff(wheel_angles, axis=0).astype(np.float32):
            dl, dr = np.float32(robot.left_radius) * left, np.float32(robot.right_radius) * right
            half = (dr - dl) / np.float32(robot.track_width) / np.float32(2)
            x, y, theta = poses[-1]
            chord = (dl + dr) / np.float32(2) * (np.sin(half) / half if half else np.float32(1))
            poses.append(
                np.array([x + chord * np.cos(theta + half), y + chord * np.sin(theta + half), theta + 2 * half])
            )
        return np.array(poses, dtype=np.float64)

    (row,) = dd.judge(single, [task(start=(1e4, 1e4, 0.0))]).rows
    assert not row.holds
    assert "single precision" in row.reason


def test_what_no_known_mistake_explains_has_no_reason():
    rng = np.random.default_rng(0)
    (row,) = dd.judge(lambda wheels, t, robot: rng.normal(size=(len(t), 3)), [task()]).rows
    assert not row.holds
    assert row.reason == ""


@pytest.mark.parametrize(
    ("angles", "start", "allowed"),
    [
        ((10.0, 10.0), (0, 0, 0), 1e-9),
        ((10.0, 0.0), (0, 0, 0), 0.5e-9),
        ((-10.0, 10.0), (0, 0, 0), 1e-9),
        ((10.0, 10.0), (2e6, 0, 0), 2e-6),
        ((0.0, 0.0), (0, -3.0, 0), 4e-12),
    ],
)
def test_arithmetic_may_be_off_by_a_billionth_of_the_way_or_by_what_coordinates_round_to(angles, start, allowed):
    robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
    (row,) = dd.judge(robot, [Task("one step", robot, [0.0, 1.0], [(0, 0), angles], start)]).rows
    assert row.allowed == pytest.approx(allowed, rel=1e-5)


def test_the_distance_is_the_way_of_the_truth():
    of = task()
    (row,) = dd.judge(ROBOT.replace(left_radius=0.2, right_radius=0.182), [task(truth=of.expected)]).rows
    assert float(row.drift.distance) == pytest.approx(float(dd.metrics.drift(of.expected, of.expected).distance))


def test_a_program_has_so_many_seconds_as_are_given():
    hanging = [sys.executable, "-c", "import time; time.sleep(60)"]
    (row,) = dd.judge(hanging, [task()], seconds=0.25).rows
    assert row.broken == ("did not end within 0.25 s of its input, after 0 of 240 answers",)


@pytest.mark.parametrize(
    ("bounds", "holds"),
    [
        ({}, True),
        ({"position": 0.0051}, True), ({"position": 0.0049}, False),
        ({"heading": 0.011}, True), ({"heading": 0.009}, False),
        ({"position": 0.0051, "heading": 0.009}, False),
    ],
)  # fmt: skip
def test_with_bounds_the_drift_from_the_truth_decides(bounds, holds):
    """Right arithmetic, and a truth that is 5 mm and 10 mrad elsewhere."""
    of = task()
    truth = of.expected + np.array([0.003, 0.004, 0.01])
    verdict = dd.judge(ROBOT, [task(truth=truth)], **bounds)
    assert verdict.holds is holds
    assert verdict.rows[0].arithmetic < 1e-12


def test_a_bound_per_metre_is_that_of_the_distance_driven():
    truth = task().expected + np.array([0.003, 0.004, 0.0])
    distance = float(dd.metrics.drift(truth, truth).distance)
    for factor, holds in ((1.01, True), (0.99, False)):
        bound = factor * 0.005 / distance
        assert dd.judge(ROBOT, [task(truth=truth)], position_per_metre=bound).holds is holds


def test_the_worst_drive_comes_first_and_failures_before_all():
    near, far = (task(truth=task().expected + np.array([off, 0, 0])) for off in (0.001, 0.1))
    tasks = [
        Task(name, of.robot, of.t, of.wheel_angles, of.start, of.truth) for name, of in (("near", near), ("far", far))
    ]

    def mine(wheel_angles, t, robot, start):
        return dd.odometry.integrate(wheel_angles, robot, start=start)

    lines = str(dd.judge(mine, tasks, position=0.01)).splitlines()
    assert lines[0] == "mine: holds on 1 of 2 drives"
    assert [line.split()[0] for line in lines[3:5]] == ["far", "near"]
    assert lines[5] == "far: position off by 100 mm, more than 10.0 mm"
    table = dd.judge(mine, tasks, position=0.01)._repr_html_()
    assert table.index("far") < table.index("near")


def test_a_candidate_that_fails_on_a_drive_is_judged_on_the_others():
    def fragile(wheel_angles, t, robot):
        if len(t) < 100:
            raise ValueError("too few")
        return dd.odometry.integrate(wheel_angles, robot)

    verdict = dd.judge(fragile, [task(period=0.05), task(period=0.2)])
    assert [row.holds for row in verdict.rows] == [True, False]
    assert verdict.rows[1].broken[0].startswith("raised ValueError: too few (test_verdict.py, line ")
    assert "none" in str(verdict)


def test_drives_are_judged_with_the_robot_that_is_given():
    of = task()
    drive = dd.Drive(of.t, of.wheel_angles, of.expected, name="log")
    assert dd.judge(ROBOT, [drive], robot=ROBOT).holds
    with refused(TypeError, "robot = None: must say what the odometry is told"):
        dd.judge(ROBOT, [drive])
    with refused(ValueError, "drives", "at least one"):
        dd.judge(ROBOT, [])
    with refused(TypeError, "drives"):
        dd.judge(ROBOT, 3)
    with refused(ValueError, "position = 0"):
        dd.judge(ROBOT, [of], position=0)


def test_a_heading_counts_as_the_way_of_a_wheel():
    """A quarter turn of a robot of 0.4 m: a wheel is 0.2 m times pi / 2 away; whole turns are none."""
    still = np.zeros((2, 3))
    for turn, off in ((math.pi / 2, 0.1 * math.pi), (2 * math.pi, 0.0)):
        turned = still + np.array([0, 0, turn])
        assert distance_between(task(), still, turned) == pytest.approx(off, abs=1e-12)
    assert distance_between(task(), still, still + np.array([3.0, 4.0, 0.0])) == pytest.approx(5.0)


def rows(*reasons):
    """Drives that do not hold, each with what explains it."""
    return tuple(Row(task(), None, 1.0, 0.1, None, ("off",), said) for said in reasons)


def test_of_reasons_that_are_as_good_the_one_that_explains_more_drives_comes_first():
    verdict = Verdict("mine", rows(("swapped", "backwards"), ("backwards",), ("backwards", "swapped")))
    assert [row.reason for row in verdict.rows] == ["backwards"] * 3
    # Numbers in them depend on the drive.
    verdict = Verdict("mine", rows(("swapped", "turns are 0.4 times"), ("turns are 0.16 times",)))
    assert [row.reason for row in verdict.rows] == ["turns are 0.4 times", "turns are 0.16 times"]
    # Nor does it matter in which order two are said.
    verdict = Verdict("mine", rows(("late", "a; and b"), ("b; and a",)))
    assert verdict.rows[0].reason == "a; and b"


@pytest.mark.parametrize(("unexplained", "said"), [(0, "swapped"), (3, "swapped"), (4, "")])
def test_a_reason_for_all_of_it_explains_a_quarter_at_least(unexplained, said):
    assert Verdict("mine", rows(("swapped",), *[()] * unexplained)).reason == said


def test_a_candidate_that_fails_at_a_reading_that_does_not_count_is_told_so():
    def divides(wheel_angles, t, robot, start):
        raise AssertionError

    class Rates:
        def __init__(self, robot):
            self.last = None

        def update(self, wheels, t):
            dt, self.last = 1.0 if self.last is None else t - self.last, t
            return 1.0 / dt, 0.0, 0.0

    of = Task("twice", ROBOT, [0.0, 1.0, 1.0, 2.0], np.zeros((4, 2)))
    (row,) = dd.judge(Rates, [of]).rows
    assert row.broken[0].startswith("raised ZeroDivisionError: float division by zero (test_verdict.py, line ")
    assert row.reason.startswith(
        "a reading that does not count is taken in (its time is not later than the one before)"
    )
    assert dd.judge(divides, [of]).rows[0].reason == ""  # nobody knows at which reading


def test_judging_that_takes_long_shows_how_far_it_has_come(monkeypatch):
    class Terminal(io.StringIO):
        def isatty(self):
            return True

    monkeypatch.setattr("sys.stderr", screen := Terminal())
    monkeypatch.setattr(_progress, "DELAY", 0.0)
    dd.judge(ROBOT, [task()] * 3)
    assert "judging robot" in screen.getvalue()
    assert "/3.00 " in screen.getvalue()


def drive(name, off, allowed, broken=("off",), drift=None):
    """What came of a drive, in figures that are given."""
    of = task()
    named = Task(name, of.robot, of.t, of.wheel_angles, of.start)
    return Row(named, of.expected, off, allowed, drift, broken)


def test_the_worst_drive_exceeds_most_what_it_is_allowed():
    long, short = drive("long", 1e-3, 1e-3), drive("short", 1e-6, 1e-9)
    assert [row.task.name for row in Verdict("mine", (long, short)).ranked] == ["short", "long"]
    less, more = drive("less", 0.5, 1.0, ()), drive("more", 0.7, 1.0, ())
    assert [row.task.name for row in Verdict("mine", (less, more)).ranked] == ["more", "less"]


def test_the_reason_for_all_of_it_is_that_of_most_drives():
    assert Verdict("mine", rows(("swapped",), ("backwards",), ("backwards",))).reason == "backwards"


def test_a_notebook_shows_the_table_with_its_header_and_the_candidate_above():
    first, *lines = Verdict("mine", (drive("bend", 0.25, 0.1, ("off by <much>",)),))._repr_html_().splitlines()
    assert first == "<table>"
    assert lines == [
        "<caption>mine</caption>",
        "<tr><th>drive</th><th>arithmetic</th><th>drift</th><th>heading</th><th>broken</th></tr>",
        "<tr><td>bend</td><td>250 mm</td><td></td><td></td><td>off by &lt;much&gt;</td></tr>",
        "</table>",
    ]


@pytest.mark.parametrize("unit", ["rad", "ticks"])
def test_readings_are_in_the_unit_that_is_asked_for(unit):
    told = []

    def mine(readings, t, header):
        told.append(header["unit"])
        return task().as_read(unit).expected

    assert dd.judge(mine, [task()], unit=unit).holds
    assert told == [unit]
