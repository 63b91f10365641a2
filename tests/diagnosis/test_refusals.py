"""Refusals: what would make a calibration worthless is named with its cure, and accepted only on request."""

import dataclasses

import numpy as np
import pytest
from helpers import refused
from hypothesis import given
from strategies import numbers
from test_suspicions import ROBOT, eight, faults, kinematic, square

import diffdrive_mj as dd
from diffdrive_mj.calibration import from_fixes, jung_chung, least_squares, speed_ratio, umbmark
from diffdrive_mj.diagnosis.refusals import implausible, mixed_up, refuse, repeated, worse
from diffdrive_mj.drive import Drive
from diffdrive_mj.errors import CalibrationRefused


@pytest.mark.parametrize("maneuver", [square, eight])
def test_mix_ups_are_refused_and_accepted_on_request(maneuver):
    drive = kinematic(maneuver, noise=0.001)
    believed = ROBOT.replace(track_width=0.301)
    assert [*mixed_up([drive], believed)] == []
    for words, faulty in faults(drive).items():
        with refused(ValueError, f"drive: {words}" if words.startswith("left and") else words, "anyway=True") as _:
            least_squares([drive, faulty], believed)
        (reason,) = mixed_up([faulty], believed)
        with pytest.raises(CalibrationRefused) as info:
            least_squares([faulty], believed)
        assert info.value.reason == reason


def test_a_mix_up_that_is_accepted_is_a_warning():
    faulty = faults(kinematic(square))["left and right look swapped"]
    found = least_squares([faulty], ROBOT, anyway=True)
    assert found.warnings[0].startswith("drive: left and right look swapped")


def test_squares_are_refused_too():
    drives = [
        kinematic(lambda robot, way=way: dd.maneuvers.square(robot, side=1.0, speed=0.4, clockwise=way))
        for way in (False, True)
    ]
    swapped = [dataclasses.replace(drive, wheel_angles=drive.wheel_angles[:, ::-1]) for drive in drives]
    for method in (umbmark, jung_chung):
        with refused(ValueError, "left and right look swapped"):
            method(swapped, ROBOT, side=1.0)
        with refused(ValueError, "one drive does not count as two"):
            method([*drives, drives[0]], ROBOT, side=1.0)
        assert any("given twice" in w for w in method([*drives, drives[0]], ROBOT, side=1.0, anyway=True).warnings)


def test_a_push_is_not_refused():
    drive = kinematic(square)
    truth = drive.truth.copy()
    truth[drive.t > 5] += (0.1, 0.1, 0.0)
    pushed = dataclasses.replace(drive, truth=truth)
    assert dd.diagnosis.suspicions(pushed, ROBOT)
    assert [*mixed_up([pushed], ROBOT)] == []


@given(shift=numbers(-1e4, 1e4))
def test_the_same_log_is_the_same_under_any_name_and_time(shift):
    drive = kinematic(square)
    copy = Drive(drive.t + shift, drive.wheel_angles, drive.truth, drive.t + shift, "copy")
    once_more = Drive(drive.t, drive.wheel_angles, drive.truth)
    assert [*repeated([drive, once_more])] == ["drive is given twice: one drive does not count as two"]
    (said,) = repeated([drive, dataclasses.replace(copy, t=drive.t, truth_t=drive.clock)])
    assert said.startswith("drive and copy are the same log")
    other = dataclasses.replace(drive, truth=drive.truth + 1e-9)
    shorter = Drive(drive.t[:-1], drive.wheel_angles[:-1], drive.truth[:-1])
    assert [*repeated([drive, other, shorter])] == []


def test_nine_copies_do_not_make_a_third_of_the_deviation():
    drive = kinematic(eight, noise=0.001)
    with refused(ValueError, "given twice"):
        least_squares([drive] * 9, ROBOT)


@given(factor=numbers(0.5, 2.0))
def test_a_parameter_that_is_a_third_off_is_not_plausible(factor):
    for name in ("left_radius", "right_radius", "track_width"):
        found = [*implausible(ROBOT, ROBOT.replace(**{name: factor * getattr(ROBOT, name)}))]
        assert len(found) == (not 1 / 1.3 <= factor <= 1.3)
        assert all(f"{name} comes out at" in sentence and "ticks_per_revolution" in sentence for sentence in found)


def test_a_gain_that_no_tyre_has_is_not_plausible():
    assert [*implausible(ROBOT, ROBOT.replace(turning_gain=-0.25))] == []
    (said,) = implausible(ROBOT, ROBOT.replace(turning_gain=-0.35))
    assert "turning_gain = False" in said


