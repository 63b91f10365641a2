"""Exact moments of the pose against closed forms, Monte Carlo and invariances."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from planar_noise import drives_with_noise

import diffdrive_mj as dd
from diffdrive_mj.estimation.moments import WheelNoise, pose_moments

ROBOT = dd.Robot(left_radius=0.100, right_radius=0.091, track_width=0.400)
NOISE = WheelNoise(left=0.002, right=0.002)


def straight(distance, samples=501):
    """Wheel angles of a straight line (samples, 2) [rad]."""
    return np.linspace(0, distance, samples)[:, None] / (ROBOT.left_radius, ROBOT.right_radius)


@pytest.mark.parametrize("distance", [1.0, 50.0, 200.0])
@pytest.mark.parametrize("k", [0.0005, 0.005])
def test_a_straight_line_ends_where_theory_says(distance, k):
    found = pose_moments(straight(distance, 20_001), ROBOT, WheelNoise(left=k, right=k))
    rate = k**2 / ROBOT.track_width**2
    # Along a step the noise turns the robot evenly, where theory's heading is a random walk.
    assert found.mean[-1, 0] == pytest.approx(-math.expm1(-rate * distance) / rate, rel=1e-6)
    assert found.mean[-1, 1:] == pytest.approx([0, 0], abs=1e-9)
    assert found.covariance[-1, 2, 2] == pytest.approx(2 * rate * distance, rel=1e-9)


def test_a_turn_on_the_spot_is_as_uncertain_as_its_wheels_have_rolled():
    half = math.pi * ROBOT.track_width / 2  # of a wheel, a turn
    angles = np.linspace(0, 1, 201)[:, None] * (-half / ROBOT.left_radius, half / ROBOT.right_radius)
    found = pose_moments(angles, ROBOT, NOISE)
    assert found.covariance[-1, 2, 2] == pytest.approx(2 * 0.002**2 * half / ROBOT.track_width**2, rel=1e-9)
    assert found.mean[-1, 2] == pytest.approx(math.pi)


@given(seed=st.integers(0, 100), x=st.floats(-5, 5), heading=st.floats(-6, 6))
def test_another_start_moves_and_turns_both(seed, x, heading):
    angles = np.cumsum(np.random.default_rng(seed).normal(0.5, 1.0, (20, 2)), axis=0)
    here, there = (pose_moments(angles, ROBOT, NOISE, start) for start in ((0, 0, 0), (x, 1.0, heading)))
    np.testing.assert_allclose(there.mean[-1], dd.se2.compose((x, 1.0, heading), here.mean[-1]), atol=1e-12)
    turn = np.eye(3)
    turn[:2, :2] = [[math.cos(heading), -math.sin(heading)], [math.sin(heading), math.cos(heading)]]
    np.testing.assert_allclose(there.covariance[-1], turn @ here.covariance[-1] @ turn.T, atol=1e-12)


def test_without_noise_it_is_odometry():
    angles = np.cumsum(np.random.default_rng(0).normal(0.5, 1.0, (50, 2)), axis=0)
    found = pose_moments(angles, ROBOT, WheelNoise(left=0.0, right=0.0), (1.0, 2.0, 3.0))
    np.testing.assert_allclose(found.mean, dd.odometry.integrate(angles, ROBOT, start=(1, 2, 3)), atol=1e-12)
    np.testing.assert_allclose(found.covariance, 0, atol=1e-12)


@pytest.mark.parametrize("seed", range(3))
def test_mean_and_covariance_are_those_of_monte_carlo(seed):
    generator = np.random.default_rng(seed)
    angles = np.cumsum(generator.normal(1.0, 1.5, (300, 2)), axis=0)
    noise = WheelNoise(left=0.005, right=0.003)
    found = pose_moments(angles, ROBOT, noise)
    ends = drives_with_noise(angles, ROBOT, (0.005, 0.003), 40_000, generator)
    off = ends - found.mean[-1]
    assert np.all(np.abs(off.mean(axis=0)) < 4 * found.sigma[-1] / 200)
    products = np.einsum("ni,nj->nij", off, off)
    error = products.std(axis=0) / 200
    assert np.all(np.abs(products.mean(axis=0) - found.covariance[-1]) < 4.5 * error)


def test_bad_input_is_refused():
    with pytest.raises(ValueError, match="one drive"):
        pose_moments(np.zeros((2, 5, 2)), ROBOT, NOISE)
    with pytest.raises(TypeError, match="noise"):
        pose_moments(np.zeros((5, 2)), ROBOT, 0.002)
    with pytest.raises(ValueError, match="must not be negative"):
        WheelNoise(left=-0.1, right=0.0)
