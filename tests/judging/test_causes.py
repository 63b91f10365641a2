"""Likely reasons: where two mistakes meet, where nothing moves, and where an answer is right but for its time."""

import dataclasses
import math

import numpy as np
import pytest

import diffdrive_mj as dd
from diffdrive_mj.judging import causes
from diffdrive_mj.judging.cases import exact_case
from diffdrive_mj.judging.causes import likely_reason, reason_of_failure
from diffdrive_mj.judging.stages import Stages
from diffdrive_mj.judging.suite import cases
from diffdrive_mj.judging.tasks import Task
from diffdrive_mj.kinematics import body_twist
from diffdrive_mj.odometry import accumulate

ROBOT = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
T = np.arange(0.0, 8.0, 0.05)
TASK = Task("bend", ROBOT, T, np.stack([6 * T + np.sin(T), 5 * T], axis=-1), start=(3.0, -2.0, 1.0))


def by_factors(far, turn):
    """Distances and turns that are wrong by factors."""
    motion = body_twist(np.diff(TASK.wheel_angles, axis=0), ROBOT)
    return accumulate(motion * (far, turn), "arc", TASK.start)


def test_answers_a_reading_early_and_late():
    late = np.concatenate([TASK.expected[:1], TASK.expected[:-1]])
    early = np.concatenate([TASK.expected[1:], TASK.expected[-1:]])
    assert likely_reason(TASK, late).startswith("each pose is that of the reading before")
    assert likely_reason(TASK, early) == "each pose is that of the reading after"


@pytest.mark.parametrize(
    ("far", "turn", "said"),
    [
        (1.0, 0.5, "turns are 0.5 times the right ones (the track width twice)"),
        (1.0, 1.01, "turns are 1.01 times the right ones (a track width of 0.396 m, where 0.4 m is right)"),
        (2.0, 1.0, "distances are 2 times the right ones (a sum where the mean belongs)"),
        (2.0, 2.0, "wheels roll 2 times the right way (diameters for radii)"),
        (1 / math.pi, 1 / math.pi, "wheels roll 0.3183 times the right way (pi is missing)"),
        (0.5, -1.0, "distances are 0.5 times the right ones (half of the mean) and turns are -1 times the right "
                    "ones (the sign is wrong)"),
    ],
)  # fmt: skip
def test_factors_are_named_for_what_they_are_of(far, turn, said):
    assert likely_reason(TASK, by_factors(far, turn)) == said


UNEQUAL = dd.Robot(left_radius=0.1, right_radius=0.08, track_width=0.37)
BENT = Task("bent", UNEQUAL, T, np.stack([6 * T + np.sin(T), 5 * T + 2 * np.cos(T)], axis=-1), start=(3.0, -2.0, 1.0))
TICK = 2 * math.pi / BENT.ticks_per_revolution


def said_of(task, far, turn=None):
    """What is said of distances and turns that are wrong by factors, or of wheels."""
    motion = body_twist(np.diff(task.wheel_angles, axis=0), task.robot)
    return likely_reason(task, accumulate(motion * (far, far if turn is None else turn), "arc", task.start))


@pytest.mark.parametrize(
    ("factor", "shown", "words"),
    [
        (2.0, "2", "diameters for radii"), (0.5, "0.5", "half of the radii"),
        (1 / (2 * math.pi), "0.1592", "2 pi is missing"), (TICK, "0.001534", "radians for ticks"),
        (1 / 0.1, "10", "the wheel radius is missing"), (1 / 0.08, "12.5", "the wheel radius is missing"),
        (1 / 0.09, "11.11", "the wheel radius is missing"),
        (4.0, "4", "edges of an encoder are counted four times"),
        (0.25, "0.25", "one of an encoder's four edges is counted"), (180 / math.pi, "57.3", "degrees for radians"),
        (math.pi / 180, "0.01745", "radians for degrees"), (3.14 / math.pi, "0.999493", "pi is taken for 3.14"),
        (math.pi / 3.14, "1.00051", "pi is taken for 3.14"), (22 / 7 / math.pi, "1.0004", "pi is taken for 22 / 7"),
        (math.pi / (22 / 7), "0.999598", "pi is taken for 22 / 7"), (1.3, "1.3", ""), (1.0123, "1.012", ""),
        (0.99912, "0.99912", ""), (1.99912, "1.999", ""),
    ],
)  # fmt: skip
def test_what_wheels_are_wrong_by_is_named(factor, shown, words):
    expected = f"wheels roll {shown} times the right way{f' ({words})' * bool(words)}"
    assert said_of(BENT, factor) == expected
    line = Task("line", UNEQUAL, T, np.stack([5 * T, 6.25 * T], axis=-1), start=(3.0, -2.0, 1.0))
    if factor != 1 / (2 * math.pi):
        assert said_of(line, factor) in (expected, "")


