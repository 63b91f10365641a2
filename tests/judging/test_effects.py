"""What real floors and parts cost odometry, one at a time."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers import refused

import diffdrive_mj as dd
from diffdrive_mj.judging.effects import Effect, outcome, usual_effects, without_parts
from diffdrive_mj.physics.mechanics import fork_trail
from diffdrive_mj.physics.tilt import resting_tilt
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


@pytest.mark.parametrize(
    "parts",
    [
        {"caster": {"kind": "swivel", "trail": 0.02, "angle": 0.3}},
        {"caster": {"friction": 0.1}, "turning_gain": 0.01},
        {"tyres": {"stiffness": 40_000, "shape": "cylinder", "rolling_resistance": 0.02}},
        {"motor": {"stall_torque": 1.5, "no_load_speed": 20.0, "gain_ratio": 0.9}, "servo": {"law": "voltage"}},
        {"payload": {"mass": 1.0, "x": -0.02, "height": 0.1}},
    ],
)
def test_parts_of_a_robot_that_are_not_ideal_are_left_away(parts):
    robot = ROBOT.replace(**parts)
    assert usual_effects(robot) == usual_effects(ROBOT)
    assert without_parts(robot) == ROBOT


def test_a_swivel_caster_pitches_a_robot_that_leans():
    """The fork leans with a rigid axle on unequal wheels: its hub goes up and down by trail sin(roll) sin(angle)."""
    robot = dd.Robot.load("mismatched").replace(axle="rigid")
    effect = named(robot, "leaning swivel")
    found = outcome(effect, side=1.0).recording
    w, x, y, z = found.attitude.T
    pitch = np.arcsin(2 * (w * y - x * z))
    trail, angle = fork_trail(effect.robot), found.caster_angle
    rises = trail * np.sin(resting_tilt(robot).roll) * np.sin(angle)
    swings = rises / (trail * np.cos(angle) - robot.caster.x)  # nose down is positive
    assert pitch - pitch[0] == pytest.approx(swings - swings[0], abs=0.05 * np.ptp(swings))
    level = dd.Robot.load("matched").replace(axle="rigid")
    assert named(level, "swivel").robot.caster.kind == "swivel"


def test_skid_steer_is_refused():
    with refused(ValueError, "robot skid: must have wheels that roll, not skid steer"):
        usual_effects(
            dd.Robot(name="skid", left_radius=0.1, right_radius=0.1, track_width=0.4, skid_steer={"wheelbase": 0.4})
        )


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
    with refused(TypeError, "effect.world"):
        outcome(Effect("a cable", ROBOT, "office"))
