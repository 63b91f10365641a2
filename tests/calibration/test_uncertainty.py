"""Stated uncertainties: the jackknife against fits that really leave drives out, and errors against what was stated."""

import itertools

import numpy as np
import pytest
from planted import BELIEVED, TRUE, ideal, mixed, noisy, vector
from real_data import optiodom_folder

import diffdrive_mj as dd
from diffdrive_mj.calibration._uncertainty import _not_below, uncertainty
from diffdrive_mj.calibration.paths import least_squares
from diffdrive_mj.drive import Drive


def line(rng, lengths, width=2, count=3):
    """A linear problem: derivatives (M, k, P) and residuals (M, k) of poses."""
    poses = sum(lengths)
    return rng.normal(size=(poses, width, count)), rng.normal(size=(poses, width))


def test_the_jackknife_is_that_of_fits_without_each_drive():
    """Against numpy's least squares, with a drive really left out and the prior among the rows."""
    rng, lengths = np.random.default_rng(0), (7, 5, 9, 6, 8)
    jacobian, rows = line(rng, lengths)
    edges = np.cumsum([0, *lengths])
    for prior_std in (np.full(3, 1e6), np.array([0.5, 1.0, 2.0])):

        def solution(kept, prior_std=prior_std):
            columns = np.concatenate([jacobian[kept].reshape(-1, 3), np.diag(1 / prior_std)])
            return np.linalg.lstsq(columns, np.concatenate([rows[kept].ravel(), np.zeros(3)]), rcond=None)[0]

        everything = np.arange(edges[-1])
        best = solution(everything)
        without = np.array([solution(np.delete(everything, slice(a, b))) for a, b in itertools.pairwise(edges)]) - best
        # Residuals so small in variance that independent ones would leave next to nothing.
        found = uncertainty(jacobian, jacobian @ best - rows, lengths, prior_std, 1e-9, np.zeros((3, 3)))
        assert found.parts == 5
        if prior_std[0] > 1e3:
            assert found.covariance == pytest.approx(4 / 5 * without.T @ without, rel=1e-6)
        assert (np.linalg.eigvalsh(found.covariance - 4 / 5 * without.T @ without) > -1e-9).all()


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
    found = uncertainty(jacobian, rows, (400, 300), np.full(3, 1e6), 1.7, np.zeros((3, 3)))
    columns = jacobian.reshape(-1, 3)
    assert found.covariance == pytest.approx(1.7 * np.linalg.inv(columns.T @ columns), rel=1e-6)
    assert (found.parts, found.rough) == (0, False)


@pytest.mark.parametrize(("drives", "parts", "rough"), [(1, 10, True), (2, 10, True), (3, 12, False), (5, 5, False)])
def test_from_what_scatter_the_covariance_of_correlated_residuals_is(drives, parts, rough):
    rng = np.random.default_rng(3)
    jacobian, rows = line(rng, [100] * drives)
    # Derivatives and residuals that both go on, as those of a path do.
    jacobian, rows = np.cumsum(jacobian, axis=0), np.cumsum(rows, axis=0)
    found = uncertainty(jacobian, rows, [100] * drives, np.full(3, 1e3), 1.0, np.zeros((3, 3)))
    assert (found.parts, found.rough) == (parts, rough)


def test_what_ticks_leave_is_added_to_what_independent_residuals_do():
    rng = np.random.default_rng(6)
    jacobian, rows = line(rng, (400, 300))
    jacobian = jacobian @ rng.normal(size=(3, 3))
    root = 0.1 * rng.normal(size=(3, 3))
    prior_std = np.array([1e4, 3e4, 2e5])
    found = uncertainty(jacobian, rows, (400, 300), prior_std, 1.0, root @ root.T)
    columns = jacobian.reshape(-1, 3)
    assert found.covariance == pytest.approx(np.linalg.inv(columns.T @ columns) + root @ root.T, rel=1e-5)


@pytest.mark.parametrize("lengths", [(200,), (120, 80)])
def test_of_one_or_two_drives_deviations_are_at_least_twice_those_of_independent_residuals(lengths):
    """Of a parameter whose own residuals are none, beside one whose residuals go on; and ticks come on top."""
    jacobian = np.tile(np.eye(2), (200, 1, 1))
    rows = np.stack([np.cumsum(np.random.default_rng(5).normal(size=200)), np.zeros(200)], axis=-1)
    found = uncertainty(jacobian, rows, lengths, np.full(2, 1e3), 1.5, np.diag([0.0, 0.25]))
    assert found.rough
    assert found.covariance[1, 1] == pytest.approx(4 * 1.5 / 200 + 0.25, rel=1e-4)


def test_a_single_drive_that_shows_next_to_nothing_of_a_parameter_has_a_covariance():
    """Its columns are all but the same, and one stretch has all that is left of it."""
    rng = np.random.default_rng(4)
    jacobian, rows = 1e6 * rng.normal(size=(300, 2, 1)) * np.ones(3), np.cumsum(rng.normal(size=(300, 2)), axis=0)
    jacobian[10:20, :, 2] += 1e-3 * rng.normal(size=(10, 2))
    found = uncertainty(jacobian, rows, [300], np.ones(3), 1.0, np.zeros((3, 3)))
    assert np.isfinite(found.covariance).all()
    assert (np.diag(found.covariance) > 0.01).all()


@pytest.mark.parametrize(
    ("count", "noise"), [(3, "per drive"), (6, "per drive"), pytest.param(6, "per pose", marks=pytest.mark.slow)]
)
def test_errors_are_as_large_as_stated(count, noise):
    """Each drive is of a slightly different robot, as where tyres and floor change from drive to drive; or none is."""
    rng, ratios, independent = np.random.default_rng(count), [], []
    for _ in range(20):
        robots = [
            TRUE.replace(track_width=TRUE.track_width * (1 + 1e-3 * rng.normal() * (noise == "per drive")))
            for _ in range(count)
        ]
        drives = [noisy(ideal(robot, mixed(period=0.1), rate=0.5), 1e-3, rng) for robot in robots]
        found = least_squares(drives, BELIEVED, turning_gain=False)
        ratios.append((found.values - vector(TRUE)[:3]) / found.std)
        independent.append(found.std[2] / TRUE.track_width)
    # Of three drives the deviation itself has two degrees of freedom: its quotients are Student's.
    track = np.abs(ratios)[:, 2]
    assert 0.4 < np.median(track) < 1.2
    assert np.mean(track < 2) > (0.85 if count > 3 else 0.7)
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
