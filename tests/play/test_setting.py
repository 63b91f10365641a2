"""Settings of the page: what they open with, what is refused, and in which words."""

import dataclasses

import pytest
from helpers import refused

import diffdrive_mj as dd
from diffdrive_mj.play.setting import KNOBS, Setting
from diffdrive_mj.robot import presets

OPENING = Setting.of(dd.Robot.load("matched"))
TEXT = {name: str(value) for name, value in dataclasses.asdict(OPENING).items()}


@pytest.mark.parametrize("name", presets())
def test_it_opens_with_a_robot_that_believes_something_wrong(name):
    robot = dd.Robot.load(name)
    opening = Setting.of(robot)
    assert (opening.left_radius, opening.right_radius, opening.track_width) == (
        robot.left_radius, robot.right_radius, robot.track_width)  # fmt: skip
    assert opening.believed_right_radius != robot.right_radius
    assert opening.maneuver == "k"


def test_text_comes_back_with_all_its_digits():
    odd = dataclasses.replace(OPENING, left_radius=0.1 + 1e-16, k=1 / 3)
    assert Setting.parsed({name: repr(value).strip("'") for name, value in dataclasses.asdict(odd).items()}) == odd


@pytest.mark.parametrize(
    ("change", "kind", "words"),
    [
        ({"left_radius": "-0.1"}, ValueError, "left_radius = -0.1 m: must lie between 0.005 and 0.5 m"),
        ({"track_width": "1e300"}, ValueError, "track_width = 1e+300: must be within 1e+100 of zero"),
        ({"believed_track_width": "nan"}, ValueError, "believed_track_width = nan: must be finite"),
        ({"k": "inf"}, ValueError, "k = inf: must be finite"),
        ({"k": "0"}, ValueError, "k = 0: must lie between 0.2 and 5"),
        ({"k": ""}, TypeError, "k = '': must be a number"),
        ({"k": "x" * 3000}, TypeError, "must be a number"),
        ({"seconds": "61"}, ValueError, "seconds = 61 s: must lie between 1 and 60 s"),
        ({"ticks": "0.5"}, ValueError, "ticks = 0.5: must be 0, for none, or at least 1"),
        ({"friction": "0"}, ValueError, "friction = 0: must lie between"),
        ({"colour": "blue"}, KeyError, "unknown setting 'colour'"),
    ],
)
def test_bad_text_is_refused_by_name(change, kind, words):
    with refused(kind, words) as _:
        Setting.parsed({**TEXT, **change})


@pytest.mark.parametrize("name", TEXT)
def test_a_missing_field_is_named(name):
    with refused(ValueError, f"{name}: is missing"):
        Setting.parsed({other: text for other, text in TEXT.items() if other != name})


@pytest.mark.parametrize("name", KNOBS)
def test_both_ends_of_a_range_are_allowed(name):
    knob = KNOBS[name]
    for end in (knob.least, knob.most):
        assert knob.checked(name, end) == end
    for beyond in (knob.least - 1e-9, knob.most * (1 + 1e-9)):
        with refused(ValueError, name):
            knob.checked(name, beyond)
