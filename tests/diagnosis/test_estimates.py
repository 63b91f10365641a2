"""Faults that are planted into an estimate's log, or the truth's, and estimates that are merely bad."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import diffdrive_mj as dd
from diffdrive_mj import se2
from diffdrive_mj.diagnosis._windows import windows
from diffdrive_mj.diagnosis.estimates import _lateness, _moved, _sideways, _sizes, odd_poses
from diffdrive_mj.judging.evaluation import evaluate

ROBOT = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
T = np.arange(0, 30, 0.02)
WHEELS = np.stack([2 * T + 3 * np.sin(T), 2.5 * T + 2 * np.cos(0.7 * T)], axis=-1)
TRUTH = dd.odometry.integrate(WHEELS, ROBOT)
ODOM = dd.odometry.integrate(WHEELS, ROBOT.replace(track_width=0.41, left_radius=0.102))


def odd(truth=TRUTH, estimate=ODOM, t=T, offset=0.0):
    return odd_poses(t, truth, estimate, ("mocap", "odom"), offset)


@settings(deadline=None, max_examples=30)
@given(
    scale=st.floats(0.85, 1.15),
    track=st.floats(0.85, 1.15),
    noise=st.floats(0, 3e-3),
    origin=st.tuples(*[st.floats(-9, 9)] * 3),
    seed=st.integers(0, 99),
)
def test_a_bad_odometry_and_a_noisy_truth_are_no_faults(scale, track, noise, origin, seed):
    rng = np.random.default_rng(seed)
    estimate = dd.odometry.integrate(WHEELS * (scale, 1), ROBOT.replace(track_width=0.4 * track))
    truth = TRUTH + noise * rng.standard_normal(TRUTH.shape)
    x, y, theta = se2.compose(origin, estimate).T
    assert odd(truth, np.stack([x, y, se2.wrap_angle(theta)], axis=-1)) == ()


@pytest.mark.parametrize("late", [-2.0, -0.3, -0.08, 0.08, 0.3, 1.234, 4.0])
@pytest.mark.parametrize("offset", [0.0, 0.5])
def test_clocks_that_are_apart_are_found_with_their_cure(late, offset):
    """The estimate's stamps are late: at the same time it is where the robot was before."""
    truth, odom = dd.PoseLog(T, TRUTH, "mocap"), dd.PoseLog(T + late - offset, ODOM, "odom")
    (said,) = evaluate(truth, odom, offset=offset).warnings
    assert f"the clock of odom looks {abs(late):.2g} s {'late' if late > 0 else 'early'}: offset = " in said
    cure = float(said.partition("offset = ")[2].split()[0])
    assert cure == pytest.approx(offset - late, abs=0.01)
    assert evaluate(truth, odom, offset=offset - late).warnings == ()


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        (TRUTH * (1e3, 1e3, 1), ("odom drives 1000 times as far as mocap", "position_unit")),
        (TRUTH * (0.01, 0.01, 1), ("odom drives 0.01 times", "position_unit")),
        (ODOM * (1, 1, 180 / np.pi), ("odom turns 5", "angle_unit")),
        (ODOM * (1, -1, -1), ("odom turns the other way than mocap",)),
        (ODOM[:, [1, 0, 2]], ("odom moves sideways", "are x and y exchanged")),
        (np.add(ODOM, (0, 0, np.pi / 2)), ("odom moves sideways for 100% of its way", "another axis")),
        (ODOM * (1, 1, -1), ("odom turns the other way", "is theta counter-clockwise")),
    ],
)
def test_units_axes_and_signs_are_found(fault, words):
    assert all(any(word in line for line in odd(estimate=fault)) for word in words)


def test_a_truth_of_another_axis_is_named():
    (said,) = odd(truth=np.add(TRUTH, (0, 0, np.pi / 2)))
    assert said.startswith("mocap moves sideways for 100% of its way")


def test_what_does_not_move_or_is_sparse_shows_nothing():
    still = np.zeros((50, 3))
    assert odd(still, still, np.arange(50) * 0.1) == ()
    assert odd(still, still + 1e-4 * np.random.default_rng(0).standard_normal((50, 3)), np.arange(50) * 0.1) == ()
    assert odd(TRUTH[::100], ODOM[::100] * (1e3, 1e3, 1), T[::100]) == ()  # two seconds apart
    steady = np.stack([T, 0 * T, 0 * T], axis=-1)
    assert odd(steady, steady - (0.3, 0, 0)) == ()  # nothing tells when


def test_a_marker_beside_the_axle_of_a_robot_that_drives_is_no_fault():
    marker = se2.compose(TRUTH, np.array([0.05, 0.03, 0.0]))
    assert odd(truth=marker) == ()


@pytest.mark.parametrize("rate", [0.3, 2.0])
def test_a_marker_that_swings_where_the_robot_spins_is_no_fault(rate):
    spin = np.stack([0 * T, 0 * T, rate * T], axis=-1)
    assert odd(truth=se2.compose(spin, np.array([0.1, 0.05, 0.0])), estimate=spin * (1, 1, 1.02)) == ()


