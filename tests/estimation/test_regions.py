"""Ellipses and bananas: what they hold, what they are where the noise is small, and that they move with the pose."""

import numpy as np
import pytest
from helpers import refused
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import chi2

import diffdrive_mj as dd
from diffdrive_mj.estimation.regions import ellipse, squared_distance, threshold

ROOT = np.array([[0.02, 0.0, 0.0], [0.1, 0.5, 0.0], [0.05, 0.4, 0.2]])
STATED = ROOT @ ROOT.T


def test_the_threshold_is_the_quantile_of_chi_squared():
    for level in (0.1, 0.5, 0.95, 0.999):
        assert threshold(level) == pytest.approx(chi2.ppf(level, 2), rel=1e-12)


@given(seed=st.integers(0, 1000), level=st.floats(0.01, 0.999))
def test_the_outline_is_where_the_squared_distance_is_the_threshold(seed, level):
    rng = np.random.default_rng(seed)
    root, mean = rng.normal(size=(4, 2, 2)), rng.normal(size=(4, 2))
    stated = root @ np.swapaxes(root, 1, 2)
    off = ellipse(mean, stated, level, 17) - mean[:, None]
    squares = np.einsum("kni,kij,knj->kn", off, np.linalg.inv(stated), off)
    np.testing.assert_allclose(squares, threshold(level), rtol=1e-5)


def test_of_poses_it_is_that_of_their_positions():
    np.testing.assert_array_equal(ellipse((1, 2, 3), STATED), ellipse((1, 2), STATED[:2, :2]))


def test_a_singular_covariance_has_a_line_and_a_zero_one_a_point():
    assert np.ptp(ellipse((0, 0), np.diag([0.04, 0.0])), axis=0) == pytest.approx([0.4 * threshold(0.95) ** 0.5, 0])
    np.testing.assert_array_equal(ellipse((1.0, 2.0), np.zeros((2, 2)), points=5), np.tile([1.0, 2.0], (5, 1)))


@pytest.mark.parametrize("level", [0.5, 0.95])
def test_the_banana_holds_its_share(level):
    """Of poses whose exponential coordinates are normal, with a heading of a third of a radian after 3 m."""
    pose = np.array([3.0, -1.0, 0.7])
    xi = np.random.default_rng(0).normal(size=(20_000, 3)) @ ROOT.T
    places = dd.se2.compose(pose, dd.se2.exp(xi))[:, :2]
    share = np.mean(squared_distance(places, pose, STATED) < threshold(level))
    # It is a region of positions by their likeliest headings: near the level, and not exactly it.
    assert share == pytest.approx(level, abs=0.015)


def test_where_the_noise_is_small_it_is_the_ellipse():
    small, off = 1e-10 * STATED, 1e-5 * np.random.default_rng(0).normal(size=(50, 2)) @ ROOT[:2, :2].T
    expected = np.einsum("ni,ij,nj->n", off, np.linalg.inv(small[:2, :2]), off)
    np.testing.assert_allclose(squared_distance(off, (0, 0, 0), small), expected, rtol=1e-3)


@given(x=st.floats(-9, 9), heading=st.floats(-7, 7))
def test_it_moves_with_the_pose(x, heading):
    places, pose = np.random.default_rng(0).normal(size=(20, 2)), np.array([x, 2.0, heading])
    moved = dd.se2.compose(pose, np.concatenate([places, np.zeros((20, 1))], axis=1))[:, :2]
    here, there = squared_distance(places, (0, 0, 0), STATED), squared_distance(moved, pose, STATED)
    np.testing.assert_allclose(there, here, rtol=1e-6, atol=1e-9)


def test_the_likeliest_heading_is_found():
    """Against every heading in steps of a thousandth of a radian."""
    places = np.random.default_rng(1).normal(size=(30, 2)) * (0.05, 1.0)
    headings = np.linspace(-3, 3, 6001)
    tried = np.concatenate(
        [np.broadcast_to(places[:, None], (30, 6001, 2)), np.tile(headings[:, None], (30, 1, 1))], axis=2
    )
    whitened = np.linalg.solve(ROOT, np.moveaxis(dd.se2.log(tried), -1, 0).reshape(3, -1))
    expected = np.sum(whitened**2, axis=0).reshape(30, -1).min(axis=1)
    np.testing.assert_allclose(squared_distance(places, (0, 0, 0), STATED), expected, rtol=1e-3, atol=1e-3)


def test_bad_input_is_refused():
    with refused(ValueError, "level = 1: must be below 1"):
        threshold(1.0)
    with refused(ValueError, "must be those of positions or of poses"):
        ellipse((0, 0, 0, 0), STATED)
    with refused(ValueError, "covariance", "must be symmetric"):
        ellipse((0, 0), [[1.0, 0.5], [0.0, 1.0]])
    with refused(ValueError, "covariance: must not be singular"):
        squared_distance((0, 0), (0, 0, 0), np.diag([1.0, 0.0, 1.0]))
    with refused(ValueError, "must be (3, 3)"):
        squared_distance((0, 0), (0, 0, 0), np.broadcast_to(np.eye(3), (2, 3, 3)))
