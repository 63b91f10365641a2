"""`error_attribution` with a user's own options, and its bounds broken on purpose."""

import pytest
from experiment_runs import answer, broken, each_robot, right_or_refused, sizes, whole
from helpers import experiment

from diffdrive_mj.estimation import shapley

SCRIPT = experiment("error_attribution")


@each_robot
def test_any_options_have_the_right_answer(robot):
    right_or_refused(SCRIPT, robot, mixes=whole(2, 8), friction=sizes(0.04, 1.0), seed=whole(0, 99))


@pytest.mark.slow
def test_three_hundred_mixes():
    report = answer(SCRIPT, mixes=300)
    assert report.metrics["mixes_judged"] == 300


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"mixes": 0}, "mixes = 0"),
        ({"friction": -1.0}, "friction = -1.0: must be positive"),
        ({"robot": "nobody.toml"}, "nobody.toml: no such robot file"),
    ],
)
def test_what_has_no_answer_is_said_in_one_line(options, said):
    assert said in answer(SCRIPT, **options)


def test_parts_that_leave_something_over_break_a_bound(monkeypatch):
    right = shapley.parts
    monkeypatch.setattr(shapley, "parts", lambda outcomes: 0.999 * right(outcomes))
    assert "parts against the error" in broken(SCRIPT.run(mixes=2))[0]
