import dataclasses
import math
import pickle

import numpy as np
import pytest
from helpers import refused

import diffdrive_mj as dd
from diffdrive_mj.robot import presets

GEOMETRY = {"left_radius": 0.1, "right_radius": 0.091, "track_width": 0.4}
ROBOT = dd.Robot(**GEOMETRY)

NUMBERS = [field.name for field in dataclasses.fields(dd.Robot) if field.type == "float"]
SIGNED = ["center_of_mass_x", "caster_x", "turning_gain"]
MAY_BE_ZERO = ["rotor_inertia"]
POSITIVE = [name for name in NUMBERS if name not in (*SIGNED, *MAY_BE_ZERO)]


# Fields


def test_the_three_numbers_that_odometry_needs_are_enough():
    assert (ROBOT.left_radius, ROBOT.right_radius, ROBOT.track_width) == (0.1, 0.091, 0.4)
    for field in dataclasses.fields(dd.Robot):
        has_default = field.default is not dataclasses.MISSING
        assert has_default == (field.name not in GEOMETRY)


def test_derived_numbers():
    assert ROBOT.radius_ratio == pytest.approx(0.91)
    assert ROBOT.mean_radius == pytest.approx(0.0955)
    assert ROBOT.replace(body_mass=4, wheel_mass=0.3).mass == pytest.approx(4.6)


@pytest.mark.parametrize("field", [*POSITIVE, *MAY_BE_ZERO])
@pytest.mark.parametrize("value", [1, np.int64(1), np.float32(0.25)])
def test_numbers_become_floats(field, value):
    result = getattr(ROBOT.replace(**{field: value}), field)
    assert type(result) is float
    assert result == value


def test_places_become_floats():
    robot = ROBOT.replace(center_of_mass_x=np.float32(-0.25), caster_x=-1)
    assert (robot.center_of_mass_x, robot.caster_x) == (-0.25, -1.0)
    assert type(robot.center_of_mass_x) is type(robot.caster_x) is float


@pytest.mark.parametrize("field", POSITIVE)
@pytest.mark.parametrize("value", [0, -0.1, -math.inf])
def test_sizes_must_be_positive(field, value):
    with refused(ValueError, f"Robot.{field} = {value}", "must be"):
        ROBOT.replace(**{field: value})


@pytest.mark.parametrize("field", MAY_BE_ZERO)
def test_some_may_be_zero_but_not_less(field):
    assert getattr(ROBOT.replace(**{field: 0}), field) == 0
    with refused(ValueError, f"Robot.{field} = -1", "must not be negative"):
        ROBOT.replace(**{field: -1})


@pytest.mark.parametrize("field", NUMBERS)
@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_numbers_must_be_finite(field, value):
    with refused(ValueError, f"Robot.{field} = {value}", "must be finite"):
        ROBOT.replace(**{field: value})


@pytest.mark.parametrize("field", NUMBERS)
@pytest.mark.parametrize("value", ["0.1", None, True, [0.1], np.array([0.1]), 0.1j])
def test_numbers_must_be_numbers(field, value):
    with refused(TypeError, f"Robot.{field} = {value!r}", "must be a number"):
        ROBOT.replace(**{field: value})


@pytest.mark.parametrize(
    ("field", "value", "words"),
    [
        ("hanging", "coaxal", ("coaxial, level", "did you mean 'coaxial'?")),
        ("hanging", "sideways", ("coaxial, level",)),
        ("hanging", None, ("None", "coaxial, level")),
        ("servo_gains", "match", ("equal, matched", "did you mean 'matched'?")),
    ],
)
@pytest.mark.parametrize("builtin", [ValueError, KeyError])
def test_words_must_be_known(field, value, words, builtin):
    with refused(builtin, f"Robot.{field}", repr(value), *words):
        ROBOT.replace(**{field: value})


def test_the_name_must_be_a_text():
    assert ROBOT.replace(name="Ada").name == "Ada"
    with refused(TypeError, "Robot.name = 7", "text"):
        ROBOT.replace(name=7)


@pytest.mark.parametrize(("mass_x", "caster_x"), [(0.01, -0.2), (-0.21, -0.2), (-0.2, -0.2), (0, -0.2), (-0.06, 0)])
def test_a_robot_must_not_tip_over(mass_x, caster_x):
    with refused(ValueError, f"Robot.center_of_mass_x = {mass_x:g} m", f"caster_x = {caster_x:g} m"):
        ROBOT.replace(center_of_mass_x=mass_x, caster_x=caster_x)


def test_the_caster_may_be_in_front():
    assert ROBOT.replace(center_of_mass_x=0.06, caster_x=0.2).caster_x == 0.2


def test_one_straight_axle_must_reach_the_floor_on_both_sides():
    wide = {"left_radius": 0.5, "right_radius": 0.1}
    assert ROBOT.replace(hanging="coaxial", track_width=0.41, **wide).hanging == "coaxial"
    assert ROBOT.replace(hanging="level", track_width=0.4, **wide).hanging == "level"
    with refused(ValueError, "Robot.track_width = 0.4 m", "0.4 m"):
        ROBOT.replace(hanging="coaxial", track_width=0.4, **wide)


# One value, never changed


def test_frozen():
    for field in dataclasses.fields(dd.Robot):
        with pytest.raises(dataclasses.FrozenInstanceError):
            setattr(ROBOT, field.name, getattr(ROBOT, field.name))


