import copy
import dataclasses
import math
import pickle

import numpy as np
import pytest
from helpers import refused
from hypothesis import given
from strategies import laden_robots, numbers, robots, sizes

import diffdrive_mj as dd
from diffdrive_mj._described import given as given_to
from diffdrive_mj.parts import PARTS
from diffdrive_mj.robot import presets

GEOMETRY = {"left_radius": 0.1, "right_radius": 0.091, "track_width": 0.4}
ROBOT = dd.Robot(**GEOMETRY)

# Every size of a robot, as (part or None, field); tolerances, which are parts of a size, have tests of their own.
NUMBERS = [
    *((None, field.name) for field in dataclasses.fields(dd.Robot) if field.type == "float"),
    *(
        (part, field.name)
        for part, kind in PARTS.items()
        for field in dataclasses.fields(kind)
        if field.type == "float" and part != "tolerances"
    ),
]
SIGNED = [
    (None, "center_of_mass_x"),
    (None, "turning_gain"),
    ("caster", "x"),
    ("caster", "angle"),
    ("payload", "x"),
    ("payload", "y"),
]
MAY_BE_ZERO = [
    ("skid_steer", "wheelbase"),
    ("tyres", "rolling_resistance"),
    ("caster", "friction"),
    ("motor", "rotor_inertia"),
    ("payload", "mass"),
    ("payload", "height"),
]
POSITIVE = [place for place in NUMBERS if place not in (*SIGNED, *MAY_BE_ZERO)]
FORMER = {
    "wheel_width": ("tyres", "width"),
    "wheel_mass": ("tyres", "mass"),
    "caster_x": ("caster", "x"),
    "caster_radius": ("caster", "radius"),
    "rotor_inertia": ("motor", "rotor_inertia"),
    "servo_bandwidth": ("servo", "bandwidth"),
    "servo_gains": ("servo", "gains"),
    "ticks_per_revolution": ("encoder", "ticks_per_revolution"),
}


def change(place, value):
    part, field = place
    return {field: value} if part is None else {part: {field: value}}


def label(place):
    part, field = place
    return f"{PARTS[part].__name__ if part else 'Robot'}.{field}"


def read(robot, place):
    part, field = place
    return getattr(getattr(robot, part) if part else robot, field)


# Fields


def test_the_three_numbers_that_odometry_needs_are_enough():
    assert (ROBOT.left_radius, ROBOT.right_radius, ROBOT.track_width) == (0.1, 0.091, 0.4)
    needed = {field.name for field in dataclasses.fields(dd.Robot) if field.default is dataclasses.MISSING}
    assert needed == set(GEOMETRY)


def test_what_follows_from_the_fields():
    assert ROBOT.radius_ratio == pytest.approx(0.91)
    assert ROBOT.mean_radius == pytest.approx(0.0955)
    robot = ROBOT.replace(body_mass=4, tyres={"mass": 0.3}, payload={"mass": 2, "x": -0.12, "y": 0.03, "height": 0.2})
    assert robot.mass == pytest.approx(6.6)
    assert robot.loaded_center_of_mass == pytest.approx((-0.08, 0.01, 0.12))


@pytest.mark.parametrize("place", [*POSITIVE, *MAY_BE_ZERO], ids=label)
@pytest.mark.parametrize("value", [1, np.int64(1), np.float32(0.25)])
def test_numbers_become_floats(place, value):
    result = read(ROBOT.replace(**change(place, value)), place)
    assert type(result) is float
    assert result == value


def test_places_become_floats():
    robot = ROBOT.replace(center_of_mass_x=np.float32(-0.25), caster={"x": -1})
    assert (robot.center_of_mass_x, robot.caster.x) == (-0.25, -1.0)
    assert type(robot.center_of_mass_x) is type(robot.caster.x) is float


@pytest.mark.parametrize("place", POSITIVE, ids=label)
@pytest.mark.parametrize("value", [0, -0.1, -math.inf])
def test_sizes_must_be_positive(place, value):
    with refused(ValueError, f"{label(place)} = {value}", "must be"):
        ROBOT.replace(**change(place, value))


@pytest.mark.parametrize("place", MAY_BE_ZERO, ids=label)
def test_some_may_be_zero_but_not_less(place):
    assert read(ROBOT.replace(**change(place, 0)), place) == 0
    with refused(ValueError, f"{label(place)} = -1", "must not be negative"):
        ROBOT.replace(**change(place, -1))


