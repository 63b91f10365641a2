import math

import numpy as np
import pytest
from helpers import refused
from hypothesis import assume, given
from hypothesis import strategies as st
from strategies import numbers, poses, robots, sizes, twists, wheel_rates

import diffdrive_mj as dd
from diffdrive_mj import kinematics, se2

ROBOT = dd.Robot(left_radius=0.1, right_radius=0.091, track_width=0.4)
EQUAL = ROBOT.replace(right_radius=0.1)
UNIT = dd.Robot(left_radius=1, right_radius=1, track_width=1)
INFINITE = (np.inf, np.inf)

same = {"rtol": 1e-12, "atol": 1e-12}


# Wheel rates and twist


@pytest.mark.parametrize(
    ("rates", "robot", "twist"),
    [
        ((1, 2), UNIT, (1.5, 1)),
        ((5, 5), EQUAL, (0.5, 0)),
        ((-5, 5), EQUAL, (0, 2.5)),
        ((0, 4), EQUAL, (0.2, 1)),
        ((10, 10), ROBOT, (0.955, -0.225)),
    ],
)
def test_twist_of_known_rates(rates, robot, twist):
    np.testing.assert_allclose(kinematics.body_twist(rates, robot), twist, rtol=1e-14, atol=1e-15)


@given(wheel_rates, robots)
def test_rates_of_the_twist_are_the_rates(rates, robot):
    np.testing.assert_allclose(kinematics.wheel_rates(kinematics.body_twist(rates, robot), robot), rates, **same)


@given(twists, robots)
def test_twist_of_the_rates_is_the_twist(twist, robot):
    np.testing.assert_allclose(kinematics.body_twist(kinematics.wheel_rates(twist, robot), robot), twist, **same)


@given(wheel_rates, robots)
def test_contacts_of_a_rigid_body(rates, robot):
    """The wheel centres of a rigid body at y = b/2 and -b/2 move at v - omega y."""
    v, omega = kinematics.body_twist(rates, robot)
    half = robot.track_width / 2
    np.testing.assert_allclose(v - omega * half, robot.left_radius * rates[0], **same)
    np.testing.assert_allclose(v + omega * half, robot.right_radius * rates[1], **same)


@given(wheel_rates, robots)
def test_a_mirrored_robot_turns_the_other_way(rates, robot):
    mirrored = robot.replace(left_radius=robot.right_radius, right_radius=robot.left_radius)
    v, omega = kinematics.body_twist(rates, robot)
    np.testing.assert_array_equal(kinematics.body_twist(rates[::-1], mirrored), (v, -omega))


def test_leading_dimensions():
    rates = np.random.default_rng(0).uniform(-10, 10, (3, 4, 2))
    twist = kinematics.body_twist(rates, ROBOT)
    assert twist.shape == rates.shape
    np.testing.assert_array_equal(twist[2, 1], kinematics.body_twist(rates[2, 1], ROBOT))
    np.testing.assert_allclose(kinematics.wheel_rates(twist, ROBOT), rates, **same)


# The instantaneous centre of curvature


@given(poses, twists)
def test_the_turning_center_stands_still(pose, twist):
    """Of all points fixed to the body, the one at the centre has no velocity: v heading + omega z x (p - c) = 0."""
    v, omega = twist
    assume(abs(omega) > 1e-3)
    x, y, theta = pose
    cx, cy = kinematics.turning_center(pose, twist)
    velocity = (v * math.cos(theta) - omega * (cy - y), v * math.sin(theta) + omega * (cx - x))
    np.testing.assert_allclose(velocity, 0, atol=1e-12)


@given(poses, twists, robots)
def test_wheels_roll_in_proportion_to_their_distance_from_the_center(pose, twist, robot):
    omega = twist[1]
    assume(abs(omega) > 1e-3)
    center = kinematics.turning_center(pose, twist)
    left, right = ((0, robot.track_width / 2, 0), (0, -robot.track_width / 2, 0))
    for contact, speed in zip((left, right), kinematics.wheel_rates(twist, robot) * _radii(robot), strict=True):
        distance = math.dist(se2.compose(pose, contact)[:2], center)
        np.testing.assert_allclose(abs(speed), abs(omega) * distance, rtol=1e-9, atol=1e-9)


@given(poses, numbers(-3, 3))
def test_the_center_is_infinite_where_nothing_turns(pose, v):
    np.testing.assert_array_equal(kinematics.turning_center(pose, (v, 0)), INFINITE)
    assert kinematics.turning_radius((v, 0)) == np.inf


def test_the_center_of_a_spin_is_the_robot():
    np.testing.assert_array_equal(kinematics.turning_center((1, 2, 3), (0, -0.7)), (1, 2))


def test_turning_left_the_center_is_on_the_left():
    np.testing.assert_allclose(kinematics.turning_center((0, 0, 0), (1, 0.5)), (0, 2))
    np.testing.assert_allclose(kinematics.turning_center((0, 0, np.pi / 2), (1, 0.5)), (-2, 0), atol=1e-15)
    np.testing.assert_allclose(kinematics.turning_center((0, 0, 0), (1, -0.5)), (0, -2))


