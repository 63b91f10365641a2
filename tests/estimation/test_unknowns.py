"""Parameters that are not known, the same along the whole drive, against Monte Carlo."""

from __future__ import annotations

import numpy as np
import pytest
from planar_noise import drives_of_robots, farthest, least_eigenvalue
from test_moments import PATHS, ROBOT, wandering, wheels

import diffdrive_mj as dd
from diffdrive_mj.calibration import least_squares
from diffdrive_mj.estimation.unknowns import parameter_covariance

BELIEVED = (ROBOT.left_radius, ROBOT.right_radius, ROBOT.track_width)
# Radii alike by half, and the track on its own.
COVARIANCE = np.array([[1.0, 0.3, 0.0], [0.3, 1.0, 0.1], [0.0, 0.1, 40.0]])
PATH = wandering(40.0, 120)


@pytest.mark.parametrize("sigma", [2e-4, 2e-3])
@pytest.mark.parametrize("path", ["wandering", "straight of 200 m"])
def test_mean_and_covariance_are_within_two_per_cent_of_monte_carlo(sigma, path):
    """Up to headings that are off by two radians and more."""
    angles = PATH if path == "wandering" else PATHS[path][::20] / 10
    found = dd.covariance(angles, ROBOT, parameters=sigma**2 * COVARIANCE)
    robots = np.random.default_rng(7).multivariate_normal(BELIEVED, sigma**2 * COVARIANCE, 100_000)
    ends = drives_of_robots(angles, robots)
    sampled = np.cov(ends.T)
    scale = np.sqrt(np.diag(sampled))
    # Chance leaves a percent of a variance at most.
    assert np.abs((found.covariance[-1] - sampled) / np.outer(scale, scale)).max() < 0.02
    assert np.abs((found.mean[-1] - ends.mean(axis=0)) / scale).max() < 0.02
    assert least_eigenvalue(found.covariance[1:]) > -1e-9


def on_a_grid(angles, covariance):
    """Mean and covariance of where a drive ends, by 30 nodes for each parameter, whatever it does to the heading."""
    nodes, weights = np.polynomial.hermite_e.hermegauss(30)
    drawn = np.stack(np.meshgrid(nodes, nodes, nodes, indexing="ij"), axis=-1).reshape(-1, 3)
    odds = np.einsum("i,j,k->ijk", weights, weights, weights).ravel() / weights.sum() ** 3
    drawn, odds = drawn[odds > 1e-12], odds[odds > 1e-12]
    ends = drives_of_robots(angles, np.array(BELIEVED) + drawn @ np.linalg.cholesky(covariance).T)
    mean = odds @ ends
    return mean, (odds[:, None] * (ends - mean)).T @ (ends - mean)


@pytest.mark.parametrize("sigma", [1e-5, 2e-4, 1e-3, 2e-3])
@pytest.mark.parametrize("angles", [PATH, PATHS["straight of 200 m"][::20] / 10], ids=["wandering", "straight"])
@pytest.mark.parametrize(
    "shape", [COVARIANCE, np.array([[1, -0.9, 0], [-0.9, 1, 0], [0, 0, 10.0]])], ids=["alike", "against each other"]
)
def test_a_few_nodes_along_the_right_axes_do_what_many_do(sigma, angles, shape):
    mean, covariance = on_a_grid(angles, sigma**2 * shape)
    found = dd.covariance(angles, ROBOT, parameters=sigma**2 * shape)
    scale = np.sqrt(np.diag(covariance))
    np.testing.assert_allclose((found.mean[-1] - mean) / scale, 0, atol=2e-4)
    np.testing.assert_allclose((found.covariance[-1] - covariance) / np.outer(scale, scale), 0, atol=2e-4)


@pytest.mark.parametrize("turns", [1, 5, 20])
@pytest.mark.parametrize("share", [1e-4, 1e-3, 1e-2])
def test_whole_turns_on_the_spot_whose_ends_scatter_by_the_third_order_alone(turns, share):
    """Sideways the end is off by the cube of what one radius is off by: a few nodes must see it all the same."""
    robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
    angles = np.linspace(0, 2 * np.pi * turns * 2, 41)[:, None] * (-1, 1)
    found = dd.covariance(angles, robot, parameters={"left_radius": 0.1 * share}).covariance[-1]
    nodes, weights = np.polynomial.hermite_e.hermegauss(60)
    ends = drives_of_robots(angles, np.array([0.1, 0.1, 0.4]) + nodes[:, None] * (0.1 * share, 0, 0))
    expected = np.cov(ends.T, aweights=weights, ddof=0)
    np.testing.assert_allclose(np.diag(found), np.diag(expected), rtol=0.002, atol=1e-20)


