"""The ticks of an encoder: found in its angles, allowed for in what a fit states, and no information by themselves."""

import numpy as np
import pytest
from hypothesis import given
from planted import BELIEVED, TRUE, counted, ideal, mixed, noisy, similar, vector
from strategies import numbers

import diffdrive_mj as dd
from diffdrive_mj.calibration._ticks import _errors, _redrawn, tick
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


@pytest.mark.parametrize(("off", "whole"), [(0.009, True), (0.015, False)])
def test_ticks_are_whole_to_one_per_cent(off, whole):
    steps = np.random.default_rng(0).choice([1.0, 2.0, 3.0 + off], 60)
    assert bool(tick(np.append(0, np.cumsum(steps)) * 1e-3)) == whole


@pytest.mark.parametrize(
    ("longer", "found"), [((20, 50, 80), False), ((20, 50, 80, 99), False), ((20, 40, 60, 80), True)]
)
def test_steps_that_change_seldom_are_planned_and_not_counted(longer, found):
    """One longer step among a hundred changes the acceleration thrice, and once at the end."""
    steps = np.full(100, 5.0)
    steps[list(longer)] = 6.0
    assert bool(tick(np.append(0, np.cumsum(steps)))) == found


def test_a_wheel_passes_through_the_tick_that_its_counter_shows():
    """Slowly, its error grows evenly from reading to reading; fast, it is anywhere."""
    rng = np.random.default_rng(0)
    slow = _errors(np.repeat(np.arange(20), 4), rng, 1000).reshape(1000, 20, 4)
    assert np.diff(slow) == pytest.approx(np.full((1000, 20, 3), 0.25))
    assert np.abs(slow).max() <= 0.5
    fast = _errors(3.0 * np.arange(2000), rng, 50)
    for errors in (slow, fast):
        assert errors.mean() == pytest.approx(0.0, abs=0.01)
        assert errors.std() == pytest.approx(np.sqrt(1 / 12), abs=0.01)
    assert np.abs(np.corrcoef(fast[:, 0], fast[:, 1])[0, 1]) < 0.5
    assert np.abs(fast).max() <= 0.5


@pytest.mark.parametrize(
    ("lengths", "rests"),
    [
        *[((1, 1, 30, 1), True), ((9, 9, 30, 9), True), ((10, 9, 30, 9), True), ((9, 10, 30, 9), False)],
        *[((9, 9, 30, 10), False), ((1, 1, 30), True), ((1, 10, 30), False), ((30, 1, 1), True)],
        *[((30, 10, 1), False), ((4, 1), True), ((3, 1), False)],
    ],
)
def test_a_counter_that_shows_the_same_for_long_is_that_of_a_wheel_at_rest(lengths, rests):
    """Longer than three times both its neighbours'; beyond the ends of the log a count lasts one reading."""
    counts = np.repeat(np.arange(len(lengths)), lengths)
    k = int(np.argmax(lengths))
    errors = _errors(counts, np.random.default_rng(0), 20)[:, counts == k]
    moved = np.ptp(errors, axis=1)
    assert moved == pytest.approx(np.full(20, 0.0 if rests else 1 - 1 / len(errors[0])))
    assert np.abs(errors).max() <= 0.5


def test_readings_are_redrawn_within_half_a_tick_where_a_wheel_has_one():
    t = np.arange(0, 100, 0.05)
    sizes = np.array([[0.01, 0.0], [0.0, 0.02]])
    wheels = np.stack([np.round(500 * np.sin(t)), np.round(20 * t)], axis=-1) * sizes.max(axis=0)
    drives = [dd.Drive(t, wheels, np.zeros((len(t), 3)))] * 2
    for angles, ticks in zip(_redrawn(drives, sizes, 50), sizes, strict=True):
        off = angles - wheels
        assert off.shape == (50, len(t), 2)
        assert np.abs(off).max(axis=(0, 1)) == pytest.approx(ticks / 2, rel=0.01)
        # One count a reading: each is anywhere in its tick.
        assert off[:, 100:].std(axis=(0, 1)) == pytest.approx(ticks / np.sqrt(12), rel=0.02)


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