@pytest.mark.parametrize("place", NUMBERS, ids=label)
@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_numbers_must_be_finite(place, value):
    with refused(ValueError, f"{label(place)} = {value}", "must be finite"):
        ROBOT.replace(**change(place, value))


@pytest.mark.parametrize("place", NUMBERS, ids=label)
@pytest.mark.parametrize("value", ["0.1", True, [0.1], np.array([0.1]), 0.1j])
def test_numbers_must_be_numbers(place, value):
    with refused(TypeError, f"{label(place)} = {value!r}", "must be a number"):
        ROBOT.replace(**change(place, value))


@pytest.mark.parametrize("place", [(None, "left_radius"), ("encoder", "gear"), ("payload", "mass")], ids=label)
def test_none_is_not_a_number_where_nothing_scales(place):
    with refused(TypeError, f"{label(place)} = None", "must be a number"):
        ROBOT.replace(**change(place, None))


@pytest.mark.parametrize(
    ("place", "value", "words"),
    [
        ((None, "axle"), "rigit", ("independent, rigid", "did you mean 'rigid'?")),
        ((None, "axle"), "level", ("independent, rigid",)),
        ((None, "axle"), None, ("None", "independent, rigid")),
        (("servo", "gains"), "match", ("equal, matched", "did you mean 'matched'?")),
        (("servo", "law"), "PID", ("P, PI, voltage", "did you mean 'PI'?")),
    ],
)
@pytest.mark.parametrize("builtin", [ValueError, KeyError])
def test_words_must_be_known(place, value, words, builtin):
    with refused(builtin, label(place), repr(value), *words):
        ROBOT.replace(**change(place, value))


def test_the_name_must_be_a_string():
    assert ROBOT.replace(name="Ada").name == "Ada"
    with refused(TypeError, "Robot.name = 7", "must be a string"):
        ROBOT.replace(name=7)


@pytest.mark.parametrize(
    ("field", "value", "words"),
    [
        ("left_radius", 32.5, "Robot.left_radius = 32.5 m: must be below 2 m; in millimetres? then 0.0325"),
        ("right_radius", 3.25, "Robot.right_radius = 3.25 m: must be below 2 m; in centimetres? then 0.0325"),
        ("track_width", 160, "Robot.track_width = 160 m: must be below 10 m; in millimetres? then 0.16"),
        ("track_width", 16, "Robot.track_width = 16 m: must be below 10 m; in centimetres? then 0.16"),
        ("left_radius", 2.0, "Robot.left_radius = 2 m: must be below 2 m"),
        ("track_width", 10.0, "Robot.track_width = 10 m: must be below 10 m"),
    ],
)
def test_other_units_are_refused_with_the_likely_one(field, value, words):
    with refused(ValueError, words):
        dd.Robot(**{**GEOMETRY, field: value})


def test_a_size_beyond_any_unit_gets_no_hint():
    with pytest.raises(dd.DiffdriveError, match=r"^Robot.left_radius = 1e\+06 m: must be below 2 m$"):
        ROBOT.replace(left_radius=1e6)


@pytest.mark.parametrize("largest", [{"left_radius": 1.99}, {"track_width": 9.99}])
def test_large_robots_are_robots(largest):
    assert ROBOT.replace(**largest) != ROBOT


@pytest.mark.parametrize(("mass_x", "caster_x"), [(0.01, -0.2), (-0.21, -0.2), (-0.2, -0.2), (0, -0.2), (-0.06, 0)])
def test_a_robot_must_not_tip_over(mass_x, caster_x):
    with refused(ValueError, f"Robot.center_of_mass_x = {mass_x:g} m", f"caster.x = {caster_x:g} m"):
        ROBOT.replace(center_of_mass_x=mass_x, caster={"x": caster_x})


@pytest.mark.parametrize("load", [{"x": 0.1}, {"x": -0.3}, {"x": -0.06, "y": 0.2}, {"x": -0.06, "y": -0.2}])
def test_a_payload_must_not_tip_a_robot_over(load):
    assert ROBOT.replace(payload={"mass": 0.5, **load}).payload.mass == 0.5
    with refused(ValueError, "Robot.payload", "mass=40.0", "tips over"):
        ROBOT.replace(payload={"mass": 40, **load})


