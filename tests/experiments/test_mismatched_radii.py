"""`mismatched_radii` with a user's own options: the bounds follow from them, and break when the law does."""

import pytest
from experiment_runs import answer, broken, each_robot, even, right_or_refused, sizes
from figure_checks import check_layout
from helpers import experiment

import diffdrive_mj as dd

SCRIPT = experiment("mismatched_radii")


@each_robot
def test_any_options_have_the_right_answer(robot):
    distance = even(0.2, 5.0)
    right_or_refused(
        SCRIPT, robot, distance=lambda rng: distance(rng) * rng.choice([-1.0, 1.0]), speed=sizes(0.1, 3.0),
        side=sizes(0.1, 1.0),
    )  # fmt: skip


def test_a_robot_of_ones_own(tmp_path):
    """Servos that are not matched, on an axle that tilts, with a load to one side: the law asks for none of it."""
    robot = dd.Robot.load("mismatched").replace(
        axle="rigid", servo={"gains": "equal", "law": "P"}, payload={"mass": 1.0, "y": 0.05, "height": 0.1}
    )
    robot.save(tmp_path / "mine.toml")
    report = answer(SCRIPT, robot=str(tmp_path / "mine.toml"), distance=3.0, side=0.5)
    for picture in report.pictures.values():
        check_layout(picture)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"distance": 0.0}, "distance = 0"),
        ({"speed": -1.0}, "speed = -1.0: must be positive"),
        ({"side": float("nan")}, "side = nan: must be finite"),
        ({"distance": 1e12}, "samples"),
        ({"robot": "nobody.toml"}, "nobody.toml: no such robot file"),
    ],
)
def test_what_has_no_answer_is_said_in_one_line(options, said):
    assert said in answer(SCRIPT, **options)


def test_a_wrong_law_breaks_a_bound(monkeypatch):
    right = SCRIPT.believed_path
    monkeypatch.setattr(SCRIPT, "believed_path", lambda path, believed, true: right(path, true, believed))
    assert len(broken(SCRIPT.run(distance=2.0, side=0.5))) == 4
