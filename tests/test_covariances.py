"""Covariances as inputs, and squared distances in them, against SciPy and in every kind of bad shape."""

import numpy as np
import pytest
from helpers import refused
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import multivariate_normal

from diffdrive_mj import _covariances as covariances


def random(seed, size=3, scales=1.0):
    root = np.random.default_rng(seed).normal(size=(size, size)) * scales
    return root @ root.T


@given(seed=st.integers(0, 10_000), size=st.integers(1, 6))
def test_a_squared_distance_is_that_in_the_density(seed, size):
    stated = random(seed, size) + 1e-3 * np.eye(size)
    error = np.random.default_rng(seed).normal(size=size)
    expected = -2 * multivariate_normal(cov=stated).logpdf(error) - np.linalg.slogdet(2 * np.pi * stated)[1]
    assert covariances.squared(error, covariances.covariance("C", stated)) == pytest.approx(expected, rel=1e-6)


def test_units_do_not_matter():
    """Metres beside millionths of a radian: nothing is lost to the other's size."""
    stated, error = random(0), np.array([0.3, -0.2, 0.5])
    scale = np.array([1e6, 1.0, 1e-6])
    scaled = covariances.covariance("C", stated * np.outer(scale, scale))
    assert covariances.squared(scale * error, scaled) == pytest.approx(covariances.squared(error, stated))


def test_what_is_singular_has_no_squares():
    flat = np.array([[1.0, 1.0], [1.0, 1.0]])
    found = covariances.squared(np.ones((3, 2)), covariances.covariance("C", [np.eye(2), flat, np.zeros((2, 2))]))
    np.testing.assert_array_equal(found, [2.0, np.nan, np.nan])


def test_rounding_is_no_reason_to_refuse():
    stated = random(1)
    stated[0, 1] *= 1 + 1e-9
    covariances.covariance("C", stated)
    covariances.covariance("C", np.outer([1, 2, 3], [1, 2, 3]) - 1e-9 * np.eye(3))
    covariances.covariance("C", [[1e-22, 3e-22], [2e-22, 1e-22]])  # of less than a nanometre


@pytest.mark.parametrize(
    ("matrix", "words"),
    [
        (np.diag([1.0, -1e-9, 1.0]), "variance 1 is -1e-09: must not be negative"),
        ([[1.0, 0.5], [0.4, 1.0]], "[0, 1] is 0.5 and [1, 0] is 0.4: must be symmetric"),
        ([[1.0, 1.5], [1.5, 1.0]], "must be positive, and correlations at most 1"),
        (np.array([[1, -0.6, -0.6], [-0.6, 1, -0.6], [-0.6, -0.6, 1]]), "must be positive"),
        ([[0.0, 0.5], [0.5, 1.0]], "must be positive"),
        ([[np.nan, 0.0], [0.0, 1.0]], "must be finite"),
    ],
)
def test_what_is_no_covariance_is_named_by_its_index(matrix, words):
    matrix = np.array(matrix)
    with refused(ValueError, "C", words):
        covariances.covariance("C", matrix)
    several = np.broadcast_to(np.eye(len(matrix)), (2, 3, *matrix.shape)).copy()
    several[1, 2] = matrix
    with refused(ValueError, "C[1, 2", words):
        covariances.covariance("C", several)


def test_other_shapes_are_refused():
    with refused(ValueError, "(..., 3, 3)"):
        covariances.covariance("C", np.eye(2), 3)
    with refused(ValueError, "(..., K, K)"):
        covariances.covariance("C", np.ones((2, 3)))


@given(seed=st.integers(0, 100))
def test_a_covariance_in_space_has_the_one_in_the_plane(seed):
    stated = np.stack([random(seed), random(seed + 1)])
    whole = covariances.in_space(stated, 0.5)
    np.testing.assert_array_equal(covariances.in_plane(whole), stated)
    assert np.all(np.linalg.eigvalsh(whole.reshape(2, 6, 6)) > 0)
    assert whole[:, [14, 21, 28]].tolist() == [[0.5] * 3] * 2
