"""Covariances for ROS 2: their places in the messages, and a filter like robot_localization's that is given them."""

import numpy as np
import pytest
from helpers import refused
from hypothesis import given
from hypothesis import strategies as st

import diffdrive_mj as dd
from diffdrive_mj.estimation import covariance_export as export

ROBOT = dd.Robot(left_radius=0.100, right_radius=0.091, track_width=0.400)
NOISE = dd.WheelNoise(left=0.002, right=0.003)


def test_a_pose_is_laid_out_row_by_row():
    stated = np.array([[4.0, 1.0, 0.3], [1.0, 9.0, 0.2], [0.3, 0.2, 1.0]])
    whole = export.pose_message(stated, unseen=0.5).reshape(6, 6)
    for i, row in zip((0, 1, 5), stated, strict=True):
        assert whole[i, [0, 1, 5]].tolist() == row.tolist()
        assert whole[i, 2:5].tolist() == [0, 0, 0]
    assert np.diag(whole)[2:5].tolist() == [0.5] * 3


@given(
    left=st.floats(-20, 20),
    right=st.floats(-20, 20),
    interval=st.floats(0.001, 1.0),
    k=st.tuples(st.floats(0.0005, 0.01), st.floats(0.0005, 0.01)),
)
def test_a_twist_over_an_interval_is_as_uncertain_as_the_step(left, right, interval, k):
    """The covariance of a small step's way and turn, from the exact moments, over the interval squared."""
    noise = dd.WheelNoise(left=1e-3 * k[0], right=1e-3 * k[1])  # small, so that the first order is all there is
    whole = export.twist_message((left, right), ROBOT, dd.WheelNoise(left=k[0], right=k[1]), interval).reshape(6, 6)
    step = 1e-3 * interval  # short, so that a chord is its arc
    angles = np.array([[0.0, 0.0], [left * step, right * step]])
    exact = dd.covariance(angles, ROBOT, noise=noise).covariance[-1] * 1e6 / (step * interval)
    expected = exact[np.ix_([0, 2], [0, 2])]
    scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    found = whole[np.ix_([0, 5], [0, 5])] - export.LEAST * np.eye(2)
    np.testing.assert_allclose(found, expected, atol=2e-2 * scale.max() + 1e-12, rtol=2e-2)


def test_twists_of_a_robot_that_stands_have_no_variance_that_a_filter_replaces():
    whole = export.twist_message((0.0, 0.0), ROBOT, NOISE, 0.02).reshape(6, 6)
    assert np.diag(whole).min() >= 1e-9
    assert np.linalg.eigvalsh(whole).min() > 0


def filtered(rates, h, covariances, process):
    """The covariance of x, y and yaw that a filter states which fuses speeds: the prediction and correction of an EKF
    with the states x, y, yaw, v, vy, omega, written out after the source of robot_localization in two_d_mode."""
    state, spread = np.zeros(6), 1e-9 * np.eye(6)
    seen = np.eye(6)[3:]
    for twist, stated in zip(rates, covariances, strict=True):
        c, s = np.cos(state[2]), np.sin(state[2])
        move = np.eye(6)
        move[0, 3], move[0, 4], move[1, 3], move[1, 4], move[2, 5] = c * h, -s * h, s * h, c * h, h
        move[0, 2], move[1, 2] = (-s * state[3] - c * state[4]) * h, (c * state[3] - s * state[4]) * h
        state = move @ np.array([*state[:2], 0, *state[3:]]) + np.array([0, 0, state[2], 0, 0, 0])
        spread = move @ spread @ move.T + h * np.diag(process)
        noise = stated.reshape(6, 6)[np.ix_([0, 1, 5], [0, 1, 5])]
        gain = spread @ seen.T @ np.linalg.inv(seen @ spread @ seen.T + noise)
        state = state + gain @ (np.array([twist[0], 0.0, twist[1]]) - state[3:])
        left = np.eye(6) - gain @ seen
        spread = left @ spread @ left.T + gain @ noise @ gain.T
    return spread[:3, :3]


def process():
    """The process noise of the configuration that is written, of the states that `filtered` has."""
    yaml = pytest.importorskip("yaml")
    numbers = yaml.safe_load(export.robot_localization())["ekf_filter_node"]["ros__parameters"][
        "process_noise_covariance"
    ]
    return np.diag(np.reshape(numbers, (15, 15)))[[0, 1, 5, 6, 7, 11]]


@pytest.mark.parametrize("rates", [(4.0, 4.4), (4.0, 6.0), (-3.0, 3.5)])
@pytest.mark.parametrize("h", [0.02, 0.05])
def test_a_filter_that_is_given_it_states_the_covariance_that_the_noise_has(rates, h):
    """At any rate of messages: what is fused is the twist, what is stated grows as the exact covariance does."""
    count = round(15 / h)
    steps = np.tile(rates, (count, 1))
    stated = export.twist_message(steps, ROBOT, NOISE, h)
    found = filtered(dd.kinematics.body_twist(steps, ROBOT), h, stated, process())
    angles = np.arange(count + 1)[:, None] * h * np.array(rates)
    exact = dd.covariance(angles, ROBOT, noise=NOISE).covariance[-1]
    scale = np.sqrt(np.outer(np.diag(exact), np.diag(exact)))
    np.testing.assert_allclose(found / scale, exact / scale, atol=0.05)


