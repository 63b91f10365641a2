"""The experiment on fixes with other options than its own: the laws of courses, bends and wander hold."""

import pytest
from experiment_runs import broken, each_robot, right_or_refused, sizes, whole
from figure_checks import problems
from helpers import experiment, refused

import diffdrive_mj as dd

SCRIPT = experiment("course_from_fixes")


@each_robot
def test_any_robot_number_of_runs_and_wander_keep_the_bounds(robot):
    right_or_refused(SCRIPT, robot, runs=whole(1, 300), seed=whole(0, 99), wander_deg=sizes(0.001, 20.0))


def test_a_heading_that_holds_has_no_best_baseline():
    report = SCRIPT.run(runs=100, wander_deg=0.0)
    assert "the longer the drive, the better" in report.finding
    assert "worse" not in report.finding
    assert not any("best baseline" in bound.name for bound in report.bounds)


def test_a_robot_of_ones_own(tmp_path):
    """Servos of their own and an axle that tilts: while the wheels turn evenly the path is an arc all the same."""
    robot = dd.Robot(left_radius=0.05, right_radius=0.06, track_width=0.25, axle="rigid", servo={"gains": "equal"})
    robot.save(tmp_path / "mine.toml")
    report = SCRIPT.run(str(tmp_path / "mine.toml"), runs=20)
    assert broken(report) == []
    assert problems(report.pictures["course_from_fixes"]) == []


def test_wrong_laws_break_their_bounds(monkeypatch):
    wrong = {
        "direction_std": (1.07, "fixes alone"),
        "first_order_std": (0.98, "noise under baseline / 10"),
        "chord_shortening": (1.0001, "bends: epsilon"),
        "share_noticed": (0.9, "bends: share noticed"),
        "best_baseline": (1.06, "best baseline off"),
    }
    for law, (factor, _) in wrong.items():
        right = getattr(SCRIPT, law)
        monkeypatch.setattr(SCRIPT, law, lambda *given, right=right, factor=factor: factor * right(*given))
    lines = broken(SCRIPT.run())
    for _, words in wrong.values():
        assert any(words in line for line in lines)


@pytest.mark.parametrize(
    ("options", "word"),
    [
        ({"runs": 0}, "runs = 0"),
        ({"seed": -1}, "seed = -1"),
        ({"wander_deg": -1.0}, "wander_deg = -1.0: must not be negative"),
        ({"wander_deg": 90.0}, "wander_deg = 90: must be at most 20"),
        ({"robot": "nix"}, "unknown preset"),
    ],
)
def test_bad_options_are_refused(options, word):
    with refused(ValueError, word):
        SCRIPT.run(**options)
