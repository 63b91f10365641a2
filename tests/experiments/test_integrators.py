"""`integrators` with a user's own options: closed forms and orders hold, and break when a formula does."""

import pytest
from experiment_runs import answer, broken, each_robot, right_or_refused, sizes
from helpers import experiment

SCRIPT = experiment("integrators")


@each_robot
def test_any_options_have_the_right_answer_or_a_clear_line(robot):
    right_or_refused(SCRIPT, robot, radius=sizes(0.1, 20.0), speed=sizes(0.05, 2.0))


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"radius": -1.0}, "radius = -1.0: must be positive"),
        ({"radius": 1e9}, "drive faster, or a smaller circle"),
        ({"speed": 1e9}, "samples"),
    ],
)
def test_what_has_no_answer_is_said_in_one_line(options, said):
    assert said in answer(SCRIPT, **options)


def test_a_formula_without_its_start_heading_breaks_a_bound(monkeypatch):
    monkeypatch.setattr(SCRIPT, "arc", SCRIPT.arc_as_printed)
    (line,) = broken(SCRIPT.run())
    assert "with its start heading" in line
