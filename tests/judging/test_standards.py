"""Residuals against planted errors, relative to what was driven."""

import numpy as np
import pytest

import diffdrive_mj as dd
from diffdrive_mj.judging import standards
from diffdrive_mj.judging.standards import STANDARD_MANEUVERS, Residual, residual, standard_residuals

ROBOT = dd.Robot.load("mismatched")


def recorded(maneuver, planted=(0.0, 0.0, 0.0)):
    """A recording of perfect odometry whose last pose is moved."""
    commands = STANDARD_MANEUVERS[maneuver](ROBOT)
    angles = np.concatenate([[[0.0, 0.0]], np.cumsum(commands.wheel_rates * commands.period, axis=0)])
    truth = dd.odometry.integrate(angles, ROBOT)
    truth[-1] += planted
    t = commands.period * np.arange(len(angles))
    return dd.Recording(t, angles, truth, ROBOT, commands, dd.World(), dd.Physics())


@pytest.mark.parametrize(
    ("maneuver", "distance", "angle"),
    [
        ("straight", 15.0, 1.0),  # it turns by nothing: compared with a radian
        ("square", 16.0, 2 * np.pi),
        ("square, clockwise", 16.0, 2 * np.pi),
        ("spin", 6 * np.pi * 0.2, 6 * np.pi),  # the way of a wheel about the axle's midpoint
        ("figure eight", 4 * np.pi, 4 * np.pi),
    ],
)
def test_a_residual_is_relative_to_the_way_and_to_the_turn(maneuver, distance, angle):
    left = residual(recorded(maneuver, (3e-6, 4e-6, 1e-6)), ROBOT)
    assert left.position == pytest.approx(5.0 / distance, rel=1e-3)
    assert left.heading == pytest.approx(1.0 / angle, rel=1e-3)
    none = residual(recorded(maneuver), ROBOT)
    assert none.within(1e-6, 1e-6)


def test_the_constant_arc_is_ten_metres_of_the_rates_that_it_says():
    recording = recorded("arc")
    assert float(recording.drift(ROBOT).distance) == pytest.approx(10.0, rel=1e-9)
    assert recording.commands.wheel_rates[300] == pytest.approx((12.0, 15.0), rel=1e-9)


@pytest.mark.parametrize(("position", "heading", "kept"), [(1, 1, True), (2, 1, False), (1, 2, False)])
def test_a_residual_keeps_both_bounds(position, heading, kept):
    assert Residual(position, heading).within(1.0, 1.0) is kept


def test_every_standard_maneuver_is_judged_by_what_is_believed():
    """A track a per mille too wide: headings are off by that part of every turn."""
    fast = dd.Physics.fast()
    left = standard_residuals(ROBOT, fast, believed=ROBOT.replace(track_width=0.4004))
    assert list(left) == list(STANDARD_MANEUVERS)
    for maneuver in ("arc", "square", "square, clockwise", "spin"):
        assert left[maneuver].heading == pytest.approx(1e3, rel=2e-3), maneuver


def test_the_floors_of_the_physics_are_those_of_the_documentation():
    """Parts per million of the way and of the turn: of the standard maneuvers, at full speed, and of any drive."""
    assert (standards.POSITION_FLOOR, standards.HEADING_FLOOR) == (0.4, 0.3)
    assert (standards.FAST_POSITION_FLOOR, standards.ANY_FLOOR) == (1.0, 1.0)


def test_squares_are_driven_in_both_directions():
    """One full turn each."""
    for maneuver, turn in (("square", 1), ("square, clockwise", -1)):
        commands = STANDARD_MANEUVERS[maneuver](ROBOT)
        left, right = commands.wheel_rates.sum(axis=0) * commands.period * (ROBOT.left_radius, ROBOT.right_radius)
        assert (right - left) / ROBOT.track_width == pytest.approx(turn * 2 * np.pi, rel=1e-9)


def test_the_physics_that_is_asked_for_is_driven():
    """Cylinders and default contacts lose a per mille, the package's own choices next to nothing."""
    careless = standard_residuals(ROBOT, dd.Physics.mujoco_defaults())
    assert careless["straight"].position > 100
    assert standard_residuals(ROBOT)["straight"].position < 0.4
