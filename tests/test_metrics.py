import logging
import math

import numpy as np
import pytest
from helpers import matrix, refused
from hypothesis import given
from hypothesis import strategies as st
from strategies import drives, numbers, poses, robots

import diffdrive_mj as dd
from diffdrive_mj import metrics, se2

ROBOT = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
STRAIGHT = np.stack([np.linspace(0, 10, 101), np.zeros(101), np.zeros(101)], axis=-1)
ROUND = dd.odometry.integrate(np.cumsum([(0.9, 1.1 + 0.3 * math.sin(i / 5)) for i in range(60)], axis=0), ROBOT)

same = {"rtol": 1e-11, "atol": 1e-11}


# The distance driven


def test_travelled_on_a_straight_line():
    np.testing.assert_allclose(metrics.travelled(STRAIGHT), np.linspace(0, 10, 101), rtol=1e-14)
    np.testing.assert_allclose(metrics.travelled(STRAIGHT * (-1, 1, 1)), np.linspace(0, 10, 101), rtol=1e-14)


@pytest.mark.parametrize("samples", [4, 9, 1000])
@pytest.mark.parametrize("turn", [2 * np.pi, -2 * np.pi])
def test_travelled_on_a_circle_is_the_arc(samples, turn):
    """Three chords of a circle of 2 m make 10.4 m, its three arcs 12.6 m."""
    theta = np.linspace(0, turn, samples)
    circle = np.stack([2 * np.sin(theta), 2 - 2 * np.cos(theta), theta], axis=-1)
    np.testing.assert_allclose(metrics.travelled(circle), 2 * np.abs(theta), rtol=1e-13)


def test_travelled_across_the_seam():
    theta = np.linspace(0, 2 * np.pi, 9)
    circle = np.stack([np.sin(theta), 1 - np.cos(theta), se2.wrap_angle(theta)], axis=-1)
    np.testing.assert_allclose(metrics.travelled(circle), theta, rtol=1e-13)


def test_travelled_in_a_spin_is_nothing():
    np.testing.assert_array_equal(metrics.travelled([(1, 2, theta) for theta in np.arange(0, 9, 0.5)]), np.zeros(18))


@given(drives(), robots, poses)
def test_travelled_does_not_depend_on_the_frame(wheel_angles, robot, frame):
    path = dd.odometry.integrate(wheel_angles, robot)
    np.testing.assert_allclose(metrics.travelled(se2.compose(frame, path)), metrics.travelled(path), **same)


# Drift


def test_drift_of_a_perfect_estimate_is_nothing():
    drift = metrics.drift(ROUND, ROUND)
    assert drift.max_position == drift.final_position == drift.max_heading == drift.final_heading == 0
    assert drift.max_position_per_metre == drift.final_heading_per_metre == 0


def test_drift_of_a_constant_offset():
    drift = metrics.drift(STRAIGHT, np.add(STRAIGHT, (0.3, -0.4, 0.1)))
    assert drift.distance == pytest.approx(10)
    np.testing.assert_allclose(drift.position_error, 0.5)
    np.testing.assert_allclose(drift.heading_error, 0.1)
    assert drift.max_position == drift.final_position == pytest.approx(0.5)
    assert drift.max_position_per_metre == drift.final_position_per_metre == pytest.approx(0.05)
    assert drift.max_heading_per_metre == drift.final_heading_per_metre == pytest.approx(0.01)


@pytest.mark.parametrize("error", [0.02, -0.3, 2.0])
def test_drift_of_a_constant_heading_error(error):
    """On a straight line of s metres the position is off by the chord 2 s sin(error / 2)."""
    drift = metrics.drift(STRAIGHT, se2.compose((0, 0, error), STRAIGHT))
    np.testing.assert_allclose(drift.position_error, 2 * STRAIGHT[:, 0] * abs(math.sin(error / 2)), rtol=1e-13)
    np.testing.assert_array_equal(drift.heading_error, np.full(101, error))
    assert drift.final_heading == error
    assert drift.max_heading == abs(error)
    assert drift.final_heading_per_metre == pytest.approx(error / 10)
    assert drift.final_position_per_metre == pytest.approx(2 * abs(math.sin(error / 2)))


