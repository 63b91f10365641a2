"""Any robot as an MJCF file: what plain MuJoCo reads from it, and how it drives."""

import re
import xml.etree.ElementTree as ET

import mujoco
import numpy as np
import pytest
from helpers import refused
from hypothesis import HealthCheck, given, settings
from strategies import laden_robots

import diffdrive_mj as dd
from diffdrive_mj.errors import DiffdriveError
from diffdrive_mj.physics.limits import largest_acceleration
from diffdrive_mj.physics.mechanics import contact_forces
from diffdrive_mj.physics.mjcf import to_mjcf
from diffdrive_mj.physics.model import compile_model
from diffdrive_mj.physics.tilt import level_twin
from diffdrive_mj.robot import presets

RIGID = dd.Robot.load("mismatched").replace(axle="rigid", name="rigid")
FRONT = dd.Robot.load("matched").replace(caster={"x": 0.2}, center_of_mass_x=0.06, name="caster in front")
ROBOTS = [*(dd.Robot.load(name) for name in presets()), RIGID, RIGID.replace(servo={"law": "P"}), FRONT]
NUMBERS = {
    "body": ("pos", "quat", "ipos", "iquat", "mass", "inertia"),
    "geom": ("type", "pos", "quat", "size", "contype", "conaffinity", "group"),
    "jnt": ("type", "pos", "axis"),
    "pair": ("dim", "friction", "solref", "solreffriction", "solimp", "margin", "gap"),
    "dof": ("armature", "damping", "frictionloss"),
    "sensor": ("type", "objid", "refid", "dim", "adr"),
}


def read(robot, physics=dd.Physics()):
    return mujoco.MjModel.from_xml_string(to_mjcf(robot, physics))


def driven(model, seconds=4.0):
    """The data at the end of some time of the keyframe "straight"."""
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("straight").id)
    mujoco.mj_step(model, data, nstep=round(seconds / model.opt.timestep))
    return data


@pytest.mark.parametrize("physics", [dd.Physics(), dd.Physics.sliding(), dd.Physics.mujoco_defaults()])
@pytest.mark.parametrize("robot", ROBOTS, ids=lambda robot: robot.name)
def test_its_numbers_are_those_of_the_package_to_six_digits(robot, physics):
    written, ours = read(robot, physics), compile_model(robot, physics)
    for kind, fields in NUMBERS.items():
        for field in fields:
            mine, other = (getattr(model, f"{kind}_{field}") for model in (ours, written))
            # What the compiler derives from rounded numbers, a quaternion's small parts, has six digits of the largest.
            np.testing.assert_allclose(other, mine, rtol=5e-6, atol=1e-6 * np.abs(mine).max())
    for field in ("timestep", "integrator", "cone", "impratio", "solver", "tolerance", "gravity", "disableflags"):
        assert np.array_equal(getattr(written.opt, field), getattr(ours.opt, field)), field


@pytest.mark.parametrize("robot", ROBOTS, ids=lambda robot: robot.name)
def test_it_drives_straight_from_the_keyframe(robot):
    speed = 1.5 * robot.mean_radius / 0.0955
    model = read(robot)
    data = driven(model)
    x, y = data.qpos[:2]
    heading = 2 * np.arctan2(data.qpos[6], data.qpos[3])
    assert data.qvel[0] == pytest.approx(speed, rel=1e-4)
    assert 3 * speed < x < 4 * speed
    # A tilted robot's centre of mass is not on its middle line, so that it turns a little while it speeds up.
    assert abs(heading) < (2e-3 if robot.axle == "rigid" else 5e-5)
    assert abs(y) < (2e-3 if robot.axle == "rigid" else 5e-5) * x
    twin = level_twin(robot)
    np.testing.assert_allclose(model.key("straight").ctrl * (twin.left_radius, twin.right_radius), speed, rtol=1e-5)
    np.testing.assert_allclose(model.actuator_ctrlrange[:, 1], 2 * model.key("straight").ctrl, rtol=1e-5)
    np.testing.assert_allclose(model.actuator_ctrlrange[:, 0], -model.actuator_ctrlrange[:, 1])


@pytest.mark.parametrize("robot", ROBOTS, ids=lambda robot: robot.name)
def test_a_servo_at_its_limit_accelerates_at_half_of_what_the_contacts_hold(robot):
    data = driven(read(robot), 0.1)
    at, model = data.qvel[0], read(robot)
    data = driven(model, 0.12)
    assert np.abs(data.actuator_force) == pytest.approx(model.actuator_forcerange[:, 1])
    assert (data.qvel[0] - at) / 0.02 == pytest.approx(largest_acceleration(robot) / 2, rel=2e-3)


