"""Motors: the line from stall torque to no-load speed, limits that are said, unequal gains."""

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest
from coasting import wheel_loads
from helpers import refused
from random_robots import random_robots

import diffdrive_mj as dd
from diffdrive_mj.errors import PhysicsWarning
from diffdrive_mj.physics.effects.motors import top_speed
from diffdrive_mj.physics.model import compile_model

ROBOT = dd.Robot.load("matched").replace(motor={"stall_torque": 1.5, "no_load_speed": 20.0})
BOTH = np.ones(2)


def ramp(rate, seconds, up=3.0, period=0.01):
    """Up to a rate within some seconds, and on."""
    t = np.arange(round(seconds / period)) * period
    return dd.Commands(period, np.minimum(t / up, 1)[:, None] * rate * BOTH)


def driven(robot, commands, **options):
    """A drive whose warnings are looked for elsewhere."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PhysicsWarning)
        return dd.simulate(robot, commands, **options)


def rates(recording):
    return np.diff(recording.wheel_angles, axis=-2) / np.diff(recording.t)[:, None]


def motorised(robot, law, world, generator):
    """A random robot with equal wheels that the motors bring to a speed of 0.3 m/s, in a second or so."""
    robot = robot.replace(right_radius=robot.left_radius)
    radius = robot.left_radius
    load = float(world.rolling_resistance * wheel_loads(robot, 9.81)[0] * radius)
    stall, speed = load + robot.mass * radius * float(generator.uniform(0.2, 0.5)), 0.3 / radius
    rotor = 4 * 0.002 * stall / speed  # which the time step holds
    motor = {"stall_torque": stall, "no_load_speed": speed, "rotor_inertia": max(rotor, robot.motor.rotor_inertia)}
    return robot.replace(motor=motor, servo={"law": law}), load


def limits(motor):
    return {"stall_torque": motor.stall_torque, "no_load_speed": motor.no_load_speed}


@pytest.mark.parametrize("law", ["PI", "P", "voltage"])
def test_the_top_speed_is_where_the_torque_meets_the_load(law):
    """w_0 (1 - load / stall) within a part in a million, for random robots on floors that resist."""
    generator = np.random.default_rng(3)
    for drawn in random_robots(12, seed=12):
        world = dd.World(rolling_resistance=float(generator.uniform(0.0, 0.02)))
        robot, load = motorised(drawn, law, world, generator)
        expected = robot.motor.no_load_speed * (1 - load / robot.motor.stall_torque)
        assert top_speed(robot, load) == pytest.approx(expected, rel=1e-12)
        recording = driven(robot, ramp(1.5 * robot.motor.no_load_speed, 25.0), world=world, sample_rate=10.0)
        assert rates(recording)[-10:] == pytest.approx(expected, rel=1e-6)


def test_at_its_limit_it_accelerates_along_the_line():
    """J w' = S - k w: from rest to the no-load speed as 1 - (1 - k dt / J)^n in n of the engine's steps."""
    robot = ROBOT.replace(motor={"stall_torque": 0.6, "no_load_speed": 10.0}, servo={"law": "voltage"})
    inertia = robot.mass * 0.1**2 / 2 + robot.tyres.mass * 0.1**2 / 2 + robot.motor.rotor_inertia
    recording = dd.simulate(robot, dd.Commands(0.01, np.full((200, 2), 10.0)), sample_rate=500.0)
    steps = np.arange(1, len(recording.t))
    expected = 10.0 * (1 - (1 - 0.06 * 0.002 / inertia) ** steps)
    assert rates(recording)[:, 0] == pytest.approx(expected, rel=1e-5, abs=1e-5)


@pytest.mark.parametrize("law", ["PI", "P"])
def test_a_limit_that_is_not_reached_changes_nothing(law):
    """Nor do the cuts of the drive, which motors with limits need."""
    ideal = dd.Robot.load("mismatched").replace(servo={"law": law})
    strong = ideal.replace(motor={"stall_torque": 1e6})
    for world in (dd.World(), dd.World(patches=(dd.Patch(x=(0.2, 0.5), y=(-1, 0), friction=0.5),))):
        drives = [dd.simulate(robot, ramp(5.0, 2.0, up=1.0), world=world) for robot in (ideal, strong)]
        np.testing.assert_array_equal(drives[0].truth, drives[1].truth)
        np.testing.assert_array_equal(drives[0].wheel_angles, drives[1].wheel_angles)


def test_back_emf_within_reach_of_the_servo_changes_next_to_nothing():
    """The servo adds to its voltage what back-EMF takes."""
    square = dd.maneuvers.square(ROBOT, side=1.0, speed=0.5)
    ideal, real = (dd.simulate(robot, square) for robot in (dd.Robot.load("matched"), ROBOT))
    np.testing.assert_allclose(ideal.truth, real.truth, rtol=0, atol=1e-11)
    assert not real.events


def test_a_batch_of_unlike_motors_has_the_bits_of_each_alone():
    robots = [dd.Robot.load("matched"), ROBOT, ROBOT.replace(motor={"stall_torque": 0.3, "gain_ratio": 0.9})]
    commands = ramp(10.0, 4.0)
    together = driven(robots, commands)
    for robot, run in zip(robots, together.runs, strict=True):
        np.testing.assert_array_equal(run.truth, driven(robot, commands).truth)


def test_the_integral_does_not_wind_up():
    """Two seconds at the limit, then half of the top speed: the wheel goes there as an ideal servo does, from where
    it is, and never catches up with the angle that it was told to turn."""
    rate = np.concatenate(
        [ramp(30.0, 5.0).wheel_rates, np.linspace(30.0, 10.0, 200)[:, None] * BOTH, np.full((100, 2), 10.0)]
    )
    recording = driven(ROBOT, dd.Commands(0.01, rate))
    driven_rates, t = rates(recording)[:, 0], recording.t[1:]
    assert driven_rates[t < 5.0][-1] == pytest.approx(20.0, rel=1e-3)
    below = rate[:, 0] < 20.0  # what the motor can do
    assert (driven_rates[below] < rate[below, 0] + 0.5).all()  # the lag of 33 ms at 10 rad/s^2 is 0.33 rad/s
    assert driven_rates[-1] == pytest.approx(10.0, rel=1e-4)
    assert rate[:, 0].sum() * 0.01 - recording.wheel_angles[-1, 0] > 10.0


def test_a_motor_that_gives_all_it_has_is_said():
    with pytest.warns(PhysicsWarning, match="left motor gave all it has"):
        recording = dd.simulate(ROBOT, ramp(25.0, 25.0, up=20.0))
    assert any("right motor gave all it has" in event and "% too slow" in event for event in recording.events)
    assert recording.grip.shortfall == pytest.approx(np.full(2, 0.2), abs=0.03)
    assert recording.runs[0].events == recording.events
    assert dd.simulate(ROBOT, ramp(15.0, 5.0)).events == ()


def test_unequal_gains_bend_the_path_of_an_open_loop():
    """Each wheel turns as its voltage says less what the floor takes: with the centre of mass at c (behind the axle),
    F_r, F_l = +-c M v omega / b - M omega^2 c / 2, which bends the path further."""
    robot = ROBOT.replace(motor={**limits(ROBOT.motor), "gain_ratio": 1.02}, servo={"law": "voltage"})
    recording = dd.simulate(robot, ramp(10.0, 15.0))
    c, mass, track, back_emf = (
        robot.loaded_center_of_mass[0] * robot.body_mass / robot.mass,
        robot.mass,
        0.4,
        1.5 / 20.0,
    )
    expected = np.array([10.0, 10.2])
    for _ in range(50):
        v, omega = expected.mean() * 0.1, (expected[1] - expected[0]) * 0.1 / track
        force = np.array([-1, 1]) * c * mass * v * omega / track - mass * omega**2 * c / 2
        expected = np.array([10.0, 10.2]) - force * 0.1 / back_emf
    assert rates(recording)[-1] == pytest.approx(expected, rel=1e-5)
    assert expected[1] - expected[0] > 0.3
    assert abs(recording.drift(robot).final_heading) < 1e-6  # odometry reads the wheels


def test_a_pi_servo_makes_up_for_unequal_gains():
    robot = ROBOT.replace(motor={**limits(ROBOT.motor), "gain_ratio": 0.8})
    recording = dd.simulate(robot, ramp(10.0, 10.0))
    assert rates(recording)[-1] == pytest.approx(10.0 * BOTH, rel=1e-6)
    assert 1e-4 < abs(recording.truth[-1, 2]) < 0.2  # it turned a little while it sped up


def test_a_p_servo_of_a_weaker_motor_falls_shorter():
    """By load / (gain x damping) beyond what back-EMF takes: g (d (u - w) + k w) - k w = load."""
    gain, resistance, commanded = 0.8, 0.05, 8.0
    robot = ROBOT.replace(
        motor={**limits(ROBOT.motor), "gain_ratio": gain},
        servo={"law": "P"},
        tyres={"rolling_resistance": resistance},
    )
    inertia = (robot.mass + robot.tyres.mass) * 0.1**2 / 2 + robot.motor.rotor_inertia
    damping, back_emf = 2 * robot.servo.bandwidth * inertia, 1.5 / 20.0
    load = resistance * wheel_loads(robot, 9.81)[1] * 0.100
    expected = (gain * damping * commanded - load) / (gain * (damping - back_emf) + back_emf)
    recording = driven(robot, ramp(commanded, 8.0))
    assert rates(recording)[-1, 1] == pytest.approx(expected, rel=1e-3)


def test_a_motor_without_meaning_is_named():
    with refused(ValueError, "Motor.no_load_speed", "needs a stall_torque"):
        dd.Motor(no_load_speed=20.0)
    with refused(ValueError, "Motor.stall_torque"):
        dd.Motor(stall_torque=-1.0)
    with refused(ValueError, "Motor.gain_ratio"):
        dd.Motor(gain_ratio=0.0)
    with refused(ValueError, 'law = "voltage"', "no_load_speed"):
        dd.Robot.load("matched").replace(servo={"law": "voltage"})
    with refused(ValueError, "load = 2 N m", "1.5 N m"):
        top_speed(ROBOT, 2.0)


def test_back_emf_too_stiff_for_the_time_step_is_named():
    fast = ROBOT.replace(motor={"stall_torque": 100.0, "no_load_speed": 1.0, "rotor_inertia": 0.001})
    with refused(ValueError, "Physics.timestep", "Motor.rotor_inertia"):
        compile_model(fast)


def test_a_motor_without_a_limit_has_no_top_speed():
    assert top_speed(dd.Robot.load("matched")) == math.inf
    assert top_speed(dd.Robot.load("matched").replace(motor={"stall_torque": 1.0})) == math.inf
