"""Bumps under one wheel: their geometry, and what they do to a drive."""

import math

import numpy as np
import pytest
from helpers import refused
from hypothesis import given
from strategies import numbers, sizes

import diffdrive_mj as dd
from diffdrive_mj.judging.bumps import bump_angle, over_bumps

ROBOT = dd.Robot.load("mismatched")


@given(sizes(0.01, 1.0), numbers(0.001, 0.9))
def test_a_wheel_swings_over_an_edge_by_twice_the_angle_of_its_chord(radius, share):
    """The hub is as far behind the edge at first as ahead of it at last; on the flat it would roll by that chord."""
    height = share * radius
    half_chord = math.sqrt(radius**2 - (radius - height) ** 2)
    turned = 2 * math.atan2(half_chord, radius - height)
    assert bump_angle(radius, height) == pytest.approx(turned - 2 * half_chord / radius, rel=1e-6, abs=1e-12)


def test_small_bumps_cost_by_the_power_of_three_halves():
    assert bump_angle(1.0, 1e-6) / bump_angle(1.0, 1e-8) == pytest.approx(1000, rel=1e-4)


def test_bumps_turn_the_path_where_they_lie_and_nowhere_else():
    t = np.linspace(0, 10, 1001)
    angles = np.outer(t, (0.91, 1.0)) * 5
    drive = dd.Drive(t, angles, dd.odometry.integrate(angles, ROBOT, start=(1.0, 2.0, 0.5)), name="mine")
    rough = over_bumps(drive, ROBOT, height=0.005, first=2.0, spacing=0.1, count=4)
    along = dd.metrics.travelled(drive.truth)
    change = rough.truth[:, 2] - drive.truth[:, 2]
    lost = ROBOT.right_radius * bump_angle(ROBOT.right_radius, 0.005)
    assert (change[along <= 2.0] == 0).all()
    assert change[along >= 2.41] == pytest.approx(-4 * lost / ROBOT.track_width)
    assert rough.name == "mine"
    assert (rough.wheel_angles == angles).all()
    assert (rough.truth[0] == drive.truth[0]).all()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"height": 0.2}, "must be below the radius of the wheel"),
        ({"height": 0.0}, "height = 0.0: must be positive"),
        ({"spacing": 0.0}, "spacing = 0.0: must be positive"),
        ({"count": -1}, "count = -1"),
    ],
)
def test_bumps_that_no_wheel_gets_over_are_refused(change, words):
    t = np.linspace(0, 1, 11)
    angles = np.outer(t, (1.0, 1.0))
    drive = dd.Drive(t, angles, dd.odometry.integrate(angles, ROBOT))
    with refused(ValueError, words):
        over_bumps(drive, ROBOT, **{"height": 0.01, "first": 0.0, "spacing": 0.1, "count": 3, **change})
