"""Gravity and slopes: what falls, and what a slope does to odometry."""

from __future__ import annotations

import math

import numpy as np
import pytest

import diffdrive_mj as dd
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.judging.random_drives import LEAST_LOAD, MOST_FRICTION, random_cases
from diffdrive_mj.judging.standards import residual
from diffdrive_mj.physics.limits import needed_grip
from diffdrive_mj.physics.mechanics import gravity
from diffdrive_mj.physics.model import compile_model
from diffdrive_mj.physics.tilt import level_twin
from diffdrive_mj.terrain import Slope

ROBOT = dd.Robot.load("mismatched")
WEIGHTS = ("a slope", "a payload", "a slope and a payload", "the moon", "Jupiter")


def weighed(kind, robot, rng):
    """A robot and a world in which something pulls otherwise, drawn at random."""
    fields = {"gravity": {"the moon": 1.62, "Jupiter": 24.8}.get(kind, 9.81)}
    if "slope" in kind:
        fields["slope"] = {"angle": rng.uniform(0.01, 0.2), "direction": rng.uniform(-math.pi, math.pi)}
    if "payload" in kind:
        mass, x, y = rng.uniform(0.05, 1.5), rng.uniform(0.1, 0.8), rng.uniform(-0.15, 0.15)
        at = {"x": x * robot.caster.x, "y": y * robot.track_width, "height": rng.uniform(0.5, 2) * robot.mean_radius}
        robot = robot.replace(payload={"mass": mass * robot.mass, **at})
    return robot, dd.World(**fields)


def worst(kind, physics, cases):
    """The largest error of odometry at every step [ppm of the distance] where mechanics is sure of the grip."""
    rng, found = np.random.default_rng(5), []
    for case in cases:
        try:
            robot, world = weighed(kind, case.robot, rng)
        except InvalidValue:  # the payload would tip it over
            continue
        need, load = needed_grip(robot, case.commands, world)
        if (need <= MOST_FRICTION).all() and load >= LEAST_LOAD:
            recording = dd.simulate(robot, case.commands, world=world, physics=physics, sample_rate=500.0)
            found.append(residual(recording, level_twin(robot)).position)
    assert len(found) > len(cases) / 8
    return max(found)


@pytest.mark.parametrize("kind", WEIGHTS)
def test_odometry_is_within_a_ppm_whatever_pulls(kind):
    assert worst(kind, dd.Physics(friction_impedance=100.0), random_cases(16, seed=21)) < 1.0


@pytest.mark.slow
@pytest.mark.parametrize("kind", WEIGHTS)
def test_odometry_of_many_robots_is_within_a_ppm_whatever_pulls(kind):
    assert worst(kind, dd.Physics(friction_impedance=100.0), random_cases(250, seed=22)) < 1.0


@pytest.mark.slow
def test_what_the_defaults_give_on_slopes():
    """Slip in proportion to the force: 10 times as much as above, and 10 times as little as MuJoCo's impratio of 1."""
    assert worst("a slope", dd.Physics(), random_cases(250, seed=22)) < 2.0


@pytest.mark.parametrize("world", [dd.World(gravity=1.62), dd.World(slope={"angle": 0.3}), dd.World(gravity=30.0)])
def test_contacts_are_balanced_against_the_weight_on_the_floor(world):
    """They act above the floor by what they sink, which goes with the load."""
    level, other = compile_model(ROBOT), compile_model(ROBOT, world=world)
    share = world.gravity / 9.81 * (math.cos(world.slope.angle) if world.slope else 1.0)
    for name in ("left_floor", "right_floor", "caster_floor"):
        assert other.pair(name).margin[0] == pytest.approx(share * level.pair(name).margin[0], rel=1e-12)


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


@pytest.mark.parametrize("axle", ["independent", "rigid"])
def test_on_a_slope_a_robot_stands_still_from_the_beginning(axle):
    """Its servos hold it before they are told anything: without that it sags by millimetres."""
    robot = ROBOT.replace(axle=axle)
    world = dd.World(slope=Slope(angle=0.2, direction=0.6))
    rest = dd.simulate(robot, dd.Commands(0.01, np.zeros((100, 2))), world=world, start=(0, 0, 2.0))
    assert np.abs(rest.truth[:, :2]).max() < 2e-7
    assert np.abs(rest.wheel_angles).max() < 2e-6
