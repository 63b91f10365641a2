"""Cables and thresholds: closed forms of rolling over them, what they do to odometry, and what is no way across."""

from __future__ import annotations

import math
import warnings

import mujoco
import numpy as np
import pytest
import strategies
from helpers import refused
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from physics.rolling import rolled_and_gone

import diffdrive_mj as dd
from diffdrive_mj.estimation import obstacles
from diffdrive_mj.judging.bumps import over_bumps
from diffdrive_mj.physics.model import compile_model
from diffdrive_mj.terrain import Cable

ROBOT = dd.Robot.load("matched")
R = ROBOT.mean_radius


def straight(robot=ROBOT, **options):
    return dd.maneuvers.straight(robot, **options)


def simulated(robot, commands, world, **options):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", dd.errors.PhysicsWarning)
        return dd.simulate(robot, commands, world=world, **options)


def across(x=0.4, height=0.005, **fields):
    return Cable(x=x, y=(-0.6, 0.6), height=height, **fields)


def beside_the_caster(x, height):
    """For the wheels alone."""
    return tuple(Cable(x=x, y=(side * 0.1, side * 0.6), height=height) for side in (1, -1))


def extra(recording):
    return float(recording.odometry(recording.robot)[-1, 0] - recording.truth[-1, 0])


def test_the_extra_distance_is_that_of_a_hub_that_swings_over_the_top():
    """In steps: the hub stays r + c from the top's centre and turns by its way over r."""
    r, h, c = 0.07, 0.013, 0.009
    half = math.sqrt((r + c) ** 2 - (r + c - h) ** 2)
    x = np.linspace(-half, half, 200_001)
    z = np.sqrt((r + c) ** 2 - x**2)
    way = np.hypot(np.diff(x), np.diff(z)).sum()
    assert obstacles.extra_distance(r, h, c) == pytest.approx(way - 2 * half, rel=1e-6)


def test_a_half_sunk_cable_has_the_textbook_form():
    r, h = 0.1, np.array([0.002, 0.005, 0.03])
    printed = 2 * (r + h) * np.arccos(r / (r + h)) - 2 * np.sqrt((r + h) ** 2 - r**2)
    np.testing.assert_allclose(obstacles.extra_distance(r, h, h), printed, rtol=1e-11)


@pytest.mark.parametrize("height", [0.002, 0.005])
@pytest.mark.parametrize("top", [0.5, 1.0, 5.0])
def test_a_slow_wheel_turns_as_far_as_theory_says(height, top):
    recording = dd.simulate(
        ROBOT, straight(speed=0.02, distance=0.8), world=dd.World(cables=(across(height=height, radius=top * height),))
    )
    assert extra(recording) == pytest.approx(obstacles.extra_distance(R, height, top * height), rel=0.015)
    rolled, gone = rolled_and_gone(recording)
    np.testing.assert_allclose(rolled, gone, atol=3e-5)


@pytest.mark.parametrize(("speed", "within"), [(0.05, 0.02), (0.1, 0.05), (0.2, 0.05), (0.3, 0.1)])
def test_faster_wheels_do_too_and_it_is_the_caster_that_slides_them(speed, within):
    drive, height = straight(speed=speed, distance=1.0), 0.005
    theory = obstacles.extra_distance(R, height, height / 2)
    alone = simulated(ROBOT, drive, dd.World(cables=beside_the_caster(0.4, height)))
    assert extra(alone) == pytest.approx(theory, rel=within)
    whole = simulated(ROBOT, drive, dd.World(cables=(across(height=height),)))
    assert extra(whole) > extra(alone) - 0.02 * theory
    if speed > 0.2:
        assert extra(whole) > 1.2 * theory  # a rigid ball that hits a cable stops the robot, and its wheels slide


