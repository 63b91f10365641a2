"""Pictures of sweeps: what they draw, and that nothing covers anything else."""

import numpy as np
import pytest
from figure_checks import check_layout

import diffdrive_mj as dd
from diffdrive_mj.report import sweeps
from diffdrive_mj.sweeps import Maneuver, Study, Trials, budget

KEPT = ("position_along", "final_position", "distance")


@pytest.fixture(scope="module")
def study():
    options = {"trials": 5 * 150, "design": "saltelli", "truth": "kinematics", "sample_rate": 20.0, "figures": KEPT}
    return Study.of_tolerances(dd.Robot.load("matched"), Maneuver("square", {"side": 0.5}), **options)


@pytest.fixture(scope="module")
def trials(study):
    return dd.sweep(study)


def test_a_fan_ends_at_the_percentiles(trials):
    _, ax = dd.plots.figure("A fan")
    sweeps.fan(ax, trials)
    tops = [band.get_paths()[0].vertices[:, 1].max() for band in ax.collections]
    expected = [1e3 * trials.percentile("position_along", share).value.max() for share in sweeps.BANDS]
    np.testing.assert_allclose(tops, expected)
    assert ax.get_xlim()[1] == pytest.approx(float(np.median(trials.figures["distance"])))


def test_a_curve_passes_the_percentiles(trials):
    _, ax = dd.plots.figure("A curve")
    sweeps.exceedance_curve(ax, trials)
    x, y = ax.lines[0].get_xdata(), ax.lines[0].get_ydata()
    for share in (0.5, 0.9):
        place = 1e3 * float(trials.percentile("final_position", share).value)
        assert np.interp(place, x, y) == pytest.approx(100 * (1 - share), rel=0.15)


def test_lost_robots_leave_a_floor():
    ends = np.array(["ok"] * 90 + ["fell"] * 10)
    off = np.where(ends == "ok", np.arange(100) / 1e3, np.nan)
    _, ax = dd.plots.figure("A curve")
    sweeps.exceedance_curve(ax, Trials(np.arange(100), {}, {"final_position": off}, ends, ends))
    assert ax.lines[0].get_ydata().min() == pytest.approx(10)


def test_pictures_are_readable(study, trials):
    for picture in (
        sweeps.swept("99 % of the robots stay under 0.2 m", trials, limit=0.1),
        sweeps.budgeted(budget(study, trials, share=0.9)),
    ):
        check_layout(picture)


def test_only_position_errors_have_a_curve(trials):
    with pytest.raises(ValueError, match="position error"):
        sweeps.exceedance_curve(dd.plots.figure("A curve")[1], trials, "distance")
