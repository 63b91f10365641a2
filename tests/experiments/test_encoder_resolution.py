"""The encoders' experiment with other options than its own: the laws of rounding, of the rate and of lateness hold."""

import dataclasses

import pytest
from experiment_runs import broken, each_robot, even, right_or_refused, whole
from figure_checks import problems
from helpers import experiment, refused

SCRIPT = experiment("encoder_resolution")


@each_robot
def test_any_robot_square_and_speed_keep_the_bounds(robot, monkeypatch):
    monkeypatch.setattr(SCRIPT, "RATES", [5, 25, 250])
    right_or_refused(
        SCRIPT, robot, side=even(2.5, 4.0), speed=even(0.4, 0.8), samples=whole(1, 5000), seed=whole(0, 99)
    )


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
    monkeypatch.setattr(
        SCRIPT, "sampling_error", lambda done, rate, place=SCRIPT.FAR: 3 * rate**-0.2 * right(done, rate, place)
    )
    lines = broken(SCRIPT.run(samples=10_000))
    for words in ("slalom, farthest point", "order of what the rate leaves"):
        assert any(words in line for line in lines)


def test_readings_later_than_they_say_break_the_law_of_lateness(monkeypatch):
    class Later(SCRIPT.dd.Encoder):
        def __post_init__(self, *given):
            object.__setattr__(self, "latency", 1.1 * self.latency)
            super().__post_init__(*given)

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
