"""The least-squares problem: derivatives against differences, planted robots leave nothing, robust scales."""

import numpy as np
import pytest
from helpers import refused
from hypothesis import given
from strategies import numbers

import diffdrive_mj as dd
from diffdrive_mj.calibration._first_guess import linear_fit
from diffdrive_mj.calibration._problem import Problem, _spread
from diffdrive_mj.estimation.derivatives import parameters_of

BELIEVED = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
TRUE = BELIEVED.replace(left_radius=0.102, right_radius=0.097, track_width=0.413, turning_gain=0.02)


def driven(true, start, late=0.0, noise=0.0, seed=0, every=7):
    """A winding drive of 12 s; true poses from `late` on, between the encoder's samples too."""
    t = np.arange(0, 12, 0.05)
    angles = np.stack([6 * t + 4 * np.sin(t), 6 * t - 4 * np.sin(t) + 3 * np.sin(2.3 * t)], axis=-1)
    clock = t[:-1][t[:-1] >= late][::every] + 0.02
    times = np.union1d(t, clock)
    between = np.stack([np.interp(times, t, wheel) for wheel in angles.T], axis=-1)
    truth = dd.odometry.integrate(between, true, start=start)[np.searchsorted(times, clock)]
    return dd.Drive(t, angles, truth + noise * np.random.default_rng(seed).normal(size=truth.shape), clock)


def problem(drives, start, *, clock_offset=False, headings=True):
    return Problem(drives, BELIEVED, start=start, clock_offset=clock_offset, headings=headings)


def differences(of, x, step=1e-6):
    """Derivatives of residuals by differences (N, P)."""
    return np.stack([(of.residuals(x + d) - of.residuals(x - d)) / (2 * step) for d in step * np.eye(len(x))], axis=-1)


@pytest.mark.parametrize("headings", [True, False])
@pytest.mark.parametrize("count", [3, 4])
def test_a_pinned_start_has_the_derivatives_of_the_way_from_it(headings, count):
    """With noise, so that the gaps are not zero; the truth starts after the encoder, and at any pose."""
    drives = [driven(TRUE, (3.0, -2.0, 1.0), 0.5, 0.02, 1), driven(TRUE, (-1.0, 5.0, -2.5), 2.0, 0.02, 2)]
    pinned, x = problem(drives, "truth", headings=headings), parameters_of(TRUE)[:count]
    numeric = differences(pinned, x)
    assert pinned.jacobian(x) == pytest.approx(numeric, abs=1e-6 * np.abs(numeric).max())


@pytest.mark.parametrize("clock_offset", [True, False])
@pytest.mark.parametrize("headings", [True, False])
def test_an_estimated_start_is_projected_out(clock_offset, headings):
    """Without noise: the derivative of Kaufman is that of the residuals where these are zero."""
    drives = [driven(TRUE, (3.0, -2.0, 1.0), 0.5), driven(TRUE, (-1.0, 5.0, -2.5), 2.0)]
    free, x = problem(drives, "estimated", clock_offset=clock_offset, headings=headings), parameters_of(TRUE)
    numeric = differences(free, x)
    assert free.jacobian(x) == pytest.approx(numeric, abs=1e-5 * np.abs(numeric).max())


@given(x=numbers(-5, 5), y=numbers(-5, 5), theta=numbers(-3, 3), late=numbers(0, 5))
def test_the_true_robot_leaves_nothing_wherever_it_starts(x, y, theta, late):
    drive = driven(TRUE, (x, y, theta), late)
    for start in ("estimated", "truth"):
        for headings in (True, False):
            of = problem([drive], start, headings=headings)
            assert np.abs(of.residuals(parameters_of(TRUE))[:-4]).max() < 1e-6
            assert of.residuals(parameters_of(TRUE))[-4:] == pytest.approx(
                (parameters_of(TRUE) - parameters_of(BELIEVED)) / of.prior_std
            )


def test_a_pinned_start_without_headings_has_the_heading_of_the_first_pose():
    """It does not lay the path as a whole over the positions."""
    true = TRUE.replace(turning_gain=0.0)
    drive = driven(true, (1.0, 2.0, 0.5))
    turned = dd.Drive(drive.t, drive.wheel_angles, drive.truth + np.array([0.0, 0.0, 0.3]), drive.clock)
    gap = problem([turned], "truth", headings=False).terms(parameters_of(true)[:3])[0].gap
    from_start = drive.truth[:, :2] - drive.truth[0, :2]
    assert gap[:, :2] == pytest.approx(dd.se2.rotate(from_start, 0.3) - from_start, abs=1e-9)


