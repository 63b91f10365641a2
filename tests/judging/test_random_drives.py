"""Random cases: as wide as they say and no wider, streams of their own, what mechanics says of them."""

import dataclasses

import numpy as np
import pytest
from helpers import refused
from hypothesis import given
from hypothesis import strategies as st

import diffdrive_mj as dd
from diffdrive_mj.errors import RobotFell
from diffdrive_mj.judging import random_drives
from diffdrive_mj.judging.random_drives import outcome, random_cases, random_drive, random_robot
from diffdrive_mj.physics.mechanics import contact_forces

ROBOT = dd.Robot.load("mismatched")


def spans(values, low, high):
    """Whether values lie between two others, and near both of them."""
    near = (high / low) ** 0.1
    return low <= min(values) < low * near and high / near < max(values) <= high


def test_robots_are_as_different_as_they_say_and_no_more():
    rng = np.random.default_rng(1)
    robots = [random_robot(rng) for _ in range(600)]
    assert spans([robot.left_radius for robot in robots], 0.02, 0.25)
    assert spans([robot.radius_ratio for robot in robots], 0.75, 1.33)
    assert spans([robot.track_width for robot in robots], 0.08, 1.2)
    wheels = np.array([2 * robot.tyres.mass for robot in robots])
    total = wheels + [robot.body_mass for robot in robots]
    assert spans(total, 0.3, 80)
    assert spans(wheels / total, 0.05, 0.15)
    size = np.array([robot.mean_radius for robot in robots])
    assert [robot.tyres.width for robot in robots] == pytest.approx(0.4 * size)
    assert [robot.caster.radius for robot in robots] == pytest.approx(0.25 * size)
    inertia = np.array([robot.motor.rotor_inertia for robot in robots])
    assert spans(inertia / (total * size**2), 0.04, 0.3)
    behind = np.array([-robot.caster.x / robot.track_width for robot in robots])
    assert spans(behind, 0.3, 0.7)
    assert spans([robot.center_of_mass_x / robot.caster.x for robot in robots], 0.15, 0.6)
    assert spans([robot.center_of_mass_height for robot in robots] / size, 0.5, 1.2)
    rigid = np.mean([robot.axle == "rigid" for robot in robots])
    assert 0.4 < rigid < 0.6


@pytest.fixture(scope="module")
def drawn():
    """Kinds, legs and ramps of many drives of one robot."""
    found = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(random_drives, "sequence", lambda robot, legs, ramp: found.append((legs, ramp)))
        rng = np.random.default_rng(2)
        kinds = [random_drive(rng, ROBOT)[0] for _ in range(3000)]
    return [(kind, *drive) for kind, drive in zip(kinds, found, strict=True)]


def legs_of(drawn, *kinds):
    return [leg for kind, legs, _ in drawn if kind in kinds for (leg,) in legs]


def test_drives_are_of_all_kinds_and_ramps(drawn):
    kinds, counts = np.unique([kind for kind, _, _ in drawn], return_counts=True)
    assert list(kinds) == ["arc", "pivot", "reverse", "slalom", "spin"]
    assert counts.min() > 500
    assert spans([ramp for _, _, ramp in drawn], 0.1, 2.0)


@pytest.mark.parametrize(("kind", "way"), [("arc", 1), ("reverse", -1)])
def test_arcs_bend_both_ways_as_fast_and_as_wide_as_they_say(drawn, kind, way):
    legs = legs_of(drawn, kind)
    assert all(way * leg.distance > 0 for leg in legs)
    assert spans([leg.duration for leg in legs], 2.0, 6.0)
    assert spans([way * leg.distance / leg.duration for leg in legs], 0.1, 1.5)
    radii = np.array([way * leg.distance / leg.angle for leg in legs]) / ROBOT.track_width
    assert spans(abs(radii), 0.6, 20.0)
    assert 0.4 < (radii > 0).mean() < 0.6


@pytest.mark.parametrize("kind", ["spin", "pivot"])
def test_spins_and_pivots_turn_both_ways_as_fast_as_they_say(drawn, kind):
    legs = legs_of(drawn, kind)
    assert spans([abs(leg.angle) / leg.duration for leg in legs], 0.3, 3.5)
    assert 0.4 < np.mean([leg.angle > 0 for leg in legs]) < 0.6
    # About the middle of the axle, or about one of its ends.
    about = [leg.distance / abs(leg.angle) for leg in legs]
    assert about == pytest.approx(np.full(len(legs), 0 if kind == "spin" else ROBOT.track_width / 2))


def test_slaloms_are_four_bends_that_end_with_the_first_heading(drawn):
    slaloms = [legs for kind, legs, _ in drawn if kind == "slalom"]
    bends = [leg for legs in slaloms for (leg,) in legs]
    assert all(len(legs) == 4 and sum(leg.angle for (leg,) in legs) == 0 for legs in slaloms)
    assert all(legs[0][0].angle > 0 > legs[1][0].angle for legs in slaloms)
    assert spans([leg.distance / abs(leg.angle) / ROBOT.track_width for leg in bends], 1.0, 10.0)
    assert spans([abs(leg.angle) for leg in bends], 0.3, 1.5)
    assert spans([leg.distance / leg.duration for leg in bends], 0.1, 1.5)


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


def test_no_wheel_may_need_more_than_three_fifths_nor_carry_less_than_a_fiftieth(monkeypatch):
    case = random_drives.Case(ROBOT, "arc", dd.maneuvers.straight(ROBOT, distance=1.0))
    for need, load, kept in [(0.59, 0.03, True), (0.61, 0.03, False), (0.59, 0.01, False), (0.6, 0.02, True)]:
        monkeypatch.setattr(random_drives, "needed_grip", lambda *_, n=need, m=load: (np.array([0.1, n]), m))
        assert case.keeps_grip is kept


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


def test_what_a_lower_rate_loses_is_no_fault_of_the_physics():
    """On a slalom the curvature varies between two readings at 100 Hz."""
    case = dataclasses.replace(random_cases(1, seed=0)[0], robot=ROBOT, commands=dd.maneuvers.slalom(ROBOT))
    readings = dd.simulate(ROBOT, case.commands, sample_rate=100.0)
    assert random_drives.residual(readings, random_drives.level_twin(ROBOT)).position > 5 * outcome(case).position
