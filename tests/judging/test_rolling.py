"""Drives on which the wheels must roll, at full speed and seen at any rate."""

import dataclasses
import warnings

import numpy as np
import pytest
from helpers import refused
from hypothesis import given
from strategies import numbers, robots, sizes

import diffdrive_mj as dd
from diffdrive_mj.errors import RobotFell
from diffdrive_mj.judging.full_speed import steady_arc
from diffdrive_mj.judging.rolling import gentle_ramp, simulate_rolling
from diffdrive_mj.judging.sampled import sampled_odometry
from diffdrive_mj.physics.limits import needed_grip

ROBOT = dd.Robot.load("mismatched")


def test_a_drive_that_rolls_is_the_one_of_simulate():
    commands = dd.maneuvers.arc(ROBOT, radius=1.0, distance=0.5, speed=0.5)
    assert np.array_equal(simulate_rolling(ROBOT, commands).truth, dd.simulate(ROBOT, commands).truth)


def test_a_drive_that_slips_is_refused_without_a_warning():
    jump = dd.maneuvers.straight(ROBOT, speed=0.5, distance=0.5, ramp=0.05)
    gentle = dd.maneuvers.straight(ROBOT, speed=0.3, distance=0.3)
    with refused(ValueError, "robot 1", "friction", "must roll"):
        simulate_rolling(ROBOT, [gentle, jump.extended(gentle.duration)])


def test_a_robot_that_falls_is_an_error_of_its_own():
    robot = dd.Robot.load("turtlebot3_burger")
    with pytest.raises(RobotFell):
        simulate_rolling(robot, dd.maneuvers.straight(robot, speed=1.0, distance=1.0, ramp=0.2))


@given(robots, sizes(0.05, 3.0))
def test_on_a_gentle_ramp_half_of_the_grip_is_left(robot, speed):
    """What a wheel needs grows with the acceleration, at first in proportion: at half of the limit it is below it."""
    ramp = gentle_ramp(robot, speed)
    commands = dd.maneuvers.straight(robot, speed=speed, distance=2 * speed * ramp, ramp=ramp)
    need, load = needed_grip(robot, commands)
    assert need.max() < 0.75
    assert load > 0


@given(numbers(0.1, 1.0), numbers(0.5, 3.0))
def test_the_arc_at_full_speed_is_that_of_its_wheel_rates(speed, radius):
    """A planted recording: the circle that the rates make, up to an offset that is planted too."""
    duration, offset = 4.0, 3e-6
    commands = dd.maneuvers.arc(ROBOT, radius=radius, distance=speed * duration, speed=speed)
    t = np.arange(0.0, commands.duration, 0.01)
    angles = np.stack([np.interp(t, *_turned(commands, wheel)) for wheel in (0, 1)], axis=-1)
    truth = dd.odometry.integrate(angles, ROBOT)
    recording = dd.Recording(t, angles, truth, ROBOT, commands, dd.World(), dd.Physics())
    found = steady_arc(recording, ROBOT)
    assert found.twist == pytest.approx((speed, speed / radius), rel=1e-9)
    assert found.speed == pytest.approx(speed, rel=1e-9)
    assert found.off < 1e-6
    assert found.recording.t[0] == pytest.approx((1.0 + duration) / 2, abs=0.02)
    moved = truth.copy()
    moved[-200:, 0] += offset  # somewhere in the stretch
    jumped = dataclasses.replace(recording, truth=moved)
    stretch = steady_arc(jumped, ROBOT)
    assert stretch.off == pytest.approx(1e6 * offset / (speed * np.ptp(stretch.recording.t)), rel=1e-3)


def _turned(commands, wheel):
    """The times of the commands, and how far a wheel has turned by then."""
    angles = np.concatenate([[0.0], np.cumsum(commands.wheel_rates[:, wheel] * commands.period)])
    return commands.period * np.arange(len(angles)), angles


def test_wheels_that_do_not_come_to_turn_evenly_are_refused():
    soft = ROBOT.replace(servo={"bandwidth": 0.5})
    recording = dd.simulate(soft, dd.maneuvers.arc(soft, radius=1.0, distance=1.0, speed=0.5))
    with refused(ValueError, "too short"):
        steady_arc(recording, soft)


def test_how_uneven_the_wheels_are_explains_what_the_path_is_off():
    """A servo that is still settling: the path is off the arc by less than its wheels say, and by more than nothing."""
    soft = ROBOT.replace(servo={"bandwidth": 3.0})
    arc = steady_arc(dd.simulate(soft, dd.maneuvers.arc(soft, radius=1.0, distance=4.0, speed=0.5)), soft)
    assert 0.3 < arc.off < arc.unsteady + 1


def test_a_rate_costs_nothing_on_a_circle_and_much_where_the_curvature_varies():
    circle = dd.simulate(ROBOT, dd.maneuvers.arc(ROBOT, radius=1.0, distance=6.0, speed=1.0), sample_rate=500)
    slalom = dd.simulate(ROBOT, dd.maneuvers.slalom(ROBOT, waves=1.0), sample_rate=500)
    losses = [sampled_odometry(run, ROBOT, 2.0).loss for run in (circle.during(2.0, 6.0), slalom)]
    assert losses[0] < 1e-6
    assert losses[1] > 1e-3
    # It is of second order.
    half = sampled_odometry(slalom, ROBOT, 20.0).loss / sampled_odometry(slalom, ROBOT, 40.0).loss
    assert half == pytest.approx(4, rel=0.1)


def test_at_the_recorded_rate_it_is_the_odometry_of_the_recording():
    recording = dd.simulate(ROBOT, dd.maneuvers.square(ROBOT, side=0.3), sample_rate=100)
    sampled = sampled_odometry(recording, ROBOT, 100.0)
    assert sampled.path == pytest.approx(recording.odometry(ROBOT), abs=1e-7)
    assert sampled.loss < 1e-7
    assert float(sampled.drift.max_position) < 1e-6


@given(robots, sizes(0.05, 3.0))
def test_a_gentle_ramp_uses_half_of_the_largest_acceleration_and_no_less_time_than_asked(robot, speed):
    from diffdrive_mj.physics.limits import largest_acceleration

    assert gentle_ramp(robot, speed, least=1e-6) == pytest.approx(2 * speed / largest_acceleration(robot))
    assert gentle_ramp(robot, speed, least=1e6) == 1e6


def test_warnings_of_others_are_not_hidden(monkeypatch):
    from diffdrive_mj.judging import rolling

    def warning(*arguments, **options):
        warnings.warn("mine", UserWarning, stacklevel=1)
        return dd.simulate(*arguments, **options)

    monkeypatch.setattr(rolling, "simulate", warning)
    with pytest.warns(UserWarning, match="mine"):
        simulate_rolling(ROBOT, dd.maneuvers.straight(ROBOT, speed=0.2, distance=0.1))


def test_a_flow_sensor_and_a_start_reach_the_simulation():
    drive = dd.maneuvers.straight(ROBOT, speed=0.2, distance=0.1)
    recording = simulate_rolling(ROBOT, drive, start=(1.0, 2.0, 0.5), flow_sensor=dd.FlowSensor(x=0.1))
    assert recording.truth[0] == pytest.approx((1.0, 2.0, 0.5))
    assert np.hypot(*recording.flow[-1]) == pytest.approx(0.1, rel=1e-3)
