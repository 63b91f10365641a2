"""One rule for all clocks: repeats are dropped, going back is refused, gaps are said."""

import numpy as np
import pytest
from helpers import refused
from hypothesis import given
from hypothesis import strategies as st

from diffdrive_mj import logs
from diffdrive_mj.logs import _clocks


def at(k):
    return f"row {k}"


@given(st.lists(st.integers(1, 3), min_size=2, max_size=20), st.integers(0, 2**32 - 1))
def test_however_often_samples_are_repeated_they_count_once(times, seed):
    """Any log with repeats is the log without them."""
    rng = np.random.default_rng(seed)
    t, values = np.cumsum(rng.random(len(times)) + 0.1), rng.standard_normal((len(times), 2))
    found, left, said = _clocks.settled("log", "wheels", np.repeat(t, times), np.repeat(values, times, axis=0), at)
    np.testing.assert_array_equal(found, t)
    np.testing.assert_array_equal(left, values)
    dropped = sum(times) - len(times)
    assert any(f"wheels: {dropped} repeated sample" in line for line in said) == (dropped > 0)


@pytest.mark.parametrize(
    ("t", "x", "words"),
    [
        ([0, 1, 0.5], [0, 1, 2], "row 2: 0.5 s after 1 s: times must increase"),
        ([0, 1, 1], [0, 1, 2], "row 2: 1 s after 1 s: times must increase; only a sample that repeats"),
        ([0, 1, 1, 1], [0, 1, 1, 2], "row 3: 1 s after 1 s"),
        ([0, 1, 0, 1], [0, 1, 0, 1], "row 2: 0 s after 1 s"),
        ([1.7e9 + 0.25, 1.7e9], [0, 0], "row 1: 1700000000 s after 1700000000.25 s"),
    ],
)
def test_a_clock_that_goes_back_or_shows_two_things_is_refused(t, x, words):
    with refused(ValueError, words):
        _clocks.settled("log", "wheels", np.array(t, dtype=float), np.array(x, dtype=float)[:, None], at)


def test_samples_of_several_kinds_repeat_only_as_a_whole():
    """Two rows of one time, of which one has the wheels and the other the pose, are not the same."""
    t, values = np.array([0.0, 0.0, 1.0]), np.zeros((2, 1))
    with refused(ValueError, "row 1: 0 s after 0 s"):
        _clocks.kept(t, [(values, np.array([True, False, True])), (values, np.array([False, True, True]))], at)
    with refused(ValueError, "row 2: 1 s after 1 s"):
        _clocks.kept(np.array([0.0, 1.0, 1.0]), [(np.array([[1.0], [2.0]]), np.array([False, True, True]))], at)
    counts = _clocks.kept(t, [(np.zeros((3, 1)), None), (np.ones((1, 1)), np.array([False, False, True]))], at)
    assert counts.tolist() == [True, False, True]


def test_gaps_are_longer_than_five_median_intervals():
    t = np.cumsum([0, 1, 1, 5, 1, 1, 5.1, 1, 30, 1, 1, 1, 1])
    assert t[_clocks.gaps(t)].tolist() == [9.0, 15.1]
    [said] = _clocks.remarks("truth", t)
    assert said == "truth: 2 gaps, the longest of 30 s at 15.1 s (the median interval is 1 s)"
    assert _clocks.remarks("truth", np.array([0.0, 1.0, 3.0])) == ()
    assert _clocks.remarks("truth", np.array([0.0, 100.0])) == ()


def test_what_lies_in_a_gap():
    t = np.array([0, 1, 2, 3, 13, 14, 15.0])
    instants = np.array([-1, 0, 0.5, 3, 3 + 1e-12, 3.1, 12.9, 13, 13.5, 15, 16])
    expected = [False, False, False, False, False, True, True, False, False, False, False]
    assert _clocks.in_gaps(t, instants).tolist() == expected


def test_a_first_gap_and_ends_that_are_rounded():
    t = np.array([0.0, 10.0, 11.0, 12.0, 13.0])
    instants = np.array([1e-12, 5.0, 10.0 - 1e-12, 10.5])
    assert _clocks.in_gaps(t, instants).tolist() == [False, True, False, False]


def test_a_csv_file_keeps_the_rule(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("t,left,right,x,y,theta\n0,0,0,0,0,0\n0.1,1,1,,,\n0.1,1,1,,,\n0.2,2,2,1,0,0\n5,3,3,2,0,0\n")
    drive = logs.read_csv(path)
    assert drive.t.tolist() == [0, 0.1, 0.2, 5]
    assert "wheels: 1 repeated sample dropped" in drive.warnings
    assert "wheels: 1 gap, the longest of 4.8 s at 0.2 s (the median interval is 0.1 s)" in drive.warnings
    assert len(drive.warnings) == 2
    path.write_text(path.read_text().replace("0.1,1,1,,,\n0.1,1,1,,,", "0.1,1,1,,,\n0.1,1,2,,,"))
    with refused(ValueError, "line 4, column 1 (t): 0.1 s after 0.1 s"):
        logs.read_csv(path)


def test_repeated_increments_count_once(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("t,left,right,x,y,theta\n0,1,1,0,0,0\n1,1,2,0,0,0\n1,1,2,0,0,0\n2,1,3,0,0,0\n")
    drive = logs.read_csv(path, logs.Columns(wheels="increments"))
    assert drive.wheel_angles.tolist() == [[1, 1], [2, 3], [3, 6]]
    assert sorted(drive.warnings) == ["poses: 1 repeated sample dropped", "wheels: 1 repeated sample dropped"]


def test_a_drift_repeats_what_is_to_be_known_of_the_log(tmp_path):
    import diffdrive_mj as dd

    path = tmp_path / "log.csv"
    path.write_text("t,left,right,x,y,theta\n0,0,0,0,0,0\n0,0,0,0,0,0\n1,1,1,0.1,0,0\n")
    drive = logs.read(path)
    robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
    assert drive.drift(robot).warnings == drive.warnings != ()


@pytest.mark.parametrize(("unit", "said"), [(1, False), (1e3, True), (1e6, True), (1e9, True)])
def test_times_of_today_that_are_not_in_seconds_are_reported(tmp_path, unit, said):
    path = tmp_path / "a.tum"
    path.write_text("".join(f"{(1_700_000_000 + k) * int(unit)} {k} 0 0 0 0 0 1\n" for k in range(3)))
    assert any("are they in ms, us or ns" in line for line in logs.read_poses(path).warnings) == said
