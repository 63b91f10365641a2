"""The encoders' experiment with other options than its own: the laws of rounding, of the rate and of lateness hold."""

import dataclasses

import pytest
from experiment_runs import FEW, broken
from figure_checks import problems
from helpers import experiment, refused
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import numbers, sizes

from diffdrive_mj.judging.standards import PRESETS

SCRIPT = experiment("encoder_resolution")


@settings(FEW, max_examples=3)
@given(st.sampled_from(PRESETS), numbers(3.5, 8.0), sizes(0.1, 0.8), st.integers(1, 5000), st.integers(0, 99))
def test_any_robot_square_and_speed_keep_the_bounds(robot, seconds, speed, samples, seed):
    assert broken(SCRIPT.run(robot, seconds * speed, speed, samples, seed)) == []


def test_wrong_laws_of_rounding_break_their_bounds(monkeypatch):
    end_error, simple_law = SCRIPT.end_error, SCRIPT.simple_law

    def law(*given):
        right = end_error(*given)
        return dataclasses.replace(right, position=0.8 * right.position, heading=0.7 * right.heading)

    monkeypatch.setattr(SCRIPT, "end_error", law)
    monkeypatch.setattr(SCRIPT, "simple_law", lambda *given: 0.75 * simple_law(*given))
    lines = broken(SCRIPT.run(samples=10_000))
    for words in (*(f"{place}: RMS" for place in (SCRIPT.FAR, SCRIPT.END, SCRIPT.HEADING)), "simple law off the exact"):
        assert any(words in line for line in lines)


def test_a_wrong_law_of_the_rate_breaks_its_bounds(monkeypatch):
    right = SCRIPT.sampling_error
    monkeypatch.setattr(SCRIPT, "sampling_error", lambda done, rate: 3 * rate**-0.2 * right(done, rate))
    lines = broken(SCRIPT.run(samples=10_000))
    for words in ("slalom, farthest point", "order of what the rate leaves"):
        assert any(words in line for line in lines)


def test_readings_later_than_they_say_break_the_law_of_lateness(monkeypatch):
    class Later(SCRIPT.dd.Encoder):
        def __post_init__(self):
            object.__setattr__(self, "latency", 1.1 * self.latency)
            super().__post_init__()

    monkeypatch.setattr(SCRIPT.dd, "Encoder", Later)
    report = SCRIPT.run("matched", 2.0, samples=1)
    assert problems(report.pictures["encoder_resolution"]) == []
    lines = broken(report)
    assert [line.split(":")[0] for line in lines] == ["BROKEN latency, moving", "BROKEN latency, turning"]


@pytest.mark.parametrize(
    ("options", "word"),
    [
        ({"samples": 0}, "samples = 0"),
        ({"samples": -5}, "samples = -5"),
        ({"seed": -1}, "seed = -1"),
        ({"side": 1.0}, "side = 1 m: must be at least 1.5 m"),
        ({"side": 1e9}, "samples"),
        ({"speed": float("nan")}, "speed = nan"),
        ({"speed": 4.5, "side": 20.0}, "must roll"),
        ({"robot": "nix"}, "unknown preset"),
    ],
)
def test_what_has_no_answer_is_refused(options, word):
    with refused(ValueError, word):
        SCRIPT.run(**options)
