"""Gravity and slopes: what falls, and what a slope does to odometry."""

from __future__ import annotations

import math

import numpy as np
import pytest

import diffdrive_mj as dd
from diffdrive_mj.physics.mechanics import gravity
from diffdrive_mj.terrain import Slope

ROBOT = dd.Robot.load("mismatched")


def test_a_slope_turns_gravity_and_keeps_its_size():
    pulled = gravity(dd.World(gravity=3.0, slope=Slope(angle=0.3, direction=2.0)))
    assert np.linalg.norm(pulled) == pytest.approx(3.0)
    assert pulled[2] == pytest.approx(-3.0 * math.cos(0.3))
    assert math.atan2(-pulled[1], -pulled[0]) == pytest.approx(2.0)  # pulled down, the floor rises the other way


def test_a_level_slope_changes_no_bit():
    straight = dd.maneuvers.straight(ROBOT, speed=0.5, distance=0.5)
    level = dd.simulate(ROBOT, straight)
    same = dd.simulate(ROBOT, straight, world=dd.World(slope=Slope(angle=0.0, direction=1.0)))
    np.testing.assert_array_equal(level.truth, same.truth)


@pytest.mark.parametrize("direction", [0.0, 1.0, math.pi / 2, math.pi])
def test_odometry_on_a_slope_is_off_by_less_than_a_ppm(direction):
    world = dd.World(slope=Slope(angle=math.radians(10), direction=direction))
    recording = dd.simulate(
        ROBOT,
        dd.maneuvers.straight(ROBOT, speed=0.5, distance=2.0),
        world=world,
        physics=dd.Physics(friction_impedance=100.0),
    )
    assert recording.drift(ROBOT).max_position_per_metre < 1e-6
