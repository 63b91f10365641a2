"""What ticks and rates between samples add, against adversaries at random, and the worst that theory knows."""

from __future__ import annotations

import numpy as np
import pytest

import diffdrive_mj as dd
from diffdrive_mj import maneuvers
from diffdrive_mj.estimation._reading_errors import by_sampling, by_ticks

ROBOT = dd.Robot(left_radius=0.100, right_radius=0.091, track_width=0.400)
RADII = np.array([ROBOT.left_radius, ROBOT.right_radius])
DRIVES = {
    "straight": maneuvers.straight(ROBOT, distance=5.0, period=0.05).wheel_angles,
    "square": maneuvers.square(ROBOT, side=1.0, period=0.05).wheel_angles,
    "slalom": maneuvers.slalom(ROBOT, period=0.05).wheel_angles,
    "spin": maneuvers.spin(ROBOT, period=0.05).wheel_angles,
}
TICK = 2 * np.pi / 500


def end(angles, robot=ROBOT):
    x, y, _ = np.moveaxis(dd.odometry.integrate(angles, robot)[..., -1, :], -1, 0)
    return x + 1j * y


def climbed(angles, generator, rounds=6):
    """The largest effect of readings within a tick: patterns that climb by their derivatives, of all signs."""
    best, step = 0.0, 1e-6
    true = end(angles)
    for _ in range(rounds):
        off = TICK * generator.uniform(-1, 1, angles.shape)
        off[0] = 0
        for _ in range(4):
            aim = end(angles + off) - true
            aim /= abs(aim)
            nudged = angles + off + step * np.eye(angles.size).reshape(-1, *angles.shape)
            by_reading = ((end(nudged) - end(angles + off)) * aim.conjugate()).real.reshape(angles.shape)
            off = TICK * np.sign(by_reading)
            off[0] = 0
            best = max(best, abs(end(angles + off) - true))
    return best


@pytest.mark.parametrize("drive", DRIVES)
def test_no_pattern_of_ticks_adds_more(drive):
    angles = DRIVES[drive][::8]
    generator = np.random.default_rng(0)
    bound, turned = by_ticks(angles, ROBOT, TICK, False)
    off = TICK * generator.choice([-1.0, 1.0], (2000, *angles.shape))
    off[:, 0] = 0
    assert np.abs(end(angles + off) - end(angles)).max() <= bound
    worst = climbed(angles, generator)
    assert worst <= bound <= 1.3 * worst + 1e-3
    heading = dd.odometry.integrate(angles + off, ROBOT)[:, -1, 2] - dd.odometry.integrate(angles, ROBOT)[-1, 2]
    assert np.abs(heading).max() <= turned == pytest.approx(TICK * RADII.sum() / ROBOT.track_width)


def test_a_counter_is_within_the_ticks():
    """Whole ticks counted from any phases, as encoders do."""
    generator = np.random.default_rng(0)
    for angles in DRIVES.values():
        bound, _ = by_ticks(angles, ROBOT, TICK, True)
        phases = generator.uniform(0, 1, (50, 1, 2))
        counted = TICK * np.floor(angles / TICK + phases)
        read, true = (dd.odometry.integrate(each, ROBOT)[..., :2] for each in (counted, angles))
        assert np.hypot(*np.moveaxis(read - true, -1, 0)).max() <= bound


def test_ticks_anywhere_are_at_least_those_at_the_end():
    for angles in DRIVES.values():
        assert by_ticks(angles, ROBOT, TICK, True)[0] >= by_ticks(angles, ROBOT, TICK, False)[0]
    assert by_ticks(DRIVES["spin"][:1], ROBOT, TICK, False) == (0, 0)


def pushed(angles, intervals, acceleration, signs, pieces=40):
    """Wheels that accelerate at the limit between samples, with either sign: fine wheel angles.

    Within an interval each wheel is off by a t (T - t) / 2, which is zero at both samples.
    """
    t = np.arange(pieces) / pieces
    steps = np.diff(angles, axis=0)
    even = angles[:-1, None] + t[:, None] * steps[:, None]
    off = signs[:, None] * acceleration / 2 * (t * (1 - t))[:, None] * intervals[:, None, None] ** 2
    return np.concatenate([(even + off).reshape(-1, 2), angles[-1:]])


@pytest.mark.parametrize("drive", DRIVES)
@pytest.mark.parametrize("acceleration", [5.0, 100.0])
def test_no_rates_between_samples_add_more(drive, acceleration):
    angles = DRIVES[drive][::8]
    intervals = np.full(len(angles) - 1, 0.4)
    bound = by_sampling(angles, intervals, acceleration, RADII, ROBOT.track_width)
    generator = np.random.default_rng(0)
    same = np.ones((len(angles) - 1, 2))
    chosen = [same, -same, same * (1, -1), same * (-1, 1)]
    found = 0.0
    for signs in [*chosen, *generator.choice([-1.0, 1.0], (20, *same.shape))]:
        found = max(found, abs(end(pushed(angles, intervals, acceleration, signs)) - end(angles)))
    assert found <= bound


def test_wheels_that_push_apart_on_a_straight_come_close_to_the_bound():
    angles, intervals = DRIVES["straight"][::4], np.full(len(DRIVES["straight"][::4]) - 1, 0.2)
    signs = np.ones((len(angles) - 1, 2)) * (-1, 1)
    found = abs(end(pushed(angles, intervals, 2.0, signs)) - end(angles))
    assert found > 0.95 * by_sampling(angles, intervals, 2.0, RADII, ROBOT.track_width)