@settings(max_examples=25)
@given(
    robot=strategies.robots,
    height=strategies.sizes(0.01, 0.12),
    top=st.sampled_from((0.5, 1.0, 3.0, 20.0)),
)
def test_any_robot_crosses_a_cable_as_theory_says(robot, height, top):
    """At a crawl, where friction suffices and it does not tip over its wheels on the way down."""
    r = robot.left_radius
    robot = robot.replace(right_radius=r)
    h = height * r
    c = top * h
    angle = float(obstacles.meeting_angle(r, h, c))
    ahead = abs(robot.body_mass * robot.center_of_mass_x / robot.mass)
    assume(r * math.sin(angle) < 0.6 * ahead)
    assume(h < 0.3 * robot.caster.radius)
    assume(h > 4e-4)  # in less, wheels sink in by a part that counts
    reach = (r + c) * math.sin(angle)
    drive = straight(robot, speed=math.sqrt(0.04 * 9.81 * h), distance=4 * reach + abs(robot.caster.x) + 0.2, ramp=0.2)
    cable = Cable(x=2 * reach + 0.1, y=(-1.0, 1.0), height=h, radius=c)
    recording = simulated(robot, drive, dd.World(cables=(cable,)))
    assert extra(recording) == pytest.approx(obstacles.extra_distance(r, h, c), rel=0.1)


@pytest.mark.parametrize(("y", "turn"), [((-0.6, -0.05), 1.0), ((0.05, 0.6), -1.0)])
def test_a_cable_under_one_wheel_turns_the_belief(y, turn):
    """To the left for the right wheel, which turns further; the robot itself turns to the right."""
    h = 0.005
    cable = Cable(x=0.4, y=y, height=h)
    recording = simulated(ROBOT, straight(speed=0.05, distance=0.8), dd.World(cables=(cable,)))
    off = recording.odometry(ROBOT)[-1, 2] - recording.truth[-1, 2]
    assert off == pytest.approx(turn * obstacles.extra_distance(R, h, h / 2) / ROBOT.track_width, rel=0.03)


def test_bumps_under_the_right_wheel_are_what_judging_predicts_without_physics():
    h, count, spacing = 0.003, 4, 0.15
    cables = tuple(Cable(x=0.3 + k * spacing, y=(-0.6, -0.05), height=h, radius=h / 2) for k in range(count))
    recording = simulated(ROBOT, straight(speed=0.05, distance=1.2), dd.World(cables=cables))
    drive = dd.Drive(recording.t, recording.wheel_angles, recording.truth)
    # A thin edge, where the cables are round: what they differ by is known.
    rounder = obstacles.extra_distance(R, h, h / 2) / obstacles.extra_distance(R, h)
    predicted = over_bumps(drive, ROBOT, height=h, first=0.25, spacing=spacing, count=count)
    believed = recording.odometry(ROBOT)[-1]
    turned = recording.truth[-1, 2] - believed[2]
    assert turned == pytest.approx(rounder * (predicted.truth[-1, 2] - believed[2]), rel=0.05)


@pytest.mark.parametrize("friction", [0.3, 0.6, 1.0])
@pytest.mark.parametrize(("share", "climbs"), [(0.95, True), (1.15, False)])
def test_friction_decides_how_high_wheels_climb(friction, share, climbs):
    """Cables with h = 2 c: (r + h / 2) times what a sharp edge has per radius."""
    steep = obstacles.highest_climb(1.0, friction)
    height = share * steep * R / (1 - steep / 2)
    world = dd.World(friction=friction, cables=beside_the_caster(0.3, float(height)))
    recording = simulated(ROBOT, straight(speed=0.03, distance=0.6), world, on_fall="record")
    reached = recording.truth[:, 0].max()
    stuck = any("got stuck" in event for event in recording.events)
    assert (reached > 0.4) == climbs == (not stuck)
    if stuck:
        # Where the wheel's front meets the cable it has stopped.
        angle = float(obstacles.meeting_angle(R, height, height / 2))
        met = 0.3 - (R + height / 2) * math.sin(angle)
        at = recording.truth[np.searchsorted(recording.t, recording.grip.stuck_time), 0]
        assert abs(at - met) < 0.01


def test_a_fast_wheel_hops_and_a_slow_one_does_not():
    fast = simulated(ROBOT, straight(speed=0.8, distance=1.5), dd.World(cables=beside_the_caster(0.8, 0.005)))
    slow = simulated(ROBOT, straight(speed=0.02, distance=0.5), dd.World(cables=beside_the_caster(0.3, 0.002)))
    assert fast.lift
    assert any("off the floor" in event for event in fast.events)
    assert not slow.lift
    assert slow.events == ()


