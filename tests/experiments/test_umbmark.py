"""UMBmark's experiment with other options than its own: its bounds follow from them, and show when a law is wrong."""

import functools

import numpy as np
import pytest
from experiment_runs import SLIPS, broken, each_robot, even, right_or_refused, sizes, whole
from figure_checks import problems
from helpers import experiment, refused
from real_data import optiodom_folder

SCRIPT = experiment("umbmark")


@pytest.fixture
def fewer(monkeypatch):
    """Two mismatches, one on each side of the limit, and two sides: what they show does not depend on the options."""
    monkeypatch.setattr(SCRIPT, "MISMATCHES", (0.05, 0.45))
    monkeypatch.setattr(SCRIPT, "SIDES", (2.5, 5.0))
    return monkeypatch


@each_robot
def test_any_robot_square_and_noise_keep_the_bounds_or_are_refused(robot, fewer):
    right_or_refused(
        SCRIPT, robot, f"{SLIPS}|sides are no longer straight|must be a square", side=sizes(0.5, 6.0),
        radius_ratio=even(0.97, 1.03), track_error=even(-0.1, 0.1), runs=whole(1, 6), position_noise=sizes(1e-5, 1e-2),
        heading_noise=sizes(1e-5, 1e-2), seed=whole(0, 99),
    )  # fmt: skip


@pytest.mark.parametrize(
    "options",
    [{"runs": 1, "side": 1.0}, {"radius_ratio": 0.98, "side": 2.0, "position_noise": 0.01, "heading_noise": 0.01}],
)
def test_options_that_once_broke_a_bound(fewer, options):
    report = SCRIPT.run(**options)
    assert broken(report) == []
    assert problems(report.pictures["umbmark"]) == []


def test_wrong_laws_break_their_bounds(fewer):
    """Bumps two per cent higher, a method of first order for the exact one, an update that does not swing."""
    right = SCRIPT.bump_angle
    fewer.setattr(SCRIPT, "bump_angle", lambda *given: 1.02 * right(*given))
    fewer.setitem(SCRIPT.METHODS, SCRIPT.EXACT, functools.partial(SCRIPT.umbmark, forms="both", rounds=1))
    fewer.setattr(SCRIPT, "oscillation", lambda *given: list(np.linspace(0.975, 0.99, 7)))
    lines = broken(SCRIPT.run(runs=2))
    for words in ("first side, headings", "second side, headings", "E_max down, worst", "swings on"):
        assert any(words in line for line in lines)


def test_the_real_robot_is_found_as_published(fewer):
    report = SCRIPT.run(runs=2, data=str(optiodom_folder()))
    assert broken(report) == []
    assert sum("published by" in bound.name for bound in report.bounds) == 3


@pytest.mark.parametrize(
    ("options", "kind", "word"),
    [
        ({"data": "nowhere"}, FileNotFoundError, "nowhere is not a folder"),
        ({"runs": 0}, ValueError, "runs = 0"),
        ({"seed": -1}, ValueError, "seed = -1"),
        ({"side": -3.0}, ValueError, "side = -3.0"),
        ({"radius_ratio": float("nan")}, ValueError, "radius_ratio = nan"),
        ({"track_error": -1.0}, ValueError, "track_width"),
        ({"position_noise": -1.0}, ValueError, "position_noise"),
        ({"robot": "nix"}, ValueError, "unknown preset"),
    ],
)
def test_bad_options_are_refused_before_any_work(options, kind, word, monkeypatch):
    monkeypatch.delattr(SCRIPT, "simulate_rolling")
    with refused(kind, word):
        SCRIPT.run(**options)


def test_sides_that_are_too_bent_are_refused(fewer):
    with refused(ValueError, "side = 4 m", "must be at most 0.3", "drive a square of at most 1.3 m"):
        SCRIPT.run(radius_ratio=0.91)
