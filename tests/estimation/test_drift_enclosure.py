"""Bounds over boxes of robots: against robots inside, in 50 digits, in their order; branch and bound by itself."""

from __future__ import annotations

import itertools

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from many_robots import drifts
from strategies import drives, robots

import diffdrive_mj as dd
from diffdrive_mj import maneuvers
from diffdrive_mj.estimation import _boxes
from diffdrive_mj.estimation._boxes import Enclosures, maximum
from diffdrive_mj.estimation._drift_enclosure import DriftOverBoxes
from diffdrive_mj.estimation._robot_box import corners, robot_box
from diffdrive_mj.estimation._wheel_path import wheel_path

ROBOT = dd.Robot(left_radius=0.100, right_radius=0.091, track_width=0.400)


def box_of(robot=ROBOT, part=0.05, heading=0.0):
    tolerances = dd.Tolerances(radius=part, radius_ratio=part, track_width=part)
    return robot_box(robot, tolerances, None, None, None, heading)


def inner_boxes(box, generator, count):
    """Boxes inside of a box (count, 2, 4), of all sizes."""
    low, high = box.low, box.high
    middle = generator.uniform(low, high, (count, 4))
    half = (high - low) / 2 * 10 ** generator.uniform(-4, 0, (count, 4))
    return np.stack([np.maximum(low, middle - half), np.minimum(high, middle + half)], axis=1)


PATHS = {
    "straight": maneuvers.straight(ROBOT, distance=5.0, period=0.1).wheel_angles,
    "circles": maneuvers.arc(ROBOT, radius=0.3, distance=30.0, period=0.1).wheel_angles,
    "square": maneuvers.square(ROBOT, side=1.0, period=0.1).wheel_angles,
    "slalom": maneuvers.slalom(ROBOT, period=0.1).wheel_angles,
    "spins and straights": np.cumsum([(0, 0), (-60, 65), (20, 20), (70, -65), (30, 20)], axis=0),
    "any": np.cumsum(np.random.default_rng(0).normal(0.2, 1.0, (60, 2)), axis=0),
}


@pytest.mark.parametrize("anywhere", [False, True])
@pytest.mark.parametrize("path", PATHS)
def test_no_robot_of_a_box_exceeds_its_bound(path, anywhere):
    generator = np.random.default_rng(1)
    box = box_of(heading=0.2)
    drift = DriftOverBoxes(PATHS[path], ROBOT, box, anywhere)
    inner = inner_boxes(box, generator, 60)
    upper = drift.enclose(inner).upper
    for k, (low, high) in enumerate(inner):
        points = np.concatenate([corners(inner[k : k + 1])[0], generator.uniform(low, high, (40, 4))])
        found = drifts(PATHS[path], ROBOT, box.lengths(points), points[:, 3], anywhere)
        assert found.max() <= upper[k]


@given(robot=robots, angles=drives(), part=st.floats(0, 0.3), seed=st.integers(0, 99))
def test_nor_of_any_drive_and_box(robot, angles, part, seed):
    generator = np.random.default_rng(seed)
    box = box_of(robot, part, heading=part)
    drift = DriftOverBoxes(angles, robot, box, False)
    inner = inner_boxes(box, generator, 4)
    upper = drift.enclose(inner).upper
    for k, (low, high) in enumerate(inner):
        points = np.concatenate([corners(inner[k : k + 1])[0], generator.uniform(low, high, (10, 4))])
        assert drifts(angles, robot, box.lengths(points), points[:, 3]).max() <= upper[k] + 1e-12


@pytest.mark.parametrize("path", PATHS)
def test_rounding_is_counted(path):
    """A box that is a point: its bound holds in 50 digits, and leaves little above."""
    angles, box = PATHS[path], box_of()
    drift = DriftOverBoxes(angles, ROBOT, box, False)
    points = np.random.default_rng(0).uniform(box.low, box.high, (5, 4))
    upper = drift.enclose(np.repeat(points[:, None], 2, axis=1)).upper
    for point, bound in zip(points, upper, strict=True):
        believed = (ROBOT.left_radius, ROBOT.right_radius, ROBOT.track_width)
        exact = abs(exact_end(angles, box.lengths(point)) - exact_end(angles, believed))
        assert exact <= bound <= exact + 1e-6


def exact_end(angles, lengths):
    """Where a drive ends, in 50 digits."""
    with mpmath.workdps(50):
        left, right, track = map(mpmath.mpf, lengths)
        end = mpmath.mpc(0)
        for (l0, r0), (l1, r1) in itertools.pairwise(angles):
            ways = [left * (mpmath.mpf(l1) - mpmath.mpf(l0)), right * (mpmath.mpf(r1) - mpmath.mpf(r0))]
            half = (ways[1] - ways[0]) / track / 2
            first = [mpmath.mpf(l0) - mpmath.mpf(angles[0][0]), mpmath.mpf(r0) - mpmath.mpf(angles[0][1])]
            heading = (right * first[1] - left * first[0]) / track
            end += (ways[0] + ways[1]) / 2 * mpmath.sinc(half) * mpmath.expj(heading + half)
        return complex(end)


