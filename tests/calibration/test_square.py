"""The square's geometry: first order, any size, what the scatter of runs says."""

import math

import numpy as np
import pytest
from helpers import refused
from hypothesis import given
from hypothesis import strategies as st
from strategies import numbers

import diffdrive_mj as dd
from diffdrive_mj.calibration import _square as square
from diffdrive_mj.calibration._square_drives import return_errors
from diffdrive_mj.calibration._square_scatter import covariance, outliers

BELIEVED = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)


def wheels(ratio, track=0.4):
    """The robot of a radius ratio and a track, with the believed mean radius."""
    return square.corrected(BELIEVED, ratio, track)


@given(alpha=numbers(-1e-4, 1e-4), beta=numbers(-1e-4, 1e-4), side=numbers(0.5, 10.0))
def test_first_order_of_the_sums(alpha, beta, side):
    ends = square.square_ends(np.array([alpha, beta]), side)
    for s, end in zip((1, -1), ends, strict=True):
        expected = [2 * side * (s * beta - alpha), 2 * side * (s * alpha - beta), 4 * (beta - s * alpha)]
        assert end == pytest.approx(expected, abs=1e-6 * side)


@given(alpha=numbers(-0.01, 0.01), beta=numbers(-0.01, 0.01), side=numbers(0.5, 10.0))
def test_every_form_reads_the_angles_back(alpha, beta, side):
    s = np.array([1, -1])
    rows = [2 * side * (s * beta - alpha), 2 * side * (s * alpha - beta), 4 * (beta - s * alpha)]
    for form in square.corner_and_side(np.stack(rows, axis=-1), side).values():
        assert form == pytest.approx([alpha, beta], abs=1e-15)


@given(alpha=numbers(-0.15, 0.15), beta=numbers(-0.3, 0.3), side=numbers(0.5, 10.0))
def test_exact_angles_have_no_small_angle(alpha, beta, side):
    ends = square.square_ends(np.array([alpha, beta]), side)
    assert square.angles("exact", ends, side, np.zeros(2)) == pytest.approx([alpha, beta], abs=1e-12)
    assert square.angles("theta", ends, side, np.zeros(2)) == pytest.approx([alpha, beta], abs=1e-15)


@given(side=numbers(0.5, 10.0))
def test_exact_is_the_mean_of_x_and_y_at_zero(side):
    assert square.readout("exact", side) == pytest.approx(square.readout("both", side), abs=1e-8)
    mean = (square.readout("x", side) + square.readout("y", side)) / 2
    assert square.readout("both", side) == pytest.approx(mean, abs=1e-15)


@given(ratio=numbers(0.95, 1.05), track=numbers(0.3, 0.5), side=numbers(0.3, 2.0))
def test_headings_give_the_ratios_exactly(ratio, track, side):
    """What a robot turns by along a side and at a corner, from its kinematics, and back."""
    rates = dd.kinematics.wheel_rates([(side, 0.0), (0.0, math.pi / 2)], BELIEVED)
    beta, quarter = dd.kinematics.body_twist(rates, wheels(ratio, track))[:, 1]
    found = square.error_ratios(math.pi / 2 - quarter, beta, side, BELIEVED.track_width)
    assert found == pytest.approx((ratio, track / BELIEVED.track_width), rel=1e-12)


def test_published_radius_of_the_side():
    """The paper takes the side for the chord of its arc: beta^2 / 24 of the mismatch apart."""
    beta, side, track = 0.1, 4.0, 0.4
    radius = side / 2 / math.sin(beta / 2)
    published = (radius + track / 2) / (radius - track / 2)
    assert published - 1 == pytest.approx((square.error_ratios(0, beta, side, track)[0] - 1) * (1 - beta**2 / 24), 1e-4)


@given(ratio=numbers(0.8, 1.25), track=numbers(0.2, 0.6))
def test_corrected_keeps_the_mean_radius(ratio, track):
    robot = wheels(ratio, track)
    assert robot.mean_radius == pytest.approx(BELIEVED.mean_radius, rel=1e-15)
    assert robot.radius_ratio == pytest.approx(ratio, rel=1e-14)
    assert robot.track_width == track


