"""To a goal without a compass, in the physics: a straight metre shows the course, the missing turn follows from it."""

import numpy as np
import pytest

import diffdrive_mj as dd
from diffdrive_mj.estimation import course
from diffdrive_mj.estimation.course_tracker import CourseTracker
from diffdrive_mj.judging.rolling import simulate_rolling
from diffdrive_mj.maneuvers import Segment, sequence
from diffdrive_mj.report import chance

START, METRE, AWAY, NOISE = (1.0, 2.0, 2.2), 1.0, 3.0, 0.01
GOALS, RUNS = 32, 10_000


def distance(recording, robot):
    return dd.kinematics.body_twist(recording.wheel_angles, robot)[..., -1, 0]


@pytest.fixture(scope="module")
def drives():
    """The fixes of a straight metre again and again, and drives to goals all around, the first of them in physics."""
    robot, rng = dd.Robot.load("matched"), np.random.default_rng(0)
    first = simulate_rolling(robot, dd.maneuvers.straight(robot, speed=0.5, distance=METRE), start=START)
    stop, driven = first.truth[-1], distance(first, robot)
    fixes = np.array([START[:2], stop[:2]])[:, None] + NOISE * rng.normal(size=(2, RUNS, 2))
    # Three standard deviations flag one straight drive in 400; who cannot trust a course does not go on.
    there, here = fixes[:, course.from_fixes(*fixes, travelled=driven, fix_noise=NOISE).straight]
    around = 2 * np.pi * np.arange(len(here)) / GOALS
    goals = stop[:2] + AWAY * dd.se2.rotate((1.0, 0.0), around)
    seen = course.from_fixes(there, here, driven, fix_noise=NOISE)
    turns, lengths = course.missing_angle(seen.yaw, here, goals), np.hypot(*(goals - here).T)
    legs = [[[Segment(0, t, abs(t))], [Segment(w, 0, w)]] for t, w in zip(turns[:GOALS], lengths, strict=False)]
    commands = [sequence(robot, both) for both in legs]
    longest = max(each.duration for each in commands)
    second = simulate_rolling(
        [robot] * GOALS, [each.extended(longest) for each in commands], sample_rate=10.0, start=stop
    )
    ends = stop[:2] + lengths[:, None] * dd.se2.rotate((1.0, 0.0), stop[2] + turns)
    # The second fix errs in the position as in the course: where the robot goes on ahead, the two add up.
    law = NOISE * np.sqrt(2 + 2 * (AWAY / METRE) ** 2 + 2 * AWAY / METRE * np.cos(around - stop[2]))
    return {
        "stop": stop, "driven": driven, "there": there, "here": here, "goals": goals, "ends": ends, "law": law,
        "arrived": second.truth[:, -1], "gone": distance(second, robot),
    }  # fmt: skip


def test_the_robot_ends_where_the_geometry_says(drives):
    off = np.hypot(*(drives["arrived"][:, :2] - drives["ends"][:GOALS]).T)
    assert off.max() < 0.2e-3


def test_goals_are_missed_by_what_the_fixes_are_off(drives):
    over_law = np.hypot(*(drives["ends"] - drives["goals"]).T) / drives["law"]
    assert abs(chance.rms(over_law) - 1) < chance.rms_tolerance(len(over_law)) + 0.01
    assert chance.rms(drives["law"]) == pytest.approx(0.0447, rel=0.01)


def test_the_second_drive_makes_the_course_as_sure_as_the_tracker_says(drives):
    rng = np.random.default_rng(1)
    errors = []
    for n, pose in enumerate(drives["arrived"]):
        here, goal = drives["here"][n], drives["goals"][n]
        tracker = CourseTracker()
        tracker.update(course.from_fixes(drives["there"][n], here, drives["driven"], fix_noise=NOISE))
        tracker.turn(tracker.missing_angle(here, goal))
        first_std = tracker.std
        before, after = [drives["stop"][:2], pose[:2]] + NOISE * rng.normal(size=(2, 2))
        again = course.from_fixes(before, after, drives["gone"][n], fix_noise=NOISE)
        if again.straight:
            tracker.update(again)
            assert tracker.std < first_std / 3
        errors.append(float(dd.se2.wrap_angle(tracker.yaw - pose[2])) / tracker.std)
    assert abs(chance.rms(errors) - 1) < chance.rms_tolerance(GOALS)
