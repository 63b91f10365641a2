"""Replays: thinned by no more than can be seen, the same after they were written, refused where they make no sense."""

import json

import numpy as np
import page_cases as cases
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import robots

import diffdrive_mj as dd
from diffdrive_mj.errors import DiffdriveError, InvalidType, InvalidValue, UnknownName
from diffdrive_mj.report import Replay, Report
from diffdrive_mj.report._thinning import kept
from diffdrive_mj.report.replays import from_json, to_json

ROBOT = cases.ROBOT
STILL = np.zeros((3, 3))


@given(seed=st.integers(0, 2**32 - 1), samples=st.integers(2, 300), roughness=st.floats(0.0, 1.0))
def test_lines_between_the_kept_samples_stay_within_the_tolerances(seed, samples, roughness):
    rng = np.random.default_rng(seed)
    t = np.cumsum(rng.uniform(0.01, 1.0, samples))
    curves = np.stack([np.sin(t), roughness * rng.normal(size=samples)])
    tolerances = np.array([0.02, 0.3])
    chosen = kept(t, curves, tolerances, most=samples)
    assert (chosen[0], chosen[-1]) == (0, samples - 1)
    assert (np.diff(chosen) > 0).all()
    for curve, tolerance in zip(curves, tolerances, strict=True):
        assert np.abs(np.interp(t, t[chosen], curve[chosen]) - curve).max() <= tolerance * (1 + 1e-9)


def test_a_limit_keeps_what_matters_most():
    t = np.arange(1001.0)
    curve = np.where(t == 300, 50.0, np.random.default_rng(0).normal(size=1001))
    chosen = kept(t, curve[None], np.array([1e-6]), most=10)
    assert len(chosen) == 10
    assert 300 in chosen
    assert list(kept(t, np.zeros((1, 1001)), np.array([1.0]), most=10)) == [0, 1000]


def test_long_recordings_are_thinned_evenly_first():
    t = np.linspace(0.0, 1.0, 300_000)
    chosen = kept(t, np.sin(20 * t)[None], np.array([1e-3]), most=400)
    assert (chosen[0], chosen[-1]) == (0, 299_999)
    assert np.abs(np.interp(t, t[chosen], np.sin(20 * t[chosen])) - np.sin(20 * t)).max() < 1.1e-3


def test_a_thinned_replay_is_what_it_was():
    whole = cases.replay()
    thin = whole.thinned()
    assert 10 < len(thin.t) < len(whole.t)
    for name, path in whole.beliefs.items():
        extent = 1e-4 * np.ptp(path[:, :2]).max() * 2
        for axis, tolerance in ((0, extent), (1, extent), (2, 5e-3)):
            between = np.interp(whole.t, thin.t, thin.beliefs[name][:, axis])
            assert np.abs(between - path[:, axis]).max() < tolerance
        off = np.interp(whole.t, thin.t, thin.errors(name).position_error)
        assert np.abs(off - whole.errors(name).position_error).max() < 5e-3 * off.max() * 1.01
    assert len(thin.thinned().t) <= len(thin.t)
    assert len(whole.thinned(7).t) == 7


@given(robot=robots)
def test_a_replay_is_read_as_it_was_written(robot):
    t = np.array([0.0, 0.1, 0.3])
    poses = np.array([(0.0, 0.0, 0.0), (1 / 3, 0.1, 0.2), (0.5, -1e-9, 7.0)])
    (read,) = from_json(to_json([Replay("x", t, poses, {"a": poses + 0.1}, robot, {"a": robot})]))
    assert read.t.tolist() == [0.0, 0.1, 0.3]
    assert read.truth.tolist() == poses.tolist()
    assert read.beliefs["a"].tolist() == (poses + 0.1).tolist()
    for one in (read.robot, read.believed["a"]):
        assert (one.left_radius, one.right_radius, one.track_width) == (
            robot.left_radius, robot.right_radius, robot.track_width,
        )  # fmt: skip
        assert (one.tyres.width, one.caster) == (robot.tyres.width, robot.caster)


def test_a_spin_stays_one_however_few_samples_are_left():
    """Between two samples it may turn by more than a turn."""
    t = np.linspace(0.0, 10.0, 501)
    spin = np.stack([0 * t, 0 * t, 2 * t], axis=-1)
    (read,) = from_json(to_json([Replay("x", t, spin, {"a": 0.9 * spin}, ROBOT)]))
    assert read.truth[-1, 2] == 20.0
    assert read.beliefs["a"][-1, 2] == 18.0
    # The errors jump where they pass the far side of the circle, and nowhere else.
    error = np.interp(t, read.t, read.errors("a").heading_error)
    assert np.abs(error + 0.2 * t).max() < 0.02


def test_a_heading_error_of_several_turns_keeps_a_few_samples_a_turn():
    """Else nobody could tell a turn from a jump."""
    t = np.linspace(0.0, 10.0, 2001)
    spin = np.stack([0 * t, 0 * t, 2 * t], axis=-1)
    thin = Replay("x", t, spin, {"a": 2 * spin}, ROBOT).thinned()
    assert np.diff(2 * thin.t).max() < 1.0
    assert len(thin.t) < 100


