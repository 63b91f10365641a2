"""Poses on a clock: checked once, unchangeable, taken from what has them."""

import numpy as np
import pytest
from helpers import refused

import diffdrive_mj as dd
from diffdrive_mj.pose_log import poses_of


def test_nobody_changes_it_afterwards():
    t, poses = np.arange(3.0), np.zeros((3, 3))
    log = dd.PoseLog(t, poses)
    t[0], poses[0] = 9, 9
    assert log.t[0] == log.poses[0, 0] == 0
    for field in (log.t, log.poses):
        with pytest.raises(ValueError, match="read-only"):
            field[0] = 1


def test_it_reads_as_text():
    log = dd.PoseLog([1_700_000_000, 1_700_000_002.5], [(0, 0, 0), (3, 4, 0)], "a\nb", ["1 gap"])
    assert repr(log) == r"PoseLog(a\nb: 2 poses, 1700000000 to 1700000002.5 s)"
    assert str(log) == f"{log!r}\nwarning: 1 gap"
    html = log._repr_html_()
    assert r"<caption>a\nb</caption>" in html
    assert "<td>5 m</td>" in html
    assert "<td>2.5 s</td>" in html
    assert "1 gap" in html


@pytest.mark.parametrize(
    ("fields", "builtin", "words"),
    [
        ({"t": [0, 1, 1]}, ValueError, "mine: t[2] = 1 s after 1 s: times must increase"),
        ({"t": [0, 2, 1]}, ValueError, "mine: t[2] = 1 s after 2 s"),
        ({"t": [0], "poses": np.zeros((1, 3))}, ValueError, "at least two times"),
        ({"poses": np.full((3, 3), np.nan)}, ValueError, "mine: poses[0, 0] = nan: must be finite"),
        ({"poses": "poses"}, TypeError, "mine: poses: must be an array of real numbers"),
        ({"poses": np.zeros((2, 3))}, ValueError, "mine: poses has shape (2, 3) and t 3 times: must be (T, 3)"),
        ({"poses": np.zeros((2, 3, 3))}, ValueError, "must be (T, 3)"),
        ({"name": 3}, TypeError, "PoseLog.name = 3: must be a string"),
        ({"warnings": [3]}, TypeError, "PoseLog.warnings = 3: must be a string"),
        ({"warnings": 3}, TypeError, "PoseLog.warnings = 3: must be a list"),
    ],
)
def test_what_is_no_pose_log(fields, builtin, words):
    with refused(builtin, words):
        dd.PoseLog(**{"t": np.arange(3.0), "poses": np.zeros((3, 3)), "name": "mine", **fields})


def test_poses_of_what_has_them():
    drive = dd.Drive(np.arange(4.0), np.zeros((4, 2)), np.eye(3), [0.0, 1.0, 3.0], "lab", warnings=["1 gap"])
    log = poses_of("truth", drive)
    assert (log.name, log.warnings) == ("lab", ("1 gap",))
    np.testing.assert_array_equal(log.t, [0, 1, 3])
    np.testing.assert_array_equal(log.poses, np.eye(3))
    assert poses_of("truth", log) is log
    with refused(TypeError, "truth = None: must be a PoseLog or a Drive or a Recording"):
        poses_of("truth", None)


def test_a_drive_has_warnings_that_its_drift_repeats():
    robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
    drive = dd.Drive([0, 1], np.zeros((2, 2)), np.zeros((2, 3)), warnings=("1 gap",))
    assert drive.drift(robot).warnings == ("1 gap",)
    assert dd.Drive([0, 1], np.zeros((2, 2)), np.zeros((2, 3))).drift(robot).warnings == ()
    with refused(TypeError, "Drive.warnings = 3: must be a string"):
        dd.Drive([0, 1], np.zeros((2, 2)), np.zeros((2, 3)), warnings=(3,))


@pytest.mark.parametrize("kind", [dd.PoseLog, dd.Drive])
def test_a_warning_alone_is_not_taken_for_its_letters(kind):
    poses = (np.zeros((2, 3)),) if kind is dd.PoseLog else (np.zeros((2, 2)), np.zeros((2, 3)))
    with refused(TypeError, f"{kind.__name__}.warnings = 'gap': must be a list of strings"):
        kind([0.0, 1.0], *poses, warnings="gap")
    with refused(TypeError, f"{kind.__name__}.warnings = 3: must be a string"):
        kind([0.0, 1.0], *poses, warnings=["gap", 3])


def test_a_name_is_a_string_however_large_a_number_it_is():
    with pytest.raises(TypeError, match="name = an int: must be a string"):
        poses_of(10**5000, None)


def test_covariances_are_checked_copied_and_kept():
    stated = np.tile(np.eye(3), (3, 1, 1))
    log = dd.PoseLog(np.arange(3.0), np.zeros((3, 3)), covariance=stated)
    stated[0] = 9
    np.testing.assert_array_equal(log.covariance, np.tile(np.eye(3), (3, 1, 1)))
    with pytest.raises(ValueError, match="read-only"):
        log.covariance[0] = 1
    with refused(ValueError, "mine: covariance has shape (3, 3) and t 3 times: must be (T, 3, 3)"):
        dd.PoseLog(np.arange(3.0), np.zeros((3, 3)), "mine", covariance=np.eye(3))
    with refused(ValueError, "mine: covariance[1]: [0, 1] is 1 and [1, 0] is 0: must be symmetric"):
        bad = np.tile(np.eye(3), (3, 1, 1))
        bad[1, 0, 1] = 1
        dd.PoseLog(np.arange(3.0), np.zeros((3, 3)), "mine", covariance=bad)
