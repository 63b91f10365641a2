"""The controller's experiment with other options than its own: the law holds, or one line says why it cannot."""

import re

import numpy as np
import pytest
from experiment_runs import FEW, answer, broken
from figure_checks import check_layout
from helpers import experiment, refused
from hypothesis import event, given
from hypothesis import strategies as st
from strategies import numbers

from diffdrive_mj.judging import beliefs
from diffdrive_mj.judging.standards import PRESETS

SCRIPT = experiment("go_to_goal")


@FEW
@given(
    st.fixed_dictionaries(
        {
            "robot": st.sampled_from(PRESETS),
            "believed_ratio": numbers(0.8, 1.25),
            "robots": st.integers(1, 2),
            "speed": numbers(0.2, 1.0),
            "seconds": numbers(5.0, 24.0),
            "seed": st.integers(0, 9),
        }
    )
)
def test_any_options_have_the_right_answer_or_say_what_would_do(options):
    report = answer(SCRIPT, **options)
    if isinstance(report, str):
        event("refused")
        assert re.search("still move after .* s; give more|wheels must roll", report)
        return
    for picture in report.pictures.values():
        check_layout(picture)


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
