"""Rough floors: the waves that they are made of, what they do to odometry, and their edge."""

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest
from helpers import refused
from physics.rolling import rolled_and_gone

import diffdrive_mj as dd
from diffdrive_mj.robot import presets
from diffdrive_mj.terrain import Cable, RoughFloor

ROBOT = dd.Robot.load("matched")


def floor(**fields):
    return RoughFloor(**{"x": (-1.0, 3.0), "y": (-1.5, 1.5), "rms": 0.002, "wavelength": 0.2, **fields})


def simulated(robot, commands, world, **options):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", dd.errors.PhysicsWarning)
        return dd.simulate(robot, commands, world=world, **options)


def straight(robot=ROBOT, **options):
    return dd.maneuvers.straight(robot, **options)


def test_the_seed_decides_every_bit():
    same, other = floor(seed=3), floor(seed=4)
    np.testing.assert_array_equal(floor(seed=3).grid[2], same.grid[2])
    assert np.abs(same.grid[2] - other.grid[2]).max() > same.rms


def test_heights_and_slopes_are_those_of_waves_that_run_all_ways():
    """RMS height s and slope s 2 pi / wavelength, away from the start and the edges."""
    heights, slopes = [], []
    for seed in range(8):
        x, y, z = floor(seed=seed, x=(-4.0, 4.0), y=(-4.0, 4.0), wavelength=0.3, level=0.1).grid
        inner = np.s_[len(y) // 8 : len(y) // 8 * 3, len(x) // 8 : -len(x) // 8]
        heights.append((z[inner] ** 2).mean())
        slopes.append(sum((g[inner] ** 2).mean() for g in np.gradient(z, y, x)))
    assert math.sqrt(np.mean(heights)) == pytest.approx(0.002, rel=0.1)
    assert math.sqrt(np.mean(slopes)) == pytest.approx(0.002 * 2 * math.pi / 0.3, rel=0.1)


def test_it_is_level_where_robots_start_and_comes_down_to_the_smooth_floor_at_its_edge():
    rough = floor(start=(0.5, 0.2), level=0.4)
    around = np.linspace(0, 2 * np.pi, 50)
    circle = np.array((0.5, 0.2)) + 0.38 * np.stack([np.cos(around), np.sin(around)], axis=-1)
    np.testing.assert_array_equal(rough.height_at(circle), 0.0)
    x, y, z = rough.grid
    for edge in (z[0], z[-1], z[:, 0], z[:, -1]):
        np.testing.assert_allclose(edge, -rough.depth)
    assert rough.height_at((99.0, 0.0)) == pytest.approx(-rough.depth)
    j, i = 20, 30
    assert rough.height_at((x[i], y[j])) == pytest.approx(z[j, i])
    assert np.abs(z).max() == pytest.approx(rough.depth)


@pytest.mark.parametrize(("speed", "within"), [(0.05, 1.5e-4), (0.3, 2e-4)])
@pytest.mark.parametrize("rms", [0.001, 0.002, 0.003])
def test_wheels_roll_on_it(rms, speed, within):
    """Within parts of the 2.5 m, with what the facets of the field cost."""
    recording = simulated(ROBOT, straight(speed=speed, distance=2.5), dd.World(rough=floor(rms=rms)))
    rolled, gone = rolled_and_gone(recording)
    np.testing.assert_allclose(rolled, gone, rtol=within)
    assert recording.upright


def test_odometry_counts_the_way_up_and_down():
    """Long waves, which wheels follow: half the mean square of the slope along their tracks, integrated."""
    rough = floor(x=(-1.0, 6.0), rms=0.008, wavelength=0.6, seed=2)
    recording = simulated(ROBOT, straight(speed=0.1, distance=4.0), dd.World(rough=rough))
    truth, half = recording.truth, ROBOT.track_width / 2
    across = np.stack([-np.sin(truth[:, 2]), np.cos(truth[:, 2])], axis=-1) * half
    rolled, _ = rolled_and_gone(recording)
    for side, turned in zip((1, -1), rolled, strict=True):
        track = truth[:, :2] + side * across
        step = np.hypot(*np.diff(track, axis=0).T)
        moved = step > 1e-6
        rise = np.diff(rough.height_at(track))[moved]
        counted = (rise**2 / step[moved] / 2).sum()
        assert turned - step.sum() == pytest.approx(counted, rel=0.1)
        assert counted > 5e-3


def test_a_robot_that_leaves_it_is_noticed_and_goes_on_as_low_as_its_hollows():
    rough = floor(x=(-1.0, 1.5))
    recording = simulated(ROBOT, straight(speed=0.3, distance=2.5), dd.World(rough=rough))
    assert np.interp(recording.grip.edge_time, recording.t, recording.truth[:, 0]) == pytest.approx(1.5, abs=0.005)
    assert any("left the rough floor at" in event for event in recording.events)
    assert recording.height[-1] - recording.height[0] == pytest.approx(-rough.depth, abs=1e-5)
    assert recording.upright
    stays = simulated(ROBOT, straight(speed=0.3, distance=1.0), dd.World(rough=rough))
    assert np.isnan(stays.grip.edge_time)


@pytest.mark.parametrize("name", presets())
@pytest.mark.parametrize("rms", [0.0007, 0.0015])
def test_fields_with_crests_of_two_to_five_millimetres_are_stable(name, rms):
    robot = dd.Robot.load(name)
    world = dd.World(rough=floor(rms=rms))
    recording = simulated(robot, straight(robot, speed=3 * robot.mean_radius, distance=2.0), world)
    assert recording.upright
    follows = world.rough.height_at(recording.truth[:, :2])
    assert np.abs(recording.height - recording.height[0] - follows).max() < 5 * rms
    assert recording.drift(robot).max_position < 0.1


def test_a_robot_whose_belly_touches_says_so():
    """Crests as high as what this one has under it."""
    robot = dd.Robot.load("turtlebot3_burger")
    recording = simulated(robot, straight(robot, distance=2.0, speed=0.1), dd.World(rough=floor(rms=0.005, seed=1)))
    assert any("its chassis touched the ground at" in event for event in recording.events)


def test_robots_start_on_its_level_part():
    drive = straight(distance=0.1)
    with refused(ValueError, "robot 1 (matched)", "outside the level circle", "larger level"):
        simulated([ROBOT] * 2, drive, dd.World(rough=floor()), start=[(0, 0, 0), (0.48, 0, 0)])
    moved = simulated(ROBOT, drive, dd.World(rough=floor(start=(0.4, 0.0))), start=(0.4, 0.0, 0.5))
    assert moved.events == ()


@pytest.mark.parametrize("fields", [{"x": (-0.25, 2.5)}, {"start": (10.0, 10.0)}])
def test_robots_start_away_from_its_edge(fields):
    """Where the level circle runs into the edge, or lies beyond it, the floor under them is lower."""
    floor = RoughFloor(**{"x": (-1.0, 2.0), "y": (-1.0, 1.0), "rms": 0.002, "wavelength": 0.3, **fields})
    robot = dd.Robot.load("matched")
    with refused(ValueError, "robot 0 (matched)", "rough floor's edge", "larger x or y"):
        dd.simulate(
            robot, dd.maneuvers.straight(robot, distance=0.1), world=dd.World(rough=floor), start=(*floor.start, 0.0)
        )


def test_a_level_part_costs_little():
    """What the facets of a field without waves cost: a tenth of a millimetre a metre."""
    recording = simulated(ROBOT, straight(speed=0.2, distance=2.0), dd.World(rough=floor(level=10.0)))
    assert recording.drift(ROBOT).max_position_per_metre < 2e-4


def test_cables_and_slopes_go_with_it():
    world = dd.World(
        rough=floor(),
        cables=(Cable(x=1.0, y=(-1.0, 1.0), height=0.008),),
        slope={"angle": 0.05},
        friction=0.8,
    )
    recording = simulated(ROBOT, straight(speed=0.1, distance=1.5), world)
    assert recording.upright
    assert recording.truth[-1, 0] > 1.4
