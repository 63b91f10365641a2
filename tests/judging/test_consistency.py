"""NEES and NIS against draws of known distributions, a Kalman filter of the tests' own, and invariances."""

import numpy as np
import pytest
from helpers import refused
from hypothesis import given
from hypothesis import strategies as st

import diffdrive_mj as dd
from diffdrive_mj.estimation.covariance_export import diagonals
from diffdrive_mj.judging.consistency import Consistency, nees, nis

ROBOT = dd.Robot(left_radius=0.100, right_radius=0.091, track_width=0.400)
NOISE = dd.WheelNoise(left=0.002, right=0.003)
ROOT = np.array([[0.1, 0.0, 0.0], [0.03, 0.05, 0.0], [-0.02, 0.1, 0.08]])
STATED = ROOT @ ROOT.T


def drawn(runs, samples=1, seed=0, scale=1.0):
    """Truths around the origin with the stated covariance times the square of a scale (runs, samples, 3)."""
    return scale * np.random.default_rng(seed).normal(size=(runs, samples, 3)) @ ROOT.T


def noisy_drives(runs, seed=0, samples=150):
    """Wheel angles that were read (samples, 2), and true paths (runs, samples, 3) with the noise of the wheels."""
    rng, u = np.random.default_rng(seed), np.linspace(0, 1, samples)
    read = np.stack([80 * u, 100 * u], axis=-1)
    radii = np.array([ROBOT.left_radius, ROBOT.right_radius])
    sigma = np.array([NOISE.left, NOISE.right]) * np.sqrt(np.diff(read, axis=0) * radii) / radii
    wander = np.cumsum(sigma * rng.normal(size=(runs, *sigma.shape)), axis=1)
    return read, dd.odometry.integrate(read + np.concatenate([np.zeros((runs, 1, 2)), wander], axis=1), ROBOT)


@pytest.mark.parametrize("scale", [0.5, 1.0, 2.0])
def test_the_factor_is_that_by_which_variances_are_off(scale):
    found = nees(drawn(2000, scale=scale), np.zeros((1, 3)), STATED)
    assert found.mean == pytest.approx(scale**2, rel=4 * (2 / 3 / 2000) ** 0.5)
    assert found.holds == (scale == 1.0)
    assert found.verdict.startswith(
        {0.5: "timid by a factor 4", 1.0: "honest", 2.0: "overconfident by a factor"}[scale]
    )
    assert f"errors are {found.mean**0.5:.3g} times the stated deviations" in found.verdict or scale == 1.0


def test_shares_are_those_of_the_regions():
    found = nees(drawn(20_000), np.zeros((1, 3)), STATED)
    for level in (0.5, 0.95, 0.99):
        assert found.inside(level) == pytest.approx(level, abs=4 * (level * (1 - level) / 20_000) ** 0.5)


@given(x=st.floats(-9, 9), y=st.floats(-9, 9), heading=st.floats(-9, 9), turns=st.integers(-2, 2))
def test_another_frame_and_whole_turns_change_nothing(x, y, heading, turns):
    truth = drawn(5, 4)
    turn = np.eye(3)
    turn[:2, :2] = [[np.cos(heading), -np.sin(heading)], [np.sin(heading), np.cos(heading)]]
    moved = dd.se2.compose((x, y, heading), truth) + np.array([0, 0, turns * 2 * np.pi])
    here, there = (
        nees(truth, np.zeros((4, 3)), STATED),
        nees(moved, np.full((4, 3), (x, y, heading)), turn @ STATED @ turn.T),
    )
    np.testing.assert_allclose(there.squares, here.squares, rtol=1e-9, atol=1e-9)


def test_in_the_body_errors_are_exponential_coordinates():
    xi, pose = drawn(500), np.array([[3.0, -2.0, 2.5]])
    found = nees(dd.se2.compose(pose, dd.se2.exp(xi)), pose, STATED, frame="mean")
    expected = np.sum(np.linalg.solve(ROOT, xi[:, 0].T) ** 2, axis=0)
    np.testing.assert_allclose(found.squares[:, 0], expected, rtol=1e-9)


@pytest.mark.parametrize("runs", [1, 4, 40])
def test_honest_covariances_are_found_to_be_honest(runs):
    """As often as is claimed at least, where samples are independent and where they are sums along a drive."""
    white, summed = [], []
    for seed in range(300):
        noise = drawn(runs, 30, seed)
        white.append(nees(noise, np.zeros((30, 3)), STATED).holds)
        steps = np.arange(1, 31)[:, None, None]
        summed.append(nees(np.cumsum(noise, axis=1), np.zeros((30, 3)), steps * STATED).holds)
    least = 0.95 - 3 * (0.95 * 0.05 / 300) ** 0.5
    assert min(np.mean(white), np.mean(summed)) >= least