def test_fields_are_named():
    with pytest.raises(TypeError):
        dd.Robot(0.1, 0.091, 0.4)


def test_equal_robots_are_equal():
    assert dd.Robot(**GEOMETRY) == ROBOT
    assert hash(dd.Robot(**GEOMETRY)) == hash(ROBOT)
    assert ROBOT.replace(right_radius=0.1) != ROBOT
    assert pickle.loads(pickle.dumps(ROBOT)) == ROBOT


def test_replacing_leaves_the_rest_and_the_original():
    changed = ROBOT.replace(right_radius=0.1, name="compensated")
    assert (ROBOT.right_radius, ROBOT.name) == (0.091, "robot")
    assert dataclasses.replace(changed, right_radius=0.091, name="robot") == ROBOT


@pytest.mark.parametrize("builtin", [ValueError, KeyError])
def test_unknown_fields_are_answered_with_the_nearest(builtin):
    with refused(builtin, "Robot field 'track_widht'", "track_width", "did you mean 'track_width'?"):
        ROBOT.replace(track_widht=0.3)


# Files


def test_a_robot_in_ten_lines(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text(
        'left_radius = 0.033\nright_radius = 0.033\ntrack_width = 0.16\nbody_mass = 1\nhanging = "coaxial"\n'
    )
    robot = dd.Robot.load(file)
    expected = dd.Robot(
        left_radius=0.033, right_radius=0.033, track_width=0.16, body_mass=1, hanging="coaxial", name="mine"
    )
    assert robot == expected == dd.Robot.load(str(file))


def test_a_file_may_name_its_robot(tmp_path):
    assert dd.Robot.load(_file(tmp_path, name='"Ada"')).name == "Ada"


def test_a_path_needs_no_folder(tmp_path, monkeypatch):
    _file(tmp_path)
    monkeypatch.chdir(tmp_path)
    assert dd.Robot.load("robot.toml").left_radius == 0.1


@pytest.mark.parametrize(
    ("changes", "builtin", "words"),
    [
        ({"left_radius": "0"}, ValueError, ("Robot.left_radius = 0", "positive")),
        ({"left_radius": "nan"}, ValueError, ("Robot.left_radius = nan", "finite")),
        ({"left_radius": '"big"'}, TypeError, ("Robot.left_radius = 'big'", "number")),
        ({"left_radius": "[0.1, 0.1]"}, TypeError, ("Robot.left_radius = [0.1, 0.1]",)),
        ({"left_raduis": "0.1"}, KeyError, ("key in robot.toml 'left_raduis'", "did you mean 'left_radius'?")),
        ({"left_raduis": "0.1"}, ValueError, ()),
        ({"hanging": '"levl"'}, ValueError, ("did you mean 'level'?",)),
    ],
)
def test_bad_fields_in_a_file_are_refused(tmp_path, changes, builtin, words):
    with refused(builtin, *words):
        dd.Robot.load(_file(tmp_path, **changes))


def test_missing_fields_are_named(tmp_path):
    file = tmp_path / "half.toml"
    file.write_text("left_radius = 0.1\n")
    with refused(ValueError, "half.toml", "right_radius, track_width missing"):
        dd.Robot.load(file)
    file.write_text("")
    with refused(ValueError, "left_radius, right_radius, track_width missing"):
        dd.Robot.load(file)


@pytest.mark.parametrize(
    "content", [b"left_radius: 0.1\n", b"\x00\x01\xff\xfe\x80binary", b"left_radius = 1\nleft_radius = 2\n"]
)
def test_files_that_are_not_toml_are_refused(tmp_path, content):
    file = tmp_path / "robot.toml"
    file.write_bytes(content)
    with refused(ValueError, "robot.toml", "not a robot's TOML file"):
        dd.Robot.load(file)


def test_a_folder_is_refused(tmp_path):
    with refused(ValueError, tmp_path.name, "not a robot's TOML file"):
        dd.Robot.load(tmp_path)


def test_a_missing_file_is_refused(tmp_path):
    with refused(FileNotFoundError, "nowhere.toml", "no such robot file"):
        dd.Robot.load(tmp_path / "nowhere.toml")


@pytest.mark.parametrize("builtin", [ValueError, KeyError])
def test_unknown_presets_are_answered_with_the_names(builtin):
    with refused(builtin, "preset 'no such robot'", *presets()):
        dd.Robot.load("no such robot")


@pytest.mark.parametrize("value", [None, 3, ROBOT])
def test_what_is_neither_name_nor_path_is_refused(value):
    with refused(TypeError, repr(value), "name or a path"):
        dd.Robot.load(value)


def _file(folder, **changes):
    values = {name: str(value) for name, value in GEOMETRY.items()} | changes
    file = folder / "robot.toml"
    file.write_text("".join(f"{key} = {value}\n" for key, value in values.items()))
    return file


@pytest.mark.parametrize("gain", [-0.5, 0.5, 2.0])
def test_a_turning_gain_is_a_small_correction(gain):
    with refused(ValueError, "Robot.turning_gain", "must lie between -0.5 and 0.5"):
        ROBOT.replace(turning_gain=gain)


def test_a_robot_with_a_turning_gain_does_not_drive_in_physics():
    with refused(ValueError, "Robot.turning_gain = 0.01", "must be 0 for a robot that drives in physics"):
        dd.simulate(ROBOT.replace(turning_gain=0.01), dd.maneuvers.straight(ROBOT))
