"""Suspicions: every planted fault is named with its cure, and nothing is said of clean drives."""

import dataclasses

import numpy as np
import pytest
from helpers import refused
from real_data import optiodom_recordings

import diffdrive_mj as dd
from diffdrive_mj import diagnosis, logs
from diffdrive_mj.drive import Drive

ROBOT = dd.Robot(left_radius=0.05, right_radius=0.049, track_width=0.3, encoder={"ticks_per_revolution": 1000})

# On these the robot neither runs straight between turns on the spot nor turns one way all the time: every fault shows.
TURNING_BOTH_WAYS = ("230620202042", "230620202317", "231220200040", "250620202104", "250620202119", "030120210001")


def kinematic(maneuver, robot=ROBOT, noise=0.0):
    """A drive without physics, from commands that the robot follows exactly."""
    commands = maneuver(robot)
    angles = np.concatenate([[[0, 0]], np.cumsum(commands.wheel_rates * commands.period, axis=0)])
    truth = dd.odometry.integrate(angles, robot, start=(1.0, -2.0, 0.7))
    truth = truth + noise * np.random.default_rng(4).standard_normal(truth.shape)
    return Drive(np.arange(len(angles)) * commands.period, angles, truth)


def eight(robot):
    return dd.maneuvers.figure_eight(robot)


def square(robot):
    return dd.maneuvers.square(robot, side=1.5, speed=0.4)


def faults(drive):
    """Drives with one fault each, by the words that must name it."""
    angles, truth, change = drive.wheel_angles, drive.truth, dataclasses.replace
    return {
        "left and right look swapped": change(drive, wheel_angles=angles[:, ::-1]),
        "left wheel looks reversed": change(drive, wheel_angles=angles * [-1, 1]),
        "right wheel looks reversed": change(drive, wheel_angles=angles * [1, -1]),
        "both wheels look reversed": change(drive, wheel_angles=-angles),
        "theta looks clockwise": change(drive, truth=truth * [1, 1, -1]),
        "theta looks clockwise and 9": change(drive, truth=truth * [1, 1, -1] + [0, 0, np.pi / 2]),
        "theta looks given in degrees": change(drive, truth=truth * [1, 1, 180 / np.pi]),
        "unit of x and y": change(drive, truth=truth * [1000, 1000, 1]),
        "and of the wheels": change(drive, wheel_angles=angles * 20),
        "is the time": change(drive, t=drive.t * 1000, truth_t=drive.clock * 1000),
    }


@pytest.mark.parametrize("maneuver", [square, eight])
@pytest.mark.parametrize("noise", [0.0, 0.002])
def test_planted_faults_are_named(maneuver, noise):
    drive = kinematic(maneuver, noise=noise)
    assert diagnosis.suspicions(drive, ROBOT) == ()
    for words, faulty in faults(drive).items():
        (found,) = diagnosis.suspicions(faulty, ROBOT)
        assert words in found


CURES = {
    "swapped": "exchange the columns left and right", "the left wheel": "reverse_left", "the right wheel":
    "reverse_right", "both wheels": "reverse_left and reverse_right", "in degrees": "angle_unit = deg",
    "of x and y": "position_unit", "is the time": "time_unit",
}  # fmt: skip


def test_faults_are_named_with_the_field_that_cures_them():
    said = [diagnosis.suspicions(faulty, ROBOT)[0] for faulty in faults(kinematic(square)).values()]
    for words, cure in CURES.items():
        found = [sentence for sentence in said if words in sentence]
        assert found
        assert all(cure in sentence for sentence in found)
    fields = {field.name for field in dataclasses.fields(logs.Columns)}
    assert {"reverse_left", "reverse_right", "angle_unit", "position_unit", "time_unit", "wheel_unit"} <= fields


@pytest.mark.parametrize("factor", [1e-2, 1e-3])
def test_wheels_that_hardly_turn_while_the_truth_moves(factor):
    drive = kinematic(square)
    (found,) = diagnosis.suspicions(dataclasses.replace(drive, wheel_angles=factor * drive.wheel_angles), ROBOT)
    assert found.startswith(f"the truth drives {1 / factor:g} times as far as the wheels")
    assert "ticks_per_revolution" in found


