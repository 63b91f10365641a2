"""How far robots can go on slopes: against the engine, closed forms, and mechanics a little beyond."""

import math

import mujoco
import numpy as np
import pytest
from helpers import refused
from hypothesis import given, settings
from hypothesis import strategies as st
from locked import center_of_mass, locked, slope

import diffdrive_mj as dd
from diffdrive_mj.errors import PhysicsWarning
from diffdrive_mj.physics.limits import largest_acceleration, needed_grip, steepest_slope
from diffdrive_mj.physics.mechanics import contact_forces
from diffdrive_mj.robot import presets

ROBOTS = {name: dd.Robot.load(name) for name in presets()}
STILL = dd.Commands(0.01, np.zeros((100, 2)))
HEADINGS = st.floats(-math.pi, math.pi)


def on(angle, direction=0.0, **fields):
    return dd.World(slope={"angle": angle, "direction": direction}, **fields)


@pytest.mark.parametrize("friction", [0.3, 0.5, 0.8])
@pytest.mark.parametrize("name", presets())
def test_facing_uphill_the_steepest_slope_is_that_of_the_closed_form(name, friction):
    robot = ROBOTS[name]
    assert math.tan(steepest_slope(robot, dd.World(friction=friction))) == pytest.approx(slope(robot, friction))


@pytest.mark.parametrize("name", presets())
def test_on_a_sticky_floor_a_robot_tips_where_its_weight_leaves_the_triangle_of_its_contacts(name):
    """Over the wheels facing downhill; over the line from a wheel to the caster with that side down."""
    robot = ROBOTS[name]
    (c, h), world = center_of_mass(robot), dd.World(friction=1e8)
    assert math.tan(steepest_slope(robot, world, math.pi)) == pytest.approx(-c / h)
    half, caster = robot.track_width / 2, -robot.caster.x
    edge = math.atan2(half, caster)  # of the line to the caster with the axis
    inside = (caster + c) * math.sin(edge)  # from the centre of mass to the line
    tangent = inside / h
    assert math.tan(steepest_slope(robot, world, math.pi / 2 - edge)) == pytest.approx(tangent)


@pytest.mark.parametrize("heading", [0.7, 1.57, -2.4])
@pytest.mark.parametrize("name", ["matched", "optiodom", "turtlebot3_burger"])
def test_braked_robots_hold_on_the_slope_that_statics_allows_and_on_none_steeper(name, heading):
    """At an angle to the slope; the engine tilts its gravity slowly, beside the robot rather than under it."""
    robot = ROBOTS[name]
    steepest = float(steepest_slope(robot, dd.World(friction=0.3), heading))
    for share, slides in ((0.99, False), (1.01, True)):
        model = locked(robot, 0.3, dd.Physics.sliding())
        data = mujoco.MjData(model)
        for ramp in np.linspace(0, 1, 750):
            angle = share * steepest * (3 - 2 * ramp) * ramp**2
            down = math.sin(angle)
            model.opt.gravity[:] = 9.81 * np.array(
                [-down * math.cos(heading), down * math.sin(heading), -math.cos(angle)]
            )
            mujoco.mj_step(model, data)
        before = data.qpos[:2].copy()
        mujoco.mj_step(model, data, nstep=500)
        moved = np.hypot(*(data.qpos[:2] - before))
        assert moved > 3e-4 if slides else moved < 3e-5


@given(HEADINGS, HEADINGS, st.floats(0.1, 1.5), st.sampled_from(sorted(ROBOTS)))
def test_only_the_heading_against_the_slope_counts(heading, direction, friction, name):
    robot = ROBOTS[name]
    turned = steepest_slope(robot, on(0.1, direction, friction=friction), heading)
    assert turned == pytest.approx(steepest_slope(robot, dd.World(friction=friction), heading - direction), abs=1e-9)
    moon = on(0.1, direction, friction=friction, gravity=1.62)
    assert steepest_slope(robot, moon, heading) == pytest.approx(turned, abs=1e-9)  # whatever the gravity


@settings(max_examples=50)
@given(HEADINGS, st.floats(0.02, 0.2), st.floats(0.3, 1.5), st.floats(1.0, 30.0), st.sampled_from(sorted(ROBOTS)))
def test_at_the_largest_acceleration_a_contact_is_at_its_limit(heading, angle, friction, gravity, name):
    robot, world = ROBOTS[name], on(angle, 1.0, friction=friction, gravity=gravity)

    def slack(acceleration):
        forces = [contact_forces(robot, (0, 0), (way * acceleration, 0.0), world, heading) for way in (1, -1)]
        return min(
            min(force.load.min(), (friction * force.load[:2] - force.pull).min()) / (robot.mass * gravity)
            for force in forces
        )

    limit = largest_acceleration(robot, world, heading)
    assert limit == 0 or slack(limit) == pytest.approx(0, abs=1e-9)
    assert slack(limit + 1e-3 * gravity) < 0
    assert limit == 0 or slack(0.99 * limit) > 0
    assert (limit > 0) == (slack(0.0) > 0)


