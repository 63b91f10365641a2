"""In physics as in kinematics: noise is planted in ideal wheel angles, and true poses are where it says."""

from __future__ import annotations

import numpy as np
import pytest

import diffdrive_mj as dd

ROBOT = dd.Robot.load("mismatched")
K, DRIVES = 0.004, 2000


@pytest.mark.parametrize("path", ["square", "slalom"])
def test_true_poses_are_where_noisy_wheels_say_within_what_they_state(path):
    commands = {
        "square": lambda: dd.maneuvers.square(ROBOT, side=2.0),
        "slalom": lambda: dd.maneuvers.slalom(ROBOT),
    }[path]()
    recording = dd.simulate(ROBOT, commands, sample_rate=20.0)
    radii = np.array([ROBOT.left_radius, ROBOT.right_radius])
    sigma = K * np.sqrt(np.abs(np.diff(recording.wheel_angles, axis=0)) * radii) / radii
    generator = np.random.default_rng(2)
    wander = np.cumsum(sigma * generator.normal(size=(DRIVES, *sigma.shape)), axis=1)
    # What was read is off the truth by the noise.
    read = recording.wheel_angles + np.pad(wander, ((0, 0), (1, 0), (0, 0)))
    found = dd.covariance(read, ROBOT, noise=dd.WheelNoise(left=K, right=K), start=recording.truth[0])
    off = recording.truth[-1] - found.mean[:, -1]
    squares = np.einsum("ni,nij,nj->n", off, np.linalg.inv(found.covariance[:, -1]), off) / 3
    assert abs(squares.mean() - 1) < 4 * squares.std() / np.sqrt(DRIVES)
