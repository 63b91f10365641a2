import math

import numpy as np
import pytest
from helpers import refused
from hypothesis import given
from hypothesis import strategies as st
from strategies import angles, numbers, sizes

from diffdrive_mj import se2
from diffdrive_mj.estimation import course
from diffdrive_mj.estimation.course_noise import end_std
from diffdrive_mj.estimation.course_tracker import CourseTracker


def off(a, b):
    """How far two directions are apart."""
    return np.abs(se2.wrap_angle(np.subtract(a, b)))


def straight(yaw, *, length=1.0, fix_noise=0.01):
    """The course of a straight drive."""
    return course.from_fixes((0, 0), (length * np.cos(yaw), length * np.sin(yaw)), length, fix_noise=fix_noise)


def test_the_first_drive_is_the_course():
    tracker = CourseTracker()
    assert tracker.std == np.inf
    tracker.turn(1.0)
    assert tracker.std == np.inf
    result = straight(2.5)
    assert tracker.update(result) == tracker.yaw == result.yaw
    assert math.isclose(tracker.std, result.std)


def test_a_heading_that_is_a_random_walk_is_less_certain_from_the_start():
    tracker = CourseTracker(random_walk=1e-3)
    tracker.update(straight(2.5, length=2.0))
    assert math.isclose(tracker.std, end_std(0.01, 2.0, 1e-3), rel_tol=1e-4)


@given(
    st.lists(st.tuples(numbers(-0.2, 0.2), sizes(0.3, 5), sizes(1e-3, 0.03), angles), min_size=1, max_size=8),
    numbers(-np.pi, np.pi),
)
def test_the_tracker_is_the_weighted_mean(legs, yaw):
    """Without a random walk: every course, turned along to the end, weighted by the inverse of its variance."""
    tracker, heading, deviations, weights = CourseTracker(), yaw, [], []
    for error, length, noise, turn in legs:
        leg = straight(heading + error, length=length, fix_noise=noise)
        tracker.update(leg)
        tracker.turn(turn)
        heading += turn
        deviations.append(error)
        weights.append(1 / leg.std**2)
    assert off(tracker.yaw, heading + np.average(deviations, weights=weights)) <= 1e-11
    assert -np.pi < tracker.yaw <= np.pi
    assert math.isclose(tracker.std, 1 / math.sqrt(sum(weights)), rel_tol=1e-9)


@pytest.mark.parametrize("error", [0.01, 0.5, 1.5])
def test_the_mean_is_taken_on_the_circle(error):
    """Two courses on either side of west: the mean of +-179 degrees is 180, not 0."""
    tracker = CourseTracker()
    tracker.update(straight(np.pi - error))
    tracker.update(straight(-np.pi + error))
    assert off(tracker.yaw, np.pi) <= 1e-14
    tracker.update(straight(-np.pi + error + 0.3))
    assert off(tracker.yaw, -np.pi + error / 3 + 0.1) <= 1e-14
    assert -np.pi < tracker.yaw <= np.pi


@given(
    st.lists(st.tuples(numbers(-0.1, 0.1), sizes(0.3, 5), numbers(-3, 3), sizes(1e-4, 0.03)), min_size=1, max_size=6),
    sizes(1e-6, 1e-2),
    sizes(3e-3, 0.03),
)
def test_the_tracker_is_the_best_linear_estimate(legs, random_walk, noise):
    """With a random walk and uncertain turns: the generalised least squares of all the drives at once.

    In a drive the random walk W and its mean over the way share q w / 2; all the rest is independent.
    """
    tracker, heading = CourseTracker(random_walk), 0.3
    drives = len(legs)
    # Unknowns but for the first heading: W and the turn's error of every drive, as rows of a joint covariance.
    covariance, seen, final = np.zeros((3 * drives, 3 * drives)), np.zeros((drives, 3 * drives)), np.zeros(3 * drives)
    errors, fix_variance = [], []
    for n, (error, length, turn, turn_std) in enumerate(legs):
        leg = straight(heading + error, length=length, fix_noise=noise)
        tracker.update(leg)
        tracker.turn(turn, turn_std)
        heading += turn
        walk, mean, slip = 3 * n, 3 * n + 1, 3 * n + 2
        covariance[np.ix_([walk, mean], [walk, mean])] = random_walk * length * np.array([[1, 1 / 2], [1 / 2, 1 / 3]])
        covariance[slip, slip] = turn_std**2
        seen[n, mean] = 1
        seen[n + 1 :, [walk, slip]] = 1
        final[[walk, slip]] = 1
        errors.append(error)
        fix_variance.append(leg.std**2)
    inner = np.linalg.inv(seen @ covariance @ seen.T + np.diag(fix_variance))
    ones = np.ones(drives)
    first = ones @ inner @ errors / (ones @ inner @ ones)
    gain = final @ covariance @ seen.T @ inner
    expected = first + gain @ (np.array(errors) - first)
    variance = (
        final @ covariance @ final - gain @ seen @ covariance @ final + (1 - gain @ ones) ** 2 / (ones @ inner @ ones)
    )
    assert off(tracker.yaw, heading + expected) <= 1e-9
    assert math.isclose(tracker.std, math.sqrt(variance), rel_tol=1e-7)


def test_fixes_without_noise_are_believed():
    tracker = CourseTracker()
    for yaw in (1.0, 1.25):
        tracker.update(straight(yaw, fix_noise=0))
        assert math.isclose(tracker.yaw, yaw)
        assert tracker.std == 0


def test_the_tracker_knows_the_turn_to_its_goal():
    tracker = CourseTracker()
    tracker.update(straight(3.0))
    tracker.turn(tracker.missing_angle((1, 1), (-2, -3)))
    assert off(tracker.yaw, math.atan2(-4, -3)) <= 1e-14
    assert abs(tracker.missing_angle((1, 1), (-2, -3))) <= 1e-14


# Bad input


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: CourseTracker(random_walk=-1), ("random_walk = -1", "not be negative")),
        (lambda: CourseTracker(random_walk=math.nan), ("random_walk", "finite")),
    ],
)
def test_bad_values_are_refused(call, words):
    with refused(ValueError, *words):
        call()


def test_the_tracker_refuses_what_it_cannot_use():
    tracker = CourseTracker()
    with refused(ValueError, "not known before the first straight drive"):
        _ = tracker.yaw
    with refused(ValueError, "not known"):
        tracker.missing_angle((0, 0), (1, 1))
    with refused(ValueError, "must be straight"):
        tracker.update(course.from_fixes((0, 0), (0.5, 0), 1.0, fix_noise=0.01))
    with refused(ValueError, "single drive"):
        tracker.update(course.from_fixes((0, 0), np.ones((2, 2)), 1.4, fix_noise=0.1))
    with refused(TypeError, "must be a Course"):
        tracker.update(1.57)
    assert tracker.std == np.inf
    tracker.update(straight(1.0))
    for call in (
        lambda: tracker.turn(math.nan),
        lambda: tracker.turn(1.0, std=-0.1),
        lambda: tracker.turn(1.0, math.inf),
    ):
        with refused(ValueError):
            call()
    with refused(ValueError, "goal[1] = nan"):
        tracker.missing_angle((0, 0), (1, math.nan))
    with refused(ValueError, "goal has shape (1, 2)"):
        tracker.missing_angle((0, 0), [(1, 2)])
    with refused(ValueError, "coincide"):
        tracker.missing_angle((1, 2), (1, 2))
    assert tracker.yaw == straight(1.0).yaw