def test_drift_is_largest_before_the_end():
    estimate = STRAIGHT.copy()
    estimate[30] += (0, 0.2, -0.4)
    drift = metrics.drift(STRAIGHT, estimate)
    assert (drift.max_position, drift.final_position) == (0.2, 0)
    assert (drift.max_heading, drift.final_heading) == (0.4, 0)
    assert drift.max_position_per_metre == pytest.approx(0.02)
    assert drift.max_heading_per_metre == pytest.approx(0.04)


def test_drift_along_the_drive():
    drift = metrics.drift(STRAIGHT, STRAIGHT * (1.01, 1, 1))
    np.testing.assert_allclose(drift.travelled, STRAIGHT[:, 0])
    np.testing.assert_allclose(drift.position_error, 0.01 * drift.travelled, atol=1e-15)


@pytest.mark.parametrize(
    ("truth", "estimate", "error"),
    [
        (3.1, -3.1, 2 * np.pi - 6.2),
        (-3.1, 3.1, 6.2 - 2 * np.pi),
        (0.1, 0.3 + 8 * np.pi, 0.2),
        (-7.0, -7.5, -0.5),
        (0.0, np.pi, np.pi),
        (0.0, -np.pi, np.pi),
    ],
)
def test_headings_are_compared_on_the_circle(truth, estimate, error):
    drift = metrics.drift([(0, 0, truth)], [(0, 0, estimate)])
    assert drift.final_heading == pytest.approx(error, abs=1e-14)
    assert drift.max_heading == pytest.approx(abs(error), abs=1e-14)


def test_standing_still():
    still = np.zeros((5, 3))
    drift = metrics.drift(still, still)
    assert drift.distance == drift.max_position_per_metre == drift.final_heading_per_metre == 0
    off = metrics.drift(still, np.add(still, (0.1, 0, -0.1)))
    assert off.max_position == pytest.approx(0.1)
    assert off.max_position_per_metre == off.max_heading_per_metre == np.inf
    assert off.final_heading_per_metre == -np.inf


def test_a_single_sample():
    drift = metrics.drift([(1, 2, 3)], [(1, 2.5, 3)])
    assert drift.distance == 0
    np.testing.assert_array_equal(drift.position_error, [0.5])
    assert metrics.ate([(1, 2, 3)], [(1, 2.5, 3)], align="none").rmse == 0.5
    assert metrics.ate([(1, 2, 3)], [(1, 2.5, 3)], align="origin").rmse == pytest.approx(0, abs=1e-15)
    assert metrics.ate([(1, 2, 3)], [(1, 2.5, 3)], align="se2").rmse == pytest.approx(0, abs=1e-15)


@given(drives(), drives(), poses)
def test_drift_does_not_depend_on_the_frame(wheel_angles, other, frame):
    n = min(len(wheel_angles), len(other))
    truth, estimate = (dd.odometry.integrate(angles[:n], ROBOT) for angles in (wheel_angles, other))
    here = metrics.drift(truth, estimate)
    there = metrics.drift(se2.compose(frame, truth), se2.compose(frame, estimate))
    np.testing.assert_allclose(there.position_error, here.position_error, **same)
    np.testing.assert_allclose(se2.wrap_angle(there.heading_error - here.heading_error), 0, atol=1e-11)
    np.testing.assert_allclose(there.distance, here.distance, **same)


