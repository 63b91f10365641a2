"""The assertion in tests: what it passes on, and where its pictures go."""

import inspect
from pathlib import Path

import numpy as np
import pytest

import diffdrive_mj as dd
from diffdrive_mj import testing
from diffdrive_mj.judging.verdict import Row, Verdict
from diffdrive_mj.report.experiment import Report

ROBOT = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
AHEAD = dd.Task("ahead", ROBOT, [0.0, 1.0], [(0, 0), (10, 10)])
BROKEN = Verdict("mine", (Row(AHEAD, np.ones((2, 3)), 1.0, 0.1, None, ("off",)),))


@pytest.fixture
def written(monkeypatch):
    """The folders into which reports are written."""
    found = []
    monkeypatch.setattr(Report, "write", lambda report, folder: found.append(Path(folder)))
    return found


def test_options_reach_the_judge_as_they_are(monkeypatch):
    asked = []

    def judge(*arguments, **options):
        asked.append((arguments, options))
        return Verdict("mine", ())

    monkeypatch.setattr(testing, "judge", judge)
    options = {
        "robot": ROBOT, "position": 1.0, "heading": 2.0, "position_per_metre": 3.0, "unit": "ticks", "seconds": 4.0
    }  # fmt: skip
    testing.assert_drift(AHEAD, ROBOT, **options)
    testing.assert_drift(AHEAD, ROBOT)
    assert asked[0] == ((ROBOT, [AHEAD]), options)
    assert asked[1][1] == {**dict.fromkeys(options), "unit": "rad", "seconds": 10.0}
    assert list(inspect.signature(testing.assert_drift).parameters)[2:] == list(options)


def test_each_case_of_a_test_has_a_folder_for_its_pictures(monkeypatch, written, tmp_path):
    monkeypatch.setenv("DIFFDRIVE_PICTURES", str(tmp_path))
    monkeypatch.setenv("PYTEST_CURRENT_TEST", "tests/test_mine.py::test_drive[a b-1.5] (call)")
    folder = tmp_path / "tests_test_mine.py_test_drive_a_b-1.5_"
    assert testing._pictures(BROKEN) == [folder / "ahead.png"]
    assert written == [folder]


def test_without_a_folder_pictures_are_temporary(monkeypatch, written, tmp_path):
    monkeypatch.delenv("DIFFDRIVE_PICTURES", raising=False)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    (picture,) = testing._pictures(BROKEN)
    assert written == [picture.parent]
    assert picture.parent.parent == tmp_path
    assert picture.parent.name.startswith("diffdrive-")


def test_what_is_broken_is_said_with_the_picture_below(monkeypatch, written, tmp_path):
    monkeypatch.setattr(testing, "judge", lambda *_, **__: BROKEN)
    monkeypatch.setenv("DIFFDRIVE_PICTURES", str(tmp_path))
    with pytest.raises(AssertionError) as failed:
        testing.assert_drift(AHEAD, ROBOT)
    assert str(failed.value) == f"{BROKEN}\npicture: {written[0] / 'ahead.png'}"