def test_other_things_than_drives_and_robots():
    drive = kinematic(square)
    with refused(TypeError, "drive = a list: must be a Drive"):
        diagnosis.suspicions([drive], ROBOT)
    with refused(TypeError, "believed = 'matched': must be a Robot"):
        diagnosis.suspicions(drive, "matched")


@pytest.mark.parametrize("radius", [0.3, 1.0, -1.0])
def test_on_a_circle_too(radius):
    drive = kinematic(lambda robot: dd.maneuvers.arc(robot, radius=radius, distance=4.0, speed=0.5))
    for words, faulty in faults(drive).items():
        (found,) = diagnosis.suspicions(faulty, ROBOT)
        assert words in found


@pytest.mark.parametrize("angle", [-90, 20, 180])
def test_a_heading_that_is_off_by_a_constant(angle):
    drive = kinematic(square)
    off = dataclasses.replace(drive, truth=drive.truth + np.array([0, 0, np.radians(angle)]))
    (found,) = diagnosis.suspicions(off, ROBOT)
    assert f"theta looks {angle} deg off" in found.replace("-180", "180")


def test_smaller_and_larger_units():
    drive = kinematic(square)
    for factor in (1e-3, 1e-2, 1e2, 1e3):
        (found,) = diagnosis.suspicions(dataclasses.replace(drive, truth=drive.truth * [factor, factor, 1]), ROBOT)
        assert "drives" in found
        assert f"{factor:.0e}"[-2:] in found or f"{factor:g}" in found
    (found,) = diagnosis.suspicions(dataclasses.replace(drive, t=drive.t / 1000, truth_t=drive.clock / 1000), ROBOT)
    assert "is the time in another unit" in found


@pytest.mark.parametrize("noise", [0.0, 0.003])
@pytest.mark.parametrize("at", [3.0, 8.0])
@pytest.mark.parametrize("believed", [ROBOT, ROBOT.replace(left_radius=0.055)], ids=["right", "wrong"])
def test_a_robot_that_is_pushed_or_carried(noise, at, believed):
    drive = kinematic(square, noise=noise)
    truth, after = drive.truth.copy(), drive.t >= at
    carried = dd.se2.compose(truth[after][0], [0.1, 0.15, 0.3])
    truth[after] = dd.se2.compose(carried, dd.se2.between(truth[after][0], truth[after]))
    (found,) = diagnosis.suspicions(dataclasses.replace(drive, truth=truth), believed)
    assert "pushed or lifted" in found
    assert abs(float(found.split()[2]) - at) < 0.2


def test_a_push_right_after_the_start_is_between_it_and_the_end_of_the_first_second():
    drive = kinematic(square)
    truth = drive.truth + np.outer(drive.t >= 0.3, (0.2, 0.0, 0.0))
    (found,) = diagnosis.suspicions(dataclasses.replace(drive, truth=truth), ROBOT)
    assert float(found.split()[2]) == pytest.approx((0.3 + 1.0) / 2, abs=0.02)


def test_the_time_unit_is_judged_from_a_track_width_of_driving_on():
    """At 500 m/s; from less than that it may be one jump of a counter."""
    for driven, named in ((0.9, False), (1.5, True)):
        turned = driven * ROBOT.track_width / ROBOT.left_radius
        angles = np.outer(np.linspace(0, turned, 50), (1.0, 1.0))
        t = np.arange(50) * turned * ROBOT.left_radius / 49 / 500
        drive = Drive(t, angles, dd.odometry.integrate(angles, ROBOT))
        assert any("is the time in another unit" in words for words in diagnosis.suspicions(drive, ROBOT)) == named


def test_of_two_true_poses_none_is_later_than_its_time():
    """A tenth of the way lies behind the second one, in the last second."""
    t = np.arange(0, 10.01, 0.1)
    angles = np.outer(4 * t, (1.0, 1.0))
    truth = dd.odometry.integrate(angles, ROBOT)
    found = diagnosis.suspicions(Drive(t, angles, truth[[0, 90]], t[[0, 90]]), ROBOT)
    assert any(words.startswith("10% of the wheels' turning lies outside") for words in found)


def test_a_robot_that_is_lifted_while_its_wheels_turn():
    drive = kinematic(square)
    turning = np.cumsum(np.where((drive.t > 4) & (drive.t < 5), np.gradient(drive.t) * 20, 0.0))
    (found,) = diagnosis.suspicions(
        dataclasses.replace(drive, wheel_angles=drive.wheel_angles + turning[:, None]), ROBOT
    )
    assert "pushed or lifted" in found
    assert abs(float(found.split()[2]) - 4.5) < 0.6