@pytest.mark.parametrize(
    ("truth_shape", "estimate_shape"), [((4, 1), (5,)), ((), (5,)), ((5,), ()), ((2, 3), (2, 3)), ((), ())]
)
def test_leading_dimensions_broadcast(truth_shape, estimate_shape):
    rng = np.random.default_rng(5)
    truth, estimate = (rng.uniform(-2, 2, (*shape, 7, 3)) for shape in (truth_shape, estimate_shape))
    lead = np.broadcast_shapes(truth_shape, estimate_shape)
    drift = metrics.drift(truth, estimate)
    statistics = [metrics.ate(truth, estimate, align) for align in metrics.ALIGNMENTS]
    statistics += [metrics.rpe(truth, estimate, distance=2), metrics.rpe(truth, estimate, duration=2, t=range(7))]
    assert drift.position_error.shape == drift.heading_error.shape == drift.travelled.shape == (*lead, 7)
    assert drift.distance.shape == drift.max_position.shape == drift.final_heading_per_metre.shape == lead
    truths, estimates = (np.broadcast_to(paths, (*lead, 7, 3)) for paths in (truth, estimate))
    for run in np.ndindex(lead):
        one = metrics.drift(truths[run], estimates[run])
        for name in ("distance", "travelled", "position_error", "max_heading", "final_position_per_metre"):
            np.testing.assert_allclose(getattr(drift, name)[run], getattr(one, name), **same)
        each = [metrics.ate(truths[run], estimates[run], align) for align in metrics.ALIGNMENTS]
        each.append(metrics.rpe(truths[run], estimates[run], distance=2))
        each.append(metrics.rpe(truths[run], estimates[run], duration=2, t=range(7)))
        for many, single in zip(statistics, each, strict=True):
            for name in ("rmse", "mean", "median", "max", "heading_rmse", "heading_max", "position_error"):
                np.testing.assert_allclose(getattr(many, name)[run], getattr(single, name), **same)


# The absolute trajectory error


def test_ate_statistics():
    truth, estimate = np.zeros((4, 3)), np.zeros((4, 3))
    estimate[:, 0], estimate[:, 2] = (0, 1, 2, 5), (0, -0.1, 0.2, 0.2)
    ate = metrics.ate(truth, estimate, align="none")
    assert ate.rmse == pytest.approx(math.sqrt(30 / 4))
    assert (ate.mean, ate.median, ate.max) == (2, 1.5, 5)
    assert ate.heading_rmse == pytest.approx(0.15)
    assert ate.heading_max == 0.2


def test_ate_without_alignment_is_the_drift():
    estimate = se2.compose((0.1, 0.2, 0.3), ROUND)
    ate, drift = metrics.ate(ROUND, estimate, align="none"), metrics.drift(ROUND, estimate)
    np.testing.assert_array_equal(ate.position_error, drift.position_error)
    np.testing.assert_array_equal(ate.heading_error, np.abs(drift.heading_error))


@given(poses, st.sampled_from(["round", "straight"]))
def test_alignment_takes_a_rigid_motion_out(motion, name):
    """Also on a straight line, where a decomposition of the covariance has no unique answer."""
    truth = {"round": ROUND, "straight": STRAIGHT}[name]
    moved = se2.compose(motion, truth)
    for align in ("origin", "se2"):
        ate = metrics.ate(truth, moved, align)
        np.testing.assert_allclose(ate.position_error, 0, atol=1e-12)
        np.testing.assert_allclose(ate.heading_error, 0, atol=1e-12)
    assert metrics.ate(truth, moved).max == metrics.ate(truth, moved, "origin").max


def test_alignment_at_the_origin_keeps_the_first_pose():
    """A straight line believed to turn by 0.1 rad at its first sample: only the later headings are off."""
    estimate = se2.compose((0, 0, 0.1), STRAIGHT)
    estimate[0] = (0, 0, 0)
    ate = metrics.ate(STRAIGHT, se2.compose((5, 6, 2), estimate), "origin")
    np.testing.assert_allclose(ate.position_error, 20 * np.linspace(0, 1, 101) * math.sin(0.05), atol=1e-13)
    np.testing.assert_allclose(ate.heading_error[1:], 0.1, atol=1e-13)


def test_the_best_fit_of_a_line_that_is_too_long():
    """1 % longer: the middle fits, and the ends are off by half of it."""
    ate = metrics.ate(STRAIGHT, STRAIGHT * (1.01, 1, 1), "se2")
    np.testing.assert_allclose(ate.position_error, 0.01 * np.abs(STRAIGHT[:, 0] - 5), atol=1e-14)


