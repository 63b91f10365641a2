"""Closed forms of the moments against the recursion, whose steps are made shorter, and against simpler ones still."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test_moments import ROBOT, wheels

import diffdrive_mj as dd
from diffdrive_mj.estimation.moment_closed_forms import even_motion


@pytest.mark.parametrize("distance", [1.0, 50.0, 200.0])
@pytest.mark.parametrize("k", [0.0005, 0.005])
def test_a_straight_line_ends_where_theory_says(distance, k):
    rate = k**2 / ROBOT.track_width**2
    noise = dd.WheelNoise(left=k, right=k)
    stated = even_motion(distance, 0.0, ROBOT.track_width, noise)
    assert stated.mean[0, 0] == pytest.approx(-math.expm1(-rate * distance) / rate, rel=1e-9)
    found = dd.covariance(wheels(np.full(20_000, distance / 20_000), 0.0), ROBOT, noise=noise)
    # Along a step the noise turns the robot evenly, where theory's heading is a random walk.
    np.testing.assert_allclose(found.mean[-1], stated.mean[0], rtol=1e-6, atol=1e-8)
    assert found.covariance[-1, 2, 2] == pytest.approx(2 * rate * distance, rel=1e-9)


@given(
    distance=st.floats(-50, 50),
    turn=st.floats(-40, 40),
    left=st.floats(0.002, 0.01),
    right=st.floats(0.002, 0.01),
)
@settings(max_examples=25)
def test_short_steps_approach_the_closed_form(distance, turn, left, right):
    noise = dd.WheelNoise(left=left, right=right)
    if abs(distance) + abs(turn) < 0.5:
        return
    stated = even_motion(distance, turn, ROBOT.track_width, noise)
    gaps = []
    for steps in (1000, 4000):
        found = dd.covariance(wheels(np.full(steps, distance / steps), turn / steps), ROBOT, noise=noise)
        scale = np.sqrt(np.diag(stated.covariance[0]))
        gaps.append(np.abs((found.covariance[-1] - stated.covariance[0]) / np.outer(scale, scale)).max())
        np.testing.assert_allclose(found.mean[-1], stated.mean[0], atol=1e-3 * scale.max() + 1e-9)
    assert gaps[1] < 1e-3
    assert gaps[1] < gaps[0] / 3 or gaps[1] < 1e-6


def test_a_turn_on_the_spot_is_as_uncertain_as_its_wheels_have_rolled():
    k, turn = 0.002, 2 * math.pi
    found = even_motion(0.0, turn, 0.4, dd.WheelNoise(left=k, right=k))
    assert found.covariance[0, 2, 2] == pytest.approx(2 * k**2 * (turn * 0.2) / 0.4**2)
    # Both wheels' ways add to the distance, which points everywhere alike.
    assert found.covariance[0, 0, 0] == pytest.approx(k**2 * turn * 0.2 / 4, rel=1e-3)
    assert found.mean[0] == pytest.approx([0, 0, turn])
