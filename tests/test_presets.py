"""The presets, and the sources of their numbers and of the model's in models/README.md."""

import dataclasses
import math
import re
import tomllib
import xml.etree.ElementTree as ET

import mujoco
import numpy as np
import pytest

import diffdrive_mj as dd
from diffdrive_mj._resources import MODELS
from diffdrive_mj.grip import LARGEST_USE
from diffdrive_mj.physics import _probes
from diffdrive_mj.physics.mechanics import body_box
from diffdrive_mj.physics.model import XML, compile_model
from diffdrive_mj.physics.servo import servo_gains
from diffdrive_mj.robot import presets
from diffdrive_mj.sensors._gyro_grades import GRADES
from diffdrive_mj.solver import COARSEST_STEP

PRESETS = ("ct_bot", "matched", "mismatched", "optiodom", "turtlebot3_burger")
DEGREE = math.pi / 180
README = (MODELS / "README.md").read_text(encoding="utf-8")
REFERENCE = dd.Robot(left_radius=0.100, right_radius=0.091, track_width=0.400)
SCALED = {
    "tyres.width",
    "tyres.mass",
    "body_mass",
    "center_of_mass_x",
    "center_of_mass_height",
    "caster.x",
    "caster.radius",
    "motor.rotor_inertia",
}
PICTURE_ONLY = ("rgba", "rgb1", "rgb2", "diffuse", "ambient", "specular", "emission")

# Literal published figures: diameters or radii, and the distance between the wheels [m].
GEOMETRY = {
    "mismatched": (0.100, 0.091, 0.400),
    "matched": (0.100, 0.100, 0.400),
    "ct_bot": (0.0567 / 2, 0.0567 / 2, 0.0972),
    "optiodom": (0.084 / 2, 0.084 / 2, 0.200),
    "turtlebot3_burger": (0.033, 0.033, 0.160),
}


def table(heading):
    """The rows of the first table under a heading of the README, as dictionaries."""
    section = re.split(rf"^#+ {re.escape(heading)}$", README, flags=re.MULTILINE)[1]
    section = re.split(r"^#", section, flags=re.MULTILINE)[0]
    header, _, *rows = [
        [cell.strip() for cell in line[1:-1].split("|")] for line in section.splitlines() if line.startswith("|")
    ]
    assert rows
    assert all(len(row) == len(header) for row in rows)
    return [dict(zip(header, row, strict=True)) for row in rows]


def sourced(heading):
    """Field and value of every row; each has a source, and no field has two rows."""
    rows = table(heading)
    assert all(row["source"] for row in rows)
    fields = [row["field"] for row in rows]
    assert len(set(fields)) == len(fields)
    return {row["field"]: row["value"] for row in rows}


def same(cell, value):
    return cell == (value or "none") if value is None or isinstance(value, str) else float(cell) == value


def flat(nested):
    """The fields of nested mappings under dotted names."""
    found = {}
    for key, value in nested.items():
        found |= {f"{key}.{part}": v for part, v in value.items()} if isinstance(value, dict) else {key: value}
    return found


def toml(name):
    return flat(tomllib.loads((MODELS / "robots" / f"{name}.toml").read_text(encoding="utf-8")))


def test_the_presets_are_these():
    assert presets() == PRESETS


@pytest.mark.parametrize("name", PRESETS)
def test_a_preset_loads_and_has_the_published_geometry(name):
    robot = dd.Robot.load(name)
    assert robot.name == name
    assert (robot.left_radius, robot.right_radius, robot.track_width) == pytest.approx(GEOMETRY[name], rel=1e-15)


@pytest.mark.parametrize("name", PRESETS)
def test_a_preset_starts_with_a_comment(name):
    first, second, third = (MODELS / "robots" / f"{name}.toml").read_text(encoding="utf-8").splitlines()[:3]
    assert first.startswith("# ")
    assert not (second.startswith("#") and third.startswith("#"))


def test_presets_leave_no_size_to_scale_but_the_one_that_all_scale_from():
    for name in set(PRESETS) - {"mismatched"}:
        assert set(toml(name)) >= SCALED
    assert not SCALED & set(toml("mismatched"))


def test_k_of_the_reference_robot():
    robot = dd.Robot.load("mismatched")
    assert robot.radius_ratio == pytest.approx(0.91, rel=1e-15)
    assert dd.kinematics.compensated_right_radius(robot.left_radius, 0.91) == pytest.approx(robot.right_radius)
    matched = dd.Robot.load("matched")
    assert (matched.left_radius, matched.right_radius) == (0.100, 0.100)
    assert numbers_of(matched) == numbers_of(REFERENCE) | {"name": "matched", "right_radius": 0.100}
    assert robot == REFERENCE.replace(name="mismatched")