@given(poses, numbers(-0.2, 0.2), numbers(-0.2, 0.2), numbers(-0.2, 0.2))
def test_no_rigid_motion_fits_better(motion, dx, dy, turn):
    noise = np.random.default_rng(6).normal(0, 0.1, ROUND.shape) * (1, 1, 0)
    estimate = se2.compose(motion, ROUND + noise)
    best = metrics.ate(ROUND, estimate, "se2").rmse
    nearly = se2.compose(se2.inverse(motion), estimate)
    other = metrics.ate(ROUND, se2.compose((dx, dy, turn), nearly), "none").rmse
    assert best <= other + 1e-12


# The relative pose error


def test_rpe_of_a_scale_error():
    """1 % too long: every stretch of 2 m is off by 2 cm, whether counted in metres or, at 0.5 m/s, in seconds."""
    estimate = STRAIGHT * (1.01, 1, 1)
    for rpe in (
        metrics.rpe(STRAIGHT, estimate, distance=2),
        metrics.rpe(STRAIGHT, estimate, duration=4, t=np.linspace(0, 20, 101)),
    ):
        np.testing.assert_allclose(rpe.position_error[:81], 0.02, rtol=1e-12)
        assert np.isnan(rpe.position_error[81:]).all()
        assert (rpe.rmse, rpe.max) == pytest.approx((0.02, 0.02))
        assert rpe.heading_max == 0


@pytest.mark.parametrize("curvature", [0.05, -0.2])
def test_rpe_of_a_bend(curvature):
    """A straight line believed to be a circle: each stretch s is off by its chord's end, and by curvature s."""
    theta = curvature * STRAIGHT[:, 0]
    estimate = np.stack([np.sin(theta) / curvature, (1 - np.cos(theta)) / curvature, theta], axis=-1)
    rpe = metrics.rpe(STRAIGHT, estimate, distance=3)
    turn = 3 * curvature
    off = math.hypot(math.sin(turn) / curvature - 3, (1 - math.cos(turn)) / curvature)
    np.testing.assert_allclose(rpe.position_error[:71], off, rtol=1e-10)
    np.testing.assert_allclose(rpe.heading_error[:71], abs(turn), rtol=1e-12)


@given(poses, poses)
def test_rpe_does_not_see_where_either_path_lies(a, b):
    estimate = dd.odometry.integrate(dd.kinematics.wheel_rates(ROUND[:, [0, 2]], ROBOT), ROBOT)
    here = metrics.rpe(ROUND, estimate, distance=1)
    there = metrics.rpe(se2.compose(a, ROUND), se2.compose(b, estimate), distance=1)
    np.testing.assert_allclose(there.position_error, here.position_error, **same)
    np.testing.assert_allclose(there.heading_error, here.heading_error, **same)


def test_stretches_end_at_the_first_sample_that_is_far_enough():
    x = np.array([0, 0.4, 0.7, 1.1, 2.0])
    error = np.array([0, 0.01, 0.02, 0.04, 0.08])
    truth, estimate = np.zeros((5, 3)), np.zeros((5, 3))
    truth[:, 0], estimate[:, 0] = x, x + error
    by_distance = metrics.rpe(truth, estimate, distance=1)
    np.testing.assert_allclose(by_distance.position_error, (0.04, 0.07, 0.06, np.nan, np.nan), rtol=1e-12)
    assert by_distance.mean == pytest.approx(0.17 / 3)
    assert by_distance.median == pytest.approx(0.06)
    small = metrics.rpe(1e-5 * truth, 1e-5 * estimate, distance=1e-5)
    np.testing.assert_allclose(small.position_error, 1e-5 * by_distance.position_error, rtol=1e-9)
    by_time = metrics.rpe(truth, estimate, duration=2, t=(0, 1, 2.5, 3, 3.5))
    np.testing.assert_allclose(by_time.position_error, (0.02, 0.03, np.nan, np.nan, np.nan), rtol=1e-12)