def test_angles_that_no_robot_turns_by():
    with refused(ValueError, "corners left"):
        square.error_ratios(1.6, 0.0, 1.0, 0.4)
    with refused(ValueError, "one wheel"):
        square.error_ratios(0.0, 6.0, 1.0, 0.4)


def test_few_good_runs_are_taken_for_outliers():
    rng, ways = np.random.default_rng(2), np.repeat([1.0, -1.0], 5)
    rate = np.mean([outliers(rng.normal(size=(10, 3)), ways).mean() for _ in range(200)])
    assert rate < 0.01
    assert not outliers(rng.normal(size=(6, 3)) * [1e3, 1, 1], np.repeat([1.0, -1.0], 3)).any()


def test_the_farther_centroid_and_the_worse_heading():
    centers = np.array([[3.0, -4.0, 0.1], [1.0, 2.0, -0.3]])
    assert square.largest_centroid(centers) == 5.0
    assert square.largest_heading(centers) == 0.3
    assert square.largest_centroid(centers[::-1]) == 5.0
    assert square.largest_heading(-centers) == 0.3


def squares(counts, rng):
    """Squares of 2 m, so many in each direction, their ends scattered; and the directions."""
    drives, directions = [], np.repeat([1.0, -1.0], counts)
    for direction in directions:
        steps = dd.kinematics.wheel_rates([(2.0, 0.0), (0.0, direction * math.pi / 2)] * 4, BELIEVED)
        angles = np.vstack([np.zeros(2), steps.cumsum(axis=0)])
        truth = dd.odometry.integrate(angles, BELIEVED)
        truth[-1] += 1e-3 * rng.normal(size=3)
        drives.append(dd.Drive(np.arange(9.0), angles, truth))
    return drives, directions


@given(shift=numbers(-0.1, 0.1), counts=st.sampled_from([(2, 2), (2, 5), (4, 3)]))
def test_the_covariance_does_not_see_where_the_centroids_are(shift, counts):
    """Only how the runs scatter about the centroid of their own direction; numbers of runs may differ."""
    drives, directions = squares(counts, np.random.default_rng(5))
    left, weights = return_errors(drives, BELIEVED), square.readout("both", 2.0)
    plain, _ = covariance(drives, directions, left, BELIEVED, weights)
    moved, _ = covariance(drives, directions, left + shift * (directions == 1)[:, None], BELIEVED, weights)
    assert moved == pytest.approx(plain, rel=1e-8)


@pytest.mark.parametrize("counts", [(2, 5), (6, 3)])
def test_unequal_numbers_of_runs_have_the_covariance_of_their_means(counts):
    """Errors in y alone, of known variance: alpha = (y_cw - y_ccw) / (-4 L) has the sum of the means' variances.

    The covariance is quadratic in the errors: its mean over independent ones is the sum of those of one run's each.
    """
    scatter = 1e-3
    drives, directions = squares(counts, np.random.default_rng(6))
    weights = square.readout("y", 2.0)
    stated = []
    for run in np.eye(len(drives)):
        left = scatter * run[:, None] * (0.0, 1.0, 0.0)
        stated.append(covariance(drives, directions, left, BELIEVED, weights)[0][1, 1])
    # The track is wrong by 2 / pi of itself for each radian of alpha.
    angle = scatter * math.sqrt(1 / counts[0] + 1 / counts[1]) / (4 * 2.0)
    assert math.sqrt(np.sum(stated)) == pytest.approx(BELIEVED.track_width * 2 / math.pi * angle, rel=0.01)


@pytest.mark.parametrize("counts", [(1, 1), (1, 4), (3, 1)])
def test_one_run_in_a_direction_shows_no_scatter(counts):
    drives, directions = squares(counts, np.random.default_rng(7))
    spread, condition = covariance(
        drives, directions, return_errors(drives, BELIEVED), BELIEVED, square.readout("y", 2.0)
    )
    assert np.isnan(spread).all()
    assert 1 <= condition < 20
