"""Exact moments of the pose against Monte Carlo, another recursion and invariances."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from plain_moments import plain_moments
from planar_noise import drives_with_noise, farthest, least_eigenvalue

import diffdrive_mj as dd
from diffdrive_mj.estimation.moments import PoseMoments

ROBOT = dd.Robot(left_radius=0.100, right_radius=0.091, track_width=0.400)
NOISE = dd.WheelNoise(left=0.002, right=0.003)


def wheels(distance, turn):
    """Wheel angles (T, 2) of steps' distances and turns (S,)."""
    steps = np.stack(np.broadcast_arrays(distance, turn), axis=-1)
    return np.vstack([(0, 0), np.cumsum(dd.kinematics.wheel_rates(steps, ROBOT), axis=0)])


def square(side, samples):
    one = np.concatenate([np.full(samples, side / samples), np.zeros(20)])
    turns = np.concatenate([np.zeros(samples), np.full(20, math.pi / 40)])
    return wheels(np.tile(one, 4), np.tile(turns, 4))


def wandering(distance, samples):
    turns = 0.3 * np.random.default_rng(5).normal(size=samples)
    return wheels(np.full(samples, distance / samples), turns)


PATHS = {
    "straight of 200 m": wheels(np.full(400, 0.5), 0.0),
    "arc of 100 m": wheels(np.full(300, 1 / 3), 0.02),
    "square of 50 m": square(12.5, 60),
    "spin of 20 turns": wheels(np.zeros(300), np.full(300, 40 * math.pi / 300)),
    "random path of 200 m": wandering(200.0, 400),
}
Random = st.integers(0, 2**32 - 1)


def random_drive(seed, samples=20):
    return np.cumsum(np.random.default_rng(seed).normal(0.5, 1.0, (samples, 2)), axis=0)


@pytest.mark.parametrize("path", PATHS)
@pytest.mark.parametrize("k", [(0.002, 0.002), (0.005, 0.003)])
def test_mean_covariance_and_nees_are_those_of_monte_carlo(path, k):
    angles = PATHS[path]
    found = dd.covariance(angles, ROBOT, noise=dd.WheelNoise(left=k[0], right=k[1]))
    ends = drives_with_noise(angles, ROBOT, k, 40_000, np.random.default_rng(2))
    assert max(farthest(ends, found.mean[-1], found.covariance[-1])) < 4


@given(seed=Random, k=st.tuples(st.floats(0, 0.02), st.floats(0, 0.02)))
@settings(max_examples=25)
def test_another_recursion_gives_the_same(seed, k):
    angles = random_drive(seed, 40)
    found = dd.covariance(angles, ROBOT, noise=dd.WheelNoise(left=k[0], right=k[1]))
    mean, covariance = plain_moments(angles, ROBOT, k)
    np.testing.assert_allclose(found.mean, mean, atol=1e-12)
    np.testing.assert_allclose(found.covariance, covariance, atol=1e-10)


@pytest.mark.parametrize("steps", [20, 20_000])
def test_blocks_of_steps_and_runs_give_what_single_drives_give(steps):
    angles = np.cumsum(np.random.default_rng(3).normal(0.2, 0.3, (3, 2, steps, 2)), axis=-2)
    together = dd.covariance(angles, ROBOT, noise=NOISE)
    odometer = dd.MomentOdometer(ROBOT, NOISE)
    for sample in angles[2, 1]:
        last = odometer.update(sample)
    np.testing.assert_allclose(together.mean[2, 1, -1], last, rtol=1e-9)
    np.testing.assert_allclose(together.covariance[2, 1, -1], odometer.covariance, rtol=1e-9)


def test_a_drive_whose_heading_is_long_lost_neither_underflows_nor_overflows():
    """Two hundred metres to and fro with a noise that turns the robot by several turns: where products are 1e-300."""
    ways = np.tile(np.repeat([1.0, -1.0], 50), 200)
    angles = np.vstack([(0, 0), np.cumsum(ways)[:, None] * (1.0, 1.1)])
    with np.errstate(all="raise", under="ignore"):
        found = dd.covariance(angles, ROBOT, noise=dd.WheelNoise(left=0.2, right=0.2))
    assert found.covariance[-1, 2, 2] > 1000
    assert np.isfinite(found.covariance).all()
    # No direction is left: the place scatters alike to all sides.
    assert found.covariance[-1, 0, 0] == pytest.approx(found.covariance[-1, 1, 1], rel=0.02)


@given(seed=Random, x=st.floats(-5, 5), heading=st.floats(-6, 6))
def test_another_start_moves_and_turns_both(seed, x, heading):
    angles = random_drive(seed)
    here, there = (dd.covariance(angles, ROBOT, noise=NOISE, start=start) for start in ((0, 0, 0), (x, 1.0, heading)))
    np.testing.assert_allclose(there.mean, dd.se2.compose((x, 1.0, heading), here.mean), atol=1e-12)
    turn = np.eye(3)
    turn[:2, :2] = [[math.cos(heading), -math.sin(heading)], [math.sin(heading), math.cos(heading)]]
    np.testing.assert_allclose(there.covariance, turn @ here.covariance @ turn.T, atol=1e-12)


