"""Estimates against truths on other clocks: closed forms, evo's numbers on what is written, gaps, offsets."""

import importlib

import numpy as np
import pytest
from helpers import refused
from hypothesis import example, given
from hypothesis import strategies as st

import diffdrive_mj as dd
from diffdrive_mj import logs, metrics, se2
from diffdrive_mj.judging.evaluation import evaluate
from diffdrive_mj.logs import Topics

ROBOT = dd.Robot(left_radius=0.05, right_radius=0.05, track_width=0.3)
SAME = {"rtol": 1e-12, "atol": 1e-12}


def circle(t, speed=0.5, rate=0.4):
    """The exact path of constant speeds, from the origin."""
    t = np.asarray(t)
    return np.stack([speed / rate * np.sin(rate * t), speed / rate * (1 - np.cos(rate * t)), rate * t], axis=-1)


def noisy(seed=0, n=400):
    """A drive with turns in both directions, and an odometry of it that drifts."""
    rng = np.random.default_rng(seed)
    t = 1_700_000_000 + 0.05 * np.arange(n)
    rates = np.stack([6 + np.sin(0.3 * t), 6 + np.cos(0.2 * t)], axis=-1)
    angles = np.cumsum(0.05 * rates, axis=0)
    truth = dd.odometry.integrate(angles, ROBOT, start=(1.0, -2.0, 3.0))
    odom = dd.odometry.integrate(angles * (1.002, 0.999), ROBOT) + 1e-3 * rng.standard_normal((n, 3))
    return dd.PoseLog(t, truth, "truth"), dd.PoseLog(t, odom, "odom")


# Clocks


@pytest.mark.parametrize("offset", [0.0, 1000.0])
@example(rate=3.0, phase=1e-7, origin=(0.0, 0.0, 0.0))
@given(rate=st.floats(3.0, 40.0), phase=st.floats(0.0, 1.0), origin=st.tuples(*[st.floats(-3, 3)] * 3))
def test_clocks_frames_and_starts_do_not_matter(offset, rate, phase, origin):
    """On a circle, which arcs interpolate exactly, a right estimate has no error, whatever its clock and its frame."""
    t = np.arange(0, 10, 0.04)
    s = phase / rate + np.arange(0, 9, 1 / rate)
    estimate = dd.PoseLog(s - offset, se2.compose(origin, circle(s)))
    found = evaluate(dd.PoseLog(t, circle(t)), estimate, offset=offset)
    # A time within a millionth of a period of a pose's is taken for that pose's own.
    near = 1e-9 + 1e-6 * np.abs(np.diff(circle(t), axis=0)).max()
    assert found.drift.max_position < near
    assert found.drift.max_heading < near
    assert found.rpe.max < near
    assert found.warnings == ()


@pytest.mark.parametrize(("every", "of"), [((1, 7), "estimate"), ((7, 1), "truth"), ((3, 3), "truth")])
def test_they_are_compared_at_the_times_of_the_fewer(every, of):
    t = np.linspace(0, 10, 211)
    truth = dd.PoseLog(t[:: every[0]], circle(t[:: every[0]]))
    estimate = dd.PoseLog(t[:: every[1]] + 0.01, circle(t[:: every[1]] + 0.01))
    found = evaluate(truth, estimate)
    expected = {"truth": truth.t[(truth.t >= 0.01)], "estimate": estimate.t[estimate.t <= 10]}[of]
    np.testing.assert_array_equal(found.t, expected)


def test_an_offset_of_the_clocks_shows_as_an_error_and_is_taken_out():
    """Half a second late at 0.5 m/s on a circle: the estimate is where the robot was half a second ago."""
    t = np.arange(0, 10, 0.05)
    late = dd.PoseLog(t + 0.5, circle(t))
    found = evaluate(dd.PoseLog(t, circle(t)), late, align="none")
    chord = 2 * 0.5 / 0.4 * np.sin(0.4 * 0.5 / 2)
    np.testing.assert_allclose(found.ate.position_error, chord, rtol=1e-6)
    np.testing.assert_allclose(found.ate.heading_error, 0.2, rtol=1e-9)
    assert evaluate(dd.PoseLog(t, circle(t)), late, align="none", offset=-0.5).ate.max < 1e-9