def test_a_clock_offset_is_one_step_away():
    drive = driven(TRUE, (1.0, 2.0, 0.5), 0.5)
    late = dd.Drive(drive.t, drive.wheel_angles, drive.truth[:-3], drive.clock[:-3] + 0.003)
    (terms,) = problem([late], "estimated", clock_offset=True).terms(parameters_of(TRUE))
    assert terms.clock_step == pytest.approx(0.003, abs=2e-4)


def test_the_scale_is_that_of_the_good_poses():
    """One in ten is a hundred times worse."""
    values = np.random.default_rng(0).normal(size=(1000, 2))
    assert _spread(values) == pytest.approx(1.0, rel=0.05)
    values[::10] *= 100
    assert _spread(values) == pytest.approx(1.0, rel=0.2)


@given(left=numbers(0.08, 0.12), right=numbers(0.08, 0.12), track=numbers(0.3, 0.5), theta=numbers(-3, 3))
def test_the_linear_fit_of_exact_poses_is_the_robot(left, right, track, theta):
    true = dd.Robot(left_radius=left, right_radius=right, track_width=track)
    drives = [driven(true, (1.0, 2.0, theta), every=3), driven(true, (0.0, 0.0, -theta), 1.0, every=3)]
    assert linear_fit(drives, BELIEVED) == pytest.approx([left, right, track, 0.0], rel=1e-9, abs=1e-12)


def test_the_linear_fit_counts_turns_of_sparse_truth_by_odometry():
    true = BELIEVED.replace(track_width=0.41)
    t = np.arange(0, 20, 0.05)
    angles = np.stack([4 * t + np.sin(t), 12 * t + np.cos(t)], axis=-1)
    truth = dd.odometry.integrate(angles, true)
    truth[:, 2] = dd.se2.wrap_angle(truth[:, 2])
    sparse = dd.Drive(t, angles, truth[::50], t[::50])  # five radians from one pose to the next
    assert linear_fit([sparse], BELIEVED) == pytest.approx([0.1, 0.1, 0.41, 0.0], rel=1e-9, abs=1e-12)


def test_the_linear_fit_of_a_wheel_that_counts_backwards_is_the_belief():
    drive = driven(TRUE, (0.0, 0.0, 0.0))
    for signs in ((-1, 1), (1, -1), (-1, -1)):
        reversed_ = dd.Drive(drive.t, drive.wheel_angles * signs, drive.truth, drive.clock)
        assert linear_fit([reversed_], BELIEVED) == pytest.approx(parameters_of(BELIEVED))


def test_each_drive_has_unknowns_of_its_own():
    """Two drives of two positions are eight measurements of nine unknowns."""
    drive = driven(TRUE, (0.0, 0.0, 0.0))
    ends = dd.Drive(drive.t, drive.wheel_angles, drive.truth[[0, -1]], drive.clock[[0, -1]])
    with refused(ValueError, "8 measurements for 9 unknowns"):
        problem([ends, ends], "estimated", headings=False)
    problem([ends, ends, ends, drive], "estimated", headings=False)


@pytest.mark.parametrize("angles", [np.outer(np.arange(50.0), (1, 1)), np.outer(np.arange(50.0), (0, 1))])
def test_the_linear_fit_of_a_drive_that_does_not_show_enough_is_the_belief(angles):
    drive = dd.Drive(np.arange(50.0), angles, dd.odometry.integrate(angles, TRUE))
    assert linear_fit([drive], BELIEVED) == pytest.approx(parameters_of(BELIEVED))


@pytest.mark.parametrize("ticks", [32, 64])
def test_the_linear_fit_is_not_misled_by_a_coarse_encoder_beside_dense_poses(ticks):
    """Single steps of no tick or one attenuate the slopes: radii came out 20 to 50 % off."""
    rng = np.random.default_rng(ticks)
    t = np.arange(0, 30, 0.02)
    angles = np.stack([60 * np.sin(t / 5), 60 * np.sin(t / 5) + 25 * np.sin(t / 2)], axis=-1)
    truth = dd.odometry.integrate(angles, TRUE.replace(turning_gain=0.0))
    tick = 2 * np.pi / ticks
    drive = dd.Drive(t, np.floor(angles / tick + rng.random(2)) * tick, truth)
    assert linear_fit([drive], BELIEVED) == pytest.approx(parameters_of(TRUE) * (1, 1, 1, 0), rel=0.01)
