"""The real robot's recordings, each fitted on itself in one and the same way: the largest final errors published."""

import pytest
from real_data import optiodom_folder

import diffdrive_mj as dd
from diffdrive_mj.calibration.paths import least_squares
from diffdrive_mj.metrics import stacked

# Largest final position error of the best published method [m].
SQUARES_AND_SMALL_CIRCLES = {
    "square/230620202042": 7.157e-3, "square/230620202317": 7.426e-3, "square/231220200040": 37.807e-3,
    "circular/250620202104": 9.155e-3, "circular/250620202119": 7.617e-3, "circular/250620202236": 6.171e-3,
}  # fmt: skip


@pytest.mark.parametrize("name", SQUARES_AND_SMALL_CIRCLES)
def test_a_fit_with_pinned_positions_leaves_less_than_any_published_one(name):
    """5.10, 7.39, 32.0, 3.33, 4.39 and 3.55 mm."""
    folder = optiodom_folder() / name
    drives = dd.logs.read_optiodom(folder)
    found = least_squares(drives, dd.logs.optiodom_robot(folder), start="position")
    left = stacked(drive.drift(found.calibrated) for drive in drives)
    assert left.final_position.max() < SQUARES_AND_SMALL_CIRCLES[name]