def test_stretches_are_measured_on_the_truth():
    """An estimate half as long is compared over the same samples."""
    half = metrics.rpe(STRAIGHT, STRAIGHT * (0.5, 1, 1), distance=4)
    np.testing.assert_allclose(half.position_error[:61], 2, rtol=1e-12)
    assert np.isnan(half.position_error[61:]).all()


def test_a_run_without_a_stretch_has_no_statistics():
    truth = np.stack([STRAIGHT, STRAIGHT * (0.1, 1, 1)])
    rpe = metrics.rpe(truth, np.add(truth, (0.1, 0, 0)), distance=2)
    for name in ("rmse", "mean", "median", "max", "heading_rmse", "heading_max"):
        long, short = getattr(rpe, name)
        assert long == pytest.approx(0, abs=1e-15)
        assert np.isnan(short)


# An independent implementation


@pytest.mark.parametrize("align", metrics.ALIGNMENTS)
def test_ate_against_evo(align):
    evo = _evo()
    truth, estimate = _noisy_pair()
    reference, moved = _evo_path(truth), _evo_path(estimate)
    if align == "origin":
        moved.align_origin(reference)
    elif align == "se2":
        moved.align(reference)
    ours = metrics.ate(truth, estimate, align)
    position, heading = (_evaluated(evo.APE(relation), reference, moved) for relation in _relations(evo))
    _agree(ours, position, heading)


def test_rpe_by_duration_against_evo():
    """A duration of seven periods is evo's delta of seven frames, over all pairs."""
    evo = _evo()
    truth, estimate = _noisy_pair()
    ours = metrics.rpe(truth, estimate, duration=0.7, t=np.arange(len(truth)) / 10)
    errors = []
    for relation in _relations(evo):
        theirs = evo.RPE(relation, delta=7, delta_unit=evo.Unit.frames, all_pairs=True)
        errors.append(_evaluated(theirs, _evo_path(truth), _evo_path(estimate)))
    _agree(ours, *errors)


def test_rpe_by_distance_against_evo():
    """On samples at equal distances, where the nearest sample, evo's choice, is also the first far enough.

    evo measures chords, which are 1e-3 shorter here, and must be told to pair by the reference.
    """
    evo = _evo()
    s = np.arange(0, 12, 0.1)
    truth = dd.odometry.integrate(dd.kinematics.wheel_rates(np.stack([s, np.sin(s)], axis=-1), ROBOT), ROBOT)
    estimate = dd.odometry.integrate(dd.kinematics.wheel_rates(np.stack([s, 1.1 * np.sin(s)], axis=-1), ROBOT), ROBOT)
    ours = metrics.rpe(truth, estimate, distance=0.8)
    errors = []
    for relation in _relations(evo):
        theirs = evo.RPE(relation, 0.8, evo.Unit.meters, rel_delta_tol=0.05, all_pairs=True, pairs_from_reference=True)
        errors.append(_evaluated(theirs, _evo_path(truth), _evo_path(estimate)))
    _agree(ours, *errors)


# For people


def test_drift_reads_as_text():
    text = str(metrics.drift(STRAIGHT, STRAIGHT * (1.01, 1, 1) + (0, 0, np.radians(3))))
    for words in ("10 m", "100 mm", "1e+04 um/m", "3 deg"):
        assert words in text


def test_many_drifts_read_as_a_range():
    many = np.stack([STRAIGHT * (1.01, 1, 1), STRAIGHT * (1.03, 1, 1)])
    assert "100 to 300 mm" in str(metrics.drift(STRAIGHT, many))
    assert "300 mm" in str(metrics.ate(STRAIGHT, many[1]))


# Bad input


