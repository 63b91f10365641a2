"""Bounds over boxes of robots: against robots inside, in 50 digits, in their order; branch and bound by itself."""

from __future__ import annotations

import itertools

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from many_robots import drifts, paths
from strategies import drives, robots

import diffdrive_mj as dd
from diffdrive_mj import maneuvers
from diffdrive_mj.estimation import _boxes
from diffdrive_mj.estimation._boxes import Enclosures, maximum
from diffdrive_mj.estimation._drift_enclosure import DriftOverBoxes
from diffdrive_mj.estimation._long_pieces import Circle, LongPieces
from diffdrive_mj.estimation._robot_box import corners, robot_box
from diffdrive_mj.estimation._short_pieces import ShortPieces
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
    "spin": np.array([(0.0, 0.0), (-60.0, 65.0)]),
    "about a wheel": np.array([(0.0, 0.0), (0.0, 150.0)]),
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


@pytest.mark.parametrize("path", PATHS)
def test_nor_of_half_of_all_robots(path):
    """Boxes in whose middle a robot may turn half as far as it differs from those at the edges."""
    box = box_of(part=0.5, heading=3.0)
    drift = DriftOverBoxes(PATHS[path], ROBOT, box, False)
    boxes = np.concatenate([np.stack([box.low, box.high])[None], box.faces])
    points = np.random.default_rng(0).uniform(box.low, box.high, (500, 4))
    found = drifts(PATHS[path], ROBOT, box.lengths(points), points[:, 3])
    upper = drift.enclose(boxes).upper
    assert np.all(np.isfinite(upper))
    assert found.max() <= upper[0]


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


def parts_of(path):
    """The pieces of one kind that make up a path, whichever that is."""
    pieces = wheel_path(PATHS[path] - PATHS[path][0], box_of(part=0.01), False)
    return LongPieces(pieces) if len(pieces.long) else ShortPieces(pieces, box_of(part=0.01))


def ends(angles, at):
    """F of robots given by kappa, g and their heading at the start (N, 3)."""
    kappa, g, heading = at.T
    return paths(angles, kappa - g / 2, kappa + g / 2, np.ones_like(g), heading)[:, -1]


def beyond_second_order(part, angles, center, d):
    """How far the series of a path is off at deviations (N, 3), and what is said of it (N,)."""
    series = part.series(center[None])
    value = series.value[0, 0] + d @ series.slope[:, 0, 0] + np.einsum("ij,ni,nj->n", series.bend[..., 0, 0], d, d)
    rest = np.array([part.rest(center[None], np.abs(one)[None])[0, 0] for one in d])
    return np.abs(ends(angles, center + d) - value), rest


CENTER = np.array([0.23, -0.02, 0.1])


@pytest.mark.parametrize("path", ["straight", "circles", "square", "slalom", "spin", "any"])
def test_what_a_series_leaves_out_is_at_most_what_is_said(path):
    angles = PATHS[path] - PATHS[path][0]
    d = np.random.default_rng(0).uniform(-1, 1, (200, 3)) * CENTER * 10 ** np.linspace(-3, -1, 200)[:, None]
    off, rest = beyond_second_order(parts_of(path), angles, CENTER, d)
    assert np.all(off <= rest + 1e-9)
    # Halved deviations leave an eighth, or less.
    half, less = beyond_second_order(parts_of(path), angles, CENTER, d[:100] / 2)
    assert np.all(less <= 0.13 * rest[:100])
    assert np.all(half <= less + 1e-9)


@pytest.mark.parametrize(
    ("path", "d"),
    [
        ("straight", (0.0, 0.005, 0.0)),  # it turns
        ("straight", (0.05, 0.002, 0.0)),  # it goes farther, and turns a little
        ("circles", (0.0023, -0.0002, 0.0)),  # all wheels are larger: the circle is the same
        ("circles", (0.0, 0.0002, 0.0)),  # the circle is another
        ("spin", (0.002, 0.1, 0.0)),  # it is no spin any more
    ],
)
def test_and_hardly_more_where_all_adds_up(path, d):
    angles = PATHS[path] - PATHS[path][0]
    off, rest = beyond_second_order(parts_of(path), angles, CENTER, np.array([d]))
    assert off[0] <= rest[0] <= 4 * off[0]


def test_nothing_is_said_of_circles_that_might_turn_the_other_way():
    rest = parts_of("circles").rest(np.repeat(CENTER[None], 2, axis=0), np.array([[0.1, 0, 0], [0.3, 0, 0]]))
    assert np.isfinite(rest[0])
    assert np.isinf(rest[1])


def test_the_farthest_point_of_circles_that_start_under_any_heading():
    pieces = wheel_path(PATHS["circles"], box_of(part=0.01), False)
    for half in (0.0, 0.3, 1.0):
        box = box_of(part=0.01, heading=half)
        points = np.random.default_rng(0).uniform(box.low, box.high, (300, 4))
        where = ends(PATHS["circles"], box.physical(points)[1]) * box.physical(points)[0]
        edges = corners(np.stack([box.low, box.high])[None])
        for estimate in (0.5j, -5j, 3 + 0j):
            farthest = Circle(pieces.circle).farthest(*box.physical(edges), np.array([estimate]))[0, 0]
            found = np.abs(where - estimate).max()
            assert found <= farthest
            assert farthest <= found * (1.02 + half**2) + 0.01


def test_robots_that_may_turn_to_either_side_are_on_no_circle():
    straight = wheel_path(PATHS["straight"], box_of(), False).circle
    box = robot_box(ROBOT, None, (0.09, 0.11), (0.09, 0.11), None, 0.0)
    edges = corners(np.stack([box.low, box.high])[None])
    assert np.isinf(Circle(straight).farthest(*box.physical(edges), np.zeros(3, complex))).all()
    assert wheel_path(PATHS["square"], box_of(), True).circle is None


def test_a_long_log_of_noisy_wheels_is_thinned_where_it_is_straight():
    generator = np.random.default_rng(0)
    noisy = np.cumsum(generator.normal(0.2, 0.1, (400, 2)), axis=0)
    ahead = noisy[-1] + np.arange(1, 301)[:, None] * [0.5, 0.25]
    back = ahead[-1] - np.arange(1, 301)[:, None] * [0.5, 0.25]
    angles = np.concatenate([np.zeros((1, 2)), noisy, ahead, back])
    path = wheel_path(angles, box_of(part=0.01), False)
    # Every noisy sample ends a piece; the way out and back is none, up to rounding.
    assert len(np.unique(path.short[:, 1], axis=0)) == pytest.approx(400, abs=3)
    whole = np.cumsum(np.diff(path.short, axis=1).sum(axis=1), axis=0)[-1]
    np.testing.assert_allclose(whole + np.diff(path.long, axis=1).sum(axis=(0, 1)), angles[-1], atol=1e-9)


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