@pytest.mark.parametrize("factor", [1.7, 1 / 1.7, 3.0, 200.0])
def test_motor_rotations_read_as_radians(factor):
    """The radii would be 41 % wrong; 1.7 is too little for a suspicion."""
    drive = kinematic(eight, noise=0.001)
    turned = dataclasses.replace(drive, wheel_angles=factor * drive.wheel_angles)
    with refused(ValueError, "ticks_per_revolution", "wheel_unit"):
        least_squares([turned], ROBOT)


METHODS = {
    "least_squares": least_squares, "from_fixes": from_fixes, "speed_ratio": speed_ratio,
    "umbmark": lambda drives, robot, **options: umbmark(drives, robot, side=1.0, **options),
    "jung_chung": lambda drives, robot, **options: jung_chung(drives, robot, side=1.0, **options),
}  # fmt: skip


def for_method(name):
    """Drives that a method takes: lines for the speed ratio, squares in both directions for all others."""
    if name == "speed_ratio":
        lines = (dd.maneuvers.straight(ROBOT, speed=0.4, distance=distance) for distance in (2, 3))
        return [kinematic(lambda robot, line=line: line, noise=1e-3) for line in lines]
    return [
        kinematic(lambda robot, way=way: dd.maneuvers.square(robot, side=1.0, speed=0.4, clockwise=way), noise=1e-3)
        for way in (False, True)
    ]


@pytest.mark.parametrize("name", METHODS)
def test_every_method_refuses_other_units_and_a_log_given_twice(name):
    """Motor rotations read as radians, millimetres as metres; the speed ratio looked at neither."""
    drives, method = for_method(name), METHODS[name]
    assert not any("unit" in warning or "twice" in warning for warning in method(drives, ROBOT).warnings)
    for turns, lengths in ((1.7, 1), (1 / 1.7, 1), (1, 1000)):
        wrong = [
            dataclasses.replace(d, wheel_angles=turns * d.wheel_angles, truth=d.truth * [lengths, lengths, 1])
            for d in drives
        ]
        with pytest.raises(CalibrationRefused, match=r"position_unit.*ticks_per_revolution"):
            method(wrong, ROBOT)
    with pytest.raises(CalibrationRefused, match="given twice"):
        method([*drives, drives[0]], ROBOT)
    assert any("given twice" in warning for warning in method([*drives, drives[0]], ROBOT, anyway=True).warnings)


def test_wheels_in_millimetres():
    """The believed robot is a thousand times too large."""
    size = {name: 1000 * getattr(ROBOT, name) for name in ("left_radius", "right_radius", "track_width")}
    drive = kinematic(eight)
    metres = dd.Robot(left_radius=0.0005, right_radius=0.00049, track_width=0.003)
    with refused(ValueError, "position_unit"):
        least_squares([drive], metres)
    assert size["track_width"] == 300


def test_odometry_that_ends_further_off_than_before():
    truth = np.zeros((2, 4, 3))
    off = [dd.metrics.drift(truth, truth + np.array([error, 0, 0])) for error in (0.0, 0.01, 0.0125, 0.02)]
    assert [*worse(off[1], off[3], 0.001)]
    assert not [*worse(off[1], off[2], 0.001)]  # within 1.2 times and three residuals
    assert not [*worse(off[1], off[3], 0.003)]
    assert not [*worse(off[3], off[1], 0.0)]
    assert [*worse(off[0], off[1], 0.003)]


def test_reasons_are_raised_or_returned():
    assert refuse([], anyway=False) == ()
    assert refuse(["one", "two"], anyway=True) == ("one", "two")
    with refused(ValueError, "one; anyway=True accepts it"):
        refuse(["one", "two"], anyway=False)


def test_near_perfect_data_are_not_warned_of_their_start():
    drives = [kinematic(square), kinematic(eight)]
    assert not any("start" in warning for warning in least_squares(drives, ROBOT).warnings)


def test_flags_are_true_or_false():
    for method, options in ((least_squares, {}), (umbmark, {"side": 1.0})):
        with refused(TypeError, "anyway = 'no': must be True or False"):
            method([kinematic(square)], ROBOT, anyway="no", **options)


def test_logs_of_the_same_late_beginning_are_the_same_too():
    t, angles = np.array([7.0, 8.0, 9.0]), np.array([(0.0, 0.0), (1.0, 2.0), (3.0, 4.0)])
    one, same, other = (dd.Drive(t + off, angles, np.zeros((3, 3)), name=name) for off, name in
                        ((0.0, "a"), (0.0, "b"), (1.5, "c")))  # fmt: skip
    assert len(list(repeated([one, same, other]))) == 3
    slower = dd.Drive(7.0 + 2 * (t - 7.0), angles, np.zeros((3, 3)), name="d")
    assert list(repeated([one, slower])) == []
