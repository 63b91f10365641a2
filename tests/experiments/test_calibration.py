"""The calibration experiment with other options than its own, and its real robot where the logs are."""

import numpy as np
import pytest
from experiment_runs import FEW, answer, broken
from figure_checks import check_layout
from helpers import experiment, refused
from hypothesis import given
from hypothesis import strategies as st
from real_data import optiodom_folder

from diffdrive_mj.judging import accuracy
from diffdrive_mj.judging.standards import PRESETS

SCRIPT = experiment("calibration")


@FEW
@given(
    st.fixed_dictionaries({"robot": st.sampled_from(PRESETS), "robots": st.integers(1, 2), "seed": st.integers(0, 99)})
)
def test_any_robot_and_few_of_them_keep_the_bounds(options):
    report = answer(SCRIPT, **options)
    assert not isinstance(report, str)
    check_layout(report.pictures["calibration"])


def test_errors_three_times_as_large_break_the_bounds(monkeypatch):
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


def test_the_real_robot_keeps_its_bounds():
    report = SCRIPT.run(robots=1, data=str(optiodom_folder()))
    assert sum(bound.name.startswith("real") for bound in report.bounds) == 5
    assert broken(report) == []
    assert set(report.pictures) == {"calibration", "calibration_real_robot"}
    for picture in report.pictures.values():
        check_layout(picture)


def test_robots_differ_from_the_believed_one_by_a_tenth_at_most():
    believed, rng = SCRIPT.dd.Robot.load("ct_bot"), np.random.default_rng(0)
    ratios = [SCRIPT.similar(believed, rng).track_width / believed.track_width for _ in range(200)]
    assert 0.9 <= min(ratios) < 0.91
    assert 1.09 < max(ratios) <= 1.1
