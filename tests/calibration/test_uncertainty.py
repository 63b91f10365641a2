"""Stated uncertainties: the jackknife against fits that really leave drives out, and errors against what was stated."""

import itertools

import numpy as np
import pytest
from planted import BELIEVED, TRUE, ideal, noisy, vector
from real_data import optiodom_folder

import diffdrive_mj as dd
from diffdrive_mj.calibration._uncertainty import _correlation, _jackknife, _not_below, uncertainty
from diffdrive_mj.calibration.paths import least_squares
from diffdrive_mj.drive import Drive


def line(rng, lengths, width=2, count=3):
    """A linear problem: derivatives (M, k, P) and residuals (M, k) of poses."""
    poses = sum(lengths)
    return rng.normal(size=(poses, width, count)), rng.normal(size=(poses, width))


def test_the_jackknife_is_that_of_fits_without_each_part():
    """Against numpy's least squares, with a part really left out, the prior among the rows."""
    rng, lengths = np.random.default_rng(0), (7, 5, 9, 6)
    jacobian, rows = line(rng, lengths)
    edges = np.cumsum([0, *lengths])
    parts = [np.arange(a, b) for a, b in itertools.pairwise(edges)]
    for weight in (0.0, 2.0):
        root = weight * np.eye(3)

        def solution(kept, root=root):
            columns = np.concatenate([jacobian[kept].reshape(-1, 3), root])
            return np.linalg.lstsq(columns, np.concatenate([rows[kept].ravel(), np.zeros(3)]), rcond=None)[0]

        everything = np.arange(edges[-1])
        best = solution(everything)
        without = np.array([solution(np.setdiff1d(everything, part)) - best for part in parts])
        found = _jackknife(jacobian, jacobian @ best - rows, parts, root.T @ root)
        assert found == pytest.approx(3 / 4 * without.T @ without, rel=1e-9)


def test_a_covariance_is_widened_to_the_least_one_and_not_further():
    rng = np.random.default_rng(1)
    root = rng.normal(size=(3, 3))
    least = root @ root.T
    assert _not_below(least, 0 * least) == pytest.approx(least)
    assert _not_below(least, 4 * least) == pytest.approx(4 * least)
    # Along one direction less, along the others more.
    mixed = root @ np.diag([0.1, 2.0, 5.0]) @ root.T
    assert _not_below(least, mixed) == pytest.approx(root @ np.diag([1.0, 2.0, 5.0]) @ root.T)


def test_independent_residuals_of_few_drives_state_the_textbook_covariance():
    rng = np.random.default_rng(2)
    jacobian, rows = line(rng, (400, 300))
    found = uncertainty(jacobian, rows, (400, 300), 1e-9 * np.eye(3), 1.7)
    columns = jacobian.reshape(-1, 3)
    assert found.covariance == pytest.approx(1.7 * np.linalg.inv(columns.T @ columns), rel=1e-6)
    assert (found.parts, found.rough) == (0, False)


@pytest.mark.parametrize(("drives", "parts", "rough"), [(1, 10, True), (2, 10, True), (3, 12, False), (5, 5, False)])
def test_from_what_scatter_the_covariance_of_correlated_residuals_is(drives, parts, rough):
    rng = np.random.default_rng(3)
    jacobian, rows = line(rng, [100] * drives)
    rows = np.cumsum(rows, axis=0)
    assert _correlation([rows[:100]]) > 0.9
    found = uncertainty(jacobian, rows, [100] * drives, np.eye(3), 1.0)
    assert (found.parts, found.rough) == (parts, rough)


def test_correlation_of_short_and_perfect_pieces_is_none():
    assert _correlation([np.ones((3, 2))]) == 0.0
    assert _correlation([np.zeros((30, 2))]) == 0.0


@pytest.mark.parametrize(("count", "noise"), [(3, "per drive"), (6, "per drive"), (6, "per pose")])
def test_errors_are_as_large_as_stated(count, noise):
    """Each drive is of a slightly different robot, as where tyres and floor change from drive to drive; or none is."""
    rng, ratios, independent = np.random.default_rng(count), [], []
    for _ in range(40):
        robots = [
            TRUE.replace(track_width=TRUE.track_width * (1 + 1e-3 * rng.normal() * (noise == "per drive")))
            for _ in range(count)
        ]
        drives = [noisy(ideal(robot, rate=0.05), 1e-3, rng) for robot in robots]
        found = least_squares(drives, BELIEVED, turning_gain=False)
        ratios.append((found.values - vector(TRUE)[:3]) / found.std)
        independent.append(found.std[2] / TRUE.track_width)
    track = np.sqrt(np.mean(np.square(ratios), axis=0))[2]
    assert 0.6 < track < (1.5 if count > 3 else 1.9)
    if noise == "per drive":
        assert np.median(independent) == pytest.approx(1e-3 / np.sqrt(count), rel=0.5)


def test_halves_of_real_recordings_differ_by_what_they_state():
    """A chi-square of one per degree of freedom; with independent residuals it is 450 and more."""
    folder, ratios = optiodom_folder(), []
    for name in ("square/230620202042", "square/230620202317", "circular/250620202104", "circular/250620202236"):
        nominal = dd.logs.optiodom_robot(folder / name)
        drives = [
            Drive(d.t, d.wheel_angles, d.truth[::5], d.clock[::5], d.name) for d in dd.logs.read_optiodom(folder / name)
        ]
        one, other = (least_squares(half, nominal, turning_gain=False) for half in (drives[::2], drives[1::2]))
        gap = one.values - other.values
        ratios.append(gap @ np.linalg.solve(one.covariance + other.covariance, gap) / 3)
    assert 0.25 < np.mean(ratios) < 2