def test_the_headings_of_a_tracker_are_joined():
    robot = dd.Robot.load("matched")
    recording = dd.simulate(robot, dd.maneuvers.spin(robot, turns=0.75))
    drive = dd.sensors.measure(recording)
    wrapped = np.column_stack([drive.truth[:, :2], dd.se2.wrap_angle(drive.truth[:, 2])])
    made = Replay.of("x", dd.Drive(drive.t, drive.wheel_angles, wrapped), {"a": robot})
    assert made.truth[-1, 2] == pytest.approx(1.5 * np.pi, abs=0.01)


def test_recordings_and_drives_become_replays():
    robot = dd.Robot.load("mismatched")
    recording = dd.simulate(robot, dd.maneuvers.spin(robot, turns=0.25))
    believed = {"wide": robot.replace(track_width=0.44)}
    made = Replay.of("A turn", recording, believed)
    assert made.robot == robot
    assert made.errors("wide").final_heading == pytest.approx(-np.pi / 2 * (1 - 0.4 / 0.44), rel=1e-3)
    drive = Replay.of("A turn", dd.sensors.measure(recording), believed)
    assert drive.robot == believed["wide"]
    assert Replay.of("A turn", dd.sensors.measure(recording), believed, robot).robot == robot
    with pytest.raises(InvalidValue, match="a recording of several robots: must be of one"):
        Replay.of("two", dd.simulate([robot] * 2, dd.maneuvers.spin(robot, turns=0.1)), believed)
    with pytest.raises(InvalidType, match="driven = a list: must be a Recording or a Drive"):
        Replay.of("none", [], believed)
    with pytest.raises(InvalidValue, match="believed is empty"):
        Replay.of("none", recording, {})
    with pytest.raises(InvalidType, match="believed\\['a'\\] = 3: must be a Robot"):
        Replay.of("none", recording, {"a": 3})


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"title": 3}, "Replay.title = 3: must be a string"),
        ({"t": [0.0, 0.0, 1.0]}, "times must increase"),
        ({"t": [0.0, 1.0]}, "has shape (3, 3): must be (2, 3), as t has 2 times"),
        ({"truth": np.zeros((3, 2))}, "truth has shape"),
        ({"truth": np.full((3, 3), np.nan)}, "must be finite"),
        ({"beliefs": {}}, "x: 0 beliefs: must be 1 to 20"),
        ({"beliefs": {str(k): STILL for k in range(21)}}, "x: 21 beliefs: must be 1 to 20"),
        ({"beliefs": [STILL]}, "beliefs: must be a mapping by name"),
        ({"beliefs": {3: STILL}}, "a name of beliefs = 3: must be a string"),
        ({"beliefs": {"a": np.zeros((4, 3))}}, "x: a has shape (4, 3)"),
        ({"robot": "matched"}, "must be a Robot"),
        ({"believed": {"b": ROBOT}}, "believed['b'] has no path in beliefs"),
        ({"believed": {"a": 3}}, "believed['a'] = 3: must be a Robot"),
    ],
)
def test_what_makes_no_sense_is_refused(changes, words):
    given = {"title": "x", "t": [0.0, 1.0, 2.0], "truth": STILL, "beliefs": {"a": STILL}, "robot": ROBOT}
    with pytest.raises(DiffdriveError) as info:
        Replay(**given | changes)
    assert words in str(info.value)


def test_a_belief_that_there_is_not():
    with pytest.raises(UnknownName, match="unknown belief 'equal'"):
        cases.replay().errors("equal")


@pytest.mark.parametrize(
    "text",
    ["", "[]", "3", "{}", '{"replays": 3}', '{"replays": [3]}', '{"replays": [{}]}', "[" * 100_000,
     '{"replays": [{"title": "x", "robot": {"left_radius": "1"}, "believed": {}}]}'],
)  # fmt: skip
def test_what_is_no_file_of_replays_is_refused(text):
    with pytest.raises(DiffdriveError):
        from_json(text)


@pytest.mark.parametrize(
    "path", [("t", 1), ("truth", 1, 2), ("robot", "track_width"), ("beliefs", "nearly right", 0, 0)]
)
@pytest.mark.parametrize("value", [None, "x", [], 1e999, -1])
def test_a_file_with_one_wrong_value_is_refused_or_read(path, value):
    content = json.loads(to_json([cases.replay()]))
    place = content["replays"][0]
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = value
    try:
        assert value == -1
        from_json(json.dumps(content))
    except (DiffdriveError, AssertionError):
        with pytest.raises(DiffdriveError):
            from_json(json.dumps(content))


def test_the_file_is_the_reports_own(tmp_path):
    made = Report("Why?", "So.", "", [], replays=[cases.replay()])
    made.write(tmp_path)
    made.write(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["metrics.json", "replays.json"]
    Report("Why?", "So.", "", []).write(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["metrics.json"]
    (tmp_path / "replays.json").write_text("my own")
    with pytest.raises(InvalidValue, match=r"replays\.json: was not written by an experiment"):
        made.write(tmp_path)
    with pytest.raises(InvalidType, match=r"Report\.replays\[0\] = 3: must be a Replay"):
        Report("Why?", "So.", "", [], replays=[3])
