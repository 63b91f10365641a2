"""The calibration experiment with other options than its own, and its real robot where the logs are."""

import numpy as np
import pytest
from experiment_runs import broken, each_robot, right_or_refused, whole
from figure_checks import check_layout
from helpers import experiment, refused
from real_data import optiodom_folder

from diffdrive_mj.judging import accuracy

SCRIPT = experiment("calibration")


@pytest.fixture
def fewer(monkeypatch):
    """Two lengths and two encoders: what they show does not depend on the options."""
    monkeypatch.setattr(SCRIPT, "LENGTHS", (5.0, 10.0))
    monkeypatch.setattr(SCRIPT, "TICKS", (64, 4096))


@each_robot
def test_any_robot_and_few_of_them_keep_the_bounds(robot, fewer):
    right_or_refused(SCRIPT, robot, robots=whole(1, 2), seed=whole(0, 99))


def test_errors_three_times_as_large_break_the_bounds(fewer, monkeypatch):
    right = SCRIPT.fit

    def worse(*given):
        fits = right(*given)
        return accuracy.Fits(3 * fits.errors, fits.expected, fits.stated)

    monkeypatch.setattr(SCRIPT, "fit", worse)
    assert len(broken(SCRIPT.run(robots=3))) == 3


@pytest.mark.parametrize(
    ("options", "kind", "word"),
    [
        ({"data": "nowhere"}, FileNotFoundError, "nowhere is not a folder"),
        ({"robots": 0}, ValueError, "robots = 0"),
        ({"seed": -1}, ValueError, "seed = -1"),
        ({"robot": "nix"}, ValueError, "unknown preset"),
    ],
)
def test_bad_options_are_refused_before_any_work(options, kind, word, monkeypatch):
    monkeypatch.delattr(SCRIPT, "simulate_rolling")
    with refused(kind, word):
        SCRIPT.run(**options)


@pytest.mark.slow
def test_the_real_robot_keeps_its_bounds(fewer):
    """The published figures are met or beaten, and drives that no fit has seen are those that it says."""
    report = SCRIPT.run(robots=1, data=str(optiodom_folder()))
    assert sum(bound.name.startswith("real") for bound in report.bounds) == 5
    assert broken(report) == []
    final = report.metrics["real_final_position_rms_m"]
    assert final["nominal"]["free"] == pytest.approx(43.7e-3, abs=0.1e-3)
    for name in ("circles", "square a", "square b"):
        assert final["the same, with the turning gain"][name] < final["fitted on all the others"][name]
    assert set(report.pictures) == {"calibration", "calibration_real_robot"}
    for picture in report.pictures.values():
        check_layout(picture)


def test_robots_differ_from_the_believed_one_by_a_tenth_at_most():
    believed, rng = SCRIPT.dd.Robot.load("ct_bot"), np.random.default_rng(0)
    ratios = [SCRIPT.similar(believed, rng).track_width / believed.track_width for _ in range(200)]
    assert 0.9 <= min(ratios) < 0.91
    assert 1.09 < max(ratios) <= 1.1