def test_the_exact_covariance_of_a_drive_is_honest_and_half_of_it_is_not():
    read, truth = noisy_drives(60)
    stated = dd.covariance(read, ROBOT, noise=NOISE)
    found = nees(truth, stated.mean, stated.covariance)
    assert found.holds, str(found)
    assert "left out: their covariance is singular" in str(found)  # the start is known
    assert nees(truth, stated.mean, stated.covariance / 2).verdict.startswith("overconfident by a factor")
    assert nees(truth, stated.mean, stated.covariance * 3).verdict.startswith("timid by a factor")


def test_a_constant_diagonal_is_honest_on_average_only():
    """Its mean NEES is 1, since its variances are the mean ones: the verdict sees that it is so at hardly a sample."""
    read, truth = noisy_drives(400)
    stated = dd.covariance(read, ROBOT, noise=NOISE)
    pose = diagonals(np.arange(len(read)) * 0.1, read, ROBOT, NOISE).pose[[0, 1, 5]]
    found = nees(truth, stated.mean, np.diag(pose))
    assert found.mean == pytest.approx(1, abs=0.1)
    assert not found.holds
    assert "on average only" in found.verdict
    assert found.along[-1] > 1.5
    assert found.along[5] < 0.1


def filtered(claimed, steps=400, seed=0):
    """The innovations and their variances of a Kalman filter on a random walk, which has a unit of noise each step."""
    rng = np.random.default_rng(seed)
    walk = np.cumsum(rng.normal(size=steps))
    fixes, x, p = walk + 0.5 * rng.normal(size=steps), 0.0, 0.0
    innovations, variances = [], []
    for z in fixes:
        p += claimed
        innovations.append([z - x])
        variances.append([[p + 0.25]])
        gain = p / (p + 0.25)
        x, p = x + gain * (z - x), (1 - gain) * p
    return innovations, variances


def test_innovations_need_no_truth():
    """A filter with the noise that is there is honest, one that claims a tenth of it is not."""
    assert np.mean([nis(*filtered(1.0, seed=seed)).holds for seed in range(100)]) > 0.9
    assert nis(*filtered(0.1)).verdict.startswith("overconfident")
    assert nis(*filtered(5.0)).verdict.startswith("timid")


def test_innovations_are_independent_trials_and_errors_of_a_drive_are_not():
    squares = np.full((4, 25), 3.0)
    white = Consistency("NIS", squares, 3, True)
    summed = Consistency("NEES", squares, 3, False)
    assert np.diff(white.interval) == pytest.approx(np.diff(summed.interval) / 5, rel=0.1)


def test_it_reads_as_a_table():
    text = str(nees(drawn(100, 3), np.zeros((3, 3)), STATED))
    assert [line.split("  ")[0] for line in text.splitlines()[2:5]] == [
        "mean, over its degrees of freedom", "the same along the drive", "inside of the 50 % region",
    ]  # fmt: skip
    assert text.splitlines()[-2:] == [
        "runs: 100, samples of each: 3",
        nees(drawn(100, 3), np.zeros((3, 3)), STATED).verdict,
    ]
    assert "<caption>honest: NEES" in nees(drawn(100, 3), np.zeros((3, 3)), STATED)._repr_html_()


def test_bad_input_is_refused():
    truth, estimate = np.zeros((5, 3)), np.zeros((5, 3))
    with refused(ValueError, "covariance[2]: [0, 1] is 1 and [1, 0] is 0: must be symmetric"):
        nees(truth, estimate, [np.eye(3)] * 2 + [np.eye(3) + np.eye(3, k=1)] + [np.eye(3)] * 2)
    with refused(ValueError, "covariance: the variance of y is zero at sample 3, where the error is 0.1: must say"):
        off = truth.copy()
        off[3, 1] = 0.1
        nees(off, estimate, np.diag([1.0, 0.0, 1.0]))
    with refused(ValueError, "covariance: singular at every sample"):
        nees(truth, estimate, np.zeros((3, 3)))
    with refused(ValueError, "must broadcast"):
        nees(truth, estimate[:4], np.eye(3))
    with refused(KeyError, "did you mean 'mean'"):
        nees(truth, estimate, np.eye(3), frame="means")
    with refused(ValueError, "confidence = 1.5: must be below 1"):
        nis(truth, np.eye(3), confidence=1.5)
    with refused(ValueError, "must be (..., 3, 3)"):
        nis(truth, np.eye(2))
