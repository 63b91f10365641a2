"""Mistakes made on purpose: each by its own formula, on a step or on a reading."""

import math

import numpy as np
import pytest

import diffdrive_mj as dd
from diffdrive_mj.judging import mistakes
from diffdrive_mj.judging.cases import exact_case
from diffdrive_mj.judging.tasks import Task
from diffdrive_mj.parts import WheelEncoder

ROBOT = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4, encoder=WheelEncoder(ticks_per_revolution=720.0))
TASK = Task("any", ROBOT, [0.0, 1.0], [(0, 0), (1, 2)])
SECONDS = np.ones(3)


def begins(found, words):
    """The one mistake whose words begin so."""
    (stages,) = [stages for said, stages in found.items() if said.startswith(words)]
    return stages


CHORD = 2.0 * math.sin(0.2) / 0.2


@pytest.mark.parametrize(
    ("words", "theta", "far", "along"),
    [
        ("steps are taken along the heading before", 0.3, 2.0, 0.3),
        ("steps are chords as long", 0.3, 2.0, 0.5),
        ("steps are taken along the heading after", 0.3, 2.0, 0.7),
        ("steps are taken along the mean of the directions", 0.3, 2.0 * math.cos(0.2), 0.5),
        ("headings on both sides of 180", math.pi - 0.1, CHORD, 0.1),
        ("headings on both sides of zero", -0.1, CHORD, math.pi + 0.1),
        ("sine and cosine are exchanged", 0.3, CHORD, math.pi / 2 - 0.5),
        ("y grows to the right", 0.3, CHORD, -0.5),
        ("sine and cosine get degrees", 0.3, CHORD, 0.5 * 180 / math.pi),
    ],
)
def test_a_step_of_two_metres_and_four_tenths_of_a_radian(words, theta, far, along):
    first, last = begins(mistakes._PATHS, words).path(np.array([(2.0, 0.4)]), np.array([5.0, 7.0, theta]))
    assert first.tolist() == [5.0, 7.0, theta]
    expected = [5.0 + far * math.cos(along), 7.0 + far * math.sin(along), theta + 0.4]
    assert last == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize(
    ("words", "read"),
    [
        ("left and right are swapped", [(2, 1), (5, 3)]),
        ("the left wheel counts backwards", [(-1, 2), (-3, 5)]),
        ("the right wheel counts backwards", [(1, -2), (3, -5)]),
        ("both wheels count backwards", [(-1, -2), (-3, -5)]),
        ("the left wheel is read for both", [(1, 1), (3, 3)]),
        ("the right wheel is read for both", [(2, 2), (5, 5)]),
        ("the left wheel's readings are one behind", [(1, 2), (1, 5)]),
        ("the right wheel's readings are one behind", [(1, 2), (3, 2)]),
    ],
)
def test_readings_of_the_wrong_wheel(words, read):
    wheels = begins(mistakes._WHEELS, words).wheels
    assert wheels(np.array([(1.0, 2.0), (3.0, 5.0)])).tolist() == [list(map(float, row)) for row in read]


@pytest.mark.parametrize(
    ("what", "radians", "ticks"), [("turns", 2 * math.pi, 720), ("radians", 1.0, 360 / math.pi), ("degrees", None, 2)]
)
def test_readings_are_cut_to_whole_turns_radians_and_degrees(what, radians, ticks):
    whole = radians or math.pi / 180
    case = exact_case("ticks", "", ROBOT, [0, 1], [(0, 0), (9, 9)], (0, 0, 0), unit="ticks")
    for task, unit in ((TASK, whole), (case, ticks)):
        cut = begins(dict(mistakes._numbers(task)), f"what the wheels have turned is cut to whole {what}").wheels
        assert cut(unit * np.array([0.9, 1.2, 7.8, -2.3])) == pytest.approx(unit * np.array([0, 1, 7, -2]), rel=1e-12)


def test_ways_of_wheels_are_cut_to_millimetres():
    """Of a track of 0.4 m: wheels of 3.7 and 11.9 mm, and of -2.6 mm both."""
    cut = begins(dict(mistakes._numbers(TASK)), "each way of a wheel is cut").motion
    ds, turn = cut(np.array([0.0078, -0.0026]), np.array([0.0205, 0.0]), SECONDS[:2])
    assert ds == pytest.approx([0.007, -0.002], abs=1e-15)
    assert turn == pytest.approx([0.02, 0.0], abs=1e-15)


@pytest.mark.parametrize(
    ("words", "distances", "degrees"),
    [
        ("each distance is cut", [3.0, 3.0, -1.0], [0.4, 0.7, -1.6]),
        ("each distance is rounded", [3.0, 4.0, -2.0], [0.4, 0.7, -1.6]),
        ("each turn is cut", [3.3, 3.7, -1.6], [0.0, 0.0, -1.0]),
        ("each turn is rounded", [3.3, 3.7, -1.6], [0.0, 1.0, -2.0]),
    ],
)
def test_steps_are_cut_and_rounded(words, distances, degrees):
    motion = begins(mistakes._MOTIONS, words).motion
    ds, turn = motion(np.array([0.0033, 0.0037, -0.0016]), np.radians([0.4, 0.7, -1.6]), SECONDS)
    assert ds == pytest.approx(np.array(distances) / 1e3, abs=1e-15)
    assert np.degrees(turn) == pytest.approx(degrees, abs=1e-12)
