"""The real robot's logs: published figures are met or beaten, on recordings seen and unseen."""

import pytest
from real_data import optiodom_folder

import diffdrive_mj as dd
from diffdrive_mj.calibration.paths import least_squares
from diffdrive_mj.logs import read_optiodom
from diffdrive_mj.metrics import stacked

CIRCLES, SMALL, FREE = "circular/250620202104", ("square/230620202042", "square/230620202317"), "free/030120210001"


@pytest.fixture(scope="module")
def groups():
    folder = optiodom_folder()
    return {name: read_optiodom(folder / name) for name in (CIRCLES, *SMALL, "square/231220200040", FREE)}


def fitted(groups, *names, gain=False):
    drives = [drive for name in names for drive in groups[name]]
    nominal = dd.Robot.load("optiodom")
    return least_squares(drives, nominal, start="truth", headings=False, turning_gain=gain).calibrated


def drift(drives, robot):
    return stacked(drive.drift(robot) for drive in drives)


def test_a_fit_on_the_circles_is_no_worse_than_the_published_one(groups):
    off = drift(groups[CIRCLES], fitted(groups, CIRCLES))
    assert off.final_position.max() <= 9.15e-3
    assert off.max_position.max() <= 22.0e-3


def test_a_joint_fit_halves_the_error_of_drives_that_it_has_not_seen(groups):
    nominal = drift(groups[FREE], dd.Robot.load("optiodom")).final_position_rms
    assert nominal == pytest.approx(43.7e-3, abs=0.1e-3)
    assert drift(groups[FREE], fitted(groups, CIRCLES, *SMALL)).final_position_rms <= nominal / 2


@pytest.mark.parametrize("unseen", [CIRCLES, *SMALL])
def test_the_turning_gain_helps_the_circles_and_small_squares_unseen(groups, unseen):
    """And raises the error of the large square and the free drives, as the calibration experiment says."""
    others = [name for name in groups if name != unseen]
    plain, with_gain = (
        drift(groups[unseen], fitted(groups, *others, gain=gain)).final_position_rms for gain in (False, True)
    )
    assert with_gain < plain
