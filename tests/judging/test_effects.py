"""What real floors and parts cost odometry, one at a time."""

from __future__ import annotations

import math

import pytest
from helpers import refused

import diffdrive_mj as dd
from diffdrive_mj.judging.effects import Effect, outcome, usual_effects
from diffdrive_mj.robot import presets

ROBOT = dd.Robot.load("matched")


def named(robot, beginning):
    """The effect whose name begins so."""
    (found,) = [effect for effect in usual_effects(robot) if effect.name.startswith(beginning)]
    return found


@pytest.mark.parametrize("name", presets())
def test_every_effect_changes_one_thing_alone(name):
    robot = dd.Robot.load(name)
    ideal, *others = usual_effects(robot)
    assert (ideal.robot, ideal.world) == (robot, dd.World())
    assert all((effect.robot == robot) != (effect.world == dd.World()) for effect in others)
    assert len({effect.name for effect in others}) == len(others)


def test_a_soft_tyre_is_a_smaller_radius_which_calibration_finds():
    """A tyre that gives way by 1 % rolls on a radius half a percent smaller: every way is longer to odometry by it."""
    found = outcome(named(ROBOT, "tyres"), side=1.0)
    assert found.calibrated is not None
    # The farthest corner is 1 / sqrt(2) of half the way round from the start, turned by what the corners add.
    assert 0.005 * math.sqrt(2) / 4 < 1e-6 * found.nominal.position < 0.02
    assert found.calibrated.position < 0.01 * found.nominal.position


def test_what_wheels_notice_costs_nothing():
    for beginning in ("nothing", "carpet", "payload", "right motor"):
        assert outcome(named(ROBOT, beginning), side=0.5).nominal.position < 1.0


def test_a_cable_is_not_calibrated_away():
    found = outcome(named(ROBOT, "5 mm cable under one wheel"), side=2.0)
    assert found.calibrated is not None
    assert min(found.nominal.position, found.calibrated.position) > 100


def test_a_robot_that_cannot_be_driven_says_why():
    found = outcome(Effect("a wall", ROBOT, dd.World(slope=dd.Slope(angle=1.2))), side=0.5)
    assert (found.recording, found.calibrated) == (None, None)
    assert "not driven" in str(found.nominal)
    with refused(TypeError, "effect"):
        outcome("a cable")