def test_ticks():
    robot = dd.Robot.load("ct_bot")
    tick = 2 * math.pi / robot.encoder.ticks_per_wheel_turn
    assert robot.left_radius * tick == pytest.approx(2.96881e-3, abs=5e-9)
    _, turn = dd.kinematics.body_twist((0, tick), robot)
    assert math.degrees(turn) == pytest.approx(1.750, abs=5e-4)
    assert dd.Robot.load("optiodom").encoder.ticks_per_wheel_turn == 2796.8
    assert dd.Robot.load("turtlebot3_burger").encoder.ticks_per_wheel_turn == 2**12


def test_turtlebot_weighs_what_its_parts_weigh():
    robot = dd.Robot.load("turtlebot3_burger")
    parts = {"base": (0.82573504, -0.032, 0.070), "lidar": (0.114, -0.020, 0.161), "caster": (0.005, -0.081, -0.004)}
    mass, x, z = np.array(list(parts.values())).T
    assert robot.body_mass == pytest.approx(mass.sum(), rel=1e-12)
    assert robot.mass == pytest.approx(1.0, rel=0.01)
    assert robot.center_of_mass_x == pytest.approx(mass @ x / mass.sum(), abs=5e-5)
    assert robot.center_of_mass_height == pytest.approx(mass @ z / mass.sum() + 0.010, abs=5e-5)


@pytest.mark.parametrize("name", PRESETS)
def test_every_number_of_a_preset_has_a_source_and_no_row_is_stale(name):
    rows, values = sourced(name), toml(name)
    assert rows.keys() == values.keys()
    wrong = {key: (rows[key], value) for key, value in values.items() if not same(rows[key], value)}
    assert not wrong


def test_every_number_of_the_reference_robot_has_a_source_and_no_row_is_stale():
    rows = sourced("The reference robot")
    values = numbers_of(REFERENCE)
    for key in ("name", "left_radius", "right_radius", "track_width"):
        del values[key]
    assert rows.keys() == values.keys()
    wrong = {key: (rows[key], value) for key, value in values.items() if not same(rows[key], value)}
    assert not wrong
    assert all(row["unit"] for row in table("The reference robot") if not isinstance(values[row["field"]], str))


def numbers_of(robot):
    return flat(dataclasses.asdict(robot))


@pytest.mark.parametrize("factor", [0.25, 0.5, 2.0])
def test_what_is_left_out_scales_as_the_readme_says(factor):
    def measured(radius, track):
        return numbers_of(dd.Robot(left_radius=0.1 * radius, right_radius=0.091 * radius, track_width=0.4 * track))

    powers = {"R": (1, 0), "b": (0, 1), "R^2 b": (2, 1), "caster.x": (0, 1), "M R^2": (4, 1)}
    rows = {row["field"]: powers[row["scales with"]] for row in table("What you leave out scales")}
    assert rows.keys() == SCALED
    before, larger, wider = measured(1, 1), measured(factor, 1), measured(1, factor)
    for field, (with_radius, with_track) in rows.items():
        assert larger[field] == pytest.approx(before[field] * factor**with_radius, rel=1e-12), field
        assert wider[field] == pytest.approx(before[field] * factor**with_track, rel=1e-12), field


def test_every_constant_of_the_xml_has_a_source_and_no_row_is_stale():
    rows = table("Constants of `diffdrive.xml`")
    assert all(row["source"] for row in rows)
    listed = [(row["element"], row["attribute"], row["value"]) for row in rows]
    assert len(set(listed)) == len(listed)
    root = ET.parse(XML).getroot()
    body = root.find("worldbody/body[@name='robot']")
    of_the_robot = {element for element in body.iter() if element.tag not in ("camera", "light")}
    present = {
        (element.tag, attribute, value)
        for element in root.iter()
        if element not in of_the_robot
        for attribute, value in element.attrib.items()
        if attribute not in PICTURE_ONLY and (element.tag in ("option", "flag") or is_numbers(value))
    }
    assert set(listed) == present


def is_numbers(text):
    return re.fullmatch(r"[-+0-9.e ]+", text) is not None


def test_every_constant_of_the_physics_has_a_source():
    rows = table("Constants of `diffdrive_mj/physics`")
    assert all(row["module"] and row["value"] and row["source"] for row in rows)
    values = {row["what"]: row["value"] for row in rows}
    robot = dd.Robot.load("matched")
    model = compile_model(robot)
    length, width, height = body_box(robot)
    assert 2 * model.geom("chassis").size == pytest.approx((length, width, height))
    assert values["mass per volume of a body"] == f"{robot.body_mass / (length * width * height):.0f} kg/m^3"
    assert values["gravity"] == f"{-model.opt.gravity[2]:g} m/s^2" == f"{dd.World().gravity:g} m/s^2"
    assert values["largest tilt of a robot that stands"] == f"{math.degrees(_probes._LARGEST_TILT):g} degrees"
    assert values["highest a robot may hop"] == f"{_probes._HIGHEST:g} m"
    assert values["share of the friction above which a wheel is said to slip"] == f"{LARGEST_USE:g}"
    assert values["coarsest time step"] == f"{COARSEST_STEP:g} s"