@pytest.mark.parametrize("friction", [0.2, 1.0])
@pytest.mark.parametrize("robot", ROBOTS, ids=lambda robot: robot.name)
def test_at_the_largest_acceleration_a_contact_is_at_its_limit(robot, friction):
    def slack(acceleration):
        forces = [contact_forces(robot, acceleration=(way * acceleration, 0.0)) for way in (1, -1)]
        return min(
            min(force.load.min(), (friction * force.load[:2] - force.pull).min()) / (robot.mass * 9.81)
            for force in forces
        )

    limit = largest_acceleration(robot, dd.World(friction=friction))
    assert slack(limit) == pytest.approx(0, abs=1e-12)
    assert slack(0.99 * limit) > 0 > slack(1.01 * limit)


def test_the_head_says_which_robot_it_is_and_how_exact():
    head = to_mjcf(dd.Robot.load("ct_bot")).split("-->")[0]
    for words in ("ct_bot", "0.02835", "0.0972", "six digits", "MjSpec", "slider"):
        assert words in head


@pytest.mark.parametrize("name", ["<a> & \"b\" 'c'", "--", "a---b-", "new\nline", "\x1b[31mred", "\ud800", "名前", ""])
def test_any_name_leaves_a_file_that_parses(name):
    robot = dd.Robot.load("ct_bot").replace(name=name)
    text = to_mjcf(robot)
    assert ET.fromstring(text.encode("utf-8")).get("model") == "".join(c for c in name if c.isprintable())
    assert read(robot).nu == 2
    assert re.search(r"<!--\s.*radii 0.02835 and 0.02835 m", text)


@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(laden_robots)
def test_any_robot_is_written_or_refused(robot):
    try:
        compile_model(robot)
    except DiffdriveError:
        return
    assert read(robot).nkey == 2


def test_a_robot_that_cannot_stand_or_believes_in_a_gain_is_refused():
    robot = dd.Robot.load("ct_bot")
    with refused(ValueError, "Robot.turning_gain"):
        to_mjcf(robot.replace(turning_gain=0.1))
    with refused(ValueError, "robot ct_bot: MuJoCo cannot build it (mass and inertia"):
        to_mjcf(robot.replace(tyres={"mass": 1e-20}))


@pytest.mark.parametrize(("name", "shown"), [("a-b", "a-b"), ("a--b---c", "a-b-c"), ("--", "-")])
def test_dashes_in_a_name_do_not_end_the_comment(name, shown):
    text = to_mjcf(dd.Robot.load("matched").replace(name=name))
    assert f" {shown}: radii 0.1 and 0.1 m" in text


def test_an_older_reader_knows_every_attribute():
    """`input` of an actuator is younger than the rest."""
    assert " input=" not in dd.to_mjcf(dd.Robot.load("mismatched"))


GARDEN = dd.World(friction=0.5, gravity=3.7, slope={"angle": 0.1, "direction": 2.0})


@pytest.mark.parametrize("robot", ROBOTS, ids=lambda robot: robot.name)
def test_a_world_is_in_the_file_and_its_robot_stays_where_it_is_put(robot):
    """The file's servos have no integral part: on a slope it rolls down as slowly as their damping lets it."""
    written, ours = mujoco.MjModel.from_xml_string(to_mjcf(robot, world=GARDEN)), compile_model(robot, world=GARDEN)
    np.testing.assert_allclose(written.opt.gravity, ours.opt.gravity, rtol=1e-5)
    assert np.linalg.norm(written.opt.gravity) == pytest.approx(3.7, rel=1e-5)
    np.testing.assert_allclose(written.pair("left_floor").friction[:2], 0.5)
    data = mujoco.MjData(written)
    mujoco.mj_step(written, data, nstep=1000)
    assert np.hypot(*data.qpos[:2]) < 0.02 * robot.mean_radius / 0.1
    assert data.qpos[2] == pytest.approx(written.qpos0[2], abs=1e-6)
    mujoco.mj_resetDataKeyframe(written, data, written.key("straight").id)
    mujoco.mj_step(written, data, nstep=2000)
    assert data.qpos[0] > 3 * robot.track_width
