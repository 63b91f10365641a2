"""Exports: each target's own formulas, written down here anew, make the calibrated robot of the exported numbers."""

import math
import re

import numpy as np
import pytest
from helpers import refused
from hypothesis import given
from hypothesis import strategies as st
from strategies import robots

import diffdrive_mj as dd
from diffdrive_mj._text import yaml_number
from diffdrive_mj.calibration import export

NOMINAL = dd.Robot(left_radius=0.033, right_radius=0.033, track_width=0.16)
CALIBRATED = NOMINAL.replace(
    left_radius=0.0331, right_radius=0.0327, track_width=0.1643, encoder={"ticks_per_revolution": 64, "gear": 43.7}
)
pairs = st.tuples(robots, robots)
rates = st.tuples(st.floats(-20, 20), st.floats(-20, 20))


def ros2_twist(p, left, right):
    """diff_drive_controller.cpp scales, odometry.cpp computes."""
    separation = p["wheel_separation_multiplier"] * p["wheel_separation"]
    left_velocity = left * p["left_wheel_radius_multiplier"] * p["wheel_radius"]
    right_velocity = right * p["right_wheel_radius_multiplier"] * p["wheel_radius"]
    return (left_velocity + right_velocity) * 0.5, (right_velocity - left_velocity) / separation


def wpilib_twist(p, left, right):
    """DifferentialDriveKinematics::ToChassisSpeeds, of sides whose encoders count rotations."""
    left_speed = left / (2 * math.pi) * p["left_metres_per_rotation"]
    right_speed = right / (2 * math.pi) * p["right_metres_per_rotation"]
    return (left_speed + right_speed) / 2, (right_speed - left_speed) / p["track_width"]


def duckietown_wheel_rates(p, v, omega, k=27.0):
    """kinematics_node.py, up to the duty cycles; and motors that turn k times their duty cycle."""
    k_r_inv = (p["gain"] + p["trim"]) / k
    k_l_inv = (p["gain"] - p["trim"]) / k
    u_r = (v + 0.5 * omega * p["baseline"]) / p["radius"] * k_r_inv
    u_l = (v - 0.5 * omega * p["baseline"]) / p["radius"] * k_l_inv
    return k * u_l, k * u_r


@given(pair=pairs, wheels=rates)
def test_ros2_computes_the_calibrated_robots_twist(pair, wheels):
    nominal, calibrated = pair
    twist = ros2_twist(export.ros2(nominal, calibrated), *wheels)
    np.testing.assert_allclose(twist, dd.kinematics.body_twist(wheels, calibrated), rtol=1e-12, atol=1e-12)


@given(pair=pairs, wheels=rates)
def test_wpilib_computes_the_calibrated_robots_twist(pair, wheels):
    words = export.wpilib(*pair)
    expected = dd.kinematics.body_twist(wheels, pair[1])
    np.testing.assert_allclose(wpilib_twist(words, *wheels), expected, rtol=1e-12, atol=1e-12)
    for side in ("left", "right"):
        pulses = pair[1].encoder.ticks_per_wheel_turn
        assert words[f"{side}_distance_per_pulse"] * pulses == pytest.approx(words[f"{side}_metres_per_rotation"])


def test_wpilib_itself_agrees():
    wpilib = pytest.importorskip("wpimath.kinematics")
    words = export.wpilib(NOMINAL, CALIBRATED)
    left, right = 3.0 * words["left_metres_per_rotation"], 5.0 * words["right_metres_per_rotation"]
    chassis = wpilib.DifferentialDriveKinematics(words["track_width"]).toChassisSpeeds(
        wpilib.DifferentialDriveWheelSpeeds(left, right)
    )
    expected = dd.kinematics.body_twist([6 * np.pi, 10 * np.pi], CALIBRATED)
    np.testing.assert_allclose([chassis.vx, chassis.omega], expected, rtol=1e-12)


@given(pair=pairs, twist=st.tuples(st.floats(-2, 2), st.floats(-5, 5)))
def test_a_duckiebot_does_what_it_is_told(pair, twist):
    wheels = duckietown_wheel_rates(export.duckietown(*pair), *twist)
    np.testing.assert_allclose(dd.kinematics.body_twist(wheels, pair[1]), twist, rtol=1e-12, atol=1e-12)


def test_the_duckiebots_trim_has_the_sign_of_the_smaller_right_wheel():
    robot = dd.Robot(left_radius=0.1, right_radius=0.091, track_width=0.4)
    words = export.duckietown(robot, robot)
    assert words["trim"] / words["gain"] == pytest.approx((1 - 0.91) / (1 + 0.91), rel=1e-12)
    assert words["trim"] / words["gain"] == pytest.approx(0.04712, abs=5e-6)
    left, right = duckietown_wheel_rates(words, 0.5, 0.0)
    assert left / right == pytest.approx(0.91, rel=1e-12)


def test_a_robot_that_was_right_needs_no_correction():
    assert set(export.ros2(NOMINAL, NOMINAL).values()) == {1.0, 0.033, 0.16}
    assert export.duckietown(NOMINAL, NOMINAL) == {"baseline": 0.16, "radius": 0.033, "gain": 1.0, "trim": 0.0}


def test_texts_hold_the_numbers():
    yaml = pytest.importorskip("yaml")
    ros2 = yaml.safe_load(export.text("ros2", NOMINAL, CALIBRATED))
    assert ros2 == {"diff_drive_controller": {"ros__parameters": export.ros2(NOMINAL, CALIBRATED)}}
    duckietown = yaml.safe_load(export.text("duckietown", NOMINAL, CALIBRATED))
    # The node's own file has these; what is missing becomes None.
    assert duckietown == export.duckietown(NOMINAL, CALIBRATED) | {"k": 27.0, "limit": 1.0}
    constants = re.findall(r"public static final double k(\w+) = (\S+);", export.text("wpilib", NOMINAL, CALIBRATED))
    assert [float(value) for _, value in constants] == list(export.wpilib(NOMINAL, CALIBRATED).values())
    assert [name for name, _ in constants][:2] == ["TrackWidth", "LeftMetresPerRotation"]
    assert export.text("toml", NOMINAL, CALIBRATED) == CALIBRATED.to_toml()


def test_very_small_numbers_stay_numbers_in_yaml():
    yaml = pytest.importorskip("yaml")
    tiny = NOMINAL.replace(right_radius=0.033 * (1 + 3e-16))
    for target in ("ros2", "duckietown"):
        words = yaml.safe_load(export.text(target, NOMINAL, tiny))
        values = words["diff_drive_controller"]["ros__parameters"] if target == "ros2" else words
        assert all(isinstance(value, float) for value in values.values())
    assert yaml.safe_load(yaml_number(1e-16)) == 1e-16
    assert yaml.safe_load(yaml_number(-2.5e-16)) == -2.5e-16


@pytest.mark.parametrize("target", ["ros2", "wpilib", "duckietown"])
def test_a_turning_gain_is_not_dropped_silently(target):
    with refused(ValueError, "turning_gain", target):
        export.text(target, NOMINAL, CALIBRATED.replace(turning_gain=0.01))


def test_unknown_targets():
    with refused(ValueError, "export target", "ros2", "did you mean 'ros2'"):
        export.text("ros", NOMINAL, CALIBRATED)


@pytest.mark.parametrize("target", ["ros2", "wpilib", "duckietown", "toml"])
def test_exports_are_of_robots(target):
    with refused(TypeError, "calibrated = 'matched': must be a Robot"):
        export.text(target, NOMINAL, "matched")
