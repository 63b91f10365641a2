"""Rolling resistance: what it holds, how it slows, and that it changes nothing where there is none."""

from __future__ import annotations

import copy
import math

import mujoco
import numpy as np
import pytest
from coasting import coasting, stop_force, wheel_loads
from helpers import refused
from random_robots import random_robots

import diffdrive_mj as dd
from diffdrive_mj.physics.effects.rolling_resistance import resisting_torques
from diffdrive_mj.physics.model import compile_model
from diffdrive_mj.terrain import Slope

ROBOTS = random_robots(30, seed=11)


def resisting(robot, coefficient):
    return robot.replace(tyres={"rolling_resistance": coefficient})


def drawn(seed):
    """A robot, and a world whose floor resists too."""
    generator = np.random.default_rng(seed)
    robot = resisting(ROBOTS[seed], float(generator.uniform(0.0, 0.01)))
    world = dd.World(
        gravity=float(generator.uniform(1.0, 12.0)), rolling_resistance=float(generator.uniform(0.001, 0.01))
    )
    return robot, world, robot.tyres.rolling_resistance + world.rolling_resistance


@pytest.mark.parametrize("seed", range(30))
def test_a_robot_that_coasts_slows_down_as_its_resistance_says(seed):
    """M a + J a / r^2 of both wheels, against c N of both; along a straight line, with the wheels' loads at rest."""
    robot, world, coefficient = drawn(seed)
    model = coasting(robot, world)
    expected = stop_force(robot, model, coefficient * wheel_loads(robot, world.gravity))
    data = mujoco.MjData(model)
    speed = 2 * expected  # coasts for two seconds
    data.qvel[0] = speed
    for side, radius in (("left", robot.left_radius), ("right", robot.right_radius)):
        data.qvel[model.joint(side).dofadr[0]] = speed / radius
    first, steps = 20, round(0.5 / model.opt.timestep)
    mujoco.mj_step(model, data, nstep=first)
    before = data.qvel[0]
    mujoco.mj_step(model, data, nstep=steps)
    heading = 2 * math.atan2(data.qpos[6], data.qpos[3])
    slowed = (before - data.qvel[0] / math.cos(heading)) / (steps * model.opt.timestep)
    assert slowed == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("seed", range(10))
@pytest.mark.parametrize(("share", "holds"), [(0.999, True), (1.001, False)])
def test_a_wheel_holds_against_a_torque_below_its_resistance(seed, share, holds):
    """A tenth of a per cent below it turns less than a hundredth as fast as a tenth of a per cent above."""
    robot, world, coefficient = drawn(seed)
    model = coasting(robot, world)
    loads, radii = wheel_loads(robot, world.gravity), np.array([robot.left_radius, robot.right_radius])
    data = mujoco.MjData(model)
    dofs = [int(model.joint(side).dofadr[0]) for side in ("left", "right")]
    data.qfrc_applied[dofs] = share * coefficient * loads * radii
    mujoco.mj_step(model, data, nstep=1000)
    expected = stop_force(robot, model, 0.001 * coefficient * loads) * data.time
    assert (abs(data.qvel[0]) < 0.01 * expected) == holds


def test_the_tyre_and_the_floor_add_up():
    robot = resisting(dd.Robot.load("mismatched"), 0.01)
    both = resisting_torques(robot, dd.World(rolling_resistance=0.02))
    assert both == pytest.approx(0.03 * wheel_loads(robot, 9.81) * (0.100, 0.091))
    assert resisting_torques(robot, dd.World(gravity=1.62)) == pytest.approx(
        0.01 * wheel_loads(robot, 1.62) * (0.100, 0.091)
    )
    slope = dd.World(slope=Slope(angle=0.2))
    assert resisting_torques(robot, slope) == pytest.approx(resisting_torques(robot, dd.World()) * math.cos(0.2))


def test_a_robot_without_resistance_has_the_bits_of_before():
    robot = dd.Robot.load("mismatched")
    for field in ("dof_frictionloss", "dof_solref", "dof_solimp"):
        plain = getattr(compile_model(robot), field)
        assert np.array_equal(plain, getattr(compile_model(resisting(robot, 0.0)), field))
    assert not compile_model(robot).dof_frictionloss.any()


@pytest.mark.parametrize("coefficient", [0.01, 0.05])
def test_the_wheels_still_roll(coefficient):
    """The servo makes up for it: odometry is as exact as on an ideal floor."""
    robot = resisting(dd.Robot.load("mismatched"), coefficient)
    for drive in (
        dd.maneuvers.square(robot, side=1.0, speed=0.5),
        dd.maneuvers.straight(robot, speed=0.5, distance=3.0),
    ):
        recording = dd.simulate(robot, drive)
        assert not recording.events
        assert recording.drift(robot).max_position_per_metre < 1e-6


def test_a_p_servo_falls_short_by_the_resistance_over_its_damping():
    robot = dd.Robot.load("matched").replace(servo={"law": "P"}, tyres={"rolling_resistance": 0.05})
    model = compile_model(robot)
    damping = -model.actuator("left_servo").biasprm[2]
    commanded = 5.0
    ramp = np.minimum(np.arange(400) / 200, 1)[:, None]
    recording = dd.simulate(robot, dd.Commands(0.01, commanded * ramp.repeat(2, axis=1)))
    rate = np.diff(recording.wheel_angles[-100:, 0]).mean() / 0.01
    torque = 0.05 * wheel_loads(robot, 9.81)[0] * 0.100
    assert commanded - rate == pytest.approx(torque / damping, rel=1e-3)


@pytest.mark.parametrize("value", [-0.01, 1.001, 5, math.nan])
def test_a_coefficient_without_meaning_is_named(value):
    with refused(ValueError, "Tyres.rolling_resistance"):
        dd.Tyres(rolling_resistance=value)
    with refused(ValueError, "World.rolling_resistance"):
        dd.World(rolling_resistance=value)


def test_the_engine_reads_what_the_torque_says():
    robot = resisting(dd.Robot.load("optiodom"), 0.02)
    model = copy.copy(compile_model(robot))
    dofs = [int(model.joint(side).dofadr[0]) for side in ("left", "right")]
    assert model.dof_frictionloss[dofs] == pytest.approx(resisting_torques(robot, dd.World()), rel=1e-12)
