"""The law of wrong beliefs against odometry on the wheel angles that both robots see."""

import numpy as np
import pytest
from hypothesis import given
from strategies import drives, poses, robots

import diffdrive_mj as dd
from diffdrive_mj.judging.beliefs import believed_path


@given(drives(), robots, robots, poses)
def test_it_is_what_odometry_believes(angles, believed, true, start):
    """Steps of less than half a turn: an arc is the shorter way from pose to pose."""
    gentle = np.asarray(angles) * 0.3 * true.track_width / (true.left_radius + true.right_radius)
    path = dd.odometry.integrate(gentle, true, start=start)
    expected = dd.odometry.integrate(gentle, believed, start=start)
    assert believed_path(path, believed, true) == pytest.approx(expected, abs=1e-9)


@given(drives(), robots, robots)
def test_with_the_robots_exchanged_it_is_the_way_back(angles, believed, true):
    gentle = np.asarray(angles) * 0.3 * true.track_width / (true.left_radius + true.right_radius)
    path = dd.odometry.integrate(gentle, true)
    seen = believed_path(path, believed, true)
    if np.abs(np.diff(seen[:, 2])).max() < 3:
        assert believed_path(seen, true, believed) == pytest.approx(path, abs=1e-8)


def test_a_line_becomes_the_arc_of_the_belief_matrix():
    true = dd.Robot.load("mismatched")
    believed = true.replace(right_radius=true.left_radius)
    scale, turn = dd.kinematics.belief_matrix(believed, true)[:, 0]
    along = np.linspace(0.0, 15.0, 301)
    line = np.stack([along, 0 * along, 0 * along], axis=-1)
    arc = dd.se2.exp(np.stack([scale * along, 0 * along, turn * along], axis=-1))
    assert believed_path(line, believed, true) == pytest.approx(arc, abs=1e-11)


def test_runs_have_paths_of_their_own():
    true, rng = dd.Robot.load("mismatched"), np.random.default_rng(0)
    believed = true.replace(track_width=0.5)
    paths = rng.normal(size=(2, 4, 9, 3))
    together = believed_path(paths, believed, true)
    for k in np.ndindex(2, 4):
        assert together[k] == pytest.approx(believed_path(paths[k], believed, true), abs=1e-12)


def test_what_is_not_a_path_is_named():
    robot = dd.Robot.load("matched")
    with pytest.raises(dd.DiffdriveError, match="path has shape"):
        believed_path(np.zeros((4, 2)), robot, robot)
