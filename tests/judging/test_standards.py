"""Residuals against planted errors; random cases: ranges, streams of their own, what mechanics says of them."""

import dataclasses

import numpy as np
import pytest
from helpers import refused
from hypothesis import given
from hypothesis import strategies as st

import diffdrive_mj as dd
from diffdrive_mj.errors import RobotFell
from diffdrive_mj.judging import random_drives
from diffdrive_mj.judging.random_drives import outcome, random_cases
from diffdrive_mj.judging.standards import STANDARD_MANEUVERS, Residual, residual, standard_residuals
from diffdrive_mj.physics.mechanics import contact_forces

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


@given(st.integers(0, 10**9))
def test_random_cases_are_in_their_ranges(seed):
    (case,) = random_cases(1, seed)
    robot = case.robot
    assert 0.02 <= robot.left_radius <= 0.25
    assert 0.75 <= robot.radius_ratio <= 1.33
    assert 0.08 <= robot.track_width <= 1.2
    assert 0.3 <= robot.mass <= 80
    assert robot.caster.x < robot.center_of_mass_x < 0
    assert case.commands.duration <= random_drives.LONGEST
    assert case.kind in ("arc", "reverse", "spin", "pivot", "slalom")


def test_a_robot_that_cannot_stand_is_drawn_anew(monkeypatch):
    """Two in a thousand of those drawn: here the first one lies on its side."""
    drawn = [ROBOT.replace(axle="rigid", right_radius=0.05, center_of_mass_height=2.0), ROBOT]
    assert (contact_forces(drawn[0]).load <= 0).any()
    monkeypatch.setattr(random_drives, "random_robot", lambda rng: drawn.pop(0))
    (case,) = random_cases(1, 0)
    assert case.robot == ROBOT
    assert drawn == []


def test_more_cases_change_none_and_another_seed_changes_all():
    few, many, other = random_cases(3, 5), random_cases(6, 5), random_cases(3, 6)
    for k in range(3):
        assert few[k].robot == many[k].robot != other[k].robot
        assert np.array_equal(few[k].commands.wheel_rates, many[k].commands.wheel_rates)
    kinds = {case.kind for case in random_cases(40, 0)}
    assert kinds == {"arc", "reverse", "spin", "pivot", "slalom"}
    assert {case.robot.axle for case in many} == {"independent", "rigid"}


def test_a_drive_keeps_its_grip_up_to_the_friction_that_it_needs():
    """Speeding up on a line, the wheels need M a / 2 of what they carry; a jump to full speed does not keep it."""

    def kept(ramp):
        commands = dd.maneuvers.straight(ROBOT, speed=1.0, distance=3.0, ramp=ramp)
        return random_drives.Case(ROBOT, "arc", commands).keeps_grip

    assert kept(1.0)
    assert not kept(0.1)


def test_what_comes_of_a_case():
    rolled, fell = random_cases(1, 0)[0], dd.Robot.load("turtlebot3_burger")
    came = outcome(rolled)
    assert came.keeps_grip == rolled.keeps_grip
    assert came.position < 1
    assert not came.flagged
    jump = dd.maneuvers.straight(fell, speed=1.0, distance=1.0, ramp=0.2)
    with pytest.raises(RobotFell):
        dd.simulate(fell, jump)
    over = outcome(random_drives.Case(fell, "arc", jump))
    assert over.flagged
    assert over.position == np.inf
    slipping = dataclasses.replace(
        rolled, robot=ROBOT, commands=dd.maneuvers.straight(ROBOT, speed=0.6, distance=0.6, ramp=0.1)
    )
    came = outcome(slipping)
    assert came.flagged
    assert came.position > 1
    assert not came.keeps_grip


@pytest.mark.parametrize(("count", "seed", "said"), [(0, 0, "count"), (1, -1, "seed"), (2.5, 0, "count")])
def test_bad_numbers_of_cases_are_named(count, seed, said):
    with refused(TypeError if isinstance(count, float) else ValueError, said):
        random_cases(count, seed)
