"""The sources' closed forms against the exact arc, their special cases, and the fault of one of them."""

import math

import numpy as np
import pytest
from helpers import refused
from hypothesis import given
from hypothesis import strategies as st

import diffdrive_mj as dd
from diffdrive_mj.estimation.closed_forms import arc, arc_as_printed, icc_update

number = st.floats(-5, 5)
turning = st.floats(0.01, 3) | st.floats(-3, -0.01)


def exact(start, twist, t):
    v, omega = twist
    return dd.se2.compose(start, dd.se2.exp((v * t, 0.0, omega * t)))


@given(number, number, number, number, turning, st.floats(0, 10))
def test_turning_about_the_icc_is_the_exact_arc(x, y, theta, v, omega, t):
    assert icc_update((x, y, theta), (v, omega), t) == pytest.approx(exact((x, y, theta), (v, omega), t), abs=1e-9)


@given(number, number, number, number)
def test_a_straight_line_is_the_limit(x, y, theta, v):
    assert icc_update((x, y, theta), (v, 0.0), 2.0) == pytest.approx(exact((x, y, theta), (v, 0.0), 2.0), abs=1e-12)


def test_a_spin_stays_in_place():
    assert icc_update((1.0, 2.0, 0.5), (0.0, 3.0), 1.0) == pytest.approx((1.0, 2.0, 3.5))


@pytest.mark.parametrize("omega", [0.0, 0.4, -1.3])
def test_ten_hertz_of_icc_updates_are_the_closed_form_and_the_odometry(omega):
    """002's path at 10 Hz, 003's form at the end of it, and wheel angles integrated as arcs."""
    robot, start, twist = dd.Robot.load("mismatched"), np.array([1.0, -2.0, 0.7]), np.array([1.5, omega])
    path = [start]
    for _ in range(50):
        path.append(icc_update(path[-1], twist, 0.1))
    assert path[-1] == pytest.approx(arc(start, twist, 5.0), abs=1e-12)
    angles = np.arange(51)[:, None] * 0.1 * dd.kinematics.wheel_rates(twist, robot)
    assert np.array(path) == pytest.approx(dd.odometry.integrate(angles, robot, start=start), abs=1e-12)


def test_the_printed_formulas_leave_the_start_heading_out_of_an_arc():
    twist = (1.0, 0.5)
    assert arc_as_printed((0, 0, 0.0), twist, 2.0) == pytest.approx(arc((0, 0, 0.0), twist, 2.0))
    printed, right = arc_as_printed((0, 0, math.pi / 2), twist, 2.0), arc((0, 0, math.pi / 2), twist, 2.0)
    assert printed[2] == right[2]
    # Off by the chord seen under the heading that is missing: 2 sin(45 degrees) times the chord of 4 sin(1/2) m.
    assert np.hypot(*(printed - right)[:2]) == pytest.approx(2 * math.sin(math.pi / 4) * 4 * math.sin(0.5))
    straight = (1.0, 0.0)
    assert arc_as_printed((0, 0, 1.0), straight, 2.0) == pytest.approx(arc((0, 0, 1.0), straight, 2.0))


def test_leading_dimensions_broadcast():
    t = np.linspace(0, 1, 5)
    assert arc((0, 0, 0), (1.0, 0.3), t).shape == (5, 3)
    assert arc(np.zeros((4, 1, 3)), (1.0, 0.3), t).shape == (4, 5, 3)
    assert arc_as_printed(np.zeros((4, 1, 3)), (1.0, 0.3), t).shape == (4, 5, 3)


def test_bad_input_is_named():
    with refused(ValueError, "pose has shape (2,)"):
        icc_update((0, 0), (1, 1), 1.0)
    with refused(ValueError, "twist[1] = nan"):
        arc((0, 0, 0), (1, math.nan), 1.0)


@pytest.mark.parametrize(
    ("pose", "twist", "dt", "said"),
    [
        (np.zeros((2, 3)), np.ones((3, 2)), 0.1, "pose (2,), twist (3,)"),
        (np.zeros((2, 3)), np.ones(2), np.full(3, 0.1), "dt (3,)"),
        (np.zeros(3), np.ones((2, 2)), np.full(3, 0.1), "dt (3,)"),
    ],
)
def test_leading_dimensions_that_do_not_fit_are_named(pose, twist, dt, said):
    with refused(ValueError, "leading dimensions", said, "must broadcast"):
        icc_update(pose, twist, dt)
