"""WPILib's data logs, written byte by byte as specified."""

import bags
import numpy as np
import pytest
from helpers import refused

import diffdrive_mj as dd
from diffdrive_mj import logs
from diffdrive_mj.logs import Entries

pytest.importorskip("wpiutil.log", reason="needs the extra wpilog")

LEFT, RIGHT, POSE = "/drive/leftPosition", "/drive/rightPosition", "/mocap"
KINDS = {LEFT: "double", RIGHT: "double", POSE: "struct:Pose2d", "/enabled": "boolean"}
ROBOT = dd.Robot(left_radius=0.05, right_radius=0.04, track_width=0.3, encoder={"ticks_per_revolution": 1000})


def values(n=6, period=20_000, late=0):
    """Wheels every 20 ms, the right one perhaps later, and a pose every 40 ms."""
    for k in range(n):
        yield "/enabled", k * period, True
        yield LEFT, k * period, 1.0 * k
        yield RIGHT, k * period + late, 2.0 * k
        if k % 2 == 0:
            yield POSE, k * period, (0.1 * k, 0.2 * k, 0.3 * k)


@pytest.fixture
def log(tmp_path):
    def write(kinds=KINDS, content=None):
        return bags.wpilog(tmp_path / "a.wpilog", kinds, values() if content is None else content)

    return write


def test_wheels_and_poses_by_name_or_as_the_only_candidates(log):
    drive = logs.read(log())
    np.testing.assert_allclose(drive.t, 0.02 * np.arange(6), atol=1e-15)
    np.testing.assert_array_equal(drive.wheel_angles, [[k, 2 * k] for k in range(6)])
    np.testing.assert_allclose(drive.truth, [(0.1 * k, 0.2 * k, 0.3 * k) for k in (0, 2, 4)])
    assert drive.warnings == ()
    swapped = logs.read(log(), Entries(left=RIGHT, right=LEFT, pose=POSE))
    np.testing.assert_array_equal(swapped.wheel_angles, drive.wheel_angles[:, ::-1])
    np.testing.assert_array_equal(logs.read_poses(log()).poses, drive.truth)


@pytest.mark.parametrize(
    ("options", "factors"),
    [
        ({}, (1, 1)),
        ({"wheel_unit": "rotations"}, (2 * np.pi, 2 * np.pi)),
        ({"wheel_unit": "rotations", "gear": 10}, (np.pi / 5, np.pi / 5)),
        ({"wheel_unit": "degrees", "reverse_left": True}, (-np.pi / 180, np.pi / 180)),
        ({"wheel_unit": "metres", "reverse_right": True}, (20, -25)),
        ({"wheel_unit": "ticks"}, (np.pi / 500, np.pi / 500)),
        ({"wheel_unit": "ticks", "ticks_per_revolution": 500}, (np.pi / 250, np.pi / 250)),
    ],
)
def test_units(log, options, factors):
    drive = logs.read(log(), Entries(**options), robot=ROBOT)
    np.testing.assert_allclose(drive.wheel_angles, [[k * factors[0], 2 * k * factors[1]] for k in range(6)], rtol=1e-15)


@pytest.mark.parametrize(("kind", "of"), [("float", float), ("int64", int)])
def test_numbers_of_other_types(log, kind, of):
    content = [(name, t, of(v) if name in (LEFT, RIGHT) else v) for name, t, v in values()]
    drive = logs.read(log({**KINDS, LEFT: kind, RIGHT: kind}, content))
    np.testing.assert_array_equal(drive.wheel_angles, [[k, 2 * k] for k in range(6)])


def test_wheels_that_are_logged_one_after_the_other(log):
    """The right wheel 30 us later: both turn evenly between their own samples, at the times of either."""
    drive = logs.read(log(content=values(late=30)))
    np.testing.assert_allclose(drive.wheel_angles[:, 0], drive.t / 0.02, atol=1e-9)
    np.testing.assert_allclose(drive.wheel_angles[:, 1], 2 * (drive.t - 30e-6) / 0.02, atol=1e-9)


