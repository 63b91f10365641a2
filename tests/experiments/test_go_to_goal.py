"""The controller's experiment with other options than its own: the law holds, or one line says why it cannot."""

import numpy as np
import pytest
from experiment_runs import SLIPS, broken, each_robot, even, right_or_refused, whole
from helpers import experiment, refused

from diffdrive_mj.judging import beliefs

SCRIPT = experiment("go_to_goal")


@each_robot
def test_any_options_have_the_right_answer_or_say_what_would_do(robot):
    right_or_refused(
        SCRIPT, robot, f"{SLIPS}|still move after .* s; give more", believed_ratio=even(0.8, 1.25), robots=whole(1, 2),
        speed=even(0.2, 0.8), seconds=even(14.0, 20.0), seed=whole(0, 9),
    )  # fmt: skip


def test_a_wrong_law_breaks_the_bounds(monkeypatch):
    right = beliefs.belief_matrix
    monkeypatch.setattr(beliefs, "belief_matrix", lambda *robots: right(*robots) + np.diag([1e-4, 0.0]))
    assert any("off the law" in line for line in broken(SCRIPT.run(robots=1)))


def test_a_controller_that_stops_short_breaks_the_bounds(monkeypatch):
    monkeypatch.setattr("diffdrive_mj.controller._THERE", 0.02)
    assert any("says that it is from the goal" in line for line in broken(SCRIPT.run(robots=1)))


def test_too_short_a_drive_is_said():
    with refused(ValueError, "seconds = 6", "3 of 3 robots to the goal still move after 6 s"):
        SCRIPT.run(robots=3, seconds=6.0)


@pytest.mark.parametrize("options", [{"robots": 0}, {"seed": -1}, {"believed_ratio": 0.0}, {"speed": -1.0}])
def test_bad_options_are_refused(options):
    with refused(ValueError, next(iter(options)), next(iter(options.values()))):
        SCRIPT.run(**options)


def test_starts_lie_around_the_goal():
    distance = np.hypot(*SCRIPT.starts(500, np.random.default_rng(0))[:, :2].T)
    assert 1.0 <= distance.min() < 1.1
    assert 1.9 < distance.max() <= 2.0