def test_the_caster_may_be_in_front():
    assert ROBOT.replace(center_of_mass_x=0.06, caster={"x": 0.2}).caster.x == 0.2


def test_a_rigid_axle_must_reach_the_floor_on_both_sides():
    wide = {"left_radius": 0.5, "right_radius": 0.1}
    assert ROBOT.replace(axle="rigid", track_width=0.41, **wide).axle == "rigid"
    assert ROBOT.replace(axle="independent", track_width=0.4, **wide).axle == "independent"
    with refused(ValueError, "Robot.track_width = 0.4 m", "0.4 m"):
        ROBOT.replace(axle="rigid", track_width=0.4, **wide)


@pytest.mark.parametrize("gain", [-0.5, 0.5, 2.0])
def test_a_turning_gain_is_a_small_correction(gain):
    with refused(ValueError, "Robot.turning_gain", "must lie between -0.5 and 0.5"):
        ROBOT.replace(turning_gain=gain)


def test_a_robot_with_a_turning_gain_does_not_drive_in_physics():
    with refused(ValueError, "Robot.turning_gain = 0.01", "must be 0 for a robot that drives in physics"):
        dd.simulate(ROBOT.replace(turning_gain=0.01), dd.maneuvers.straight(ROBOT))


# Parts


@pytest.mark.parametrize(("name", "kind"), PARTS.items())
def test_a_part_is_a_value_or_a_mapping_of_its_fields(name, kind):
    assert getattr(dd, kind.__name__) is kind
    assert type(getattr(ROBOT, name)) is kind
    complete = dataclasses.asdict(getattr(ROBOT, name))
    assert ROBOT.replace(**{name: complete}) == ROBOT.replace(**{name: kind(**complete)}) == ROBOT
    for value in (7, "P." if kind is not dd.Servo else ["P"], [complete], None, kind):
        with refused(TypeError, f"Robot.{name} = ", f"must be {kind.__name__}(...) or a mapping of its fields"):
            ROBOT.replace(**{name: value})
    with refused(KeyError, f"{kind.__name__} field 'sise'"):
        ROBOT.replace(**{name: {"sise": 1}})
    with refused(KeyError, f"{kind.__name__} field '1'"):
        ROBOT.replace(**{name: {1: 1}})


def test_ticks_of_a_wheel_count_the_gear():
    assert dd.WheelEncoder(ticks_per_revolution=64, gear=43.7).ticks_per_wheel_turn == 2796.8
    assert ROBOT.encoder.ticks_per_wheel_turn == 4096


def test_a_part_alone_does_not_know_what_scales():
    assert dd.Caster(radius=0.01).x is None
    assert dd.Caster(x=None, radius=0.01) == dd.Caster(radius=0.01)


# What is left out scales


@given(robots, numbers(0.3, 3.0))
def test_similar_robots_have_similar_parts(robot, s):
    larger = dd.Robot(**{name: s * getattr(robot, name) for name in GEOMETRY})
    powers = {"body_mass": 3, "center_of_mass_x": 1, "center_of_mass_height": 1, "mass": 3}
    parts = {("tyres", "width"): 1, ("tyres", "mass"): 3, ("caster", "x"): 1, ("caster", "radius"): 1}
    parts |= {("motor", "rotor_inertia"): 5}
    for place, power in {**{(None, name): power for name, power in powers.items()}, **parts}.items():
        assert read(larger, place) == pytest.approx(read(robot, place) * s**power, rel=1e-12), place
    assert (larger.servo, larger.encoder, larger.payload) == (robot.servo, robot.encoder, robot.payload)


def test_the_reference_robot_is_exact():
    assert (ROBOT.tyres, ROBOT.caster) == (dd.Tyres(width=0.04, mass=0.3), dd.Caster(x=-0.2, radius=0.025))
    assert (ROBOT.body_mass, ROBOT.center_of_mass_x, ROBOT.center_of_mass_height) == (4.0, -0.06, 0.08)
    assert (ROBOT.motor, ROBOT.mass) == (dd.Motor(rotor_inertia=0.01), 4.6)


