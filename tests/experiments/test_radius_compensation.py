"""`radius_compensation` with a user's own options: the bounds follow from them, and break when the formula does."""

import pytest
from experiment_runs import SLIPS, answer, broken, each_robot, even, right_or_refused, sizes
from figure_checks import check_layout
from helpers import experiment

import diffdrive_mj as dd

SCRIPT = experiment("radius_compensation")


@pytest.fixture
def fewer(monkeypatch):
    """Four of the ratios beside the chosen one."""
    monkeypatch.setattr(SCRIPT, "SWEPT", 4)


@each_robot
def test_any_options_have_the_right_answer_or_a_clear_line(robot, fewer):
    right_or_refused(
        SCRIPT, robot, f"{SLIPS}|too short|speeds up", speed_ratio=even(0.6, 1.5), speed=sizes(0.05, 2.0),
        seconds=even(2.5, 5.0), odometry_rate=sizes(1.0, 400.0),
    )  # fmt: skip


@pytest.mark.parametrize(
    "options",
    [
        {"speed_ratio": 1.05},
        {"speed_ratio": 1.0},
        {"speed": 2.5, "seconds": 4.5},
        {"odometry_rate": 3.0},
        {"robot": "turtlebot3_burger", "speed": 0.2},
    ],
)
def test_options_that_once_broke_a_bound(options, fewer):
    report = answer(SCRIPT, **{"seconds": 3.0, **options})
    for picture in report.pictures.values():
        check_layout(picture)


def test_a_robot_of_ones_own_with_servos_that_are_not_matched(tmp_path, fewer):
    """It leaves the line by dynamics, which its wheels' angles explain; a rigid axle by its tilt."""
    for k, changes in enumerate(({"servo": {"gains": "equal"}}, {"axle": "rigid"}, {"servo": {"law": "P"}})):
        dd.Robot.load("mismatched").replace(**changes).save(tmp_path / f"{k}.toml")
        report = answer(SCRIPT, robot=str(tmp_path / f"{k}.toml"), seconds=4.0, speed=1.0)
        assert report.metrics["left_radius_m"] == pytest.approx(0.1)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"speed_ratio": 0.5}, "friction"),
        ({"seconds": 1.9}, "seconds = 1.9: must be more than the 2 s in which the robot speeds up"),
        ({"seconds": 2.05}, "too short"),
        ({"speed_ratio": 0.0}, "speed_ratio = 0.0: must be positive"),
        ({"speed": float("inf")}, "speed = inf: must be finite"),
        ({"odometry_rate": 0.01}, "too short"),
        ({"robot": "mached"}, "did you mean 'matched'"),
    ],
)
def test_what_has_no_answer_is_said_in_one_line(options, said):
    assert said in answer(SCRIPT, **options)


def test_a_wrong_formula_breaks_a_bound(monkeypatch, fewer):
    right = dd.kinematics.compensated_right_radius
    monkeypatch.setattr(dd.kinematics, "compensated_right_radius", lambda r, k: right(r, k) * (1 + 1e-5))
    report = SCRIPT.run(seconds=3.0)
    assert any("any k: off the line" in line for line in broken(report))
