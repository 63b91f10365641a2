"""Likely reasons: where two mistakes meet, where nothing moves, and where an answer is right but for its time."""

import math

import numpy as np
import pytest

import diffdrive_mj as dd
from diffdrive_mj.judging.causes import likely_reason
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


def test_of_a_robot_at_rest_nothing_can_be_said():
    still = Task("still", ROBOT, [0.0, 1.0, 2.0], np.zeros((3, 2)))
    assert likely_reason(still, np.array([[0, 0, 0], [0.1, 0, 0], [0.2, 0, 0.1]])) == ""


@pytest.mark.parametrize("case", cases(), ids=lambda case: case.name)
def test_answers_that_stand_still_are_no_trouble(case):
    """Hardly a reading is taken in, and some of the mistakes have nothing to be made on."""
    for answer in (np.zeros((len(case.t), 3)), np.tile(case.start, (len(case.t), 1))):
        likely_reason(case, answer)
