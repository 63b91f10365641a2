"""One read and one write: every log in every format that has room for it, by ending and content."""

import dataclasses
import importlib

import bags
import numpy as np
import pytest
from helpers import ROOT, refused

import diffdrive_mj as dd
from diffdrive_mj import logs
from diffdrive_mj.logs import Columns, formats, rosbag

ROBOT = dd.Robot.load("matched")
RECORDING = dd.simulate(ROBOT, dd.maneuvers.arc(ROBOT, radius=0.3, distance=0.2, speed=0.3), sample_rate=50.0)
DRIVE = dd.sensors.measure(RECORDING, tracker=dd.Tracker(sample_rate=10.0))
ESTIMATE = dd.PoseLog(RECORDING.t, RECORDING.odometry(ROBOT), "odom")
WRITTEN = ("a.csv", "a.mcap", "a.db3", "a")


@pytest.mark.parametrize("name", WRITTEN)
def test_drives_and_recordings_come_back(tmp_path, name):
    for log, clock, truth in ((DRIVE, DRIVE.clock, DRIVE.truth), (RECORDING, RECORDING.t, RECORDING.truth)):
        folder = tmp_path / type(log).__name__
        folder.mkdir()
        logs.write(folder / name, log)
        again = logs.read(folder / name)
        np.testing.assert_array_equal(again.wheel_angles, log.wheel_angles)
        np.testing.assert_allclose(again.t, log.t, atol=5e-10)  # whole nanoseconds
        np.testing.assert_allclose(again.clock, clock, atol=5e-10)
        np.testing.assert_allclose(again.truth, truth, atol=1e-14)


@pytest.mark.parametrize("name", [*WRITTEN, "a.tum"])
def test_estimates_come_back(tmp_path, name):
    logs.write(tmp_path / name, ESTIMATE)
    again = logs.read_poses(tmp_path / name)
    np.testing.assert_allclose(again.t, ESTIMATE.t, atol=5e-10)
    np.testing.assert_allclose(again.poses, ESTIMATE.poses, atol=1e-14)
    assert again.name == str(tmp_path / name)


def test_csv_files_keep_every_bit(tmp_path):
    logs.write(tmp_path / "a.csv", ESTIMATE)
    np.testing.assert_array_equal(logs.read_poses(tmp_path / "a.csv").poses, ESTIMATE.poses)
    logs.write(tmp_path / "b.csv", DRIVE)
    logs.write_csv(tmp_path / "c.csv", DRIVE)
    assert (tmp_path / "b.csv").read_text() == (tmp_path / "c.csv").read_text()
    assert logs.read(tmp_path / "b.csv").truth.tolist() == DRIVE.truth.tolist()


def test_the_truth_may_be_a_log_of_its_own(tmp_path):
    logs.write(tmp_path / "drive.csv", RECORDING)
    logs.write(tmp_path / "truth.tum", dd.PoseLog(DRIVE.clock, DRIVE.truth))
    for truth in (tmp_path / "truth.tum", str(tmp_path / "truth.tum"), logs.read_poses(tmp_path / "truth.tum")):
        drive = logs.read(tmp_path / "drive.csv", truth=truth)
        np.testing.assert_array_equal(drive.clock, DRIVE.clock)
        np.testing.assert_allclose(drive.truth, DRIVE.truth, atol=1e-14)


@pytest.mark.parametrize(
    ("options", "factors"),
    [
        ({"wheel_unit": "rotations"}, (2 * np.pi, 2 * np.pi)),
        ({"wheel_unit": "degrees"}, (np.pi / 180, np.pi / 180)),
        ({"wheel_unit": "degrees", "gear": 18}, (np.pi / 3240, np.pi / 3240)),
        ({"wheel_unit": "radians", "gear": 4}, (0.25, 0.25)),
        ({"wheel_unit": "metres"}, (1 / 0.05, 1 / 0.04)),
        ({"wheel_unit": "metres", "wheels": "increments", "reverse_right": True}, (1 / 0.05, -1 / 0.04)),
    ],
)
def test_units_of_wheels_in_csv_files(tmp_path, options, factors):
    robot = dd.Robot(left_radius=0.05, right_radius=0.04, track_width=0.3)
    rows = np.array([(0, 0), (1, 2), (3, 5)])
    (tmp_path / "a.csv").write_text(
        "t,left,right,x,y,theta\n" + "".join(f"{k},{a},{b},0,0,0\n" for k, (a, b) in enumerate(rows))
    )
    turned = np.cumsum(rows, axis=0) if "wheels" in options else rows
    drive = logs.read(tmp_path / "a.csv", Columns(**options), robot=robot)
    np.testing.assert_allclose(drive.wheel_angles, turned * factors, rtol=1e-15)


def test_endings_in_capitals_and_folders_with_dots(tmp_path):
    bags.write(tmp_path / "bag", {"/p": [bags.stamped(t, t) for t in (0.0, 1.0)]})
    (tmp_path / "bag").rename(tmp_path / "rosbag2_2024.05.01")
    assert len(logs.read_poses(tmp_path / "rosbag2_2024.05.01").t) == 2
    (tmp_path / "A.CSV").write_text("t,x,y,theta\n0,0,0,0\n1,1,0,0\n")
    assert len(logs.read_poses(tmp_path / "A.CSV").t) == 2


def test_options_tell_a_text_of_eight_columns_from_tum(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("0 0 0 0 0 0 0 1\n1 1 2 3 0 0 0 1\n")
    assert logs.read_poses(path).poses[1].tolist() == [1, 2, 0]
    columns = Columns(time=1, x=2, y=3, theta=4, header=False)
    assert logs.read_poses(path, columns).poses[1].tolist() == [1, 2, 3]


def test_every_format_is_in_the_documentation():
    page = (ROOT / "docs" / "logs.md").read_text()
    for kind in formats.FORMATS:
        assert all(f"`{ending}`" in page for ending in kind.endings if ending)
    for options in (Columns, logs.Topics, logs.Entries):
        assert f"`{options.__name__}`" in page


def test_one_log_at_a_time(tmp_path):
    with refused(TypeError, "log = a list"):
        logs.write(tmp_path / "a.csv", [DRIVE])


@pytest.mark.parametrize("name", ["a.csv", "a.tum", "a.mcap", "a.db3", "folder"])
def test_a_full_disk_is_one_line_and_leaves_nothing(tmp_path, name):
    resource = pytest.importorskip("resource", reason="limits on the size of files are POSIX's")
    signal = importlib.import_module("signal")
    before, limits = signal.signal(signal.SIGXFSZ, signal.SIG_IGN), resource.getrlimit(resource.RLIMIT_FSIZE)
    poses = dd.PoseLog(np.arange(3000.0), np.zeros((3000, 3)))
    try:
        resource.setrlimit(resource.RLIMIT_FSIZE, (10_000, limits[1]))
        with refused(ValueError, f"{name}: cannot be written ("):
            logs.write(tmp_path / name, poses)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        signal.signal(signal.SIGXFSZ, before)
    assert [*tmp_path.iterdir()] == []


def test_a_folder_that_cannot_be_looked_into_is_one_line(tmp_path, monkeypatch):
    (tmp_path / "bag").mkdir()

    def locked(*_, **__):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(formats, "FORMATS", (dataclasses.replace(rosbag.FOLDER, looks=locked),))
    with refused(ValueError, "bag: cannot be read (Permission denied)"):
        logs.read_poses(tmp_path / "bag")
