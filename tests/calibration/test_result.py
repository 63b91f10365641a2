"""What a calibration returns: deviations and correlations, on paper and in a notebook."""

import re

import numpy as np
import pytest

import diffdrive_mj as dd

ROBOT = dd.Robot(left_radius=0.1, right_radius=0.091, track_width=0.4)
COVARIANCE = np.array([[4e-8, -3e-8, 0], [-3e-8, 9e-8, 0], [0, 0, 1e-6]])


def found(**changes):
    fields = {
        "method": "ruler", "believed": ROBOT, "calibrated": ROBOT.replace(track_width=0.41),
        "parameters": ("left_radius", "right_radius", "track_width"), "values": np.array([0.1, 0.0912345678, 0.41]),
        "covariance": COVARIANCE, "residuals": np.zeros(3), "warnings": ("look <out>",), "details": {"scale": 1.25},
    }  # fmt: skip
    return dd.calibration.Calibration(**{**fields, **changes})


def test_deviations_and_correlations_are_those_of_the_covariance():
    assert found().std == pytest.approx((2e-4, 3e-4, 1e-3))
    assert found().correlation == pytest.approx(np.array([[1, -0.5, 0], [-0.5, 1, 0], [0, 0, 1]]))


def test_it_prints_a_line_a_parameter_a_figure_and_a_warning():
    assert str(found()).splitlines() == [
        "calibration by ruler",
        "  left_radius    0.1 +- 0.0002",
        "  right_radius   0.09123457 +- 0.0003",
        "  track_width    0.41 +- 0.001",
        "  scale = 1.25",
        "  warning: look <out>",
    ]


def test_a_notebook_shows_the_same_as_a_table_with_its_name():
    text = re.sub(r"\s*<[^>]*>\s*", "|", found()._repr_html_())
    shown = [cell for cell in text.split("|") if cell]
    assert shown == [
        *("calibration by ruler", "left_radius", "0.1", "± 0.0002", "right_radius", "0.09123457", "± 0.0003"),
        *("track_width", "0.41", "± 0.001", "scale", "1.25", "warning", "look &lt;out&gt;"),
    ]


@pytest.mark.parametrize("show", [str, dd.calibration.Calibration._repr_html_])
def test_more_names_than_values_are_a_fault_that_shows(show):
    with pytest.raises(ValueError, match="zip"):
        show(found(parameters=("left_radius", "right_radius")))


def test_drifts_before_and_after_are_summed_up():
    drift = dd.metrics.drift(np.zeros((2, 3)), [(0, 0, 0), (0.003, 0.004, 0)])
    lines = str(found(before=drift, after=drift)).splitlines()
    assert lines[4:6] == [f"  before {drift.summary()}", f"  after  {drift.summary()}"]
    assert "5" in drift.summary()