def test_wheels_on_a_cable_use_their_friction_and_are_not_off_the_floor():
    """At the steepest place a slow wheel needs the tangent of the meeting angle."""
    h = 0.004
    recording = dd.simulate(
        ROBOT, straight(speed=0.02, distance=0.6), world=dd.World(cables=beside_the_caster(0.3, h), friction=0.9)
    )
    need = math.tan(float(obstacles.meeting_angle(R, h, h / 2))) / 0.9
    assert ((need < recording.friction_use) & (recording.friction_use < 1.1 * need)).all()  # it speeds up again, too
    assert not recording.lift


def test_ice_around_a_cable_keeps_wheels_from_climbing_it():
    ice = dd.Patch(x=(0.2, 0.6), y=(-1.0, 1.0), friction=0.05)
    drive, cables = straight(speed=0.03, distance=0.7), beside_the_caster(0.4, 0.005)
    gripping = simulated(ROBOT, drive, dd.World(cables=cables))
    slipping = simulated(ROBOT, drive, dd.World(cables=cables, patches=(ice,)))
    assert gripping.truth[-1, 0] > 0.6
    assert slipping.truth[:, 0].max() < 0.4
    assert any("got stuck" in event for event in slipping.events)


def test_a_cable_out_of_the_way_changes_no_bit():
    drive = straight(speed=0.5, distance=0.5)
    alone = dd.simulate(ROBOT, drive)
    beside = dd.simulate(ROBOT, drive, world=dd.World(cables=(across(x=5.0),)))
    for name in ("truth", "wheel_angles"):
        np.testing.assert_array_equal(getattr(alone, name), getattr(beside, name))


def test_a_cable_lies_in_the_world_wherever_robots_start():
    """Three start at three places, one of them turned around; alone or together is the same."""
    starts = [(0.0, 0.0, 0.0), (0.1, 0.3, 0.0), (1.0, 0.0, math.pi)]
    world, drive = dd.World(cables=(across(x=0.5),)), straight(speed=0.1, distance=0.9)
    together = simulated([ROBOT] * 3, drive, world, start=starts)
    for k, start in enumerate(starts):
        alone = simulated(ROBOT, drive, world, start=start)
        np.testing.assert_array_equal(alone.truth, together.truth[k])
        forward = math.cos(start[2])
        on_top = alone.truth[np.argmax(alone.height), 0]
        assert on_top == pytest.approx(0.5, abs=0.005)
        gone = forward * (alone.truth[-1, 0] - start[0])
        assert 0.9 - gone == pytest.approx(obstacles.extra_distance(R, 0.005, 0.0025), rel=0.05)


def test_how_a_drive_is_cut_into_calls_does_not_change_a_bit():
    world = dd.World(cables=(Cable(x=0.3, y=(0.0, 0.6), height=0.005),))
    drive = straight(speed=0.2, distance=0.5)
    at_once = simulated(ROBOT, drive, world)
    rows = iter(drive.wheel_rates)
    loop = dd.ClosedLoop(lambda t, angles: next(rows), drive.period, drive.duration)
    np.testing.assert_array_equal(at_once.truth, simulated(ROBOT, loop, world).truth)


def test_the_midpoint_rule_stays_as_near_to_the_engine_as_half_a_turn_of_a_step():
    world = dd.World(cables=(Cable(x=0.3, y=(0.05, 0.6), height=0.01), Cable(x=0.5, y=(-0.6, 0.6), height=0.005)))
    drive = dd.maneuvers.arc(ROBOT, speed=0.3, radius=0.8, distance=1.2)
    midpoint, engine = (
        simulated(ROBOT, drive, world, sample_rate=500.0, physics=dd.Physics(truth=truth))
        for truth in ("midpoint", "engine")
    )
    np.testing.assert_array_equal(midpoint.wheel_angles, engine.wheel_angles)
    apart = np.hypot(*(midpoint.truth - engine.truth)[1:, :2].T)
    step = np.abs(np.diff(engine.truth, axis=0))
    allowed = np.cumsum(np.hypot(step[:, 0], step[:, 1]) * step[:, 2] / 2)
    assert apart[-1] > 1e-4
    assert (apart <= 1.001 * allowed + 1e-12).all()