@pytest.mark.parametrize("path", PATHS)
def test_the_bound_closes_in_with_the_square_of_the_box(path):
    """What a bound leaves above the linear part is of second order."""
    angles, box = PATHS[path], box_of()
    drift = DriftOverBoxes(angles, ROBOT, box, False)
    middle, half = (box.low + box.high) / 2 + (box.high - box.low) / 7, (box.high - box.low) / 400
    excess = []
    for scale in (1.0, 0.5):
        inner = np.stack([middle - scale * half, middle + scale * half])[None]
        excess.append(drift.enclose(inner).upper[0] - drift.value(corners(inner)[0]).max())
    # What is counted for rounding does not shrink; it is far below.
    assert excess[1] < 0.3 * excess[0] + 1e-6


@pytest.mark.parametrize("path", PATHS)
def test_the_drift_is_that_of_odometry(path):
    box = box_of(heading=0.1)
    points = np.random.default_rng(0).uniform(box.low, box.high, (20, 4))
    for anywhere in (False, True):
        own = DriftOverBoxes(PATHS[path], ROBOT, box, anywhere).value(points)
        other = drifts(PATHS[path], ROBOT, box.lengths(points), points[:, 3], anywhere)
        np.testing.assert_allclose(own, other, atol=1e-8)


def test_few_pieces_stand_for_a_drive_whose_wheels_keep_their_ratio():
    box = box_of(part=0.01)
    ahead = wheel_path(maneuvers.straight(ROBOT, distance=5.0).wheel_angles, box, False)
    around = wheel_path(maneuvers.arc(ROBOT, radius=0.5, distance=30.0).wheel_angles, box, False)
    assert len(ahead.long) == 0
    assert len(ahead.short) < 5
    assert (len(around.long), len(around.short)) == (1, 0)
    bent = maneuvers.slalom(ROBOT, period=0.1).wheel_angles
    assert len(wheel_path(bent, box, False).short) > 0.7 * len(bent)


@pytest.mark.parametrize("path", PATHS)
def test_a_worst_robot_lies_on_a_face(path):
    """Of robots with the same ratios the smallest or the largest drifts most, and lies on a face of a length."""
    generator = np.random.default_rng(0)
    for box in (box_of(), robot_box(ROBOT, None, (0.09, 0.11), (0.085, 0.1), (0.38, 0.41), 0.0)):
        sizes = [0, 1, 2] if box.by_radii else [0, 2]
        drift = DriftOverBoxes(PATHS[path], ROBOT, box, False)
        for point in generator.uniform(box.low, box.high, (20, 4)):
            scaled = np.repeat(point[None], 2, axis=0)
            scaled[0, sizes] *= (box.low[sizes] / point[sizes]).max()
            scaled[1, sizes] *= (box.high[sizes] / point[sizes]).min()
            assert drift.value(scaled).max() >= drift.value(point[None])[0] - 1e-9
            for other in scaled:
                inside = (box.faces[:, 0] <= other + 1e-12) & (other - 1e-12 <= box.faces[:, 1])
                assert inside.all(axis=1).any()


def parabola(boxes):
    """-(x - 0.3)^2 - (y + 0.2)^2 + 1 over boxes, by intervals."""
    off = np.maximum(np.maximum(boxes[:, 0] - (0.3, -0.2), (0.3, -0.2) - boxes[:, 1]), 0)
    return Enclosures(1 - (off**2).sum(axis=1) + 0.1 * (boxes[:, 1] - boxes[:, 0]).max(axis=1), boxes.mean(axis=1),
                      boxes[:, 1] - boxes[:, 0])  # fmt: skip


def height(points):
    return 1 - ((points - (0.3, -0.2)) ** 2).sum(axis=1)


def test_branch_and_bound_finds_a_maximum():
    whole = np.array([[[-2.0, -2.0], [2.0, 2.0]]])
    found = maximum(parabola, height, whole, relative=0.0, absolute=0.01, most=10_000)
    assert 1 <= found.upper <= found.found + 0.01
    assert found.found <= 1
    np.testing.assert_allclose(found.where, (0.3, -0.2), atol=0.1)
    few = maximum(parabola, height, whole, relative=0.0, absolute=0.01, most=5)
    assert few.upper >= found.upper
    assert few.boxes < found.boxes


def test_halves_leave_nothing_out():
    boxes = np.random.default_rng(0).uniform(-1, 0, (7, 2, 3))
    boxes = np.sort(boxes, axis=1)
    halves = _boxes._halves(boxes, boxes[:, 1] - boxes[:, 0])
    volume = np.prod(halves[:, 1] - halves[:, 0], axis=1)
    np.testing.assert_allclose(volume[::2] + volume[1::2], np.prod(boxes[:, 1] - boxes[:, 0], axis=1))
    np.testing.assert_array_equal(halves[::2].min(axis=1), boxes[:, 0])
    np.testing.assert_array_equal(halves[1::2].max(axis=1), boxes[:, 1])