@given(seed=Random)
def test_a_mirrored_robot_ends_in_the_mirror(seed):
    angles = random_drive(seed)
    here = dd.covariance(angles, ROBOT, noise=NOISE)
    other = ROBOT.replace(left_radius=ROBOT.right_radius, right_radius=ROBOT.left_radius)
    there = dd.covariance(angles[:, ::-1], other, noise=dd.WheelNoise(left=NOISE.right, right=NOISE.left))
    flip = np.array([1, -1, -1])
    np.testing.assert_allclose(there.mean, here.mean * flip, atol=1e-12)
    np.testing.assert_allclose(there.covariance, here.covariance * np.outer(flip, flip), atol=1e-12)


@given(seed=Random)
def test_a_robot_that_drives_backwards_ends_behind(seed):
    """The wheels that turn the other way with the robot turned round: the same path, mirrored at the start."""
    angles = random_drive(seed)
    here = dd.covariance(angles, ROBOT, noise=NOISE)
    there = dd.covariance(-angles, ROBOT, noise=NOISE)
    flip = np.array([-1, 1, -1])
    np.testing.assert_allclose(there.mean, here.mean * flip, atol=1e-12)
    np.testing.assert_allclose(there.covariance, here.covariance * np.outer(flip, flip), atol=1e-12)


@given(seed=Random)
def test_two_halves_make_a_whole(seed):
    """Not exactly: the pose between them is not Gaussian. To first order it is."""
    angles = random_drive(seed, 21)
    small = dd.WheelNoise(left=1e-5, right=2e-5)
    whole = dd.covariance(angles, ROBOT, noise=small)
    half = dd.covariance(angles[:11], ROBOT, noise=small)
    rest = dd.covariance(angles[10:], ROBOT, noise=small, start=half.mean[-1], start_covariance=half.covariance[-1])
    np.testing.assert_allclose(rest.mean[-1], whole.mean[-1], atol=1e-9)
    np.testing.assert_allclose(rest.covariance[-1], whole.covariance[-1], atol=1e-6 * whole.covariance[-1].max())


def test_steps_that_are_halved_approach_a_limit_by_a_factor_of_their_length():
    ends = [dd.covariance(wheels(np.full(n, 20 / n), 3 / n), ROBOT, noise=NOISE) for n in (50, 100, 200, 400)]
    means, covariances = (np.array([getattr(end, name)[-1] for end in ends]) for name in ("mean", "covariance"))
    np.testing.assert_allclose(covariances[:, 2, 2], covariances[0, 2, 2], rtol=1e-12)  # the heading's is the same
    gaps = np.abs(np.diff(means[:, 0]))
    np.testing.assert_allclose(gaps[:-1] / gaps[1:], 2, rtol=0.05)


@given(seed=Random, k=st.tuples(st.floats(0, 0.05), st.floats(0, 0.05)))
def test_a_covariance_has_no_negative_eigenvalue(seed, k):
    found = dd.covariance(random_drive(seed), ROBOT, noise=dd.WheelNoise(left=k[0], right=k[1]))
    assert least_eigenvalue(found.covariance[1:]) > -1e-12


def test_without_noise_it_is_odometry():
    angles = random_drive(0, 50)
    for noise in ((), NOISE.of_variances(left=0, right=0)):
        found = dd.covariance(angles, ROBOT, noise=noise, start=(1.0, 2.0, 3.0))
        np.testing.assert_allclose(found.mean, dd.odometry.integrate(angles, ROBOT, start=(1, 2, 3)), atol=1e-12)
        assert not found.covariance.any()


def test_an_uncertain_start_is_that_of_monte_carlo():
    scatter = np.array([[0.01, 0.002, 0.01], [0.002, 0.02, -0.02], [0.01, -0.02, 0.3]])
    generator = np.random.default_rng(1)
    angles = wandering(30.0, 100)
    found = dd.covariance(
        angles, ROBOT, noise=dd.WheelNoise(left=0.005, right=0.005), start=(1, 2, 0.5), start_covariance=scatter
    )
    starts = generator.multivariate_normal((1, 2, 0.5), scatter, 40_000)
    ends = dd.se2.compose(starts, drives_with_noise(angles, ROBOT, (0.005, 0.005), 40_000, generator))
    assert max(farthest(ends, found.mean[-1], found.covariance[-1])) < 4


def test_starts_broadcast_with_drives():
    angles, starts = np.stack([random_drive(1), random_drive(2)]), np.zeros((4, 1, 3))
    starts[:, 0, 0] = np.arange(4)
    found = dd.covariance(angles, ROBOT, noise=NOISE, start=starts, start_covariance=np.eye(3))
    assert found.mean.shape == (4, 2, 20, 3)
    alone = dd.covariance(angles[1], ROBOT, noise=NOISE, start=(3, 0, 0), start_covariance=np.eye(3))
    np.testing.assert_allclose(found.covariance[3, 1], alone.covariance, atol=1e-12)


def test_drives_and_recordings_are_taken_by_their_wheels():
    angles = random_drive(4)
    drive = dd.Drive(np.arange(20.0), angles, np.zeros((20, 3)))
    np.testing.assert_array_equal(
        dd.covariance(drive, ROBOT, noise=NOISE).covariance, dd.covariance(angles, ROBOT, noise=NOISE).covariance
    )


def test_prints_say_where_and_how_surely():
    found = dd.covariance(np.stack([random_drive(1), random_drive(2)]), ROBOT, noise=NOISE)
    assert "after 19 steps" in str(found)
    assert " to " in str(found)
    assert repr(found) == "PoseMoments((2,) runs of 20 samples, in the frame of the world)"
    assert "<table>" in found._repr_html_()
    assert "forward" in str(PoseMoments(found.mean[0], found.covariance[0], "mean"))
