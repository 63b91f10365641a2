"""Floors that let wheels slide: where a patch begins, and what friction does to a robot on it."""

import math

import numpy as np
import pytest

import diffdrive_mj as dd
from diffdrive_mj.errors import PhysicsWarning
from diffdrive_mj.world import Patch

ROBOT = dd.Robot.load("matched")
G = 9.81


def test_a_patch_contains_its_inside():
    patch = Patch(x=(0, 2), y=(-1, 1), friction=0.1)
    points = np.array([(1.0, 0.0), (1.9, 0.0), (3.0, 0.0), (5.0, 5.0), (-1.0, 0.5)])
    assert patch.contains(points).tolist() == [True, True, False, False, False]


def test_a_patch_contains_the_points_that_its_friction_is_under():
    patch = Patch(x=(0, 2), y=(-1, 1), friction=0.1)
    grid = np.stack(np.meshgrid([-0.1, 0.0, 1.0, 2.0, 2.1], [-1.1, -1.0, 0.0, 1.0, 1.1]), axis=-1)
    inside = patch.contains(grid)
    assert inside.sum() == 4  # two of its borders belong to it
    assert inside[1, 1]
    np.testing.assert_array_equal(dd.World(patches=(patch,)).friction_at(grid), np.where(inside, 0.1, 1.0))


def test_the_later_of_two_patches_counts():
    world = dd.World(
        friction=0.9, patches=(Patch(x=(0, 2), y=(0, 2), friction=0.5), Patch(x=(1, 3), y=(0, 2), friction=0.1))
    )
    assert world.friction_at(np.array([(0.5, 1.0), (1.5, 1.0), (2.5, 1.0), (9.0, 9.0)])).tolist() == [
        0.5,
        0.1,
        0.1,
        0.9,
    ]


@pytest.mark.parametrize("friction", [0.1, 0.2])
def test_spinning_wheels_push_as_coulomb_says(friction):
    """Both wheels spin: m a = mu N. Speeding up shifts load from the wheels to the caster behind them.

    Moments about the caster's contact, an arm c behind the axle, with the body's mass M_b at x_b behind and h above,
    and the wheels' M_w at their radius: N c = M_b g (c - x_b) + M_w g c - (M_b h + M_w r) a.
    """
    drive = dd.maneuvers.constant_rates((60.0, 60.0), 2.0, ramp=1.0)
    with pytest.warns(PhysicsWarning, match="used 100 % of its friction"):
        recording = dd.simulate(ROBOT, drive, world=dd.World(friction=friction), physics=dd.Physics.sliding())
    assert recording.friction_use == pytest.approx(1, abs=1e-3)
    seen = (recording.t > 1.3) & (recording.t < 2.0)
    reached = np.polyfit(recording.t[seen], recording.truth[seen, 0], 2)[0] * 2
    body, wheels, arm, behind, height, radius = 4.0, 0.6, 0.2, 0.06, 0.08, 0.1
    at_rest = G * (body * (arm - behind) + wheels * arm) / arm
    shifted = (body * height + wheels * radius) / arm
    assert reached == pytest.approx(friction * at_rest / (body + wheels + friction * shifted), rel=0.02)


def test_a_patch_acts_where_it_lies_and_nowhere_else():
    drive = dd.maneuvers.straight(ROBOT, distance=3.0, speed=1.0, ramp=1.0)
    bare = dd.simulate(ROBOT, drive)
    far = dd.World(patches=(Patch(x=(50, 60), y=(-1, 1), friction=0.01),))
    assert np.array_equal(dd.simulate(ROBOT, drive, world=far).truth, bare.truth)
    # Rolling evenly takes no friction; braking, which begins at 2.5 m, does.
    ahead = dd.World(patches=(Patch(x=(2.6, 4.0), y=(-1, 1), friction=0.001),))
    with pytest.warns(PhysicsWarning):
        slid = dd.simulate(ROBOT, drive, world=ahead)
    before = bare.truth[:, 0] < 2.59
    assert np.array_equal(slid.truth[before], bare.truth[before])
    assert not np.array_equal(slid.truth, bare.truth)


def test_a_patch_of_the_floors_own_friction_changes_no_bit():
    drive = dd.maneuvers.arc(ROBOT, distance=1.5)
    same = dd.World(patches=(Patch(x=(0.3, 0.7), y=(-0.1, 1), friction=1.0),))
    assert np.array_equal(dd.simulate(ROBOT, drive, world=same).truth, dd.simulate(ROBOT, drive).truth)


def test_robots_meet_the_patch_each_at_its_own_time_with_the_same_bits():
    world = dd.World(patches=(Patch(x=(0.5, 0.8), y=(-1, 1), friction=0.05),))
    drives = [dd.maneuvers.straight(ROBOT, distance=1.5, speed=v, ramp=0.4).extended(6.0) for v in (0.4, 0.7, 1.0)]
    together = dd.simulate(ROBOT, drives, world=world)
    for i, drive in enumerate(drives):
        assert np.array_equal(together.truth[i], dd.simulate(ROBOT, drive, world=world).truth)


def test_one_slippery_wheel_turns_the_robot():
    world = dd.World(patches=(Patch(x=(-1, 5), y=(0.0, 1.0), friction=0.05),))
    drive = dd.maneuvers.straight(ROBOT, distance=1.0, speed=1.0, ramp=0.3)
    with pytest.warns(PhysicsWarning):
        recording = dd.simulate(ROBOT, drive, world=world, physics=dd.Physics.sliding())
    assert recording.truth[len(recording.t) // 4, 2] > 0.01


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Patch(x=(1, 0), y=(0, 1), friction=0.1), "Patch.x = .1, 0.: must go from a smaller to a larger"),
        (lambda: Patch(x=(0, 1), y=(0, math.inf), friction=0.1), "Patch.y"),
        (lambda: Patch(x=(0, 1), y=(0, 1), friction=0), "Patch.friction = 0: must be positive"),
        (lambda: Patch(x=(0, 1, 2), y=(0, 1), friction=0.1), "Patch.x"),
        (lambda: dd.World(patches=("ice",)), "World.patches"),
        (lambda: dd.World(friction=math.nan), "World.friction"),
    ],
)
def test_bad_worlds_are_named(make, words):
    with pytest.raises(dd.DiffdriveError, match=words):
        make()