def test_a_given_caster_takes_the_centre_of_mass_along():
    assert ROBOT.replace(caster={"x": -0.1}).center_of_mass_x == pytest.approx(-0.03)
    assert ROBOT.replace(caster={"x": 0.1}).center_of_mass_x == pytest.approx(0.03)
    assert ROBOT.replace(caster={"x": -0.1}, center_of_mass_x=-0.05).center_of_mass_x == -0.05


def test_given_masses_and_the_payload_in_the_rotors_inertia():
    assert ROBOT.replace(body_mass=8.6).motor.rotor_inertia == pytest.approx(0.02)
    assert ROBOT.replace(payload={"mass": 3.0}).motor.rotor_inertia == 0.01


@given(laden_robots, numbers(0.3, 3.0))
def test_replacing_keeps_what_was_given_and_scales_the_rest(robot, s):
    wider = robot.replace(track_width=s * robot.track_width)
    bare = dd.Robot(**{name: getattr(wider, name) for name in GEOMETRY})
    depends_on_more = {(None, "center_of_mass_x"), ("motor", "rotor_inertia")}
    for part, field in NUMBERS:
        if field in given_to(given_to(robot).get(part) if part else robot):
            if field != "track_width":
                assert read(wider, (part, field)) == read(robot, (part, field))
        elif (part, field) not in depends_on_more:
            assert read(wider, (part, field)) == read(bare, (part, field))
    assert wider.replace(track_width=robot.track_width) == robot


def test_replacing_a_part_by_a_mapping_changes_the_named_fields_alone():
    robot = ROBOT.replace(caster={"x": -0.3})
    changed = robot.replace(caster={"radius": 0.01})
    assert changed.caster == dd.Caster(x=-0.3, radius=0.01)
    assert changed.replace(track_width=0.8, left_radius=0.2).caster == changed.caster
    assert robot.replace(track_width=0.8).caster.x == -0.3
    assert ROBOT.replace(track_width=0.8).caster.x == -0.4


def test_replacing_a_part_by_a_part_replaces_the_whole():
    robot = ROBOT.replace(caster={"x": -0.3, "radius": 0.01})
    assert robot.replace(caster=dd.Caster(radius=0.02)).caster == dd.Caster(x=-0.2, radius=0.02)
    small = ROBOT.replace(track_width=0.2)
    pinned = ROBOT.replace(caster=small.caster)
    assert pinned.caster == small.caster
    assert pinned.replace(track_width=1.0).caster == small.caster


def test_none_lets_a_number_scale_again():
    robot = ROBOT.replace(body_mass=1.0, caster={"x": -0.3})
    assert robot.replace(body_mass=None, caster={"x": None}) == ROBOT


@given(laden_robots, numbers(0.11, 1.0))
def test_the_replacement_of_dataclasses_does_the_same(robot, track_width):
    for changes in (
        {"track_width": track_width},
        {"body_mass": 77.0, "name": "other"},
        {"caster": dd.Caster(x=0.1)},
        {},
    ):
        ours, theirs = robot.replace(**changes), dataclasses.replace(robot, **changes)
        assert ours == theirs
        assert repr(ours) == repr(theirs)
    assert dd.Robot.__replace__ is dd.Robot.replace  # copy.replace of newer Pythons


# Drives of any size


@given(sizes(0.015, 0.3), numbers(0.85, 1.2), numbers(3.0, 6.0))
def test_a_robot_of_any_size_drives(radius, ratio, proportion):
    robot = dd.Robot(left_radius=radius, right_radius=ratio * radius, track_width=proportion * radius)
    speed = 2.0 * math.sqrt(radius)  # similar motion under one gravity (Froude)
    rec = dd.simulate(robot, dd.maneuvers.straight(robot, speed=0.3 * speed, distance=10 * radius, ramp=0.5))
    estimate = dd.odometry.integrate(rec.wheel_angles, robot, start=rec.truth[0])
    assert rec.truth[-1, 0] == pytest.approx(10 * radius, rel=0.02)
    assert dd.metrics.drift(rec.truth, estimate).max_position_per_metre < 1e-4


# One value, never changed


def test_frozen():
    for field in dataclasses.fields(dd.Robot):
        with pytest.raises(dataclasses.FrozenInstanceError):
            setattr(ROBOT, field.name, getattr(ROBOT, field.name))


def test_fields_are_named():
    with refused(TypeError, "Robot(0.1, ...)", "by name", "Robot(left_radius=0.1)"):
        dd.Robot(0.1, 0.091, 0.4)
    with refused(TypeError, "Tyres(0.1, ...)", "Tyres(width=0.1)"):
        dd.Tyres(0.1)


