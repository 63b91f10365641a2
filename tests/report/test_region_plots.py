"""Regions as they are drawn: lines that lie where the measure is that of the level."""

import numpy as np
import pytest
from helpers import refused

import diffdrive_mj as dd
from diffdrive_mj.estimation.regions import squared_distance, threshold
from diffdrive_mj.report import plots, regions

STATED = np.array([[1e-4, 0, 0], [0, 0.0301, 0.045], [0, 0.045, 0.09]])


def axes():
    return plots.figure("A finding")[1]


@pytest.mark.parametrize("level", [0.5, 0.95])
@pytest.mark.parametrize("pose", [(1.0, 0.0, 0.0), (-3.0, 2.0, 2.5)])
def test_a_banana_is_one_closed_line_at_its_level(pose, level):
    ax = regions.banana(axes(), pose, STATED, level, label="banana")
    (line,) = ax.lines
    drawn = line.get_xydata()
    np.testing.assert_array_equal(drawn[0], drawn[-1])
    np.testing.assert_allclose(squared_distance(drawn, pose, STATED), threshold(level), rtol=0.1)
    assert ax.get_legend_handles_labels()[1] == ["banana"]


def test_ellipses_along_a_path_stand_evenly_and_grow():
    path = dd.se2.exp(np.linspace(0, 1, 101)[:, None] * (4.0, 0.0, 1.0))
    stated = np.linspace(0, 1, 101)[:, None, None] * 1e-2 * np.eye(3)
    ax = regions.uncertain_path(axes(), path, stated, count=4, label="odometry", index=1)
    line, *rings = ax.lines
    np.testing.assert_array_equal(line.get_xydata(), path[:, :2])
    assert line.get_color() == plots.style(1)["color"] == rings[0].get_color()
    middles = np.array([ring.get_xydata()[:-1].mean(axis=0) for ring in rings])
    np.testing.assert_allclose(middles, path[[25, 50, 75, 100], :2], atol=1e-9)
    sizes = [np.ptp(ring.get_xydata(), axis=0)[0] for ring in rings]
    np.testing.assert_allclose(sizes, 2 * np.sqrt(threshold(0.95) * 1e-2 * np.array([0.25, 0.5, 0.75, 1.0])), rtol=1e-3)


def test_one_name_in_the_legend_for_all_ellipses():
    ax = regions.ellipses(axes(), np.zeros((5, 2)), np.eye(2), label="95 %", color="black")
    assert ax.get_legend_handles_labels()[1] == ["95 %"]
    assert {line.get_color() for line in ax.lines} == {"black"}


def test_a_path_of_other_covariances_is_refused():
    with refused(ValueError, "must be (T, 3) and (T, 3, 3), of one drive"):
        regions.uncertain_path(axes(), np.zeros((5, 3)), np.zeros((4, 3, 3)))
