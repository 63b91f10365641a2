"""A measured drive and what odometry makes of it."""

import math
from dataclasses import replace

import numpy as np
import pytest
from helpers import refused

import diffdrive_mj as dd
from diffdrive_mj.drive import checked_drives

ROBOT = dd.Robot(left_radius=0.05, right_radius=0.05, track_width=0.3)
WRONG = ROBOT.replace(track_width=0.33)


def quarter_turn(times, truth_t=None, start=(1.0, 2.0, 3.0)):
    """The robot turns by 90 degrees on the spot within a second, evenly, for a robot of that track."""
    rim = math.pi / 2 * ROBOT.track_width / 2 / ROBOT.left_radius
    clock = np.asarray(times if truth_t is None else truth_t)
    truth = np.array(start) + np.outer(clock, [0.0, 0.0, math.pi / 2])
    return dd.Drive(times, np.outer(times, [-rim, rim]), truth, truth_t)


def test_odometry_starts_at_the_first_true_pose_whenever_that_was():
    drive = quarter_turn([0.0, 0.5, 1.0], truth_t=[0.3, 0.6, 0.9])
    np.testing.assert_allclose(drive.odometry(ROBOT), drive.truth, atol=1e-12)


def test_drift_has_the_sign_of_estimate_minus_truth_and_its_own_start():
    drift = quarter_turn([0.0, 0.5, 1.0]).drift(WRONG)
    # A track believed too wide by a tenth turns by 1 / 1.1 of the truth: too little.
    assert drift.final_heading == pytest.approx(math.pi / 2 * (1 / 1.1 - 1))
    assert drift.final_position == pytest.approx(0.0, abs=1e-12)


def test_drift_takes_wrapped_headings_for_what_they_are():
    drive = quarter_turn([0.0, 0.5, 1.0])
    wrapped = dd.Drive(drive.t, drive.wheel_angles, np.c_[drive.truth[:, :2], dd.se2.wrap_angle(drive.truth[:, 2])])
    assert wrapped.drift(ROBOT).max_heading < 1e-12


def test_the_method_reaches_the_odometry():
    """One step of a quarter circle of radius R: Euler goes straight on, midpoint takes the arc for the chord."""
    radius, turn = 1.0, math.pi / 2
    rims = np.array([radius - ROBOT.track_width / 2, radius + ROBOT.track_width / 2]) * turn / ROBOT.left_radius
    drive = dd.Drive([0.0, 1.0], [[0.0, 0.0], rims], [[0.0, 0.0, 0.0], [radius, radius, turn]])
    arc_length, chord = radius * turn, radius * math.sqrt(2)
    assert drive.drift(ROBOT).final_position == pytest.approx(0.0, abs=1e-12)
    assert drive.drift(ROBOT, "midpoint").final_position == pytest.approx(arc_length - chord)
    assert drive.drift(ROBOT, "euler").final_position == pytest.approx(math.hypot(arc_length - radius, radius))


def test_poses_outside_the_wheels_time_stay_counted_when_a_drive_is_renamed():
    drive = quarter_turn([0.0, 0.5, 1.0], truth_t=[-0.5, 0.3, 0.6, 0.9, 1.2])
    assert drive.dropped == 2
    assert replace(drive, name="another").dropped == 2


def test_between_samples_the_wheels_turn_evenly():
    drive = dd.Drive([0.0, 1.0, 3.0], [[0.0, 0.0], [1.0, -1.0], [2.0, 5.0]], np.zeros((3, 3)))
    angles = drive.angles_at([0.0, 0.25, 1.0, 2.0, 3.0])
    np.testing.assert_allclose(angles, [[0, 0], [0.25, -0.25], [1, -1], [1.5, 2], [2, 5]], atol=1e-15)
    for outside in (-0.1, 3.1):
        with refused(ValueError, f"drive: times holds {outside:g} s", "those of the encoder, 0 to 3 s"):
            drive.angles_at([1.0, outside])


def test_drives_are_a_list_of_drives():
    drive = quarter_turn([0.0, 0.5, 1.0])
    assert checked_drives(iter([drive, drive])) == [drive, drive]
    for wrong, words in (
        (drive, "give one as [drive]"),
        (3, "drives = 3"),
        ([drive, "log.csv"], "drives[1] = 'log.csv': must be a Drive"),
        ([dd.Recording.__new__(dd.Recording)], "drives[0] = a Recording: must be a Drive; sensors.measure(recording)"),
    ):
        with refused(TypeError, words):
            checked_drives(wrong)
    with refused(ValueError, "drives: must hold at least one"):
        checked_drives([])


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"truth_t": [0.0, 0.5, 1.0]}, "lab: truth has 2 poses and truth_t 3: must be as many"),
        ({"wheel_angles": np.zeros((3, 2))}, "lab: wheel_angles has 3 samples and t 2: must be as many"),
        ({"truth": np.zeros((1, 3))}, "lab: truth has 1 poses and t 2 samples: truth_t must say when they were"),
        ({"truth_t": [5.0, 6.0]}, "lab: the true poses span 5 to 6 s and the encoder 0 to 1 s"),
        ({"truth": np.zeros((1, 2, 3))}, "lab: truth has shape (1, 2, 3): must be (T, 3)"),
        ({"wheel_angles": np.zeros((1, 2, 2))}, "lab: wheel_angles has shape (1, 2, 2): must be (T, 2)"),
    ],
)
def test_parts_that_do_not_fit_are_named(changes, words):
    parts = {"t": [0.0, 1.0], "wheel_angles": np.zeros((2, 2)), "truth": np.zeros((2, 3)), "name": "lab"} | changes
    with refused(ValueError, words):
        dd.Drive(**parts)


def test_what_was_checked_cannot_be_changed():
    t, angles, truth = np.arange(3.0), np.zeros((3, 2)), np.zeros((3, 3))
    drive = dd.Drive(t, angles, truth)
    for mine, kept in ((t, drive.t), (angles, drive.wheel_angles), (truth, drive.truth), (t, drive.clock)):
        mine[:] = np.nan
        assert np.isfinite(kept).all()
        with pytest.raises(ValueError, match="read-only"):
            kept[0] = 1.0
