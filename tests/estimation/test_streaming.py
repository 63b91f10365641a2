"""Odometry with a covariance, one sample at a time, against arrays."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test_moments import NOISE, ROBOT, random_drive

import diffdrive_mj as dd

SCATTER = np.array([[0.01, 0.002, 0.01], [0.002, 0.02, -0.02], [0.01, -0.02, 0.3]])


@given(seed=st.integers(0, 2**32 - 1), scale=st.sampled_from([1e-3, 0.1, 10.0]))
@settings(max_examples=20)
def test_it_gives_the_numbers_of_arrays(seed, scale):
    angles = scale * random_drive(seed, 30)
    whole = dd.covariance(angles, ROBOT, noise=NOISE, start=(1, 2, 3), start_covariance=SCATTER)
    odometer = dd.MomentOdometer(ROBOT, NOISE, (1, 2, 3), SCATTER)
    for sample, mean, covariance in zip(angles, whole.mean, whole.covariance, strict=True):
        np.testing.assert_allclose(odometer.update(sample), mean, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(odometer.covariance, covariance, rtol=1e-9, atol=1e-12)
    assert odometer.moments.mean.shape == (1, 3)
    np.testing.assert_array_equal(odometer.moments.mean[0], odometer.pose)


def test_a_turning_gain_is_taken_into_account():
    angles, robot = random_drive(3), ROBOT.replace(turning_gain=0.2)
    odometer = dd.MomentOdometer(robot, NOISE)
    for sample in angles:
        last = odometer.update(sample)
    whole = dd.covariance(angles, robot, noise=NOISE)
    np.testing.assert_allclose(last, whole.mean[-1], rtol=1e-9)
    np.testing.assert_allclose(odometer.covariance, whole.covariance[-1], rtol=1e-9)


def test_without_noise_it_is_the_odometer():
    angles = random_drive(0)
    sure = dd.MomentOdometer(ROBOT, dd.WheelNoise(left=0.0, right=0.0))
    plain = dd.odometry.Odometer(ROBOT)
    for sample in angles:
        np.testing.assert_allclose(sure.update(sample), plain.update(sample), atol=1e-12)
    assert not sure.covariance.any()


def test_a_sample_that_is_refused_changes_nothing():
    odometer = dd.MomentOdometer(ROBOT, NOISE)
    odometer.update((0.0, 0.0))
    before = odometer.update((1.0, 1.0))
    for bad in ((np.nan, 0.0), (1.0, 2.0, 3.0), (0.0, 1e6)):
        with pytest.raises(ValueError, match="wheel_angles"):
            odometer.update(bad)
    np.testing.assert_array_equal(odometer.pose, before)
    odometer.update((2.0, 2.0))
    np.testing.assert_allclose(odometer.pose[2], 2 * before[2])
