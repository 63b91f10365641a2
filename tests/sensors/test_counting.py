"""What rounding does to a path: closed forms against counting itself, over many phases."""

import numpy as np
import pytest
from helpers import refused
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from strategies import numbers

import diffdrive_mj as dd
from diffdrive_mj.sensors.counting import Counter, end_error, even_phases, summed_errors, wheel_counters
from diffdrive_mj.sensors.optical_flow import count_error_covariance

ROBOT = dd.Robot.load("mismatched")


def path(seed, steps=60, turn=0.15):
    rng = np.random.default_rng(seed)
    angles = np.cumsum(rng.uniform(0, 0.5, (steps, 2)) + rng.normal(size=(steps, 1)) * (-turn, turn), axis=0)
    angles = np.concatenate([np.zeros((1, 2)), angles])
    return angles, dd.odometry.integrate(angles, ROBOT)


@given(
    hnp.arrays(float, st.integers(1, 20), elements=numbers(-50, 50)),
    st.integers(0, 99),
)
def test_summed_errors_are_those_of_counting(exact, seed):
    """Every phase gives one of the values, as often as stated; their mean is zero, their products the covariance."""
    weights = np.random.default_rng(seed).normal(size=(len(exact), 2))
    values, odds = summed_errors(exact, weights)
    assert odds.sum() == pytest.approx(1.0)
    assert odds @ values == pytest.approx(0.0, abs=1e-9)
    products = values.T * odds @ values
    assert products == pytest.approx(weights.T @ count_error_covariance(exact) @ weights, abs=1e-9)
    # At the middle of each range of phases: 1 - U in it.
    edges = np.concatenate([[0.0], np.cumsum(odds)])
    for value, low, high in zip(values, edges, edges[1:], strict=False):
        if high - low > 1e-6:
            phase = 1 - (low + high) / 2
            assert (np.floor(exact + phase) - exact) @ weights == pytest.approx(value, abs=1e-6)


@pytest.mark.parametrize("seed", range(4))
def test_end_errors_are_those_of_odometry_from_counts(seed):
    angles, truth = path(seed)
    encoder = dd.Encoder(ticks_per_revolution=1000, sample_rate=10)
    law = end_error(truth, wheel_counters(encoder, ROBOT, angles))
    phases = np.random.default_rng(seed).random((20_000, 2))
    counts = np.floor(angles / encoder.tick_angle + phases[:, None, :])
    error = dd.odometry.integrate(encoder.to_angles(counts), ROBOT)[:, -1] - truth[-1]
    position = np.hypot(error[:, 0], error[:, 1])
    for name, errors in (("position", position), ("heading", error[:, 2])):
        square, fourth = np.mean(errors**2), np.mean(errors**4)
        # To first order in the heading's error of a few milliradians.
        assert getattr(law, name) == pytest.approx(np.sqrt(square), rel=0.02)
        assert getattr(law, f"{name}_kurtosis") == pytest.approx(fourth / square**2, rel=0.05)


def test_even_phases_show_with_few_runs_what_many_random_ones_do():
    angles, truth = path(7)
    encoder = dd.Encoder(ticks_per_revolution=1000, sample_rate=10)
    law = end_error(truth, wheel_counters(encoder, ROBOT, angles))
    phases = even_phases(100, np.random.default_rng(0))
    assert ((phases >= 0) & (phases < 1)).all()
    counts = np.floor(angles / encoder.tick_angle + phases[:, None, :])
    error = dd.odometry.integrate(encoder.to_angles(counts), ROBOT)[:, -1, :2] - truth[-1, :2]
    assert np.sqrt((error**2).sum(axis=1).mean()) == pytest.approx(law.position, rel=0.05)


def test_counters_that_read_whole_numbers_err_nowhere():
    straight = [(0, 0, 0), (1, 0, 0), (2, 0, 0)]
    law = end_error(straight, [Counter([0, 5, 10], 0.1, 0.01)])
    assert (law.position, law.heading) == (0.0, 0.0)


def test_shapes_that_do_not_fit_are_refused():
    with refused(ValueError, "weights has shape (2, 1)"):
        summed_errors([0.5], [[1.0], [2.0]])
    with refused(ValueError, "path has shape"):
        end_error([(0, 0), (1, 1)], [])
