"""TUM files: read as evo reads them, and written so that evo reads the same poses."""

import math

import numpy as np
import pytest
from helpers import refused
from hypothesis import given
from hypothesis import strategies as st

import diffdrive_mj as dd
from diffdrive_mj import logs

GOOD = "# timestamp tx ty tz qx qy qz qw\n0.0 0 0 0 0 0 0 1\n0.5 1 2 0 0 0 0.6 0.8\n1.5 2 2 0 0 0 1 0\n"


@pytest.fixture
def read(tmp_path):
    def read(text, name="a.tum"):
        (tmp_path / name).write_text(text)
        return logs.read_poses(tmp_path / name)

    return read


def test_a_file_by_hand(read, tmp_path):
    log = read(GOOD)
    np.testing.assert_array_equal(log.t, [0, 0.5, 1.5])
    np.testing.assert_allclose(log.poses, [(0, 0, 0), (1, 2, 2 * np.arctan2(0.6, 0.8)), (2, 2, np.pi)], atol=1e-15)
    assert (log.name, log.warnings) == (str(tmp_path / "a.tum"), ())
    np.testing.assert_array_equal(read(GOOD, "a.txt").poses, log.poses)
    np.testing.assert_array_equal(read(GOOD.replace(" ", "\t"), "b.txt").poses, log.poses)


def test_names_are_no_first_row(read, tmp_path):
    with refused(ValueError, f"{tmp_path / 'a.tum'}, line 1, column 1: 'timestamp' is not a number"):
        read(GOOD.removeprefix("# "))


def test_yaw_goes_on_past_half_a_turn(read):
    yaw = np.linspace(0, 20, 200)
    rows = [f"{k} 0 0 0 0 0 {np.sin(a / 2):.17g} {np.cos(a / 2):.17g}\n" for k, a in enumerate(yaw.tolist())]
    np.testing.assert_allclose(read("".join(rows)).poses[:, 2], yaw, atol=1e-13)


@given(seed=st.integers(0, 2**32 - 1))
def test_what_is_written_is_read_by_evo_and_by_us(tmp_path_factory, seed):
    evo = pytest.importorskip("evo.tools.file_interface", reason="needs the extra oracle")
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 20))
    log = dd.PoseLog(
        1.7e9 + np.cumsum(rng.random(n) + 1e-3), rng.standard_normal((n, 3)) * [1e-9, 1e4, 1.0], warnings=["gaps"]
    )
    path = tmp_path_factory.mktemp("tum") / "a.tum"
    logs.write(path, log)
    again = logs.read_poses(path)
    np.testing.assert_array_equal(again.t, log.t)
    np.testing.assert_array_equal(again.poses[:, :2], log.poses[:, :2])
    np.testing.assert_allclose(np.exp(1j * again.poses[:, 2]), np.exp(1j * log.poses[:, 2]), atol=1e-14)
    theirs = evo.read_tum_trajectory_file(path)
    np.testing.assert_array_equal(theirs.timestamps, log.t)
    np.testing.assert_array_equal(theirs.positions_xyz, np.column_stack([log.poses[:, :2], np.zeros(n)]))
    yaw = theirs.get_orientations_euler()[:, 2]
    np.testing.assert_allclose(np.exp(1j * yaw), np.exp(1j * log.poses[:, 2]), atol=1e-14)


def test_a_line_of_names_comes_first_and_every_number_has_all_its_digits(tmp_path):
    logs.write(tmp_path / "a.tum", dd.PoseLog([0.1, 0.30000000000000004], [(0, 0, 0), (1 / 3, -2, np.pi)]))
    assert (tmp_path / "a.tum").read_text().splitlines() == [
        "# timestamp tx ty tz qx qy qz qw",
        "0.1 0.0 0.0 0.0 0.0 0.0 0.0 1.0",
        f"0.30000000000000004 0.3333333333333333 -2.0 0.0 0.0 0.0 1.0 {math.cos(math.pi / 2)!r}",
    ]


def test_what_evo_writes_is_read(tmp_path):
    evo = pytest.importorskip("evo.tools.file_interface", reason="needs the extra oracle")
    from evo.core.trajectory import PoseTrajectory3D

    yaw = np.array([0.1, 0.2, 0.4])
    quaternions = np.stack([np.cos(yaw / 2), 0 * yaw, 0 * yaw, np.sin(yaw / 2)], axis=-1)
    path = tmp_path / "evo.tum"
    evo.write_tum_trajectory_file(str(path), PoseTrajectory3D(np.eye(3) * [1, 1, 0], quaternions, np.arange(3.0)))
    np.testing.assert_allclose(logs.read_poses(path).poses, np.column_stack([np.eye(3)[:, :2], yaw]), atol=1e-15)


def test_drives_and_recordings_leave_their_true_poses(tmp_path):
    robot = dd.Robot.load("matched")
    recording = dd.simulate(robot, dd.maneuvers.spin(robot, turns=0.05), sample_rate=20.0)
    for name, log in (("r.tum", recording), ("d.tum", dd.sensors.measure(recording))):
        logs.write(tmp_path / name, log)
        np.testing.assert_allclose(logs.read_poses(tmp_path / name).poses, recording.truth, atol=1e-15)
    with refused(ValueError, "a TUM file has poses and no wheels: logs.read_poses reads it"):
        logs.read(tmp_path / "d.tum")
