"""Squares on which methods are tried: answered, refused, or not squares at all."""

import math

import pytest
from helpers import refused

import diffdrive_mj as dd
from diffdrive_mj.errors import CalibrationRefused, InvalidValue
from diffdrive_mj.judging.square_trials import Trial, median_gain, trial

ROBOT = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
TRUE = ROBOT.replace(right_radius=0.0996, track_width=0.41)


@pytest.fixture(scope="module")
def drives():
    commands = [dd.maneuvers.square(ROBOT, side=2.0, clockwise=way) for way in (False, True)]
    return dd.sensors.measure(dd.simulate([TRUE] * 2, commands, physics=dd.Physics.fast(), sample_rate=20.0))


def refusing(error):
    def method(*given, **options):
        raise error

    return method


def test_a_square_is_answered_with_what_the_method_is_worth(drives):
    found = trial(dd.calibration.umbmark, drives, ROBOT, side=2.0, bent=0.02)
    before, after = (
        max(abs(complex(*ends)) for ends in (dd.se2.between(d.odometry(robot)[-1], d.truth[-1])[:2] for d in drives))
        for robot in (ROBOT, dd.calibration.umbmark(drives, ROBOT, side=2.0).calibrated)
    )
    assert found.gain == pytest.approx(before / after, rel=0.1)
    assert found.gain > 1000
    assert (found.bent, found.refusal) == (0.02, "")


def test_what_the_method_refuses_is_kept_with_its_reason(drives):
    found = trial(refusing(CalibrationRefused("too bent")), drives, ROBOT, side=2.0, bent=0.4)
    assert found.refusal == "too bent"
    assert math.isnan(found.gain)


def test_any_other_error_is_no_refusal_of_the_square(drives):
    with refused(ValueError, "not a square"):
        trial(refusing(InvalidValue("not a square")), drives, ROBOT, side=2.0, bent=0.1)
    with refused(ValueError, "side = -2.0"):
        trial(dd.calibration.umbmark, drives, ROBOT, side=-2.0, bent=0.1)


def test_the_median_is_that_of_the_squares_that_are_answered():
    trials = [Trial(0.1, 2.0), Trial(0.1, 4.0), Trial(0.1, 9.0), Trial(0.1, refusal="no"), Trial(0.2, refusal="no")]
    assert median_gain(trials, 0.1) == 4.0
    assert math.isnan(median_gain(trials, 0.2))
