"""From a setting to a drive: where the commands lead, which physics, and what of the model reaches the page."""

import dataclasses
import math

import mujoco
import numpy as np
import pytest
from helpers import refused

import diffdrive_mj as dd
from diffdrive_mj.physics.limits import needed_grip
from diffdrive_mj.physics.model import compile_model
from diffdrive_mj.play.drives import LONGEST, MANEUVERS, plan
from diffdrive_mj.play.setting import Setting

MATCHED = dd.Robot.load("matched")
ROBOTS = {"matched": MATCHED}
OPENING = Setting.of(MATCHED)


def planned(**changes):
    return plan(dataclasses.replace(OPENING, **changes), ROBOTS)


def led(drive):
    """Where the commands lead the robot that they are computed for."""
    turned = np.cumsum(np.vstack([(0.0, 0.0), drive.commands.wheel_rates]), axis=0) * drive.commands.period
    return dd.odometry.integrate(turned, drive.believed)


def test_the_left_wheel_turns_k_times_as_fast():
    rates = planned(k=0.8, right_rate=12.0).commands.wheel_rates
    assert rates.max(axis=0) == pytest.approx([9.6, 12.0])
    assert np.allclose(rates[:, 0], 0.8 * rates[:, 1])


@pytest.mark.parametrize(
    ("maneuver", "end", "turned"),
    [
        ("straight", (15.0, 0.0), 0.0),
        ("circle", (0.0, 0.0), 2 * math.pi),
        ("square", (0.0, 0.0), 2 * math.pi),
        ("figure_eight", (0.0, 0.0), 0.0),
        ("slalom", None, 0.0),
        ("spin", (0.0, 0.0), 1.5 / 0.2 * 10),
    ],
)
def test_maneuvers_are_computed_for_the_believed_robot(maneuver, end, turned):
    drive = planned(maneuver=maneuver, speed=1.5, seconds=10.0)
    path = led(drive)
    assert path[-1, 2] == pytest.approx(turned, abs=1e-9)
    if end is not None:
        assert path[-1, :2] == pytest.approx(end, abs=1e-9)
    assert drive.believed.right_radius == 0.091
    assert drive.true.right_radius == 0.1


def test_every_maneuver_is_driven():
    assert {"straight", "circle", "square", "figure_eight", "slalom", "spin", "k"} == set(MANEUVERS)


def test_what_a_robot_was_given_stays():
    robot = MATCHED.replace(name="mine", body_mass=7.0, caster={"x": -0.15})
    drive = plan(dataclasses.replace(Setting.of(robot), left_radius=0.09), {"mine": robot})
    assert (drive.true.body_mass, drive.true.caster.x, drive.true.left_radius) == (7.0, -0.15, 0.09)


def test_where_the_floor_holds_too_little_the_physics_is_for_sliding():
    assert planned(friction=1.0).physics == dd.Physics()
    assert planned(friction=0.1).physics == dd.Physics.sliding()
    assert planned(friction=0.1).as_json()["turned_on"] == 0.0
    assert planned(friction=1.0).as_json()["turned_on"] == 0.5  # a step's displacement turns by half of its turn


def test_a_tenth_of_the_grip_is_kept_in_reserve():
    drive = planned()
    need = needed_grip(drive.true, drive.commands)[0].max()
    assert planned(friction=need / 0.92).physics == dd.Physics.sliding()
    assert planned(friction=need / 0.88).physics == dd.Physics()


def test_the_page_is_told_every_number_in_full():
    drive = planned(left_radius=0.1 / 3)
    told = drive.as_json()["model"]
    model = compile_model(drive.true, drive.physics)
    for name in ("qpos0", "body_mass", "body_inertia", "geom_size", "pair_margin", "actuator_gainprm", "dof_armature"):
        assert told["numbers"][name] == getattr(model, name).ravel().tolist()
    # What has no place in the numbers that are told must not matter: it is nothing, or for the eye.
    untold = {
        name for name in dir(model)
        if getattr(getattr(model, name), "dtype", None) == np.float64 and getattr(model, name).any()
    } - set(told["numbers"])  # fmt: skip
    assert all(name.startswith(("cam_", "light_", "bvh_")) for name in untold), untold
    assert told["option"]["impratio"] == 10.0
    assert told["statistic"]["meaninertia"] == model.stat.meaninertia


def test_the_structure_as_xml_is_the_same_model_in_six_digits():
    drive = planned()
    told = drive.as_json()["model"]
    model = mujoco.MjModel.from_xml_string(told["xml"])
    for name, values in told["numbers"].items():
        slack = 1e-12 + 1e-4 * np.abs(values).max()
        assert np.allclose(getattr(model, name).ravel(), values, rtol=1e-4, atol=slack), name
    assert "input=" not in told["xml"]  # which MuJoCo 3.14 does not know


def test_a_flat_body_survives_six_digits():
    """Its moments of inertia have A + B = C to seven digits, and MuJoCo reads none that have less."""
    ct_bot = dd.Robot.load("ct_bot")
    setting = dataclasses.replace(Setting.of(ct_bot), left_radius=0.5, right_radius=0.005, track_width=2.0)
    told = plan(setting, {"ct_bot": ct_bot}).as_json()["model"]
    model = mujoco.MjModel.from_xml_string(told["xml"])
    assert np.allclose(model.body_inertia.ravel(), told["numbers"]["body_inertia"], rtol=1e-4, atol=0)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"robot": "nobody"}, "unknown robot 'nobody'"),
        ({"maneuver": "loop"}, "unknown maneuver 'loop'"),
        ({"rate": 60.0}, "the interval 1 / rate = 0.0166667 s: must be a whole multiple of the time step = 0.002 s"),
        ({"right_rate": 100.0, "k": 5.0, "left_radius": 0.5, "right_radius": 0.5}, "too long, drive more slowly"),
        ({"maneuver": "square", "speed": 0.01, "believed_track_width": 2.0, "seconds": 60.0}, "must be at most 120 s"),
    ],
)
def test_what_cannot_be_driven_is_refused(changes, words):
    with refused(ValueError, words):
        planned(**changes)


def test_a_robot_that_cannot_stand_is_refused():
    tall = MATCHED.replace(name="tall", payload={"mass": 40.0, "x": -0.1, "y": 0.09, "height": 0.5})
    with refused(ValueError):
        plan(dataclasses.replace(Setting.of(tall), track_width=0.02), {"tall": tall}).as_json()


@pytest.mark.parametrize("part", [{"motor": {"stall_torque": 1.0}}, {"caster": {"kind": "swivel"}}])
def test_a_robot_that_the_page_cannot_drive_is_refused(part):
    robot = MATCHED.replace(name="other", **part)
    with refused(ValueError, "robot other", "simulate"):
        plan(Setting.of(robot), {"other": robot}).as_json()


def test_no_drive_takes_longer_than_it_may():
    for maneuver in MANEUVERS:
        drive = planned(maneuver=maneuver, seconds=60.0, speed=1.0)
        assert drive.commands.duration <= LONGEST