def test_an_estimate_that_stands_still_is_named():
    said = odd(estimate=np.zeros_like(TRUTH))
    assert [line.partition(" times")[0] for line in said] == ["odom drives 0", "odom turns 0"]


# Thresholds, on motions that are given.

NAMES = ("mocap", "odom")


def motions(*rows):
    return np.array(rows, dtype=np.float64)


def test_the_clock_is_cured_without_an_offset_that_was_never_added():
    late = np.stack([np.interp(T - 0.3, T, column) for column in TRUTH.T], axis=-1)
    (said,) = odd_poses(T, TRUTH, late, NAMES)
    assert float(said.partition("offset = ")[2].split()[0]) == pytest.approx(-0.3, abs=0.001)


@pytest.mark.parametrize("late", [-4.9, -4.6, -3.0, 3.0, 4.6, 4.9])
def test_lateness_is_exact_where_nothing_but_the_clock_is_wrong(late):
    """Windows that the shifted estimate does not reach are left out, at either end."""
    t = np.arange(0, 24, 0.05)
    path = path_of(t), path_of(t - late)
    pairs = windows(t)
    assert _lateness(t, _moved(path[0], pairs), path[1], pairs) == pytest.approx(late, abs=1e-4)


@pytest.mark.parametrize(("late", "found"), [(-1.9, True), (1.9, True), (2.1, False)])
def test_clocks_are_tried_as_far_apart_as_a_quarter_of_the_drive(late, found):
    t = np.arange(0, 8.01, 0.05)
    pairs = windows(t)
    lateness = _lateness(t, _moved(path_of(t), pairs), path_of(t - late), pairs)
    assert (lateness == pytest.approx(late, abs=0.01)) == found


def path_of(t):
    """A way whose speed and turn never repeat."""
    return np.stack(
        [t + 0.3 * np.sin(t) + 0.2 * np.sin(2.7 * t), 0 * t, np.sin(0.6 * t) + 2 * np.sin(0.23 * t)], axis=-1
    )


@pytest.mark.parametrize(("way", "seen"), [(0.09, False), (0.11, True), (0.19, True)])
def test_a_tenth_of_a_metre_must_be_seen_of_the_longer_way(way, seen):
    said = [*_sizes(motions((way / 3, 0, 0)), motions((way, 0, 0)), 1.0, NAMES)]
    assert said == ["odom drives 3 times as far as mocap: is the unit of x and y right (position_unit)?"] * seen


@pytest.mark.parametrize(("turn", "seen"), [(0.9, False), (1.1, True)])
def test_a_radian_must_be_seen_of_the_larger_turn(turn, seen):
    said = [*_sizes(motions((0, 0, turn / 2)), motions((0, 0, turn)), 1.0, NAMES)]
    assert said == ["odom turns 2 times as far as mocap: is the unit of theta right (angle_unit)?"] * seen


@pytest.mark.parametrize(
    ("true", "believed", "named"), [(1.0, -1.0, False), (2.0, -1.9, True), (2.0, -1.5, True), (2.0, 1.9, False)]
)
def test_more_than_a_radian_must_be_turned_the_other_way(true, believed, named):
    said = [*_sizes(motions((0, 0, true)), motions((0, 0, believed)), 1.0, NAMES)]
    assert [line.partition(" than")[0] for line in said] == ["odom turns the other way"] * named


def test_turns_the_other_way_outweigh_half_of_the_true_ones():
    """Of ten radians eight against the truth and two with it are the other way; six against four are not."""
    true = motions(*[(0, 0, 1)] * 10)
    for against, named in ((8, True), (6, False)):
        believed = motions(*[(0, 0, -1)] * against, *[(0, 0, 1)] * (10 - against))
        assert len([*_sizes(true, believed, 1.0, NAMES)]) == named


def test_what_overlapping_windows_see_counts_once():
    """Two windows in two seconds see 0.15 m, which is enough; eleven see as much of the same 0.15 m."""
    for t in (np.array([0.0, 1.0, 2.0]), np.linspace(0, 2, 21)):
        way = np.stack([0.075 * t, 0 * t, 0 * t], axis=-1)
        assert odd_poses(t, way / 3, way, NAMES)[0].startswith("odom drives 3 times")
        assert odd_poses(t, 0.6 * way / 3, 0.6 * way, NAMES) == ()


@pytest.mark.parametrize(("short", "named"), [(0.24, False), (0.26, True)])
def test_motions_of_a_quarter_of_the_longest_have_a_direction(short, named):
    """One goes a metre ahead, ten go a little to the left."""
    log = motions((1, 0, 0), *[(0, short, 0)] * 10)
    said = [*_sideways(NAMES, (motions((1, 0, 0)), log), 1.0)]
    share = 10 * short / (1 + 10 * short)
    assert [line.partition(":")[0] for line in said] == [f"odom moves sideways for {share:.0%} of its way"] * named
