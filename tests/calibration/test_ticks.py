"""The ticks of an encoder: found in its angles, allowed for in what a fit states, and no information by themselves."""

import numpy as np
import pytest
from hypothesis import given
from planted import BELIEVED, TRUE, counted, ideal, mixed, noisy, similar, vector
from strategies import numbers

import diffdrive_mj as dd
from diffdrive_mj.calibration._ticks import tick
from diffdrive_mj.calibration.paths import from_fixes, least_squares

STRAIGHT, SPIN = dd.maneuvers.straight(BELIEVED, distance=3.0, speed=0.5), dd.maneuvers.spin(BELIEVED, turns=2.0)


@given(ticks=numbers(40, 20_000), start=numbers(-100, 100), phase=numbers(0, 1))
def test_the_tick_of_counted_angles_is_found(ticks, start, phase):
    size, t = 2 * np.pi / ticks, np.arange(0, 10, 0.05)
    angles = start + 3 * t + np.sin(2 * t)
    assert tick(np.floor(angles / size + phase) * size) == pytest.approx(size, rel=1e-6)


@pytest.mark.parametrize("seed", range(5))
def test_angles_without_a_grid_have_no_tick(seed):
    rng = np.random.default_rng(seed)
    assert tick(np.cumsum(rng.normal(size=300))) < 1e-3
    for angles in (np.zeros(50), np.arange(50.0), np.cumsum(np.clip(np.arange(-20, 60), 0, 30)) * 1e-3):
        assert tick(angles) == 0  # at rest, even speed, and a ramp, whose steps are on a grid too
    assert not np.any([tick(wheel) for wheel in ideal(similar(BELIEVED, rng), mixed()).wheel_angles.T])


@pytest.mark.parametrize(("ticks", "every"), [(64, 1), (64, 4), (256, 2), (1024, 1)])
def test_errors_of_coarse_encoders_are_as_large_as_stated(ticks, every):
    """With poses so exact that ticks are all there is; independent residuals stated a sixth of the errors."""
    rng, ratios = np.random.default_rng(ticks + every), []
    for _ in range(8):
        robot = similar(BELIEVED, rng)
        drive = noisy(counted(ideal(robot, mixed(period=0.04)), ticks, every, rng), 1e-4, rng)
        found = least_squares([drive], BELIEVED, turning_gain=False)
        ratios.append((found.values - vector(robot)[:3]) / found.std)
    assert 0.3 < np.sqrt(np.mean(np.square(ratios))) < 1.5


@pytest.mark.parametrize("command", [STRAIGHT, SPIN])
@pytest.mark.parametrize("ticks", [64, 1024])
@pytest.mark.parametrize("method", [least_squares, from_fixes])
def test_what_ticks_alone_seem_to_show_stays_as_believed(command, ticks, method):
    """Wheels that turn alike but for their ticks: the track, or the radii, came out five times too large or small."""
    rng = np.random.default_rng(ticks)
    robot = similar(BELIEVED, rng, 0.1)
    drive = counted(ideal(robot, command), ticks, 1, rng)
    found = method([drive], BELIEVED)
    off = np.abs(found.values - vector(robot)[:3])
    assert (off < 5 * found.std).all()
    assert np.abs(found.values / vector(BELIEVED)[:3] - 1).max() < 0.2
    assert any("do not show" in warning for warning in found.warnings)


def test_exact_angles_leave_what_is_stated_to_the_residuals():
    drive = noisy(ideal(TRUE, rate=0.2), 1e-3, np.random.default_rng(1))
    wheels = drive.wheel_angles + 1e-12 * np.random.default_rng(2).normal(size=drive.wheel_angles.shape)
    other = dd.Drive(drive.t, wheels, drive.truth, drive.clock)
    one, same = (least_squares([each], BELIEVED, turning_gain=False) for each in (drive, other))
    assert same.std == pytest.approx(one.std, rel=1e-6)