def test_clocks_that_are_not_one():
    drive = kinematic(square)
    (found,) = diagnosis.suspicions(
        Drive(drive.t, drive.wheel_angles, drive.truth[drive.t > 4], drive.t[drive.t > 4]), ROBOT
    )
    assert "% of the wheels' turning lies outside" in found
    late = Drive(drive.t, drive.wheel_angles, drive.truth, drive.t + 2)
    found = diagnosis.suspicions(late, ROBOT)
    assert "true poses lie outside the times of the wheels: are the clocks synchronised?" in found[0]
    early = Drive(drive.t[drive.t < 9], drive.wheel_angles[drive.t < 9], drive.truth, drive.t)
    (found,) = diagnosis.suspicions(early, ROBOT)
    assert f"{early.dropped} of {len(drive.t)} true poses" in found


@pytest.mark.parametrize("believed", [{"left_radius": 0.055}, {"right_radius": 0.0455}, {"track_width": 0.35}])
@pytest.mark.parametrize("noise", [0.0, 0.005])
@pytest.mark.parametrize("maneuver", ["square", "figure_eight", "straight", "arc", "spin"])
def test_a_wrong_belief_is_no_suspicion(maneuver, believed, noise):
    make = {
        "square": square,
        "figure_eight": eight,
        "straight": lambda robot: dd.maneuvers.straight(robot, speed=0.5, distance=5),
        "arc": lambda robot: dd.maneuvers.arc(robot, radius=1.0, distance=5.0, speed=0.5),
        "spin": lambda robot: dd.maneuvers.spin(robot, turns=2.0),
    }[maneuver]
    assert diagnosis.suspicions(kinematic(make, noise=noise), ROBOT.replace(**believed)) == ()


@pytest.mark.parametrize("maneuver", [square, eight])
@pytest.mark.parametrize("rate", [100, 10, 1, 0.2])
def test_truth_taken_beside_the_axle_is_no_suspicion(maneuver, rate):
    drive = kinematic(maneuver)
    place = dd.se2.compose(drive.truth, [0.05, -0.02, 0.0])[:: int(100 / rate)]
    clock = drive.t[:: int(100 / rate)]
    for believed in (ROBOT, ROBOT.replace(left_radius=0.055), ROBOT.replace(track_width=0.33)):
        assert diagnosis.suspicions(Drive(drive.t, drive.wheel_angles, place, clock), believed) == ()


def test_simulated_drives_look_clean():
    robots = [ROBOT, ROBOT.replace(right_radius=0.051, name="other")]
    simulated = dd.simulate(robots, dd.maneuvers.square(ROBOT, side=0.5, speed=0.3), sample_rate=100.0)
    for rate in (None, 20.0, 1.0):
        for drive in dd.sensors.measure(simulated, tracker=dd.Tracker(sample_rate=rate)):
            assert diagnosis.suspicions(drive, ROBOT) == ()


def test_drives_that_tell_nothing():
    still = Drive([0.0, 1, 2, 3], np.zeros((4, 2)), np.zeros((4, 3)))
    assert diagnosis.suspicions(still, ROBOT) == ()
    drive = kinematic(square)
    ends = Drive(drive.t, drive.wheel_angles, drive.truth[[0, -1]], drive.t[[0, -1]])
    assert diagnosis.suspicions(ends, ROBOT) == ()
    short = Drive([0.0, 0.1], np.zeros((2, 2)), np.zeros((2, 3)))
    assert diagnosis.suspicions(short, ROBOT) == ()


def test_real_runs_look_clean_and_faults_planted_in_them_are_found():
    for folder in optiodom_recordings():
        nominal = logs.optiodom_robot(folder)
        for drive in logs.read_optiodom(folder)[:3]:
            for factor in (0.9, 1.1):
                for field in ("left_radius", "track_width"):
                    believed = nominal.replace(**{field: factor * getattr(nominal, field)})
                    assert diagnosis.suspicions(drive, believed) == ()
            if folder.name in TURNING_BOTH_WAYS:
                for words, faulty in faults(drive).items():
                    (found,) = diagnosis.suspicions(faulty, nominal)
                    assert words in found
