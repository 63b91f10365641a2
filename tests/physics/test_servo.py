"""The servos: a wheel follows as w / (s + w), whatever robot it drives."""

import numpy as np
import pytest

import diffdrive_mj as dd
from diffdrive_mj.robot import presets

SPEED = 0.05  # slow enough for its first step not to slip: the acceleration is w v


def step(robot, timestep):
    """The wheels' angles on a sudden command of some speed, and their share of the commanded rates."""
    rates = dd.kinematics.wheel_rates((SPEED, 0.0), robot)
    commands = dd.Commands(0.01, np.tile(rates, (60, 1)))
    recording = dd.simulate(robot, commands, physics=dd.Physics(timestep=timestep), sample_rate=500)
    return recording, recording.wheel_angles / rates


@pytest.mark.parametrize("name", presets())
def test_a_wheel_follows_a_step_as_a_first_order_lag(name):
    """rate (1 - exp(-w t)), so that the angle is rate (t - (1 - exp(-w t)) / w): within a step, and of first order."""
    robot = dd.Robot.load(name)
    w = robot.servo.bandwidth
    errors = []
    for timestep in (0.002, 0.001):
        recording, time = step(robot, timestep)
        expected = recording.t - (1 - np.exp(-w * recording.t)) / w
        errors.append(np.abs(time - expected[:, None]).max())
        assert np.diff(time, axis=0).max() <= 0.002 * (1 + 1e-9)  # it never overshoots
    assert errors[0] < 0.002 / 2
    assert errors[0] / errors[1] == pytest.approx(2, rel=0.02)


def test_both_wheels_of_unequal_radii_follow_alike():
    """Gains and inertias go with the radius squared: a compensated robot speeds up in a straight line."""
    robot = dd.Robot.load("mismatched")
    recording, time = step(robot, 0.002)
    assert np.abs(time[:, 0] - time[:, 1]).max() < 1e-9
    assert np.abs(recording.truth[:, 1:]).max() < 1e-9


def test_a_robot_ends_behind_its_command_by_the_lag():
    recording, _ = step(dd.Robot.load("matched"), 0.002)
    assert SPEED * recording.t[-1] - recording.truth[-1, 0] == pytest.approx(SPEED / 30.0, rel=1e-5)