@pytest.mark.parametrize(
    "call", [metrics.drift, metrics.ate, lambda truth, estimate: metrics.rpe(truth, estimate, distance=1)]
)
def test_bad_paths_are_refused(call):
    with refused(ValueError, "estimate has 100 samples and truth 101"):
        call(STRAIGHT, STRAIGHT[1:])
    with refused(ValueError, "truth has shape (101, 2)", "(..., T, 3)"):
        call(STRAIGHT[:, :2], STRAIGHT)
    with refused(ValueError, "estimate has shape (3,)", "(..., T, 3)"):
        call(STRAIGHT, STRAIGHT[0])
    with refused(ValueError, "estimate has shape (4, 101, 3)", "broadcast", "(5, 101, 3)"):
        call(np.stack([STRAIGHT] * 5), np.stack([STRAIGHT] * 4))
    with refused(ValueError, "truth is empty"):
        call(np.empty((0, 3)), np.empty((0, 3)))
    bad = STRAIGHT.copy()
    bad[7, 1] = math.nan
    with refused(ValueError, "truth[7, 1] = nan"):
        call(bad, STRAIGHT)
    with refused(ValueError, "estimate[7, 1] = nan"):
        call(STRAIGHT, bad)


def test_bad_path_of_travelled_is_refused():
    with refused(ValueError, "truth has shape (3,)"):
        metrics.travelled((1, 2, 3))


@pytest.mark.parametrize("builtin", [KeyError, ValueError])
def test_unknown_alignments_are_refused(builtin):
    with refused(builtin, "alignment 'orgin'", "none, origin, se2", "did you mean 'origin'?"):
        metrics.ate(STRAIGHT, STRAIGHT, "orgin")


def test_bad_steps_are_refused():
    t = np.arange(101.0)
    with refused(ValueError, "distance", "duration"):
        metrics.rpe(STRAIGHT, STRAIGHT)
    with refused(ValueError, "distance", "duration"):
        metrics.rpe(STRAIGHT, STRAIGHT, distance=1, duration=1, t=t)
    with refused(ValueError, "duration", "t ="):
        metrics.rpe(STRAIGHT, STRAIGHT, duration=1)
    with refused(ValueError, "t =", "goes with duration"):
        metrics.rpe(STRAIGHT, STRAIGHT, distance=1, t=t)
    for bad in (0, -1, math.nan):
        with refused(ValueError, f"distance = {bad}"):
            metrics.rpe(STRAIGHT, STRAIGHT, distance=bad)
        with refused(ValueError, f"duration = {bad}"):
            metrics.rpe(STRAIGHT, STRAIGHT, duration=bad, t=t)
    with refused(ValueError, "11", "longer than the whole drive, 10"):
        metrics.rpe(STRAIGHT, STRAIGHT, distance=11)
    with refused(ValueError, "101", "longer than the whole drive, 100"):
        metrics.rpe(STRAIGHT, STRAIGHT, duration=101, t=t)
    with refused(ValueError, "longer than the whole drive"):
        metrics.rpe(STRAIGHT[:1], STRAIGHT[:1], distance=1)


def test_bad_times_are_refused():
    with refused(ValueError, "t has shape (100,)", "101"):
        metrics.rpe(STRAIGHT, STRAIGHT, duration=1, t=np.arange(100))
    with refused(ValueError, "t has shape (2, 101)", "(101,)"):
        metrics.rpe(STRAIGHT, STRAIGHT, duration=1, t=np.zeros((2, 101)))
    for bad in (np.zeros(101), np.arange(101)[::-1]):
        with refused(ValueError, "t: must increase"):
            metrics.rpe(STRAIGHT, STRAIGHT, duration=1, t=bad)


def _noisy_pair():
    noise = np.cumsum(np.random.default_rng(7).normal(0, 0.01, ROUND.shape), axis=0)
    return ROUND, se2.compose((1, -2, 0.7), ROUND + noise)


def _evo():
    evo = pytest.importorskip("evo.core.metrics")
    logging.getLogger("evo").setLevel(logging.ERROR)
    return evo


def _relations(evo):
    return evo.PoseRelation.translation_part, evo.PoseRelation.rotation_angle_rad


def _evo_path(path):
    """The poses as 4x4 matrices, in the plane z = 0."""
    trajectory = pytest.importorskip("evo.core.trajectory")
    spatial = np.tile(np.eye(4), (len(path), 1, 1))
    planar = np.array([matrix(pose) for pose in path])
    spatial[:, :2, :2], spatial[:, :2, 3] = planar[:, :2, :2], planar[:, :2, 2]
    return trajectory.PosePath3D(poses_se3=list(spatial))