def test_centers_of_many_motions():
    centers = kinematics.turning_center((1, 0, 0), [(1, 0), (1, 1), (0, 1)])
    np.testing.assert_array_equal(centers, [INFINITE, (1, 1), (1, 0)])


@given(wheel_rates, robots)
def test_turning_radius_from_the_wheels(rates, robot):
    """(b / 2) (v_l + v_r) / (v_r - v_l), from the speeds of the wheels."""
    left, right = _radii(robot) * rates
    assume(abs(right - left) > 1e-6)
    expected = robot.track_width / 2 * (left + right) / (right - left)
    np.testing.assert_allclose(kinematics.turning_radius(kinematics.body_twist(rates, robot)), expected, rtol=1e-9)


# Unequal wheels: the compensation


@given(sizes(0.01, 1.0), numbers(0.5, 2.0), numbers(-50.0, 50.0), robots)
def test_a_compensated_robot_runs_straight(radius, k, right_rate, robot):
    right = kinematics.compensated_right_radius(radius, k)
    assert right == k * radius
    compensated = robot.replace(left_radius=radius, right_radius=right)
    v, omega = kinematics.body_twist((k * right_rate, right_rate), compensated)
    np.testing.assert_allclose(v, right * right_rate, rtol=1e-14)
    np.testing.assert_allclose(omega * robot.track_width, 0, atol=1e-14 * abs(v))
    assert compensated.radius_ratio == pytest.approx(k, rel=1e-15)


@given(sizes(0.1, 10.0), sizes(0.01, 0.9), numbers(0.5, 2.0))
def test_radii_for_a_speed(speed, rolling, k):
    right_rate = speed / rolling
    left, right = kinematics.radii_for_speed(speed, right_rate, k)
    assert right == pytest.approx(rolling, rel=1e-14)
    robot = dd.Robot(left_radius=left, right_radius=right, track_width=0.4)
    v, omega = kinematics.body_twist((k * right_rate, right_rate), robot)
    assert v == pytest.approx(speed, rel=1e-14)
    assert omega * robot.track_width == pytest.approx(0, abs=1e-14 * speed)


def test_radii_for_one_and_a_half_metres_a_second():
    """The left radius is 3 / (2 k phi_r'), the right one k times that."""
    k, right_rate = 0.91, 15.0
    left, right = kinematics.radii_for_speed(1.5, right_rate, k)
    assert left == pytest.approx(3 / (2 * k * right_rate), rel=1e-15)
    assert right == pytest.approx(0.1, rel=1e-15)


@given(numbers(0.5, 2.0))
def test_the_curve_that_is_left_uncompensated(k):
    """Equal wheels, the left one k times as fast: half the track sees (1 - k) / (1 + k) of the way as a turn."""
    v, omega = kinematics.body_twist((k, 1), EQUAL)
    trim = omega * EQUAL.track_width / (2 * v)
    assert trim == pytest.approx((1 - k) / (1 + k), rel=1e-12, abs=1e-15)
    # The same number, as a trim of the commands, takes the turn out.
    turn = kinematics.body_twist((k * (1 + trim), 1 - trim), EQUAL)[1]
    assert turn == pytest.approx(0, abs=1e-15)


def test_the_trim_of_the_sources_robot():
    v, omega = kinematics.body_twist((0.91, 1), EQUAL)
    assert omega * EQUAL.track_width / (2 * v) == pytest.approx(0.04712, abs=5e-6)


@given(twists, robots, robots)
def test_what_another_robot_takes_a_twist_for(twist, true, believed):
    taken_for = kinematics.body_twist(kinematics.wheel_rates(twist, true), believed)
    np.testing.assert_allclose(kinematics.belief_matrix(believed, true) @ twist, taken_for, rtol=1e-12, atol=1e-11)


@given(robots)
def test_a_right_belief_is_the_identity(robot):
    np.testing.assert_allclose(kinematics.belief_matrix(robot, robot), np.eye(2), rtol=1e-15)


# The constraints of the wheels


@given(wheel_rates, robots)
def test_rolling_breaks_no_constraint(rates, robot):
    v, omega = kinematics.body_twist(rates, robot)
    np.testing.assert_allclose(kinematics.constraint_residuals((v, 0, omega), rates, robot), 0, atol=1e-12)


@given(wheel_rates, robots, numbers(-1, 1), numbers(-1, 1), numbers(-1, 1))
def test_residuals_are_the_slip(rates, robot, slip_left, slip_right, slip_sideways):
    """A body carried by wheel centres that move faster than the wheels roll, and sideways."""
    left, right = _radii(robot) * rates + (slip_left, slip_right)
    velocity = ((left + right) / 2, slip_sideways, (right - left) / robot.track_width)
    residuals = kinematics.constraint_residuals(velocity, rates, robot)
    np.testing.assert_allclose(residuals, (slip_left, slip_right, slip_sideways), atol=1e-12)