def test_missing_numbers_are_named():
    with refused(TypeError, "Robot(...): right_radius, track_width missing"):
        dd.Robot(left_radius=0.1)


@given(laden_robots)
def test_equal_robots_are_equal(robot):
    for same in (robot.replace(), copy.copy(robot), copy.deepcopy(robot), pickle.loads(pickle.dumps(robot))):
        assert same == robot
        assert hash(same) == hash(robot)
        assert repr(same) == repr(robot)
        assert same.replace(track_width=0.35) == robot.replace(track_width=0.35)
    assert robot.replace(track_width=robot.track_width / 2) != robot


def test_equality_is_by_the_numbers_given_or_not():
    stated = ROBOT.replace(body_mass=4.0, caster=dd.Caster(x=-0.2, radius=0.025))
    assert stated == ROBOT
    assert hash(stated) == hash(ROBOT)
    assert repr(stated) != repr(ROBOT)
    assert len({ROBOT, stated, ROBOT.replace(right_radius=0.1)}) == 2


@given(laden_robots)
def test_the_repr_is_short_and_makes_the_same_robot(robot):
    names = {"Robot": dd.Robot, **{kind.__name__: kind for kind in PARTS.values()}}
    again = eval(repr(robot), names)
    assert again == robot
    assert repr(again) == repr(robot)
    assert repr(ROBOT) == "Robot(left_radius=0.1, right_radius=0.091, track_width=0.4)"


@pytest.mark.parametrize("builtin", [ValueError, KeyError])
def test_unknown_fields_are_answered_with_the_nearest(builtin):
    for make in (ROBOT.replace, lambda **wrong: dd.Robot(**GEOMETRY, **wrong)):
        with refused(builtin, "Robot field 'track_widht'", "track_width", "did you mean 'track_width'?"):
            make(track_widht=0.3)


# Former names


@pytest.mark.parametrize(("name", "now"), FORMER.items())
def test_former_names_are_refused_with_the_new_ones(tmp_path, name, now):
    part, field = now
    for make in (ROBOT.replace, lambda **old: dd.Robot(**GEOMETRY, **old)):
        with refused(TypeError, f"Robot({name}=...) is now {part}={PARTS[part].__name__}({field}=...)"):
            make(**{name: 1.0})
    file = _file(tmp_path, **{name: "1.0"})
    with refused(ValueError, f"robot.toml: key {name!r} is now {field!r} in the table [{part}]"):
        dd.Robot.load(file)
    assert hasattr(getattr(ROBOT, part), field)


@pytest.mark.parametrize(("hanging", "axle"), [("level", "independent"), ("coaxial", "rigid")])
def test_hanging_is_now_the_axle(tmp_path, hanging, axle):
    with refused(TypeError, f'Robot(hanging={hanging!r}) is now axle="{axle}"'):
        ROBOT.replace(hanging=hanging)
    with refused(ValueError, f'robot.toml: hanging = "{hanging}" is now axle = "{axle}"'):
        dd.Robot.load(_file(tmp_path, hanging=f'"{hanging}"'))
    assert ROBOT.replace(axle=axle).axle == axle


def test_hanging_of_neither_kind_names_both_axles():
    with refused(TypeError, 'is now axle="independent" or "rigid"'):
        ROBOT.replace(hanging=3)


@pytest.mark.parametrize("law", ["PI", "P"])
def test_a_servo_is_no_longer_a_word(tmp_path, law):
    with refused(TypeError, f"Robot(servo={law!r}) is now servo=Servo(law={law!r})"):
        ROBOT.replace(servo=law)
    with refused(ValueError, "robot.toml: key 'servo' is now 'law' in the table [servo]"):
        dd.Robot.load(_file(tmp_path, servo=f'"{law}"'))


# Files


@given(laden_robots)
def test_toml_is_read_back_equal(tmp_path_factory, robot):
    path = tmp_path_factory.mktemp("toml") / "it.toml"
    robot.save(path)
    again = dd.Robot.load(path)
    assert again == robot
    assert again.to_toml() == robot.to_toml() == path.read_text(encoding="utf-8")
    assert again.replace(track_width=0.33) == robot.replace(track_width=0.33)