def test_noise_parameters_and_start_add_up_to_monte_carlo():
    generator = np.random.default_rng(3)
    scatter = np.diag([1e-4, 1e-4, 0.01])
    noise = dd.WheelNoise(left=0.004, right=0.004)
    found = dd.covariance(
        PATH, ROBOT, noise=noise, parameters=1e-8 * COVARIANCE, start=(1, 2, 3), start_covariance=scatter
    )
    robots = generator.multivariate_normal(BELIEVED, 1e-8 * COVARIANCE, 40_000)
    x, y, theta = generator.multivariate_normal((1, 2, 3), scatter, 40_000).T
    for turned in np.diff(PATH, axis=0):
        ways = robots[:, :2] * turned
        left, right = (ways + 0.004 * np.sqrt(np.abs(ways)) * generator.normal(size=ways.shape)).T
        turn = (right - left) / robots[:, 2]
        chord = (left + right) / 2 * np.sinc(turn / 2 / np.pi)
        x, y, theta = x + chord * np.cos(theta + turn / 2), y + chord * np.sin(theta + turn / 2), theta + turn
    assert max(farthest(np.stack([x, y, theta], axis=-1), found.mean[-1], found.covariance[-1])) < 4


def test_a_track_that_is_not_known_turns_a_spin_by_its_share():
    spin = wheels(np.zeros(100), np.full(100, 0.1))
    found = dd.covariance(spin, ROBOT, parameters={"track_width": 0.0004})
    assert found.sigma[-1, 2] == pytest.approx(10 * 0.001, rel=1e-5)
    assert found.sigma[-1, :2] == pytest.approx([0, 0], abs=1e-12)


def test_a_scale_that_is_not_known_lengthens_the_way_alone():
    sizes = np.array(BELIEVED)
    found = dd.covariance(PATH, ROBOT, parameters=1e-6 * np.outer(sizes, sizes))
    mean = dd.odometry.integrate(PATH, ROBOT)
    np.testing.assert_allclose(found.covariance[-1, :2, :2], 1e-6 * np.outer(mean[-1, :2], mean[-1, :2]), rtol=1e-6)
    assert found.covariance[-1, 2, 2] < 1e-15


def test_a_calibration_is_taken_as_it_is():
    commands = dd.maneuvers.square(ROBOT, side=1.0)
    recordings = [dd.simulate(ROBOT, commands), dd.simulate(ROBOT, dd.maneuvers.figure_eight(ROBOT))]
    tracker = dd.Tracker(position_noise=0.002, heading_noise=0.02)
    drives = [dd.sensors.measure(each, tracker=tracker, seed=seed) for seed, each in enumerate(recordings)]
    calibrated = least_squares(drives, ROBOT)
    found = dd.covariance(PATH, calibrated.calibrated, parameters=calibrated)
    same = dd.covariance(PATH, calibrated.calibrated, parameters=calibrated.covariance)
    np.testing.assert_array_equal(found.covariance, same.covariance)
    assert 1e-5 < found.sigma[-1, 2] < 0.1


def test_a_ratio_moves_both_radii():
    sigma = 1e-6
    found = parameter_covariance({"radius_ratio": sigma}, ROBOT)
    ratio = ROBOT.radius_ratio + sigma
    left = 2 * ROBOT.mean_radius / (1 + ratio)
    moved = np.array([left, ratio * left]) - (ROBOT.left_radius, ROBOT.right_radius)
    np.testing.assert_allclose(found[:2, :2], np.outer(moved, moved), rtol=1e-5)
    np.testing.assert_array_equal(found, parameter_covariance({"speed_ratio": sigma}, ROBOT))


def test_a_turning_gain_may_be_uncertain_too():
    robot = ROBOT.replace(turning_gain=0.02)
    spin = wheels(np.zeros(100), np.full(100, 0.1))
    found = dd.covariance(spin, robot, parameters={"turning_gain": 0.001})
    assert found.sigma[-1, 2] == pytest.approx(10 * 0.001, rel=1e-6)
