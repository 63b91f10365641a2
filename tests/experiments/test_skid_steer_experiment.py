"""`skid_steer` with a user's own options, and its bounds broken on purpose."""

import dataclasses

import pytest
from experiment_runs import answer, broken
from helpers import experiment

import diffdrive_mj as dd

SCRIPT = experiment("skid_steer")


@pytest.mark.parametrize(
    "options",
    [{"wheelbase": 0.35, "friction": 0.5}, pytest.param({"track_width": 0.8, "start": 4.0}, marks=pytest.mark.slow)],
)
def test_any_options_have_the_right_answer(options):
    assert not isinstance(answer(SCRIPT, **options), str)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"wheelbase": 0.0}, "wheelbase = 0.0: must be positive"),
        ({"friction": -1.0}, "friction = -1.0: must be positive"),
        ({"start": 1.0}, "start = 1 s: must be at least 2 s"),
        ({"friction": 0.02}, "turn more slowly"),
    ],
)
def test_what_has_no_answer_is_said_in_one_line(options, said):
    assert said in answer(SCRIPT, **options)


def test_contacts_that_are_late_break_a_bound(monkeypatch):
    right = dd.Physics.skidding
    late = {"contact_impedance": (0.5, 0.5), "friction_damping": 0.001}
    monkeypatch.setattr(dd.Physics, "skidding", lambda step: dataclasses.replace(right(step), **late))
    assert any("bends" in bound for bound in broken(SCRIPT.run()))
