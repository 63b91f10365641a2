"""OptiOdom's recordings: the published figures, the right wheel first, and what is wrong with a folder."""

import numpy as np
import pytest
from helpers import refused
from real_data import optiodom_recordings

import diffdrive_mj as dd
from diffdrive_mj import logs
from diffdrive_mj.errors import MissingFile

# Largest final position error of the nominal robot [mm], published with the data set.
PUBLISHED = {
    "230620202042": 33.256, "230620202317": 33.461, "231220200040": 113.891, "250620202104": 50.799,
    "250620202119": 48.736, "250620202236": 50.992, "231220200150": 112.868, "231220200157": 75.005,
    "231220200057": 20.698, "250620201738": 24.368, "030120210001": 54.486,
}  # fmt: skip


def test_optiodom_reads_as_its_authors_do():
    for folder in optiodom_recordings():
        drives, nominal = logs.read_optiodom(folder), logs.optiodom_robot(folder)
        assert [drive.name for drive in drives] == [f"{folder.name}_run-{k + 1:02d}" for k in range(len(drives))]
        # The published column takes one nominal robot throughout; the metadata of two recordings name another.
        published_robot = dd.Robot.load("optiodom")
        sizes = {field: getattr(nominal, field) for field in ("left_radius", "track_width")}
        assert nominal == published_robot.replace(name=nominal.name, right_radius=nominal.left_radius, **sizes)
        assert sizes["left_radius"] == {"250620202236": 0.0425}.get(folder.name, 0.042)
        assert sizes["track_width"] == {"250620202119": 0.205, "250620202236": 0.205}.get(folder.name, 0.2)
        worst = 1e3 * max(drive.drift(published_robot).final_position for drive in drives)
        # The clocks of a free drive are 0.05 s apart, which its authors take out.
        assert worst == pytest.approx(PUBLISHED[folder.name], abs=0.1 if folder.parent.name == "free" else 0.002)


def optiodom_copy(folder, **changes):
    """A small recording in the data set's form; `changes` replace rows of the metadata."""
    metadata = {"Li": "0.2,", "Di": "0.084,0.080", "ngear": "43.7,", "encRes": "64,", "N": "1,"} | changes
    (folder / "7_metadata.csv").write_text("".join(f"{key},{cells}\n" for key, cells in metadata.items()))
    (folder / "7_run-01.csv").write_text("0,0,0,0,0,0\n0.05,0.1,0.2,0.3,10,20\n")
    return folder


def test_optiodom_has_the_right_wheel_first(tmp_path):
    folder = optiodom_copy(tmp_path)
    robot, (drive,) = logs.optiodom_robot(folder), logs.read_optiodom(folder)
    assert (robot.left_radius, robot.right_radius, robot.track_width) == (0.040, 0.042, 0.2)
    assert robot.encoder.ticks_per_wheel_turn == pytest.approx(2796.8)
    np.testing.assert_allclose(drive.wheel_angles[1], np.array([20, 10]) * 2 * np.pi / 2796.8)
    np.testing.assert_array_equal(drive.truth[1], [0.1, 0.2, 0.3])


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"Li": ","}, ("Li", "0 values")),
        ({"Li": "wide,"}, ("line 1", "'wide'")),
        ({"Di": "0.084,"}, ("Di", "1 values")),
        ({"ngear": "many,"}, ("line 3", "'many'")),
        ({"Di": "0,0.084"}, ("right_radius",)),
    ],
)
def test_bad_optiodom_metadata(tmp_path, changes, words):
    with refused(ValueError, *words):
        logs.read_optiodom(optiodom_copy(tmp_path, **changes))


def test_folders_that_are_no_recording(tmp_path):
    with refused(FileNotFoundError, tmp_path, "0 files"):
        logs.read_optiodom(tmp_path)
    with refused(FileNotFoundError, "nowhere"):
        logs.optiodom_robot(tmp_path / "nowhere")
    (optiodom_copy(tmp_path) / "7_run-01.csv").unlink()
    with pytest.raises(MissingFile, match="7_run-NN"):
        logs.read_optiodom(tmp_path)


def test_the_wheels_columns_are_increments_right_before_left(tmp_path):
    folder = optiodom_copy(tmp_path)
    (folder / "7_run-01.csv").write_text("0,0,0,0,0,0\n0.05,0.1,0.2,0.3,10,20\n0.10,0.2,0.2,0.3,-3,5\n")
    (drive,) = logs.read_optiodom(folder)
    tick = 2 * np.pi / (64 * 43.7)
    assert drive.wheel_angles == pytest.approx(tick * np.array([(0, 0), (20, 10), (25, 7)]))
    assert drive.truth[1] == pytest.approx((0.1, 0.2, 0.3))
