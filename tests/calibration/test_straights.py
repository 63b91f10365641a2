"""The speed ratio of wheels that were commanded alike, and the robot to build."""

import numpy as np
import pytest
from helpers import refused

import diffdrive_mj as dd
from diffdrive_mj.calibration.straights import speed_ratio
from diffdrive_mj.drive import Drive

BELIEVED = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)


def test_the_speed_ratio_of_equal_commands():
    t = np.arange(3.0)
    right = np.array([0.0, 40.0, 100.0])
    drives = [Drive(t, np.stack([0.91 * right + e * (right > 99), right], -1), np.zeros((3, 3))) for e in (-0.1, 0.1)]
    result = speed_ratio(drives, BELIEVED)
    assert result.values[0] == pytest.approx(0.91)
    assert result.calibrated.radius_ratio == pytest.approx(0.91)
    assert result.calibrated.left_radius == BELIEVED.left_radius
    assert result.std[0] == pytest.approx(1e-3)
    assert dd.kinematics.body_twist((0.91, 1.0), result.calibrated)[1] == pytest.approx(0, abs=1e-15)
    assert np.isnan(speed_ratio(drives[:1], BELIEVED).covariance).all()


def counted(lefts, rights, start):
    """A drive for each pair of wheels' turning, of counters that start anywhere."""
    return [Drive([0, 1], [start, np.add(start, pair)], np.zeros((2, 3))) for pair in zip(lefts, rights, strict=True)]


@pytest.mark.parametrize("start", [(0.0, 0.0), (1000.0, -500.0), (-3.0, 7.0)])
@pytest.mark.parametrize("way", [1, -1])
def test_the_scatter_of_three_drives_or_more_is_that_of_a_line_through_zero(start, way):
    """Against the textbook's regression; counters may start anywhere, and the robot may reverse."""
    rights = way * np.array([40.0, 90.0, 110.0, 70.0])
    lefts = 0.91 * rights + [0.1, -0.2, 0.15, 0.05]
    result = speed_ratio(counted(lefts, rights, start), BELIEVED)
    (slope,), (squares,), _, _ = np.linalg.lstsq(rights[:, None], lefts, rcond=None)
    assert result.values[0] == pytest.approx(slope, rel=1e-12)
    assert result.std[0] == pytest.approx(np.sqrt(squares / 3 / (rights @ rights)), rel=1e-10)
    assert result.residuals == pytest.approx(lefts - slope * rights, abs=1e-10)


def test_one_drive_is_said_to_show_no_scatter():
    drives = counted([9.1, 9.2], [10.0, 10.0], (0.0, 0.0))
    assert speed_ratio(drives[:1], BELIEVED).warnings == ("no covariance: it takes at least two drives",)
    assert speed_ratio(drives, BELIEVED).warnings == ()


def test_a_speed_ratio_needs_wheels_that_turn_alike():
    spin = Drive([0, 1], [[0, 0], [-3, 3]], np.zeros((2, 3)), name="spin")
    parked = Drive([0, 1], [[0, 0], [0, 3]], np.zeros((2, 3)), name="parked")
    for drive in (spin, parked):
        with refused(ValueError, drive.name, "same way"):
            speed_ratio([drive], BELIEVED)
    with refused(ValueError, "at least one"):
        speed_ratio([], BELIEVED)
    with refused(TypeError, "drives"):
        speed_ratio(spin, BELIEVED)
    with refused(TypeError, "Drive"):
        speed_ratio([None], BELIEVED)
    with refused(TypeError, "believed"):
        speed_ratio([spin], "matched")


def rolled(commands, ticks):
    """Wheels that do as told, counted in ticks."""
    angles = np.concatenate([np.zeros((1, 2)), np.cumsum(commands.wheel_rates * commands.period, axis=0)])
    tick = 2 * np.pi / ticks
    return Drive(np.arange(len(angles)) * commands.period, np.floor(angles / tick) * tick, np.zeros((len(angles), 3)))


@pytest.mark.parametrize("side", [0.5, 1.0, 4.0])
def test_squares_are_not_straight_drives(side):
    """It was 0.949 +- 0.31."""
    for clockwise in (True, False):
        drive = rolled(dd.maneuvers.square(BELIEVED, side=side, clockwise=clockwise), 4096)
        with refused(ValueError, "drive: the wheels do not turn alike throughout", "straight drives", "least_squares"):
            speed_ratio([drive], BELIEVED)


@pytest.mark.parametrize("ticks", [60, 4096])
def test_coarse_ticks_and_a_wheel_that_starts_late_are_straight_enough(ticks):
    drive = rolled(dd.maneuvers.straight(BELIEVED, speed=0.5, distance=5.0), ticks)
    late = np.maximum(drive.wheel_angles - [0.0, 0.3], 0.0) * [0.91, 1.0]
    assert speed_ratio([Drive(drive.t, late, drive.truth)], BELIEVED).values[0] == pytest.approx(0.91, rel=0.02)


@pytest.mark.parametrize(("curved", "straight"), [(0.04, True), (0.06, False)])
@pytest.mark.parametrize("way", [1, -1])
def test_a_twentieth_of_the_turning_may_be_by_another_ratio(curved, straight, way):
    """A half of the drive to the left and as much to the right."""
    share = np.array([1 - curved, 1 + curved])
    right = np.concatenate([[0.0], np.cumsum(np.ones(100))])
    left = np.concatenate([[0.0], np.cumsum(np.repeat(0.9 * share, 50))])
    drive = Drive(np.arange(101.0), way * np.stack([left, right], axis=-1), np.zeros((101, 3)), name="bent")
    if straight:
        assert speed_ratio([drive], BELIEVED).values == pytest.approx([0.9])
    else:
        with refused(ValueError, "bent", "other ratios in its turns"):
            speed_ratio([drive], BELIEVED)


def test_drives_count_by_the_square_of_their_length():
    """Of drives of unlike length and ratio: the regression through zero, whose radius is k times the left one."""
    result = speed_ratio(
        counted([9.1, 90.0], [10.0, 100.0], (0.0, 0.0)), BELIEVED.replace(left_radius=0.05, right_radius=0.05)
    )
    assert result.values == pytest.approx([(91 + 9000) / (100 + 10000)])
    assert result.calibrated.right_radius == pytest.approx(0.05 * result.values[0])