def test_the_default_process_noise_drowns_what_the_messages_say():
    steps = np.tile((5.0, 5.5), (750, 1))
    stated = export.twist_message(steps, ROBOT, NOISE, 0.02)
    found = filtered(dd.kinematics.body_twist(steps, ROBOT), 0.02, stated, [0.05, 0.05, 0.06, 0.025, 0.025, 0.02])
    exact = dd.covariance(np.arange(751)[:, None] * 0.02 * np.array([5.0, 5.5]), ROBOT, noise=NOISE).covariance[-1]
    assert found[0, 0] > 1000 * exact[0, 0]


def test_the_configuration_has_the_names_and_the_order_of_robot_localization():
    yaml = pytest.importorskip("yaml")
    words = yaml.safe_load(export.robot_localization("/base/odom", rate=50))["ekf_filter_node"]["ros__parameters"]
    assert (words["odom0"], words["frequency"], words["two_d_mode"]) == ("/base/odom", 50.0, True)
    assert [k for k, fused in enumerate(words["odom0_config"]) if fused] == [6, 7, 11]  # vx, vy, vyaw of fifteen
    assert len(words["odom0_config"]) == 15
    noise = np.array(words["process_noise_covariance"])
    assert noise.shape == (225,)
    assert all(isinstance(value, float) for value in words["process_noise_covariance"])
    assert np.linalg.eigvalsh(noise.reshape(15, 15)).min() > 0


def path(seed, samples=60):
    rng = np.random.default_rng(seed)
    t = np.cumsum(rng.uniform(0.02, 0.2, samples))
    return t, np.cumsum(rng.uniform(0.0, 1.5, (samples, 2)), axis=0)


@given(seed=st.integers(0, 1000), part=st.integers(0, 2), factor=st.floats(0.2, 5.0))
def test_no_other_constant_diagonal_is_nearer_to_the_distributions_along_the_drive(seed, part, factor):
    """By the Kullback-Leibler divergence, in the mean over the time of the drive."""
    t, angles = path(seed)
    best = export.diagonals(t, angles, ROBOT, NOISE).pose[[0, 1, 5]]
    along = np.diagonal(dd.covariance(angles, ROBOT, noise=NOISE).covariance, axis1=-2, axis2=-1)
    mean = np.trapezoid(along, t, axis=0) / (t[-1] - t[0])

    def divergence(diagonal):
        return np.sum(mean / diagonal + np.log(diagonal))

    other = best.copy()
    other[part] *= factor
    assert divergence(best) <= divergence(other) + 1e-9


def test_along_a_straight_line_it_is_what_the_growth_says():
    """The variances of heading, way and side grow with the way, the way and its cube: 2, 2 and 4 times their mean."""
    t = np.linspace(0, 20, 2001)
    small = dd.WheelNoise(left=1e-4, right=1e-4)
    found = export.diagonals(t, np.stack([5 * t, 5 * t / 0.91], axis=-1), ROBOT, small)
    assert found.at_end == pytest.approx([2, 4, 2], rel=2e-3)
    assert found.pose[5] == pytest.approx(1e-8 * 10 / 0.4**2, rel=2e-3)


def test_diagonals_read_as_parameters_of_the_controller():
    yaml = pytest.importorskip("yaml")
    found = export.diagonals(*path(0), ROBOT, NOISE, publish_rate=25.0)
    words = yaml.safe_load(str(found))["diff_drive_controller"]["ros__parameters"]
    for name, values in (("pose", found.pose), ("twist", found.twist)):
        assert words[f"{name}_covariance_diagonal"] == pytest.approx(values.tolist(), rel=1e-3)
        assert all(isinstance(value, float) for value in words[f"{name}_covariance_diagonal"])
    assert "A compromise" in str(found)
    assert "pose_covariance_diagonal" in found._repr_html_()


def test_bad_input_is_refused():
    t, angles = path(0)
    with refused(ValueError, "covariance[1]", "variance 2 is -1"):
        export.pose_message([np.eye(3), np.diag([1.0, 1.0, -1.0])])
    with refused(ValueError, "unseen", "must be positive"):
        export.pose_message(np.eye(3), unseen=0.0)
    with refused(ValueError, "interval", "must be positive"):
        export.twist_message((1, 1), ROBOT, NOISE, 0.0)
    with refused(ValueError, "calibrate without it"):
        export.twist_message((1, 1), ROBOT.replace(turning_gain=0.1), NOISE, 0.1)
    with refused(ValueError, "must be (T, 2)"):
        export.diagonals(t[:-1], angles, ROBOT, NOISE)
    with refused(ValueError, "leaves no doubt of the end"):
        export.diagonals(t, angles, ROBOT, dd.WheelNoise(left=0.0, right=0.0))
    with refused(TypeError, "noise"):
        export.twist_message((1, 1), ROBOT, 0.002, 0.1)
    with refused(ValueError, "rate", "must be positive"):
        export.robot_localization(rate=-1.0)
