"""The arc at full speed: what uneven wheels explain of a path that is off it."""

import numpy as np
import pytest
from helpers import refused

import diffdrive_mj as dd
from diffdrive_mj.judging.full_speed import STEADY, steady_arc

ROBOT = dd.Robot.load("mismatched")


def planted(wheel, stray, seconds=4.0, robot=ROBOT):
    """A straight drive at 1 m/s in which one wheel strays from turning evenly, by so many metres of its rim."""
    commands = dd.maneuvers.straight(robot, speed=1.0, distance=1.0 + seconds, ramp=1.0)
    t = np.arange(0.0, commands.duration + 1e-9, commands.period)
    angles = np.concatenate([np.zeros((1, 2)), np.cumsum(commands.wheel_rates * commands.period, axis=0)])
    angles[:, wheel] += (
        np.interp(t, [0, 1 + 0.75 * seconds, 1 + 0.76 * seconds], [0, 0, 1])
        * np.interp(t, [0, 1 + 0.76 * seconds, 1 + 0.77 * seconds], [1, 1, 0])
        * stray
        / (robot.left_radius, robot.right_radius)[wheel]
    )
    truth = dd.odometry.integrate(angles, robot)
    return dd.Recording(t, angles, truth, robot, commands, dd.World(), dd.Physics())


@pytest.mark.parametrize("wheel", [0, 1])
def test_a_wheel_that_strays_explains_its_way_and_what_it_turns_the_robot_by(wheel):
    """e (1 / L + 2 / b) of a path of 2 m."""
    arc = steady_arc(planted(wheel, 1e-5), ROBOT)
    assert np.ptp(arc.recording.t) == pytest.approx(2.0, abs=0.03)
    assert arc.unsteady == pytest.approx(1e6 * 1e-5 * (1 / 2 + 2 / ROBOT.track_width), rel=0.05)
    assert arc.off < arc.unsteady


def test_wheels_that_stray_by_more_than_a_ten_thousandth_are_refused():
    least = STEADY / (1 / 2 + 2 / ROBOT.track_width)
    assert STEADY == 1e-4
    steady_arc(planted(0, 0.9 * least), ROBOT)
    with refused(ValueError, "too short", "still speed up"):
        steady_arc(planted(0, 1.1 * least), ROBOT)


def test_a_drive_without_two_samples_at_full_speed_is_refused():
    seldom = planted(0, 0.0).at_rate(0.5)  # at 4 s, between 3 and 5 s, and no other time
    with refused(ValueError, "too short", "no time at full speed"):
        steady_arc(seldom, ROBOT)
    twice = planted(0, 0.0, seconds=3.5).at_rate(1.0)  # at 3 and 4 s, between 2.7 and 4.5 s
    assert len(steady_arc(twice, ROBOT).recording.t) == 2