@pytest.mark.parametrize(
    ("far", "turn", "words"),
    [
        (0.0, 1.0, "distances are lost"), (1.0, 0.0, "turns are lost"),
        (1.0, 0.37, "turns are 0.37 times the right ones (the track width is missing)"),
        (1.0, 180 / math.pi, "turns are 57.3 times the right ones (degrees for radians)"),
        (1.7, 0.5, "distances are 1.7 times the right ones and turns are 0.5 times the right ones (the track width "
                   "twice)"),
    ],
)  # fmt: skip
def test_what_distances_and_turns_are_wrong_by_is_named(far, turn, words):
    assert said_of(BENT, far, turn) == words


@pytest.mark.parametrize(
    ("left", "right", "words"),
    [
        (1.02, 1.0, "the left wheel rolls 1.02 times the right way"),
        (1.0, 2.0, "the right wheel rolls 2 times the right way (diameters for radii)"),
        (0.5, 1.3, "the left wheel rolls 0.5 times the right way (half of the radii) and the right wheel rolls 1.3 "
                   "times the right way"),
    ],
)  # fmt: skip
def test_a_wheel_that_is_wrong_by_a_factor_is_named(left, right, words):
    wrong = dd.odometry.integrate(BENT.wheel_angles * (left, right), UNEQUAL, start=BENT.start)
    assert likely_reason(BENT, wrong) == words


def test_of_a_robot_at_rest_nothing_can_be_said():
    still = Task("still", ROBOT, [0.0, 1.0, 2.0], np.zeros((3, 2)))
    assert likely_reason(still, np.array([[0, 0, 0], [0.1, 0, 0], [0.2, 0, 0.1]])) == ""


@pytest.mark.parametrize("case", cases(), ids=lambda case: case.name)
def test_answers_that_stand_still_are_no_trouble(case):
    """Hardly a reading is taken in, and some of the mistakes have nothing to be made on."""
    for answer in (np.zeros((len(case.t), 3)), np.tile(case.start, (len(case.t), 1))):
        likely_reason(case, answer)


AHEAD = exact_case(
    "ahead", "", ROBOT, np.arange(6.0), np.outer(np.arange(6.0), (10.0, 10.0)), (0, 0, 0), tolerance=0.25
)
LEFT = np.array([0.0, 1.0, 0.0])


@pytest.fixture
def one_mistake(monkeypatch):
    """The only mistake that is known is to answer a metre too far to the left."""
    left = Stages(answer=lambda poses: poses + LEFT)
    monkeypatch.setattr(causes, "mistakes_on", lambda task: {"to the left": left})
    monkeypatch.setattr(causes, "fitted", lambda *_: ())


@pytest.mark.usefixtures("one_mistake")
def test_a_mistake_explains_what_is_fifty_times_closer_to_it_than_to_the_right_poses():
    case = dataclasses.replace(AHEAD, tolerance=1e-9)
    for times, said in ((48.0, ""), (52.0, "to the left")):
        assert likely_reason(case, case.poses + LEFT * times / (times + 1)) == said


@pytest.mark.usefixtures("one_mistake")
def test_what_is_off_by_the_tolerance_itself_is_the_mistake_and_not_its_digits():
    answers = AHEAD.poses + LEFT
    answers[2, 1] += 2.0**-10
    assert likely_reason(dataclasses.replace(AHEAD, tolerance=2.0**-10), answers) == "to the left"
    assert "single precision" in likely_reason(dataclasses.replace(AHEAD, tolerance=2.0**-11), answers)


def test_what_comes_as_close_as_it_must_and_no_closer_is_not_good():
    found = [(1.0, "a"), (3.0, "b"), (3.5, "c")]
    assert causes._good(found, 1.0, AHEAD) == ()
    assert causes._good(found, 2.0, AHEAD) == ("a",)
    assert causes._good(found, 9.0, AHEAD) == ("a", "b")
    assert causes._good([], 9.0, AHEAD) == ()


def test_a_failure_is_not_put_down_to_a_reading_that_is_not_known_to_come_before():
    case = exact_case("late", "", ROBOT, [0.0, 1.0, 2.0], [(np.nan, 0), (0, 0), (1, 1)], (0, 0, 0))
    assert reason_of_failure(case, None) == ""
    assert "it is not a number" in reason_of_failure(case, 0)