def test_nothing_is_compared_inside_a_gap():
    t = np.arange(0, 20, 0.05)
    seen = t[(t < 5) | (t > 9)]
    estimate = dd.PoseLog(t[::2], circle(t[::2]), "odom")
    found = evaluate(dd.PoseLog(seen, circle(seen), "mocap", ["poses: 1 gap"]), estimate)
    inside = (estimate.t > seen[seen < 5].max() + 1e-9) & (estimate.t < 9.05 - 1e-9)
    np.testing.assert_array_equal(found.t, estimate.t[~inside])
    assert found.warnings == (
        "mocap: poses: 1 gap",
        f"{inside.sum()} poses lie in gaps of the other log, and were not compared",
    )
    assert str(found).endswith("were not compared")


def test_logs_that_hardly_overlap_are_counted():
    """Stamps in milliseconds, or an estimate that ended early: what is compared is a small part."""
    t = np.arange(0, 10, 0.05)
    truth, part = dd.PoseLog(t, circle(t), "mocap"), dd.PoseLog(t[:100], circle(t[:100]), "odom")
    assert evaluate(truth, part).warnings == ("100 of 200 poses of mocap lie outside the times of the other",)
    assert evaluate(part, truth).warnings == ("100 of 200 poses of mocap lie outside the times of the other",)
    assert evaluate(truth, dd.PoseLog(t[:161], circle(t[:161]))).warnings == ()
    milliseconds = dd.PoseLog(1e3 * t / 10, circle(t), "odom")
    assert "198 of 200 poses of odom lie outside the times of the other" in evaluate(truth, milliseconds).warnings


def test_drives_and_recordings_are_truths():
    t = np.arange(0, 4, 0.1)
    drive = dd.Drive(t, np.zeros((40, 2)), circle(t[::3]), t[::3], "lab")
    assert evaluate(drive, dd.PoseLog(t, circle(t))).ate.max < 1e-9
    robot = dd.Robot.load("matched")
    recording = dd.simulate(robot, dd.maneuvers.arc(robot, radius=0.5, distance=0.3, speed=0.3), sample_rate=50.0)
    odom = dd.PoseLog(recording.t, recording.odometry(robot))
    np.testing.assert_allclose(
        evaluate(recording, odom).drift.position_error, recording.drift(robot).position_error, atol=1e-12
    )


# Figures


def test_figures_are_those_of_metrics_on_the_poses():
    truth, odom = noisy()
    found = evaluate(truth, odom, align="se2", stretch=0.5)
    moved = se2.compose(truth.poses[0], se2.between(odom.poses[0], odom.poses))
    np.testing.assert_allclose(found.drift.position_error, metrics.drift(truth.poses, moved).position_error, **SAME)
    np.testing.assert_allclose(
        found.ate.position_error, metrics.ate(truth.poses, odom.poses, "se2").position_error, **SAME
    )
    np.testing.assert_allclose(
        found.rpe.position_error, metrics.rpe(truth.poses, odom.poses, distance=0.5).position_error, atol=1e-9
    )


def test_left_where_it_is():
    t = np.arange(0, 4, 0.1)
    found = evaluate(dd.PoseLog(t, circle(t)), dd.PoseLog(t, np.add(circle(t), (0.3, 0.4, 0.1))), align="none")
    np.testing.assert_allclose(found.drift.position_error, 0.5, rtol=1e-12)
    np.testing.assert_allclose(found.drift.heading_error, 0.1, rtol=1e-12)


