"""Factors: what each is known for, how it reads, and which are tried on distances, turns and wheels."""

import math

import numpy as np
import pytest

import diffdrive_mj as dd
from diffdrive_mj.judging import _factors as factors
from diffdrive_mj.judging.stages import arcs
from diffdrive_mj.judging.tasks import Task
from diffdrive_mj.parts import WheelEncoder

ROBOT = dd.Robot(
    left_radius=0.125, right_radius=0.25, track_width=0.4, encoder=WheelEncoder(ticks_per_revolution=1000.0)
)
TASK = Task("bend", ROBOT, [0.0, 1.0, 2.0, 3.0], [(0, 0), (4, 3), (6, 5), (8, 8)])
MOTION = np.array([(0.625, 0.625), (0.375, 0.625), (0.5, 1.25)])


@pytest.mark.parametrize(
    ("factor", "words"),
    [
        (2.0, "diameters for radii"), (0.5, "half of the radii"), (0.3183098862, "pi is missing"),
        (0.1591549431, "2 pi is missing"), (159.1549431, "ticks for radians"), (0.006283185307, "radians for ticks"),
        (8.0, "the wheel radius is missing"), (4.0, "edges of an encoder are counted four times"),
        (16 / 3, "the wheel radius is missing"), (0.25, "one of an encoder's four edges is counted"),
        (57.295779513, "degrees for radians"), (0.01745329252, "radians for degrees"), (1000.0, "mm for m"),
        (100.0, "cm for m"), (-1.0, "the sign is wrong"), (0.9994930426, "pi is taken for 3.14"),
        (1.0005072145, "pi is taken for 3.14"), (1.0004024994, "pi is taken for 22 / 7"),
        (0.9995976625, "pi is taken for 22 / 7"),
    ],
)  # fmt: skip
def test_factors_of_wheels_are_known_for_something(factor, words):
    known = factors._of_wheels(TASK)
    assert factors._known(factor, known) == f" ({words})"
    assert factors._known(factor * 1.0002, known) != f" ({words})"


def test_a_right_radius_that_is_missing_is_known():
    robot = ROBOT.replace(left_radius=0.3, right_radius=0.15)
    known = factors._of_wheels(Task("any", robot, TASK.t, TASK.wheel_angles))
    assert factors._known(1 / 0.15, known) == " (the wheel radius is missing)"
    assert factors._known(2 / 0.15, known) == ""


@pytest.mark.parametrize(
    ("factor", "shown"),
    [(0.99912, "0.99912"), (1.00051, "1.00051"), (1.0123, "1.012"), (2.0004, "2"), (1.99962, "2"), (57.2958, "57.3")],
)
def test_a_factor_near_one_has_six_digits_and_another_four(factor, shown):
    assert factors._times(factor) == shown


@pytest.mark.parametrize(
    ("far", "turn", "words"),
    [
        (0.0, 1.0, "distances are lost"), (1.0, 0.0, "turns are lost"),
        (2.0, 1.0, "distances are 2 times the right ones (a sum where the mean belongs)"),
        (1.3, 1.3, "wheels roll 1.3 times the right way"),
    ],
)  # fmt: skip
def test_what_is_lost_or_scaled_is_tried(far, turn, words):
    changed = MOTION * (far, turn)
    tried = dict(factors.by_factors(TASK, arcs(changed, np.zeros(3)), changed[:, 1], MOTION))
    assert tried[words] == pytest.approx(changed, abs=1e-12)


def test_where_all_is_lost_no_factor_is_tried():
    tried = list(factors.by_factors(TASK, np.zeros((4, 3)), np.zeros(3), MOTION))
    assert not [words for words, _ in tried if "lost" in words]


def test_a_ratio_is_that_of_most_and_leaves_out_what_hardly_moves():
    assert factors.ratio(np.array([2.0, 4.0, 9.0, 1.0]), np.array([1.0, 2.0, 3.0, 1e-4])) == 2.0
    assert factors.ratio(np.ones(2), np.zeros(2)) == 1.0
    assert math.isclose(factors.ratio(MOTION[:, 0] / 3, MOTION[:, 0]), 1 / 3)
