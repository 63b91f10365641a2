"""Derivatives by differences: those of the arc, and the robot that an odometry of another kind needs."""

import numpy as np
import pytest
from planted import BELIEVED, TRUE, ideal, mixed, vector

import diffdrive_mj as dd
from diffdrive_mj.estimation.derivatives import trajectory
from diffdrive_mj.estimation.differences import _forward, path_by


def arc(increments, robot):
    """The package's own steps, as a function of a user's."""
    twist = dd.kinematics.body_twist(increments, robot)
    return dd.se2.exp(np.stack([twist[..., 0], np.zeros_like(twist[..., 0]), twist[..., 1]], axis=-1))


@pytest.mark.parametrize("clock_offset", [0.0, 0.013])
@pytest.mark.parametrize("count", [3, 4])
def test_the_arc_has_the_same_derivatives_either_way(clock_offset, count):
    drive = ideal(TRUE, mixed(period=0.05), rate=0.1)
    drive = dd.Drive(drive.t, drive.wheel_angles, drive.truth[3:-3], drive.clock[3:-3] + 0.007)
    exact = trajectory(drive, vector(TRUE), clock_offset, count)
    found = path_by(arc, drive, TRUE, vector(TRUE), clock_offset, count)
    assert found.poses == pytest.approx(exact.poses, abs=1e-9)
    assert found.by_parameters == pytest.approx(exact.by_parameters, rel=1e-5, abs=1e-4)
    assert found.velocity == pytest.approx(exact.velocity, abs=1e-9)


def euler(increments, robot):
    distance, turn = np.moveaxis(dd.kinematics.body_twist(increments, robot), -1, 0)
    return np.stack([distance, np.zeros_like(turn), turn], axis=-1)


@pytest.mark.parametrize("method", ["euler", "midpoint", euler])
def test_a_robot_is_found_with_the_odometry_that_it_has(method):
    """The truth is what that odometry makes of the wheels; exact arcs do not explain it at 10 Hz."""
    fine = ideal(TRUE, mixed(period=0.1))
    truth = dd.odometry.integrate(fine.wheel_angles, TRUE, method)
    drive = dd.Drive(fine.t, fine.wheel_angles, truth)
    found = dd.calibration.least_squares([drive], BELIEVED, method=method, turning_gain=False)
    assert found.values == pytest.approx(vector(TRUE)[:3], rel=1e-6)
    assert float(found.after.max_position.max()) < 1e-6
    other = dd.calibration.least_squares([drive], BELIEVED, turning_gain=False, anyway=True)
    assert float(other.after.max_position.max()) > 1e-4


def test_what_is_no_method_is_refused():
    drive = ideal(TRUE, mixed(period=0.1))
    with pytest.raises(KeyError, match="unknown odometry method 'midpiont'"):
        dd.calibration.least_squares([drive], BELIEVED, method="midpiont")
    with pytest.raises(TypeError, match="not a class"):
        dd.calibration.least_squares([drive], BELIEVED, method=dd.Robot)


def test_whether_the_rims_roll_forwards_goes_by_the_interval_that_begins_at_a_time():
    """Both rims roll 0.1 m forwards, then 0.2 m back, then 0.3 m forwards."""
    drive = dd.Drive([0.0, 1.0, 2.0, 3.0], np.outer([0.0, 1.0, -1.0, 2.0], [1.0, 1.0]), np.zeros((2, 3)), [0.0, 3.0])
    forward = _forward(drive, np.array([0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0]), np.array([0.1, 0.1, 0.3, 1.0]))
    assert forward == pytest.approx([0.2, 0.2, -0.4, -0.4, 0.6, 0.6, 0.6])
