"""The experiment on passive wheels with other options than its own: its laws hold, and show when they do not."""

import dataclasses

import pytest
from experiment_runs import broken, each_robot, even, right_or_refused, sizes, whole
from helpers import experiment, refused

SCRIPT = experiment("passive_wheels")


@each_robot
def test_any_robot_and_noise_keep_the_bounds(robot):
    right_or_refused(
        SCRIPT, robot, turns=even(2, 20), distance=even(1, 8), noise=sizes(1e-5, 2e-3), calibrations=whole(5, 50),
        seed=whole(0, 99),
    )  # fmt: skip


def test_wrong_laws_break_their_bounds(monkeypatch):
    """Wheels that read a thousandth too little, and a calibration that states half of its deviations."""
    motion, trials = SCRIPT.dd.PassiveWheels.motion, SCRIPT.arm_trials

    def boasting(*given, **options):
        found = trials(*given, **options)
        return dataclasses.replace(found, covariance=found.covariance / 4)

    monkeypatch.setattr(
        SCRIPT.dd.PassiveWheels, "motion", lambda self, seen, **known: 0.999 * motion(self, seen, **known)
    )
    monkeypatch.setattr(SCRIPT, "arm_trials", boasting)
    lines = broken(SCRIPT.run(calibrations=30))
    for words in (
        "ideal world, three: position",
        "three before counting",
        "two before counting",
        "tracker: lever arms",
    ):
        assert any(words in line for line in lines)


def test_wheels_that_slip_are_seen_to(monkeypatch):
    """Where the ice is elsewhere the drive wheels are right, which their bound notices."""
    monkeypatch.setitem(SCRIPT.FLOORS, SCRIPT.BOTH, ((100.0, 101.0), (0.0, 1.0)))
    assert any("drive wheels off by" in line for line in broken(SCRIPT.run(calibrations=5)))


@pytest.mark.parametrize(
    ("options", "word"),
    [
        ({"noise": 0.0}, "noise = 0.0: must be positive"),
        ({"turns": 0.0}, "turns = 0"),
        ({"distance": 0.0}, "distance = 0"),
        ({"calibrations": 0}, "calibrations = 0"),
        ({"seed": -1}, "seed = -1"),
        ({"robot": "nix"}, "unknown preset"),
    ],
)
def test_bad_options_are_refused(options, word):
    with refused(ValueError, word):
        SCRIPT.run(**options)