@pytest.mark.parametrize(("stretch", "there"), [(1.9, True), (2.0, True), (2.1, False)])
def test_a_drive_shorter_than_a_stretch_has_no_relative_error(stretch, there):
    t = np.arange(5.0)
    log = dd.PoseLog(t, np.stack([t / 2, 0 * t, 0 * t], axis=-1))
    found = evaluate(log, log, stretch=stretch)
    assert (found.rpe is not None) == there
    assert ("the drive is shorter" in str(found)) != there


def test_it_reads_as_text_and_in_notebooks():
    found = evaluate(*noisy())
    for words in ("odom: 400 poses compared", "distance driven", "ATE, aligned by origin", "RPE over 1 m"):
        assert words in str(found)
    assert "RPE over 1 m" in found._repr_html_()
    assert repr(found).startswith("Evaluation(odom: 400 poses, Drift(")


# evo


@pytest.fixture(scope="module")
def evo():
    pytest.importorskip("evo", reason="needs the extra oracle")
    names = ("core.metrics", "core.trajectory", "core.sync", "tools.file_interface")
    return {name.split(".")[1]: importlib.import_module(f"evo.{name}") for name in names}


def written(tmp_path, evo, storage):
    """What evo reads of two logs that are written."""
    truth, odom = noisy()
    if storage == "tum":
        for log in (truth, odom):
            logs.write(tmp_path / f"{log.name}.tum", log)
        files = [tmp_path / f"{log.name}.tum" for log in (truth, odom)]
        return files, [evo["file_interface"].read_tum_trajectory_file(file) for file in files]
    from rosbags.rosbag2 import Reader

    files, theirs = [tmp_path / f"{log.name}.{storage}" for log in (truth, odom)], []
    for file, log in zip(files, (truth, odom), strict=True):
        logs.write(file, log, Topics(poses=f"/{log.name}"))
        with Reader(file) as reader:
            theirs.append(evo["file_interface"].read_bag_trajectory(reader, f"/{log.name}"))
    return files, theirs


@pytest.mark.parametrize("storage", ["tum", "mcap", "db3"])
@pytest.mark.parametrize("align", metrics.ALIGNMENTS)
def test_evo_finds_the_same_absolute_errors_in_what_is_written(tmp_path, evo, storage, align):
    files, (reference, moved) = written(tmp_path, evo, storage)
    ours = evaluate(*map(logs.read_poses, files), align=align).ate
    reference, moved = evo["sync"].associate_trajectories(reference, moved)
    if align == "origin":
        moved.align_origin(reference)
    elif align == "se2":
        moved.align(reference)
    for relation, rmse, largest in (("translation_part", ours.rmse, ours.max),
                                    ("rotation_angle_rad", ours.heading_rmse, ours.heading_max)):  # fmt: skip
        ape = evo["metrics"].APE(evo["metrics"].PoseRelation[relation])
        ape.process_data((reference, moved))
        statistics = ape.get_all_statistics()
        assert rmse == pytest.approx(statistics["rmse"], abs=1e-9)
        assert largest == pytest.approx(statistics["max"], abs=1e-9)


def straight(scale=1.1, n=1001):
    """A straight drive of 10 m, a pose every centimetre, and an estimate that is too long."""
    poses = np.stack([np.linspace(0, 10, n), np.zeros(n), np.zeros(n)], axis=-1)
    t = np.arange(n) / 10
    return dd.PoseLog(t, poses, "truth"), dd.PoseLog(t, poses * (scale, 1, 1), "odom")


def theirs_of(evo, logs_, **options):
    """evo's relative errors over a metre."""
    paths = []
    for log in logs_:
        half = log.poses[:, 2] / 2
        quaternions = np.stack([np.cos(half), 0 * half, 0 * half, np.sin(half)], axis=-1)
        xyz = np.column_stack([log.poses[:, :2], 0 * half])
        paths.append(evo["trajectory"].PoseTrajectory3D(xyz, quaternions, log.t))
    rpe = evo["metrics"].RPE(evo["metrics"].PoseRelation.translation_part, 1.0, evo["metrics"].Unit.meters, **options)
    rpe.process_data(tuple(paths))
    return rpe.get_result().np_arrays["error_array"]


