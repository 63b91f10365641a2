"""How exact the physics is, and that the correction of the true pose is no fit: the engine itself converges to it."""

import warnings

import numpy as np
import pytest

import diffdrive_mj as dd
from diffdrive_mj.errors import PhysicsWarning
from diffdrive_mj.robot import presets

MISMATCHED = dd.Robot.load("mismatched")


def arc(robot, period=0.01):
    """The standard arc: constant rates over 10 m."""
    rates = (12.0, 15.0)
    return dd.maneuvers.constant_rates(rates, 10 / float(dd.kinematics.body_twist(rates, robot)[0]), period=period)


DRIVES = {
    "arc": arc(MISMATCHED),
    "figure eight": dd.maneuvers.figure_eight(MISMATCHED, radius=0.5, speed=0.5),
    "slalom": dd.maneuvers.slalom(MISMATCHED, waves=1, speed=1.0),
}


def error(commands, physics, robot=MISMATCHED):
    """The largest position error of odometry from every step's wheel angles [ppm of the distance]."""
    recording = dd.simulate(robot, commands, physics=physics, sample_rate=1 / physics.timestep)
    return 1e6 * float(recording.drift(robot).max_position_per_metre)


@pytest.mark.parametrize("name", DRIVES)
def test_the_uncorrected_engine_converges_to_odometry_with_its_time_step(name):
    """Its error halves with the step, as Euler's rule says, and vanishes in the limit, as the correction says."""
    coarse, middle, fine = (error(DRIVES[name], dd.Physics(timestep=dt, truth="engine")) for dt in (2e-3, 1e-3, 5e-4))
    assert coarse / middle == pytest.approx(2, rel=2e-3)
    assert middle / fine == pytest.approx(2, rel=2e-3)
    assert abs(2 * fine - middle) < 0.12
    assert error(DRIVES[name], dd.Physics()) < 0.12
    assert coarse > 50


@pytest.mark.parametrize("name", presets())
def test_the_default_floor(name):
    robot = dd.Robot.load(name)
    assert error(arc(robot), dd.Physics(), robot) < 0.1
    assert error(dd.maneuvers.figure_eight(robot, radius=0.5), dd.Physics(), robot) < 0.1


def test_the_floor_grows_with_the_square_of_the_time_step():
    """Twice as coarse, four times the error, as the warning of coarse steps promises."""
    robot = dd.Robot.load("ct_bot")
    errors = []
    for dt in (0.005, 0.01, 0.02, 0.05):
        commands = dd.maneuvers.figure_eight(robot, period=max(dt, 0.01))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", PhysicsWarning)
            recording = dd.simulate(robot, commands, physics=dd.Physics(timestep=dt), sample_rate=1 / max(dt, 0.01))
        errors.append(1e6 * float(recording.drift(robot).max_position_per_metre))
    orders = np.diff(np.log(errors)) / np.diff(np.log((0.005, 0.01, 0.02, 0.05)))
    assert orders == pytest.approx(2, abs=0.25)
    # Physics.coarse says 0.5 ppm at 5 ms, and the square of it beyond.
    assert errors == pytest.approx([0.5, 2, 8, 50], rel=0.2)


def test_the_fast_setting_is_within_half_a_part_per_million():
    for name in presets():
        robot = dd.Robot.load(name)
        recording = dd.simulate(robot, dd.maneuvers.figure_eight(robot), physics=dd.Physics.fast())
        assert recording.drift(robot).max_position_per_metre < 0.5e-6