def test_a_wheel_without_new_values_stands_still(log):
    """Logs keep changes: a robot that stands for a second does not creep for a second."""
    kept = [(name, t, v) for name, t, v in values(60) if name == POSE or not 200_000 < t < 1_000_000]
    moved = [(name, t, v if name == POSE or t <= 200_000 or name == "/enabled" else v - (39 if name == LEFT else 78))
             for name, t, v in kept]  # fmt: skip
    drive = logs.read(log(content=moved))
    np.testing.assert_allclose(drive.angles_at([0.2, 0.6, 0.98]), [(10, 20)] * 3, atol=1e-9)
    np.testing.assert_allclose(drive.angles_at([1.0]), [(11, 22)], atol=1e-9)
    assert any(line.startswith(f"{LEFT}: 1 gap, the longest of 0.8 s at 0.2 s") for line in drive.warnings)


def test_a_wheel_that_never_turns_again_stands_still_until_the_other_ends(log):
    """A pivot about the left wheel: it has one value, or its last when the pivot begins."""
    for last in (0, 200_000):
        kept = [(name, t, v) for name, t, v in values(60) if name != LEFT or t <= last]
        drive = logs.read(log(content=kept))
        assert drive.t[-1] == pytest.approx(1.18)
        np.testing.assert_array_equal(drive.wheel_angles[-5:, 0], last / 20_000)
        np.testing.assert_allclose(drive.wheel_angles[-5:, 1], [110, 112, 114, 116, 118])
        ends = f"the left wheel has no value after {last / 1e6:g} s, and was taken to stand still until 1.18 s"
        assert drive.warnings == (ends,)


def test_a_wheel_of_one_value_may_have_it_before_the_other_begins(log):
    content = [(LEFT, 0, 7.0), *((n, t, v) for n, t, v in values() if n == POSE or (n == RIGHT and t > 0))]
    drive = logs.read(log(content=content))
    np.testing.assert_allclose(drive.t, 0.02 * np.arange(1, 6), atol=1e-15)
    np.testing.assert_array_equal(drive.wheel_angles, [[7, 2 * k] for k in range(1, 6)])


@pytest.mark.parametrize("cut", [1, 8, 25])
def test_a_log_that_is_cut_short_says_so(log, cut):
    """The reader gives the last whole record again; it must neither count nor be called a repeated sample."""
    path = log(content=[*values(), (POSE, 110_000, (9.0, 9.0, 9.0)), (POSE, 120_000, (9.5, 9.5, 9.5))])
    whole = path.read_bytes()
    path.write_bytes(whole[:-cut])
    found = logs.read_poses(path)
    assert found.t.tolist() == [0, 0.04, 0.08, 0.11]
    assert found.warnings == ("the log ends within a record, after 0.11 s: it was cut short",)
    assert logs.read(path).warnings == found.warnings
    path.write_bytes(whole)
    assert logs.read_poses(path).warnings == ()


@pytest.mark.parametrize(
    ("kinds", "options", "words"),
    [
        (
            {LEFT: "double", POSE: "struct:Pose2d"},
            {},
            "no entry of type double or float or int64 has 'right' in its name: name one of /drive/leftPosition, as in",
        ),
        ({**KINDS, "/drive/leftVelocity": "double"}, {}, f"{LEFT}, /drive/leftVelocity may be left: name one"),
        ({**KINDS, "/auto": "struct:Pose2d"}, {}, "/mocap, /auto may be pose: name one, as in Entries(pose='/mocap')"),
        ({LEFT: "double", RIGHT: "double"}, {}, "no entry of type struct:Pose2d: there is none"),
        (KINDS, {"left": "/lft"}, "unknown entry of"),
        (KINDS, {"left": "/enabled"}, "/enabled is of type boolean: must be double or float or int64"),
        (KINDS, {"pose": LEFT}, f"{LEFT} is of type double: must be struct:Pose2d"),
    ],
)
def test_entries_that_cannot_be_chosen(log, kinds, options, words):
    path = log(kinds, [(name, t, v) for name, t, v in values() if name in kinds])
    with refused(ValueError, words):
        logs.read(path, Entries(**options))


def test_without_wpiutil_one_line_has_the_command(log, monkeypatch):
    path = log()
    monkeypatch.setitem(__import__("sys").modules, "wpiutil.log", None)
    with refused(ImportError, f"{path}: a WPILib data log needs wpiutil: pip install 'diffdrive_mj[wpilog]'"):
        logs.read(path)


def test_data_logs_are_not_written(tmp_path):
    with refused(ValueError, "a WPILib data log is read and not written; logs are written to .mcap, .db3, .tum, .csv"):
        logs.write(tmp_path / "a.wpilog", dd.PoseLog([0, 1], np.zeros((2, 3))))
