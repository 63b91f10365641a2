"""Mistakes with clocks, counters and readings that do not count: each by its own numbers."""

import numpy as np
import pytest

import diffdrive_mj as dd
from diffdrive_mj.judging import _mistakes_of_readings as mistakes
from diffdrive_mj.judging.cases import exact_case
from diffdrive_mj.judging.tasks import Task

ROBOT = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
NAN = float("nan")


def test_a_first_step_that_is_timed_from_zero_is_longer_by_the_stamp():
    wheels = [(0, 0), (10, 10), (20, 20)]
    ((words, stages),) = mistakes._first_stamp(Task("late", ROBOT, [3.0, 4.0, 5.0], wheels))
    assert words.startswith("the first step is timed from a stamp of zero")
    assert stages.solve(Task("late", ROBOT, [3.0, 4.0, 5.0], wheels))[:, 0] == pytest.approx([0.0, 4.0, 5.0])
    assert not list(mistakes._first_stamp(Task("at zero", ROBOT, [0.0, 1.0, 2.0], wheels)))
    assert not list(mistakes._first_stamp(Task("one", ROBOT, [3.0], wheels[:1])))


STEPS = np.array([-40000.0, -1.0, 5.0, 40000.0])


@pytest.mark.parametrize(
    ("words", "steps"),
    [
        ("wraps of the counter are not undone", [-40000, -1, 5, 40000]),
        ("wraps are undone forwards only", [25536, -1, 5, 40000]),
        ("wraps are undone backwards only", [-40000, -1, 5, -25536]),
        ("steps are taken for unsigned ones:", [25536, 65535, 5, 40000]),
        ("steps are taken for unsigned ones of 32 bits", [4294927296, 4294967295, 5, 40000]),
        ("the motion across a wrap is left out", [0, -1, 5, 0]),
        ("wraps are undone at 8 bits", [-64, -1, 5, 64]),
        ("wraps are undone at 15 bits", [-7232, -1, 5, 7232]),
        ("wraps are undone at 24 bits", [-40000, -1, 5, 40000]),
        ("wraps are undone at 31 bits", [-40000, -1, 5, 40000]),
        ("wraps are undone at 32 bits", [-40000, -1, 5, 40000]),
    ],
)
def test_steps_of_a_counter_of_16_bits(words, steps):
    (stages,) = [stages for said, stages in mistakes._wraps(16) if said.startswith(words)]
    assert stages.steps(STEPS).tolist() == steps


def test_wraps_at_24_bits():
    """Steps of 10 million counts, of a counter of 32 bits."""
    (stages,) = [stages for said, stages in mistakes._wraps(32) if said.startswith("wraps are undone at 24 bits")]
    assert stages.steps(np.array([1e7, -1e7])).tolist() == [1e7 - 2**24, 2**24 - 1e7]


@pytest.mark.parametrize(
    ("bits", "kind", "kept"),
    [
        (8, "unsigned", [44, 216, 112, 255]),
        (8, "signed", [44, -40, 112, -1]),
        (16, "unsigned", [300, 65496, 4464, 65535]),
        (16, "signed", [300, -40, 4464, -1]),
        (32, "unsigned", [300, 2**32 - 40, 70000, 2**32 - 1]),
        (32, "signed", [300, -40, 70000, -1]),
    ],
)
def test_counts_that_are_kept_in_too_few_bits(bits, kind, kept):
    stages = dict(mistakes._narrow())[f"counts are kept in {bits} bits, {kind}: keep all of their bits"]
    assert stages.wheels(np.array([300.0, -40.0, 70000.0, -1.0])).tolist() == kept
    assert stages.steps(np.array([2.0**40])).tolist() == [2.0**40]


def test_readings_that_do_not_count_but_are_taken_in():
    """The second has no left wheel, the fourth the time of the third, and the fifth an earlier one."""
    wheels = [(0, 0), (NAN, 1), (2, 2), (3, 3), (4, 4), (5, 5)]
    case = exact_case("all", "", ROBOT, [0.0, 1.0, 2.0, 2.0, 1.5, 3.0], wheels, (0, 0, 0))
    counted = [
        (words.split(":")[0], "".join(str(int(c)) for c in stages.counts)) for words, stages in mistakes._faults(case)
    ]
    assert counted == [
        ("readings at the time of the one before are taken in", "101101"),
        ("readings are taken in whose time is not later than that of the last one", "101111"),
        ("the motion of readings at the time of the one before is lost", "101101"),
        ("the motion of readings at the time of the one before is lost", "101111"),
        ("the motion across readings that do not count is lost", "101001"),
        ("readings that are no numbers are taken for zero", "111001"),
    ]