@given(wheel_rates, robots)
def test_the_inverse_of_the_constraints_is_the_forward_kinematics(rates, robot):
    """Columns of the constraint matrix from unit velocities, inverted, applied to the speeds of the wheels' rims."""
    columns = [kinematics.constraint_residuals(unit, (0, 0), robot) for unit in np.eye(3)]
    rims = (*(_radii(robot) * rates), 0)
    v, sideways, omega = np.linalg.inv(np.transpose(columns)) @ rims
    np.testing.assert_allclose((v, omega), kinematics.body_twist(rates, robot), **same)
    assert sideways == 0


def test_residuals_of_a_recording():
    velocities, rates = np.zeros((5, 3)), np.ones((5, 2))
    expected = np.tile((-0.1, -0.091, 0), (5, 1))
    np.testing.assert_allclose(kinematics.constraint_residuals(velocities, rates, ROBOT), expected)
    np.testing.assert_allclose(kinematics.constraint_residuals((0, 0, 0), rates, ROBOT), expected)


# An independent implementation


@given(numbers(-30, 30), numbers(-30, 30), numbers(0.02, 0.3), numbers(0.1, 1.0))
def test_against_wpilib(left_rate, right_rate, radius, track_width):
    wpilib = pytest.importorskip("wpimath.kinematics")
    robot = dd.Robot(left_radius=radius, right_radius=radius, track_width=track_width)
    theirs = wpilib.DifferentialDriveKinematics(track_width)
    speeds = wpilib.DifferentialDriveWheelSpeeds(radius * left_rate, radius * right_rate)
    chassis = theirs.toChassisSpeeds(speeds)
    np.testing.assert_allclose(
        kinematics.body_twist((left_rate, right_rate), robot), (chassis.vx, chassis.omega), rtol=1e-13, atol=1e-13
    )
    back = theirs.toWheelSpeeds(chassis)
    rates = kinematics.wheel_rates((chassis.vx, chassis.omega), robot)
    np.testing.assert_allclose(rates * radius, (back.left, back.right), rtol=1e-13, atol=1e-13)


# Bad input


@pytest.mark.parametrize(
    ("call", "name", "length"),
    [
        (lambda bad: kinematics.body_twist(bad, ROBOT), "wheel_rates", 2),
        (lambda bad: kinematics.wheel_rates(bad, ROBOT), "twist", 2),
        (kinematics.turning_radius, "twist", 2),
        (lambda bad: kinematics.turning_center((0, 0, 0), bad), "twist", 2),
        (lambda bad: kinematics.turning_center(bad, (1, 1)), "pose", 3),
        (lambda bad: kinematics.constraint_residuals((0, 0, 0), bad, ROBOT), "wheel_rates", 2),
        (lambda bad: kinematics.constraint_residuals(bad, (1, 1), ROBOT), "body_velocity", 3),
    ],
)
def test_bad_arrays_are_refused(call, name, length):
    with refused(ValueError, f"{name} has shape (4,)", f"(..., {length})"):
        call(np.zeros(4))
    with refused(ValueError, f"{name}[1] = nan", "finite"):
        call([0.0, math.nan, 0.0][:length])
    with refused(TypeError, name, "numbers"):
        call("fast")


def test_shapes_that_do_not_fit_are_refused():
    with refused(ValueError, "pose (2,)", "twist (3,)", "broadcast"):
        kinematics.turning_center(np.zeros((2, 3)), np.ones((3, 2)))
    with refused(ValueError, "body_velocity (2,)", "wheel_rates (3,)"):
        kinematics.constraint_residuals(np.zeros((2, 3)), np.ones((3, 2)), ROBOT)


@pytest.mark.parametrize("bad", [0, -0.1, math.nan, math.inf])
def test_bad_sizes_are_refused(bad):
    with refused(ValueError, "left_radius", bad):
        kinematics.compensated_right_radius(bad, 0.91)
    with refused(ValueError, "speed_ratio", bad):
        kinematics.compensated_right_radius(0.1, bad)
    for name in ("speed", "right_rate", "speed_ratio"):
        arguments = {"speed": 1.5, "right_rate": 15, "speed_ratio": 0.91} | {name: bad}
        with refused(ValueError, f"{name} = {bad}"):
            kinematics.radii_for_speed(**arguments)


def _radii(robot):
    return np.array([robot.left_radius, robot.right_radius])


@given(robots, st.floats(-0.3, 0.3), st.floats(-3, 3), st.floats(-5, 5))
def test_the_turning_gain_turns_more_on_the_spot_and_the_pair_stays_inverse(robot, gain, v, omega):
    geared = robot.replace(turning_gain=gain)
    rates = kinematics.wheel_rates((v, omega), geared)
    assert kinematics.body_twist(rates, geared) == pytest.approx((v, omega), rel=1e-9, abs=1e-9)
    on_the_spot = kinematics.wheel_rates((0.0, omega), robot)
    assert kinematics.body_twist(on_the_spot, geared)[1] == pytest.approx((1 + gain) * omega, rel=1e-9)
    straight = kinematics.wheel_rates((v, 0.0), robot)
    assert kinematics.body_twist(straight, geared) == pytest.approx((v, 0.0), abs=1e-9)