def _evaluated(metric, reference, estimate):
    metric.process_data((reference, estimate))
    return metric


def _agree(ours, position, heading):
    paired = ~np.isnan(ours.position_error)
    np.testing.assert_allclose(ours.position_error[paired], position.error, rtol=0, atol=1e-12)
    # evo takes angles from rotation matrices by way of quaternions.
    np.testing.assert_allclose(ours.heading_error[paired], heading.error, rtol=0, atol=1e-8)
    for name in ("rmse", "mean", "median", "max"):
        np.testing.assert_allclose(getattr(ours, name), position.get_all_statistics()[name], rtol=1e-12)
    np.testing.assert_allclose(ours.heading_rmse, heading.get_all_statistics()["rmse"], rtol=1e-8)


def a_drift(position, heading=None, warnings=()):
    """A drift along a straight line of unit steps with given errors."""
    position = np.array(position, dtype=float)
    heading = np.zeros_like(position) if heading is None else np.array(heading)
    travelled = np.arange(len(position), dtype=float)
    return dd.metrics.Drift(travelled[-1], travelled, position, heading, warnings)


def test_drives_stacked_are_runs_and_the_shorter_keep_their_last_error():
    short, long = a_drift([0.0, 3e-3], [0.0, -0.1], ("first",)), a_drift([0.0, 5e-3, 1e-3, 4e-3], warnings=("second",))
    drift = dd.metrics.stacked([short, long])
    np.testing.assert_array_equal(drift.final_position, [3e-3, 4e-3])
    np.testing.assert_array_equal(drift.max_position, [3e-3, 5e-3])
    np.testing.assert_array_equal(drift.final_heading, [-0.1, 0.0])
    np.testing.assert_array_equal(drift.distance, [1.0, 3.0])
    np.testing.assert_array_equal(drift.travelled, [[0, 1, 1, 1], [0, 1, 2, 3]])
    assert drift.final_position_rms == pytest.approx(3.5355e-3, rel=1e-4)  # sqrt((9 + 16) / 2)
    assert drift.summary() == "final position 3.536 mm RMS, 4 mm at most; on the way 5 mm at most"
    assert drift.warnings == ("first", "second")
    assert str(drift).splitlines()[-2:] == ["warning: first", "warning: second"]


def test_only_drifts_of_one_kind_stack():
    one = a_drift([0.0, 1.0])
    with refused(ValueError, "drifts: leading dimensions none"):
        dd.metrics.stacked([])
    with refused(TypeError, "drifts[1] = 3: must be a Drift"):
        dd.metrics.stacked([one, 3])
    with refused(ValueError, "(2,), ()"):
        dd.metrics.stacked([dd.metrics.stacked([one, one]), one])


@pytest.mark.parametrize("zero", [0.0, 1e6, 1e8, 1.7e9])
@pytest.mark.parametrize("interval", [0.01, 0.15])
def test_the_zero_of_the_clock_does_not_matter(zero, interval):
    """Unix times resolve 0.24 us: no stretch of so many samples may become one longer."""
    t = np.arange(200) * interval
    truth = np.stack([t, np.sin(t), np.zeros_like(t)], axis=-1)
    estimate = truth * 1.01
    for samples in (1, 3, 10):
        found = metrics.rpe(truth, estimate, duration=samples * interval, t=zero + t)
        reference = se2.between(
            se2.between(truth[:-samples], truth[samples:]), se2.between(estimate[:-samples], estimate[samples:])
        )
        np.testing.assert_allclose(found.position_error[:-samples], np.hypot(*reference[:, :2].T), atol=1e-12)
        assert np.isnan(found.position_error[-samples:]).all()


def test_a_stretch_is_at_least_one_sample_long():
    t = 1.7e9 + np.arange(5.0)
    truth = np.zeros((5, 3))
    estimate = np.stack([np.arange(5.0), np.zeros(5), np.zeros(5)], axis=-1)
    assert metrics.rpe(truth, estimate, duration=1e-9, t=t).mean == 1.0