def test_what_is_no_way_across_is_refused():
    with refused(ValueError, "stands on World.cables[1]", "start it beside it"):
        dd.simulate(ROBOT, straight(distance=0.1), world=dd.World(cables=(across(), across(x=0.02))))
    with refused(ValueError, "World.cables[0].height = 0.2 m", "at its hub or above", "below 0.2 m"):
        dd.simulate(ROBOT, straight(distance=0.1), world=dd.World(cables=(across(height=0.2),)))


def test_a_robot_that_turns_on_the_spot_or_rests_is_not_stuck():
    for commands in (dd.maneuvers.spin(ROBOT), straight(distance=0.5, rest=3.0), straight(speed=1e-3, distance=5e-3)):
        assert dd.simulate(ROBOT, commands).events == ()


@pytest.mark.parametrize("speed", [0.2, 0.3])
def test_a_robot_that_turns_back_is_not_stuck(speed):
    """Over the second about the turn its wheels come back to where they were, and it does."""
    rate = speed / R
    rates = np.concatenate([np.linspace(0, rate, 50), np.full(250, rate), np.linspace(rate, -rate, 100)])
    rates = np.concatenate([rates, np.full(200, -rate)])
    assert dd.simulate(ROBOT, dd.Commands(0.01, np.stack([rates, rates], axis=-1))).events == ()


def test_a_robot_that_turns_and_gets_nowhere_is_stuck():
    """On ice the wheels spin; the servo follows, and the robot does not."""
    ice = dd.World(friction=1e-3)
    recording = simulated(ROBOT, straight(speed=0.5, distance=1.0), ice)
    assert recording.grip.stuck_time < 0.5
    assert recording.events[0].endswith(f"got stuck at {recording.grip.stuck_time:.4g} s")


ROUGH = {"x": (-3.0, 3.0), "y": (-2.0, 2.0), "rms": 0.003, "wavelength": 0.6, "level": 0.4}


@pytest.mark.parametrize("seed", [0, 5, 11])
def test_on_a_rough_floor_a_cable_is_as_high_above_it_as_it_says(seed):
    """Its top, as the rays of the engine find it, against the floor without it."""
    rough, height = {**ROUGH, "seed": seed}, 0.004
    cable = Cable(x=(0.9, 1.4), y=(-1.5, 1.6), height=height)
    model = compile_model(ROBOT, world=dd.World(rough=rough, cables=(cable,)))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    places = np.linspace((cable.x[0], cable.y[0]), (cable.x[1], cable.y[1]), 301)
    hit = np.zeros(1, np.int32)
    tops = [1 - mujoco.mj_ray(model, data, (*place, 1.0), (0.0, 0.0, -1.0), None, 1, -1, hit) for place in places]
    np.testing.assert_allclose(tops - dd.RoughFloor(**rough).height_at(places), height, atol=0.05 * height)


def test_a_cable_on_a_rough_floor_costs_what_it_costs_on_a_level_one():
    """What it adds to the drive over the same floor without it."""
    height = 0.004
    drive = straight(speed=0.02, distance=1.2)
    for seed in (1, 2):
        world = dd.World(rough={**ROUGH, "rms": 0.002, "seed": seed})
        with_it = world.replace(cables=beside_the_caster(0.9, height))
        added = extra(simulated(ROBOT, drive, with_it)) - extra(simulated(ROBOT, drive, world))
        assert added == pytest.approx(obstacles.extra_distance(R, height, height / 2), rel=0.15)


def test_the_cable_that_a_robot_stands_on_is_named_on_a_rough_floor_too():
    cables = (across(x=2.0), Cable(x=(-2.0, 2.0), y=0.2, height=0.005))
    with refused(ValueError, "stands on World.cables[1]; start it beside it"):
        dd.simulate(ROBOT, straight(distance=0.1), world=dd.World(rough=ROUGH, cables=cables))


def test_pieces_are_few_where_a_floor_is_smooth():
    rough = dd.RoughFloor(**ROUGH)
    assert len(Cable(x=(-500.0, -5.0), y=0.0, height=0.005).course(rough)) == 2
    assert len(Cable(x=0.0, y=(-0.3, 0.3), height=0.005).course(rough)) == 2
    assert len(Cable(x=(-2.0, 2.0), y=1.0, height=0.005).course(rough)) > 10
