"""The tilt of unequal wheels on a rigid axle: closed forms and laws."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

import diffdrive_mj as dd
from diffdrive_mj.physics.tilt import level_twin, resting_tilt

radii = st.floats(0.02, 0.2)


def rigid(left, right, **fields):
    return dd.Robot(left_radius=left, right_radius=right, track_width=0.4, axle="rigid", **fields)


@given(radii, radii)
def test_thin_wheels_tilt_by_the_slope_of_their_cone(left, right):
    at = resting_tilt(rigid(left, right, tyres={"width": 1e-6}))
    assert math.tan(at.roll) == pytest.approx((left - right) / 0.4, abs=1e-9)
    assert at.track_width == pytest.approx(math.hypot(0.4, left - right), rel=1e-9)
    assert (at.left_radius, at.right_radius) == pytest.approx((left, right), rel=1e-9)


@given(radii, radii)
def test_the_mirror_image_tilts_the_other_way(left, right):
    one, other = resting_tilt(rigid(left, right)), resting_tilt(rigid(right, left))
    assert one.roll == pytest.approx(-other.roll, abs=1e-15)
    assert one.offset == pytest.approx(-other.offset, abs=1e-15)
    assert one.track_width == pytest.approx(other.track_width)
    assert (one.left_radius, one.right_radius) == pytest.approx((other.right_radius, other.left_radius))


@given(radii)
def test_equal_wheels_do_not_tilt(radius):
    at = resting_tilt(rigid(radius, radius))
    assert (at.roll, at.offset, at.track_width, at.height) == (0, 0, 0.4, pytest.approx(radius))


def test_the_reference_robot_in_second_order():
    at = resting_tilt(rigid(0.1, 0.091, tyres={"width": 1e-6}))
    assert math.degrees(at.roll) == pytest.approx(1.29, abs=0.005)
    assert at.track_width / 0.4 - 1 == pytest.approx(253e-6, rel=2e-3)


def test_a_level_robot_is_its_own_twin():
    level = dd.Robot.load("mismatched")
    assert level_twin(level) == level
    assert resting_tilt(level).roll == 0
