"""Soft tyres: how far they give way, on which radius they roll, that bounces die out, and what is too soft."""

from __future__ import annotations

import itertools
import math

import mujoco
import numpy as np
import pytest
from coasting import wheel_loads
from helpers import refused
from random_robots import random_robots

import diffdrive_mj as dd
from diffdrive_mj.physics.effects.soft_tyres import rolling_radii, sinks
from diffdrive_mj.physics.mechanics import contact_forces
from diffdrive_mj.physics.model import compile_model

ROBOTS = random_robots(24, seed=21)


def softened(robot, share, gravity=9.81):
    """A robot whose wheels sink by some share of their mean radius."""
    tyres = {
        "width": robot.tyres.width,
        "mass": robot.tyres.mass,
        "stiffness": float(wheel_loads(robot, gravity)[0] / (share * robot.mean_radius)),
    }
    return robot.replace(tyres=tyres)


def shares(count, seed):
    """Of the radius: 0.1 to 3 %."""
    return 10 ** np.random.default_rng(seed).uniform(-3, -1.5, count)


@pytest.mark.parametrize("seed", range(24))
def test_a_wheel_sinks_by_load_over_stiffness_and_rolls_on_a_radius_that_is_smaller_by_half_of_it(seed):
    """Within 0.1 % of the loss at a steady speed; and it stands as deep as said from the start."""
    robot = softened(ROBOTS[seed], shares(24, 1)[seed])
    depth = wheel_loads(robot, 9.81) / robot.tyres.stiffness
    assert sinks(robot, dd.World()) == pytest.approx(depth, rel=1e-12)
    speed, radii = min(0.2, robot.mean_radius), np.array([robot.left_radius, robot.right_radius])
    drive = dd.maneuvers.constant_rates(speed / radii, duration=12.0, ramp=2.0)
    recording = dd.simulate(robot, drive)
    first, last = 900, 1100  # at full speed, when what the start has rocked is over
    turned = recording.wheel_angles[last] - recording.wheel_angles[first]
    way = math.dist(recording.truth[first, :2], recording.truth[last, :2])
    lost = (turned * radii).mean() - way
    assert lost == pytest.approx((turned * depth / 2).mean(), rel=1e-3)
    rigid = dd.simulate(ROBOTS[seed], drive).height
    assert rigid[0] - recording.height[0] == pytest.approx(depth.mean(), rel=1e-9)


def test_gravity_and_a_slope_change_the_load():
    robot = dd.Robot.load("mismatched").replace(tyres={"stiffness": 30_000})
    moon = dd.World(gravity=1.62)
    assert sinks(robot, moon) == pytest.approx(wheel_loads(robot, 1.62) / 30_000)
    assert rolling_radii(robot, moon) == pytest.approx(np.array([0.100, 0.091]) - sinks(robot, moon) / 2)
    straight = dd.maneuvers.straight(robot, speed=0.5, distance=2.0)
    heights = [dd.simulate(robot, straight, world=world).height[0] for world in (dd.World(), moon)]
    assert heights[1] - heights[0] == pytest.approx((sinks(robot, dd.World()) - sinks(robot, moon)).mean(), rel=1e-9)


@pytest.mark.parametrize("axle", ["independent", "rigid"])
def test_a_robot_stands_still_on_soft_tyres(axle):
    robot = dd.Robot.load("mismatched").replace(axle=axle, tyres={"stiffness": 20_000}, payload={"mass": 1, "y": 0.05})
    recording = dd.simulate(robot, dd.Commands(1.0, np.zeros((5, 2))), sample_rate=10.0)
    assert np.abs(recording.truth).max() < 1e-6
    assert np.abs(recording.height - recording.height[0]).max() < 1e-6
    later = recording.truth[10:]
    assert np.abs(later - later[-1]).max() < 1e-9


@pytest.mark.parametrize("stiffness", [2e3, 2e4, 2e5, 2e6, 2e9])
def test_a_bounce_dies_out(stiffness):
    """Dropped from a millimetre, a robot moves by less than 0.1 mm/s three seconds later; softer ones take longer."""
    model = compile_model(dd.Robot.load("matched").replace(tyres={"stiffness": stiffness}))
    data = mujoco.MjData(model)
    data.qpos[2] += 0.001
    mujoco.mj_step(model, data, nstep=1500)
    assert np.abs(data.qvel[:3]).max() < 1e-4
    assert data.qpos[2] == pytest.approx(model.qpos0[2], abs=1e-6)


@pytest.mark.parametrize(
    ("name", "rates"), [("matched", (4.0, 6.0)), ("mismatched", (12.0, 15.0)), ("optiodom", (6, 9))]
)
def test_in_a_turn_the_outer_wheel_sinks_deeper(name, rates):
    """By its share of the load there: the turn is what these radii say, within 5 % of what the load's shift takes."""
    robot = softened(dd.Robot.load(name), 0.01)
    drive = dd.maneuvers.constant_rates(rates, duration=8.0)
    recording = dd.simulate(robot, drive)
    first, last = 600, 800
    turned = recording.wheel_angles[last] - recording.wheel_angles[first]
    heading = recording.truth[last, 2] - recording.truth[first, 2]
    radii = np.array([robot.left_radius, robot.right_radius])
    v = radii * rates
    moving = contact_forces(robot, (v.mean(), (v[1] - v[0]) / robot.track_width)).load[:2]
    expected, at_rest = (
        (turned * (radii - depth / 2) * (-1, 1)).sum() / robot.track_width
        for depth in (moving / robot.tyres.stiffness, sinks(robot, dd.World()))
    )
    assert abs(at_rest - expected) > 1e-4 * abs(expected)
    assert heading == pytest.approx(expected, abs=0.05 * abs(at_rest - expected))


def test_stiffer_tyres_come_ever_closer_to_rigid_ones():
    rigid = dd.Robot.load("mismatched")
    drive = dd.maneuvers.square(rigid, side=1.0, speed=0.5)
    ends = [
        dd.simulate(rigid.replace(tyres={"stiffness": stiffness}), drive).truth[-1]
        for stiffness in (1e6, 1e7, 1e8, 1e9)
    ]
    off = [np.abs(end - dd.simulate(rigid, drive).truth[-1]).max() for end in ends]
    assert all(later < 0.2 * earlier for earlier, later in itertools.pairwise(off))
    assert off[-1] < 1e-6


def test_rigid_tyres_have_the_bits_of_before():
    robot = dd.Robot.load("mismatched")
    assert robot.tyres.stiffness is None
    assert sinks(robot, dd.World()).tolist() == [0.0, 0.0]


@pytest.mark.parametrize(("stiffness", "why"), [(200, "its chassis lies on the floor"), (600, "quarter of its radius")])
def test_tyres_that_are_too_soft_are_named(stiffness, why):
    with refused(ValueError, f"Tyres.stiffness = {stiffness} N/m", "mm", why):
        compile_model(dd.Robot.load("matched").replace(tyres={"stiffness": stiffness}))


@pytest.mark.parametrize("value", [0, -1e4, math.inf])
def test_a_stiffness_without_meaning_is_named(value):
    with refused(ValueError, "Tyres.stiffness"):
        dd.Tyres(stiffness=value)
