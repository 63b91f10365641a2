"""Derivatives of odometry against closed forms of the arc, exact arithmetic and differences of `odometry` itself."""

from decimal import Decimal, localcontext

import numpy as np
import pytest
from helpers import cos_sin
from hypothesis import assume, given
from hypothesis import strategies as st
from strategies import drives, numbers, robots, signs, sizes

import diffdrive_mj as dd
from diffdrive_mj.estimation.derivatives import PARAMETERS, Motion, chord, motion, parameters_of, trajectory

ROBOT = dd.Robot(left_radius=0.1, right_radius=0.091, track_width=0.4)


def driven(angles, truth_t=None):
    """A drive of which nothing but the wheels and the times of the true poses counts."""
    t = np.arange(float(len(angles)))
    clock = t if truth_t is None else np.asarray(truth_t)
    return dd.Drive(t, angles, np.zeros((len(clock), 3)), clock)


def arc(left, right, robot):
    """The pose after an arc and its derivatives (3, 3), a row a parameter, by the textbook's formulas."""
    distance = (robot.left_radius * left + robot.right_radius * right) / 2
    turn = (robot.right_radius * right - robot.left_radius * left) / robot.track_width
    d_distance = np.array([left / 2, right / 2, 0.0])
    d_turn = np.array([-left, right, -turn]) / robot.track_width
    c, s, radius = np.cos(turn), np.sin(turn), distance / turn
    d_radius = d_distance / turn - distance * d_turn / turn**2
    pose = np.array([radius * s, radius * (1 - c), turn])
    rows = [d_radius * s + radius * c * d_turn, d_radius * (1 - c) + radius * s * d_turn, d_turn]
    return pose, np.stack(rows, axis=-1)


@given(robot=robots, distance=numbers(-5, 5), turn=sizes(0.1, 20), sign=signs, steps=st.integers(1, 9))
def test_an_arc_in_any_number_of_steps_is_the_textbooks(robot, distance, turn, sign, steps):
    """Few steps turn far each, more than a full circle among them; one pose lies inside the last step."""
    left, right = dd.kinematics.wheel_rates((distance, sign * turn), robot)
    share = (steps - 0.4) / steps
    angles = np.linspace([0.0, 0.0], [left, right], steps + 1)
    path = trajectory(driven(angles, [0.0, steps - 0.4, steps]), parameters_of(robot))
    for k, part in ((1, share), (2, 1.0)):
        pose, slopes = arc(part * left, part * right, robot)
        size = 1 + np.abs(slopes).max()
        assert path.poses[k] == pytest.approx(pose, abs=1e-13 * size)
        assert path.by_parameters[:3, k] == pytest.approx(slopes, abs=1e-12 * size)


def sinc_slope(half):
    """sinc'(h) = (cos h - sinc h) / h, in 120 digits."""
    with localcontext(prec=120):
        h = Decimal(abs(half))
        cosine, sine = cos_sin(h)
        return np.sign(half) * float((cosine - sine / h) / h)


@pytest.mark.parametrize("sign", [1, -1])
def test_the_slope_of_the_chord_keeps_its_digits(sign):
    """On both sides of where the series begins."""
    half = sign * np.concatenate([np.geomspace(1e-12, 0.01, 20), np.linspace(0.02, 0.2, 37), np.linspace(0.3, 4, 30)])
    one, zero = np.ones(len(half)), np.zeros((3, len(half)))
    found = chord(Motion(one, 2 * half, zero, zero + 2))
    np.testing.assert_allclose(found.d_length[0], [sinc_slope(h) for h in half], rtol=1e-13)
    np.testing.assert_allclose(found.length, np.sin(half) / half, rtol=1e-14)
    np.testing.assert_array_equal(found.half_turn, half)