def test_the_robot_described_in_the_readme_loads_and_compiles(tmp_path):
    (example,) = re.findall(r"^```toml\n(.*?)^```$", README, flags=re.MULTILINE | re.DOTALL)
    path = tmp_path / "my_robot.toml"
    path.write_text(example, encoding="utf-8")
    robot = dd.Robot.load(path)
    assert robot.name == "my_robot"
    assert compile_model(robot).nu > 0


@pytest.mark.parametrize("name", PRESETS)
def test_a_preset_stands_still(name):
    robot = dd.Robot.load(name)
    rec = dd.simulate(robot, dd.Commands(0.01, np.zeros((100, 2))))
    assert rec.t[-1] == pytest.approx(1.0)
    rims = rec.wheel_angles * (robot.left_radius, robot.right_radius)
    assert np.abs(rec.truth[:, :2]).max() < 1e-6
    assert np.abs(rec.truth[:, 2]).max() * robot.track_width < 1e-6
    assert np.abs(rims).max() < 1e-6


@pytest.mark.parametrize("name", PRESETS)
def test_a_preset_drives_a_metre_and_its_odometry_agrees(name):
    robot = dd.Robot.load(name)
    rec = dd.simulate(robot, dd.maneuvers.straight(robot, speed=0.2, distance=1.0))
    drift = rec.drift(robot)
    assert rec.truth[-1, 0] == pytest.approx(1.0, abs=0.01)
    assert drift.max_position < 3e-6 * drift.distance


@pytest.mark.parametrize("name", PRESETS)
def test_a_preset_rests_on_both_wheels_and_the_caster(name):
    robot = dd.Robot.load(name)
    model = compile_model(robot)
    on_caster = robot.body_mass * robot.center_of_mass_x / robot.caster.x
    assert 0.05 * robot.mass < on_caster < 0.5 * robot.mass
    assert model.body("left_wheel").mass[0] * 2 + model.body("robot").mass[0] == pytest.approx(robot.mass)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    lowest = {g: data.geom(g).xpos[2] - model.geom(g).size[0] for g in ("left_tyre", "right_tyre", "caster")}
    assert all(abs(height) < 1e-12 for height in lowest.values())


@pytest.mark.parametrize("name", PRESETS)
def test_the_time_step_is_fine_enough_for_the_servos_of_a_preset(name):
    """The servo of the law s + w, as steep as asked, not as a coarse step allows: damping 2 w J, integral w^2 J."""
    robot = dd.Robot.load(name)
    for radius in (robot.left_radius, robot.right_radius):
        gains = servo_gains(robot, dd.Physics(), radius)
        assert 2 * gains.integral / gains.damping == pytest.approx(robot.servo.bandwidth, rel=1e-12)
        assert gains.feedforward == pytest.approx(gains.damping / 2, rel=1e-12)
        rim = robot.tyres.mass * radius**2 / 2 + gains.armature + robot.mass * radius**2 / 2
        assert gains.damping == pytest.approx(2 * robot.servo.bandwidth * rim, rel=1e-12)


def test_every_number_of_a_gyro_has_a_source_and_no_row_is_stale():
    said, gyro = {}, ""
    for row in table("Gyros"):
        gyro = row["gyro"].strip("`") or gyro
        said.setdefault(gyro, {}).update(zip(row["field"].split(", "), row["value"].split(", "), strict=False))
        assert row["source"]
    assert said.keys() == GRADES.keys()
    per = {"deg/s": DEGREE, "deg/s/sqrt(Hz)": DEGREE, "deg/sqrt(h)": DEGREE / 60, "deg/h": DEGREE / 3600, "%": 0.01}
    for name, fields in said.items():
        made = dd.Gyro.load(name)
        bottom = math.sqrt(2 * made.angle_random_walk * made.bias_random_walk / math.sqrt(3))
        noise = fields.get("noise") or fields["noise density"]
        for text, value in [
            (noise, made.angle_random_walk), (fields["in-run stability"], bottom), (fields["bias"], made.bias),
            (fields["scale"], made.scale_error), (fields["range"], made.range),
        ]:  # fmt: skip
            number, unit = text.split(" ", 1)
            assert float(number) * per[unit] == pytest.approx(value, rel=1e-9), (name, text)
