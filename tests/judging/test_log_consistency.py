"""NEES of logs: as that of arrays, whatever the frame of the estimate, the clocks and the way through a bag."""

import numpy as np
import pytest
from helpers import refused

import diffdrive_mj as dd
from diffdrive_mj.judging.consistency import nees
from diffdrive_mj.judging.log_consistency import nees_of_logs

ROBOT = dd.Robot(left_radius=0.100, right_radius=0.091, track_width=0.400)
NOISE = dd.WheelNoise(left=0.002, right=0.003)
T = 0.1 * np.arange(101)


def logged(runs=30, start=(0.0, 0.0, 0.0), seed=0):
    """True poses at 10 Hz (runs, 101, 3), and what odometry states of them in a frame of its own."""
    rng, u = np.random.default_rng(seed), np.linspace(0, 1, 101)
    read = np.stack([60 * u, 80 * u], axis=-1)
    radii = np.array([ROBOT.left_radius, ROBOT.right_radius])
    sigma = np.array([NOISE.left, NOISE.right]) * np.sqrt(np.diff(read, axis=0) * radii) / radii
    wander = np.cumsum(sigma * rng.normal(size=(runs, *sigma.shape)), axis=1)
    truth = dd.odometry.integrate(read + np.concatenate([np.zeros((runs, 1, 2)), wander], axis=1), ROBOT)
    return truth, dd.covariance(read, ROBOT, noise=NOISE, start=start)


@pytest.mark.parametrize("start", [(0.0, 0.0, 0.0), (3.0, -2.0, 2.5)])
def test_it_is_that_of_the_arrays_whatever_the_frame(start):
    truth, stated = logged(start=start)
    _, plain = logged()
    found = nees_of_logs(
        [dd.PoseLog(T, one) for one in truth],
        [dd.PoseLog(T, stated.mean, covariance=stated.covariance)] * 30,
        samples=101,
    )
    expected = nees(truth, plain.mean, plain.covariance)
    np.testing.assert_allclose(found.squares[:, 2:], expected.squares[:, 2:], rtol=1e-5)
    assert found.holds, str(found)


def test_clocks_may_differ_and_logs_be_of_other_lengths():
    """The truth of every fourth time only, and estimates that end earlier; half of the deviations is not enough."""
    truth, stated = logged(start=(1.0, 2.0, 0.3))
    drives = [dd.Drive(T, np.zeros((101, 2)), one[::4], T[::4]) for one in truth]
    told = [
        dd.PoseLog(T[: 101 - k], stated.mean[: 101 - k], covariance=stated.covariance[: 101 - k]) for k in range(30)
    ]
    found = nees_of_logs(drives, told, samples=40)
    assert found.squares.shape == (30, 40)
    assert found.along[20:].mean() == pytest.approx(1, abs=0.35)
    half = [dd.PoseLog(log.t, log.poses, covariance=log.covariance / 4) for log in told]
    assert nees_of_logs(drives, half, samples=40).verdict.startswith("overconfident by a factor")


def test_a_bag_says_the_same_as_the_log_that_was_written(tmp_path):
    pytest.importorskip("rosbags", reason="needs the extra ros")
    truth, stated = logged(runs=1)
    log = dd.PoseLog(T, stated.mean, covariance=stated.covariance)
    dd.logs.write(tmp_path / "odom.mcap", log)
    whole, back = (
        nees_of_logs([dd.PoseLog(T, truth[0])], [each]) for each in (log, dd.logs.read_poses(tmp_path / "odom.mcap"))
    )
    np.testing.assert_allclose(back.squares[:, 3:], whole.squares[:, 3:], rtol=1e-6)


def test_bad_input_is_refused():
    truth, stated = logged(runs=1)
    true, odom = dd.PoseLog(T, truth[0]), dd.PoseLog(T, stated.mean, "odom", covariance=stated.covariance)
    with refused(ValueError, "odom: has poses without a covariance"):
        nees_of_logs([true], [dd.PoseLog(T, stated.mean, "odom")])
    with refused(ValueError, "truths has 1 logs and estimates 2"):
        nees_of_logs([true], [odom, odom])
    with refused(ValueError, "truths has 0 logs"):
        nees_of_logs([], [])
    with refused(ValueError, "odom: fewer than two poses lie within the times of late"):
        nees_of_logs([dd.PoseLog(T + 99, truth[0], "late")], [odom])
    with refused(TypeError, "estimates[0]"):
        nees_of_logs([true], [stated])
    with refused(TypeError, "truths[0]"):
        nees_of_logs([truth], [odom])
