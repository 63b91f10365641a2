"""What a calibration may be off by, against least squares written down plainly on odometry from rounded readings."""

import numpy as np
import pytest
from helpers import refused

import diffdrive_mj as dd
from diffdrive_mj.judging.accuracy import Fits, expected_covariance, mixed_drive
from diffdrive_mj.maneuvers import Segment, sequence
from diffdrive_mj.odometry import integrate
from diffdrive_mj.report.chance import rms_tolerance

ROBOT = dd.Robot.load("mismatched")
FIELDS = ("left_radius", "right_radius", "track_width")
RATE, STRIDE = 20.0, 4


@pytest.fixture(scope="module")
def recording():
    """Some metres without the physics: ideal wheel angles and the path that follows from them."""
    legs = [[Segment(2, 0, 3)], [Segment(0, 1.6, 1.5)], [Segment(2.5, 2.5, 4)], [Segment(2.5, -2.5, 4)]]
    commands = sequence(ROBOT, legs, period=1 / RATE)
    angles = np.vstack([np.zeros(2), np.cumsum(commands.wheel_rates, axis=0) / RATE])
    t = np.arange(len(angles)) / RATE
    return dd.Recording(t, angles, integrate(angles, ROBOT), ROBOT, commands, dd.World(), dd.Physics())


def tracker(noise):
    return dd.Tracker(sample_rate=RATE / STRIDE, position_noise=noise, heading_noise=noise)


def encoder(ticks):
    return dd.Encoder(ticks_per_revolution=ticks, sample_rate=RATE)


def jacobian(angles):
    """Central differences of the poses by radii, track and start pose (M, 3, 6)."""

    def poses(parameters):
        robot = ROBOT.replace(**dict(zip(FIELDS, parameters[:3], strict=True)))
        return integrate(angles, robot, start=parameters[3:])[::STRIDE]

    at = np.array([*(getattr(ROBOT, field) for field in FIELDS), 0.0, 0.0, 0.0])
    steps = 1e-6 * np.eye(6)
    return np.stack([(poses(at + step) - poses(at - step)) / 2e-6 for step in steps], axis=-1)


@pytest.mark.parametrize("width", [3, 2])
def test_without_rounding_it_is_the_covariance_of_plain_least_squares(recording, width):
    rows = jacobian(recording.wheel_angles)[:, :width].reshape(-1, 6) / 1e-3
    plain = np.linalg.inv(rows.T @ rows)[:3, :3]
    found = expected_covariance(recording, encoder(1e9), tracker(1e-3), headings=width == 3)
    np.testing.assert_allclose(found, plain, rtol=1e-5, atol=1e-6 * np.abs(plain).max())


@pytest.mark.parametrize("ticks", [100, 1000])
def test_ticks_leave_what_rounded_readings_leave(recording, ticks):
    """With poses whose noise is known to be small, and taken to be so by the fit, rounding is all there is."""
    noise, count = 1e-3, 400
    rows = jacobian(recording.wheel_angles)
    turn = np.hypot(*encoder(ticks).heading_per_tick(ROBOT)) / np.sqrt(12)
    along = np.hypot(*encoder(ticks).distance_per_tick(ROBOT)) / 2 / np.sqrt(12)
    weight = 1 / np.sqrt([noise**2 + along**2 / 2] * 2 + [noise**2 + turn**2])
    weighted = (rows * weight[:, None]).reshape(-1, 6)
    phases = np.random.default_rng(1).random((count, 1, 2))
    tick = encoder(ticks).tick_angle
    readings = tick * (np.floor(recording.wheel_angles / tick + phases) - np.floor(phases))
    gaps = integrate(readings, ROBOT)[:, ::STRIDE] - recording.truth[::STRIDE]
    off = np.linalg.lstsq(weighted, (gaps * weight).reshape(count, -1).T, rcond=None)[0][:3].T
    poses = np.linalg.inv(weighted.T @ weighted)[:3, :3]
    expected = np.sqrt(np.diag(expected_covariance(recording, encoder(ticks), tracker(noise)) - poses))
    np.testing.assert_allclose(np.sqrt((off**2).mean(axis=0)), expected, rtol=rms_tolerance(count))


def test_a_tracker_without_noise_is_refused(recording):
    for noise in ((0.0, 0.0), (0.0, 1e-3), (1e-3, 0.0)):
        without = dd.Tracker(sample_rate=RATE / STRIDE, position_noise=noise[0], heading_noise=noise[1])
        with refused(ValueError, "noise"):
            expected_covariance(recording, encoder(1000), without)


def test_rates_that_do_not_divide_each_other_are_refused(recording):
    with refused(ValueError, "multiple"):
        expected_covariance(
            recording, encoder(1000), dd.Tracker(sample_rate=7.0, position_noise=1e-3, heading_noise=1e-3)
        )


def test_errors_of_the_expected_covariance_become_independent():
    rng = np.random.default_rng(0)
    factor = np.array([[2.0, 0, 0], [1.0, 0.5, 0], [-3.0, 0.2, 0.1]])
    errors = rng.standard_normal((20_000, 3)) @ factor.T
    covariances = np.broadcast_to(factor @ factor.T, (len(errors), 3, 3))
    fits = Fits(errors, covariances, 4 * covariances)
    np.testing.assert_allclose(np.cov(fits.standard.T), np.eye(3), atol=0.04)
    found, expected, stated = fits.rms
    assert found == pytest.approx(expected, rel=0.02)
    assert stated == pytest.approx(2 * expected)


def test_the_mixed_drive_is_20_m_long():
    commands = mixed_drive(ROBOT)
    angles = np.vstack([np.zeros(2), np.cumsum(commands.wheel_rates, axis=0) * commands.period])
    assert dd.metrics.travelled(integrate(angles, ROBOT))[-1] == pytest.approx(20.0, rel=1e-9)
