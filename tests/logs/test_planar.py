"""Poses in space: yaw as the rotation matrices have it, and what is not planar is said or refused."""

import numpy as np
import pytest
from helpers import refused
from hypothesis import given
from hypothesis import strategies as st

from diffdrive_mj.logs import _planar
from diffdrive_mj.logs._planar import planar, spatial


def at(k):
    return f"pose {k}"


def quaternion(yaw, pitch=0.0, roll=0.0):
    """Turned about x, then y, then z: the product of the three."""
    a, b, c = np.array([roll, pitch, yaw]) / 2
    return np.array(
        [
            np.sin(a) * np.cos(b) * np.cos(c) - np.cos(a) * np.sin(b) * np.sin(c),
            np.cos(a) * np.sin(b) * np.cos(c) + np.sin(a) * np.cos(b) * np.sin(c),
            np.cos(a) * np.cos(b) * np.sin(c) - np.sin(a) * np.sin(b) * np.cos(c),
            np.cos(a) * np.cos(b) * np.cos(c) + np.sin(a) * np.sin(b) * np.sin(c),
        ]
    )


def row(*angles, z=0.0, scale=1.0):
    return [1.0, 2.0, z, *(scale * quaternion(*angles))]


angles = st.floats(-0.7, 0.7)


@given(st.floats(-3, 3), st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.floats(0.95, 1.05), st.sampled_from([-1, 1]))
def test_yaw_is_that_of_the_x_axis_whatever_the_norm_and_the_sign(yaw, pitch, roll, scale, sign):
    """Where the x axis points, seen from above: the yaw of yaw-pitch-roll angles."""
    poses, _ = planar("p", np.array([row(yaw, pitch, roll, scale=scale * sign)]), at)
    np.testing.assert_allclose(poses[0], (1, 2, yaw), atol=1e-12)


@given(st.lists(st.floats(-1, 1), min_size=1, max_size=30), st.integers(1, 7))
def test_headings_are_continuous_however_they_are_cut(steps, block):
    yaw = np.cumsum([0.0, *steps])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(_planar, "_BLOCK", block)
        poses, said = planar("p", spatial(np.stack([yaw, yaw, yaw], axis=-1)), at)
    np.testing.assert_allclose(poses, np.stack([yaw, yaw, yaw], axis=-1), atol=1e-12)
    assert said == ()


@pytest.mark.parametrize("block", [1, 7, 40])
def test_headings_go_on_for_turns_over_many_blocks(block, monkeypatch):
    monkeypatch.setattr(_planar, "_BLOCK", block)
    yaw = np.linspace(0.0, -20.0, 41)
    poses, _ = planar("p", spatial(np.column_stack([yaw, yaw, yaw])), at)
    np.testing.assert_allclose(poses[:, 2], yaw, atol=1e-13)


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        ([row(1.0, np.radians(0.99)), row(0.0)], None),
        ([row(1.0, np.radians(1.01)), row(0.0)], "tilts by up to 1 deg"),
        ([row(1.0, 0.0, -np.radians(5)), row(0.0)], "tilts by up to 5 deg"),
        ([row(0.0, z=3.0), row(0.0, z=3.0099)], None),
        ([row(0.0, z=3.0), row(0.0, z=3.0101)], "spreads over 0.01 m in height; x, y and yaw were taken"),
        ([row(0.3, scale=1.0009), row(0.0)], None),
        (
            [row(0.3, scale=1.0011), row(0.0)],
            "quaternions are off their norm of 1 by up to 0.0011, and were normalised",
        ),
        ([row(0.3), row(0.0, scale=0.91)], "up to 0.09"),
    ],
)
def test_what_the_plane_leaves_out_is_said(rows, words):
    _, said = planar("mocap", np.array(rows), at)
    if words is None:
        assert said == ()
    else:
        [line] = said
        assert line.startswith("mocap: ")
        assert words in line


@pytest.mark.parametrize(
    ("bad", "words"),
    [
        ([0, 0, 0, 0, 0, 0, 0], "pose 2: quaternion (0, 0, 0, 0): must have a norm of 1, in the order qx qy qz qw"),
        (row(0.0, scale=1.11), "pose 2: quaternion (0, 0, 0, 1.11)"),
        (row(0.0, scale=0.89), "pose 2: quaternion (0, 0, 0, 0.89)"),
        ([0, 0, 0, 1, 0, 0, 0], "pose 2: the robot leans by 180 deg"),  # w before x, y, z
        (row(0.0, np.radians(46)), "pose 2: the robot leans by 46 deg: z must point up"),
        ([0, np.nan, 0, 0, 0, 0, 1], "pose 2: a number of the pose is not finite"),
        ([0, 0, 0, 0, 0, np.inf, 1], "pose 2: a number of the pose is not finite"),
    ],
)
@pytest.mark.parametrize("block", [2, 100])
def test_what_is_no_pose_on_a_floor_is_refused(bad, words, block, monkeypatch):
    monkeypatch.setattr(_planar, "_BLOCK", block)
    with refused(ValueError, words):
        planar("p", np.array([row(0.0), row(0.1), bad, row(0.2)]), at)


def test_a_robot_may_lean_a_little_less():
    planar("p", np.array([row(0.0, np.radians(44))]), at)
