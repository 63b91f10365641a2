"""True poses from the engine's steps: whole turns are counted from the start's heading on, in however many pieces."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from strategies import numbers

import diffdrive_mj as dd
from diffdrive_mj.physics._motion import Motion, heading
from diffdrive_mj.physics._probes import vertical

ENGINE = dd.Physics(truth="engine")


def quaternions(rotation):
    """As the engine has them, w first."""
    return np.roll(rotation.as_quat(), 1, axis=-1)


def spun(yaw):
    """Upright, turned by angles (N,)."""
    return quaternions(Rotation.from_rotvec(np.multiply.outer(yaw, [0.0, 0.0, 1.0])))


@given(numbers(-3.0, 3.0), numbers(-0.5, 0.5), numbers(-0.5, 0.5))
def test_heading_and_vertical_are_those_of_the_rotation(yaw, pitch, roll):
    rotation = Rotation.from_euler("ZYX", [yaw, pitch, roll])
    q = quaternions(rotation)
    assert heading(q) == pytest.approx(yaw, abs=1e-12)
    assert vertical(q) == pytest.approx(rotation.inv().apply([0, 0, 1]), abs=1e-12)
    # Of unit length, and the same whatever the heading is.
    assert np.linalg.norm(vertical(q)) == pytest.approx(1)
    assert vertical(quaternions(Rotation.from_euler("ZYX", [yaw + 1, pitch, roll]))) == pytest.approx(
        vertical(q), abs=1e-12
    )


@pytest.mark.parametrize("start", [0.0, 2.0, -20.0, 3 * np.pi])
@pytest.mark.parametrize("way", [1, -1])
@given(cut=st.integers(1, 58))
def test_turns_are_counted_on_from_the_start(start, way, cut):
    """Spins of 2.5 turns about a place that moves; the engine knows the heading on the circle alone."""
    turned = start + way * np.linspace(0, 5 * np.pi, 60)
    states = np.zeros((1, 60, 9))
    states[0, :, 0], states[0, :, 1] = 4 + np.linspace(0, 1, 60), np.linspace(0, -2, 60)
    states[0, :, 3:7] = spun(turned)
    motion, pieces = Motion.begin(states[:, 0], np.array([start])), []
    assert motion.poses == pytest.approx(np.array([[0, 0, start]]))
    for piece in (states[:, 1 : 1 + cut], states[:, 1 + cut :]):
        pieces.append(motion.follow(piece, ENGINE))
        motion = motion.after(piece[:, -1], pieces[-1][:, -1])
        assert motion.poses == pytest.approx(pieces[-1][:, -1])
    poses = np.concatenate(pieces, axis=1)[0]
    assert poses[:, 2] == pytest.approx(turned[1:])
    assert poses[:, :2] == pytest.approx(states[0, 1:, :2] - states[0, 0, :2])


def test_some_robots_are_moved_and_the_others_stay():
    headings = np.array([0.1, 0.2, 0.3])
    states = np.zeros((3, 9))
    states[:, 3:7] = spun(headings)
    motion = Motion.begin(states, headings)
    runs = np.array([2, 0])
    assert motion.of(runs).poses[:, 2] == pytest.approx((0.3, 0.1))
    moved = motion.replaced(runs, Motion.begin(states[runs] + [1.0, 2.0, *np.zeros(7)], headings[runs] + 2 * np.pi))
    assert moved.poses[:, 2] == pytest.approx((0.1 + 2 * np.pi, 0.2, 0.3 + 2 * np.pi))
    assert moved.engine.tolist() == [[1, 2], [0, 0], [1, 2]]
    assert motion.engine.tolist() == [[0, 0]] * 3