def test_toml_holds_what_was_given_and_the_name():
    assert ROBOT.to_toml() == 'name = "robot"\nleft_radius = 0.1\nright_radius = 0.091\ntrack_width = 0.4\n'
    robot = ROBOT.replace(axle="rigid", tyres={"mass": 0.5}, encoder={"ticks_per_revolution": 4096}, payload={})
    assert robot.to_toml() == (
        'name = "robot"\nleft_radius = 0.1\nright_radius = 0.091\ntrack_width = 0.4\naxle = "rigid"\n'
        "\n[tyres]\nmass = 0.5\n\n[encoder]\nticks_per_revolution = 4096.0\n"
    )


@pytest.mark.parametrize("name", presets())
def test_presets_survive(tmp_path, name):
    robot = dd.Robot.load(name)
    robot.save(tmp_path / "it.toml")
    assert dd.Robot.load(tmp_path / "it.toml") == robot


@pytest.mark.parametrize("name", ["a\nb", 'say "so"', "back\\slash", "\x00\x1f\x7f\x85\u2028", "\U0001f916"])
def test_names_that_need_quoting(tmp_path, name):
    ROBOT.replace(name=name).save(tmp_path / "it.toml")
    assert dd.Robot.load(tmp_path / "it.toml").name == name


def test_saving_is_all_or_nothing(tmp_path):
    ROBOT.save(tmp_path / "it.toml")
    with refused(ValueError, "cannot be written"):
        ROBOT.replace(name="\udcff").save(tmp_path / "it.toml")
    with refused(ValueError, "named .toml"):
        ROBOT.save(tmp_path / "it.yaml")
    with refused(ValueError, "cannot be written"):
        ROBOT.save(tmp_path / "nowhere" / "it.toml")
    assert [path.name for path in tmp_path.iterdir()] == ["it.toml"]
    assert dd.Robot.load(tmp_path / "it.toml") == ROBOT


def test_a_robot_in_ten_lines(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text(
        "left_radius = 0.033\nright_radius = 0.033\ntrack_width = 0.16\nbody_mass = 1\n"
        'axle = "rigid"\n[caster]\nx = -0.08\n[encoder]\nticks_per_revolution = 64\ngear = 43.7\n'
    )
    expected = dd.Robot(
        left_radius=0.033,
        right_radius=0.033,
        track_width=0.16,
        body_mass=1,
        axle="rigid",
        name="mine",
        caster=dd.Caster(x=-0.08),
        encoder=dd.WheelEncoder(ticks_per_revolution=64, gear=43.7),
    )
    assert dd.Robot.load(file) == expected == dd.Robot.load(str(file))


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
        ({"left_radius": "32.5"}, ValueError, ("in millimetres? then 0.0325",)),
        ({"left_radius": '"big"'}, TypeError, ("Robot.left_radius = 'big'", "number")),
        ({"left_radius": "[0.1, 0.1]"}, TypeError, ("Robot.left_radius = [0.1, 0.1]",)),
        ({"left_raduis": "0.1"}, KeyError, ("key in robot.toml 'left_raduis'", "did you mean 'left_radius'?")),
        ({"left_raduis": "0.1"}, ValueError, ()),
        ({"axle": '"rigit"'}, ValueError, ("did you mean 'rigid'?",)),
        ({"caster": "{ x = 0.0 }"}, ValueError, ("caster.x = 0 m",)),
        ({"caster": "{ y = 0.0 }"}, KeyError, ("key in robot.toml [caster] 'y'", "radius, trail, x")),
        ({"wheels": "{ y = 0.0 }"}, KeyError, ("key in robot.toml 'wheels'", "tyres")),
        ({"caster": "3"}, TypeError, ("Robot.caster = 3", "Caster(...)")),
        ({"caster": "[{ x = -0.1 }]"}, TypeError, ("Robot.caster = [{'x': -0.1}]", "Caster(...)")),
        ({"_given": "{}"}, KeyError, ("key in robot.toml '_given'",)),
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
    with refused(TypeError, "robot = ", "a preset's name or a path"):
        dd.Robot.load(value)


def _file(folder, **changes):
    values = {name: str(value) for name, value in GEOMETRY.items()} | changes
    file = folder / "robot.toml"
    file.write_text("".join(f"{key} = {value}\n" for key, value in values.items()))
    return file