def test_relative_errors_differ_from_evos_by_the_pairs(evo):
    """An estimate 10 % too long is 0.1 m off on every metre of truth, and 0.1 / 1.1 m on every metre of its own."""
    ours = evaluate(*straight()).rpe
    np.testing.assert_allclose(ours.position_error[:901], 0.1, rtol=1e-9)
    assert np.isnan(ours.position_error[901:]).all()
    by_default = theirs_of(evo, straight())
    assert len(by_default) < 12  # a pair begins where the last one ended
    np.testing.assert_allclose(by_default, 0.1 / 1.1, atol=0.0011)  # a pose every 11 mm of the estimate
    same_pairs = theirs_of(evo, straight(), all_pairs=True, pairs_from_reference=True, rel_delta_tol=0.01)
    np.testing.assert_allclose(same_pairs[:901], ours.position_error[:901], rtol=1e-9)
    # One more, of 0.99 m: within the tolerance, and not as far as a metre.
    np.testing.assert_allclose(same_pairs[901:], [0.099], rtol=1e-9)


# Refusing


def test_poses_that_all_lie_in_gaps_are_not_compared():
    """A truth in bursts has nothing to say of the times in between."""
    bursts = np.sort(np.concatenate([np.arange(0, 10, 0.1) + k * 1e-3 for k in range(3)]))
    t = np.arange(0.05, 9, 0.1)
    with refused(ValueError, f"{len(t)} of {len(t)} poses lie in gaps of mocap: at least two must not"):
        evaluate(dd.PoseLog(bursts, circle(bursts), "mocap"), dd.PoseLog(t, circle(t)))


def test_two_common_times_are_needed():
    truth = dd.PoseLog([0.0, 1.0, 2.0], circle([0.0, 1.0, 2.0]))
    for t in ([2.0, 3.0], [2.1, 2.2], [-5.0, 0.0]):
        with refused(ValueError, "at least two poses must lie within both", f"offset = {0 - t[0]:g} would"):
            evaluate(truth, dd.PoseLog(t, circle(t)))
    assert len(evaluate(truth, dd.PoseLog([1.0, 2.0], circle([1.0, 2.0]))).t) == 2


def test_one_shared_pose_is_not_the_fewer():
    """Of the truth one pose lies within the estimate's times: they are compared at the estimate's own."""
    t, s = np.array([0.0, 10.0, 20.0]), np.arange(5.0, 15.5, 0.5)
    found = evaluate(dd.PoseLog(t, circle(t, rate=0.1)), dd.PoseLog(s, circle(s, rate=0.1)))
    assert found.t.tolist() == s.tolist()
    assert float(found.drift.max_position) < 1e-12


def test_markdown_has_a_row_for_each_figure_and_the_warnings_below():
    t = np.array([0.0, 1.0, 2.0])
    truth = dd.PoseLog(t, np.stack([t, 0 * t, 0 * t], axis=-1), "mocap", ("a gap  of 2 s",))
    odom = dd.PoseLog([0.0, 2.0], [(0.0, 0.0, 0.0), (2.01, 0.0, 0.0)], "odom")
    assert evaluate(truth, odom).markdown().splitlines() == [
        "### odom: 2 poses compared",
        "",
        "|  |  |",
        "| --- | --- |",
        "| distance driven | 2 m |",
        "| largest position error | 10 mm 5000 um/m |",
        "| final position error | 10 mm 5000 um/m |",
        "| largest heading error | 0 deg |",
        "| final heading error | 0 deg |",
        "| ATE, aligned by origin | rmse 7.07 mm max 10.0 mm |",
        "| RPE over 1 m | rmse 10.0 mm max 10.0 mm |",
        "",
        "warning: mocap: a gap  of 2 s",
    ]