def test_a_slow_turn_on_a_slope_needs_what_standing_there_needs_at_worst():
    robot, world = ROBOTS["optiodom"], on(0.15, 0.4)
    need, load = needed_grip(robot, dd.maneuvers.spin(robot, turns=1, yaw_rate=0.05, ramp=5.0), world, heading=2.0)
    still = contact_forces(robot, world=world, heading=np.linspace(0, 2 * math.pi, 2001))
    assert need == pytest.approx(still.friction_need.max(axis=0), rel=2e-3)
    assert load == pytest.approx(still.load.min() / (robot.mass * 9.81), rel=2e-3)


def test_a_slope_that_friction_does_not_allow_is_refused_with_what_is():
    robot = ROBOTS["optiodom"]
    words = ("World.slope.angle = 0.4 rad", "robot optiodom would slide down with friction 0.5", "World.friction")
    allowed = float(steepest_slope(robot, dd.World(friction=0.5), 1.2))
    with refused(ValueError, *words, "a start heading of 1.2 rad", f"at most {allowed:.4g} rad"):
        dd.simulate(robot, STILL, world=on(0.4, friction=0.5), start=(0, 0, 1.2))
    best = steepest_slope(robot, dd.World(friction=0.5), np.linspace(-math.pi, math.pi, 721)).max()
    with refused(ValueError, f"{best:.4g} rad is at"):
        dd.simulate(robot, STILL, world=on(0.4, friction=0.5))
    at_most = dd.simulate(robot, STILL, world=on(0.9 * best, friction=0.5), start=(0, 0, math.pi))
    assert at_most.drift(robot).final_position < 1e-6


def test_a_slope_on_which_a_robot_tips_is_refused_with_the_cure():
    robot = ROBOTS["turtlebot3_burger"]
    with refused(ValueError, "would tip over", "lower its centre of mass"):
        dd.simulate(robot, STILL, world=on(0.5), start=(0, 0, math.pi))
    laden = ROBOTS["matched"].replace(payload={"mass": 8.0, "x": -0.08, "height": 0.6})
    dd.simulate(laden, STILL)
    with refused(ValueError, "World.slope.angle = 0.2 rad", "would tip over"):
        dd.simulate(laden, STILL, world=on(0.2), start=(0, 0, math.pi))


def test_what_counts_is_the_floor_under_the_wheels():
    robot, ice = ROBOTS["matched"], dd.Patch(x=(4.0, 6.0), y=(-1.0, 1.0), friction=0.05)
    world = on(0.1, patches=(ice,))
    dd.simulate(robot, STILL, world=world)
    with refused(ValueError, "would slide down with friction 0.05"):
        dd.simulate([robot, robot], STILL, world=world, start=[(0, 0, 0), (5, 0, 0)])


@pytest.mark.parametrize("physics", [dd.Physics(), dd.Physics.sliding()])
@pytest.mark.parametrize("name", ["matched", "optiodom"])
def test_a_robot_that_begins_to_slide_on_the_way_says_so(name, physics):
    """It turns from where it stands to where it does not."""
    robot, around = ROBOTS[name], np.linspace(-math.pi, math.pi, 181)
    allowed = steepest_slope(robot, dd.World(friction=0.3), around)
    turn = dd.maneuvers.spin(robot, turns=1, yaw_rate=0.5)
    drive = {"physics": physics, "start": (0, 0, around[allowed.argmax()])}
    with pytest.warns(PhysicsWarning, match="slid"):
        slid = dd.simulate(robot, turn, world=on(1.05 * allowed.min(), friction=0.3), **drive)
    assert slid.drift(robot).max_position > 0.5
    with pytest.warns(PhysicsWarning, match="used 100 % of its friction"):  # one wheel alone, and the other holds
        held = dd.simulate(robot, turn, world=on(0.9 * allowed.min(), friction=0.3), **drive)
    assert held.drift(robot).max_position < 1e-4
    assert not any("slid" in event for event in held.events)


FOUR = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4, skid_steer={"wheelbase": 0.35})


@pytest.mark.parametrize("heading", [0.0, 0.8, math.pi / 2, -2.5])
def test_four_wheels_slide_all_at_once_whichever_way_the_robot_looks(heading):
    """The load moves downhill by the height of the centre of mass, and friction acts where the load does: tan = mu."""
    limit = steepest_slope(FOUR, dd.World(friction=0.3), heading)
    assert math.tan(limit) == pytest.approx(0.3)
    still = dd.simulate(FOUR, STILL, world=on(0.93 * limit, friction=0.3), start=(0, 0, heading))
    assert np.abs(still.truth[:, :2]).max() < 1e-3
    with refused(ValueError, "would slide down with friction 0.3"):
        dd.simulate(FOUR, STILL, world=on(1.01 * limit, friction=0.3), start=(0, 0, heading))


def test_four_wheels_tip_over_the_lower_axle():
    tall = FOUR.replace(center_of_mass_height=0.3)
    mass = tall.body_mass + 4 * tall.tyres.mass
    height = (tall.body_mass * 0.3 + 4 * tall.tyres.mass * 0.1) / mass
    ahead = tall.body_mass * tall.center_of_mass_x / mass
    limit = steepest_slope(tall, dd.World(friction=50.0), math.pi)
    assert math.tan(limit) == pytest.approx((0.35 / 2 - ahead) / height)
    with refused(ValueError, "would tip over", "lower its centre of mass"):
        dd.simulate(tall, STILL, world=on(1.05 * limit, friction=50.0), start=(0, 0, math.pi))
