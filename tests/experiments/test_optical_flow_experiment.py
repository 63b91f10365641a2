"""The mouse sensor's experiment with other options than its own: its laws hold, and show when they do not."""

import dataclasses

import pytest
from experiment_runs import broken, each_robot, right_or_refused, sizes, whole
from figure_checks import problems
from helpers import experiment, refused

import diffdrive_mj as dd

SCRIPT = experiment("optical_flow")


@each_robot
def test_any_robot_mounting_and_resolution_keep_the_bounds(robot):
    mounting = sizes(0.005, 0.5)
    right_or_refused(
        SCRIPT, robot, mounting=lambda rng: mounting(rng) * rng.choice([-1.0, 1.0]), counts_per_inch=sizes(100, 10_000),
        drives=whole(1, 60), seed=whole(0, 99),
    )  # fmt: skip


def test_a_robot_of_ones_own(tmp_path):
    """Unequal wheels on a rigid axle slide even where both slip: the law says by how much the sensor is misled."""
    robot = dd.Robot(left_radius=0.05, right_radius=0.06, track_width=0.25, axle="rigid")
    robot.save(tmp_path / "mine.toml")
    report = SCRIPT.run(str(tmp_path / "mine.toml"), drives=50)
    assert broken(report) == []
    assert problems(report.pictures["optical_flow"]) == []
    assert report.metrics["drives"][SCRIPT.BOTH]["slide"] > 0.01  # [mm]


def test_wrong_laws_break_their_bounds(monkeypatch):
    """A lever arm that is off by a thousandth, and a law of counting that is off by a third."""
    motion, end_error = SCRIPT.FlowSensor.motion, SCRIPT.end_error

    def law(*given):
        right = end_error(*given)
        return dataclasses.replace(right, position=1.3 * right.position)

    monkeypatch.setattr(SCRIPT.FlowSensor, "motion", lambda self, seen: motion(self, seen) * (1.0, 1.001))
    monkeypatch.setattr(SCRIPT, "end_error", law)
    lines = broken(SCRIPT.run())
    for words in ("arc: mouse sensor", "heading off slide / mounting", "counting, position"):
        assert any(words in line for line in lines)


@pytest.mark.parametrize(
    ("options", "word"),
    [
        ({"mounting": 0.0}, "FlowSensor.x = 0"),
        ({"counts_per_inch": 1.0}, "counts_per_inch = 1"),
        ({"counts_per_inch": -400.0}, "must be positive"),
        ({"drives": 0}, "drives = 0"),
        ({"seed": -1}, "seed = -1"),
        ({"robot": "nix"}, "unknown preset"),
    ],
)
def test_bad_options_are_refused(options, word):
    with refused(ValueError, word):
        SCRIPT.run(**options)
