"""Trials of a calibration of passive wheels: reproducible, unbiased, and refused without readings."""

import numpy as np
import pytest
from helpers import refused

import diffdrive_mj as dd
from diffdrive_mj.calibration import KnownMotion
from diffdrive_mj.judging.passive_trials import arm_trials, told, tracked

ROBOT = dd.Robot.load("matched")
PODS = dd.PassiveWheels(
    wheels=(dd.PassiveWheel(y=0.08), dd.PassiveWheel(y=-0.08), dd.PassiveWheel(x=-0.05, angle=np.pi / 2))
)


@pytest.fixture(scope="module")
def drives():
    maneuvers = (dd.maneuvers.spin(ROBOT, turns=2), dd.maneuvers.straight(ROBOT, distance=2.0))
    return [dd.simulate(ROBOT, commands, passive_wheels=PODS) for commands in maneuvers]


@pytest.mark.parametrize("know", [tracked(0.001, 0.001), told(0.001, 0.001), told(0.001, 0.001, scale_std=0.001)])
def test_errors_scatter_about_zero_as_stated(drives, know):
    count = 150
    found = arm_trials(drives, PODS, PODS, know, count=count, rng=np.random.default_rng(0))
    assert found.errors.shape == (count, 3)
    score = found.errors / found.stated
    assert score.mean(axis=0) == pytest.approx(0, abs=4 / np.sqrt(count))
    assert score.std(axis=0) == pytest.approx(1, abs=4 / np.sqrt(2 * count))
    assert found.worst == np.abs(found.errors).max()


def test_the_same_seed_gives_the_same_bits_and_the_belief_does_not_matter(drives):
    one, same = (
        arm_trials(drives, PODS, PODS, told(0.001, 0.001), count=3, rng=np.random.default_rng(1)) for _ in range(2)
    )
    assert np.array_equal(one.errors, same.errors)
    ruled = dd.PassiveWheels(wheels=tuple(wheel.moved(1.02 * wheel.lever_arm) for wheel in PODS.wheels))
    other = arm_trials(drives, PODS, ruled, told(0.001, 0.001), count=3, rng=np.random.default_rng(1))
    assert other.errors == pytest.approx(one.errors, abs=1e-9)


def test_what_is_told_and_tracked_is_the_motion(drives):
    for drive, motion in zip(drives, ((0.0, 0.0, 4 * np.pi), (2.0, 0.0, 0.0)), strict=True):
        for know in (told(1e-9, 1e-9), tracked(1e-9, 1e-9)):
            known = know(drive, np.random.default_rng(0))
            assert isinstance(known, KnownMotion)
            assert known.motion == pytest.approx(motion, abs=2e-3)


def test_bad_input_is_named(drives):
    rng = np.random.default_rng(0)
    plain = dd.simulate(ROBOT, dd.maneuvers.straight(ROBOT, distance=0.5))
    with refused(ValueError, "drives[0] has no passive_angles: simulate it with passive_wheels="):
        arm_trials([plain], PODS, PODS, told(0.001, 0.001), count=3, rng=rng)
    with refused(ValueError, "count = 0: must be at least 1"):
        arm_trials(drives, PODS, PODS, told(0.001, 0.001), count=0, rng=rng)
    with refused(TypeError, "drives[0] = 'spin': must be a Recording"):
        arm_trials(["spin"], PODS, PODS, told(0.001, 0.001), count=1, rng=rng)