@given(angles=drives(least=3), robot=robots, gain=st.sampled_from([0.0, 0.03, -0.2]))
def test_the_derivatives_are_differences_of_odometry(angles, robot, gain):
    robot = robot.replace(turning_gain=gain)
    twists = dd.kinematics.body_twist(np.diff(angles, axis=0), robot)
    # Where a step neither drives nor turns the gain's share has a kink, which a difference would step over.
    assume((np.abs(twists) > 1e-3).all())
    path = trajectory(driven(angles), parameters_of(robot))
    assert path.poses == pytest.approx(dd.odometry.integrate(angles, robot), abs=1e-11)
    for k, name in enumerate(PARAMETERS):
        step = 1e-5 * (getattr(robot, name) or 1.0) if name != "turning_gain" else 1e-5
        up, down = (
            dd.odometry.integrate(angles, robot.replace(**{name: getattr(robot, name) + d})) for d in (step, -step)
        )
        numeric = (up - down) / (2 * step)
        assert path.by_parameters[k] == pytest.approx(numeric, abs=1e-6 * (1 + np.abs(numeric).max()))


@given(angles=drives(least=3), gain=st.sampled_from([0.0, 0.03]))
def test_fewer_derivatives_are_the_first_of_them(angles, gain):
    parameters = parameters_of(ROBOT.replace(turning_gain=gain))
    three, four = (trajectory(driven(angles), parameters, count=count) for count in (3, 4))
    assert three.by_parameters == pytest.approx(four.by_parameters[:3], abs=1e-12)
    assert three.poses == pytest.approx(four.poses, abs=1e-12)


@given(angles=drives(least=4, most=6), offset=numbers(0.1, 0.4))
def test_the_velocity_is_the_derivative_by_the_clock(angles, offset):
    """Inside the steps, where the wheels turn evenly; at a sample it is that of the step ahead."""
    t = np.arange(len(angles)) / 2
    drive = dd.Drive(t, angles, np.zeros((len(t) - 1, 3)), t[:-1])
    early, here, late = (trajectory(drive, parameters_of(ROBOT), -offset - d) for d in (-1e-6, 0.0, 1e-6))
    assert here.velocity == pytest.approx((late.poses - early.poses) / 2e-6, abs=1e-8)
    speed, rate = dd.kinematics.body_twist(np.diff(angles, axis=0) / 0.5, ROBOT).T
    at_samples = trajectory(drive, parameters_of(ROBOT)).velocity
    assert np.hypot(*at_samples[:, :2].T) == pytest.approx(np.abs(speed), abs=1e-12)
    assert at_samples[:, 2] == pytest.approx(rate, abs=1e-12)


def test_the_clock_stops_at_the_ends_of_the_encoders():
    drive = driven(np.array([[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]]))
    assert trajectory(drive, parameters_of(ROBOT), -5.0).poses == pytest.approx(
        np.tile(trajectory(drive, parameters_of(ROBOT)).poses[-1], (3, 1))
    )


def test_wheels_at_rest_and_turns_on_the_spot_have_derivatives():
    """The gain's share is 0 / 0 at rest and 1 on the spot."""
    steps = motion([[0.0, 0.0], [-1.0, 1.0]], [0.1, 0.1, 0.4, 0.05])
    assert np.isfinite(steps.d_turn).all()
    assert steps.turn == pytest.approx([0.0, 0.5 * 1.05])
    assert steps.d_turn[3] == pytest.approx([0.0, 0.5])


def test_bad_input_is_named():
    with pytest.raises(dd.DiffdriveError, match="parameters has shape"):
        motion([[0.0, 1.0]], [0.1, 0.1, 0.4])
    with pytest.raises(dd.DiffdriveError, match="increments has shape"):
        motion([0.0, 1.0, 2.0], [0.1, 0.1, 0.4, 0.0])
    with pytest.raises(dd.DiffdriveError, match="count = 2: must be 3 or 4"):
        motion([[0.0, 1.0]], [0.1, 0.1, 0.4, 0.0], count=2)
    with pytest.raises(dd.DiffdriveError, match="robot = 'matched': must be a Robot"):
        parameters_of("matched")
    with pytest.raises(dd.DiffdriveError, match="clock_offset = 'late': must be a number"):
        trajectory(driven(np.eye(2)), parameters_of(ROBOT), "late")


def test_turns_of_any_size_have_derivatives():
    """The series for small turns is not asked about large ones."""
    steps = motion(np.array([[1e9, -1e9]]), [0.1, 0.1, 0.4, 1e90])
    assert np.isfinite(chord(steps).d_length).all()
