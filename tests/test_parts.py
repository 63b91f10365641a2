"""The parts of a robot: what is too large, and what a part is that nobody has described."""

import dataclasses

import pytest
from helpers import refused

import diffdrive_mj as dd
from diffdrive_mj.parts import Caster, Motor, Payload, Servo, SkidSteer, Tyres, WheelEncoder
from diffdrive_mj.tolerances import Tolerances


@pytest.mark.parametrize(
    ("part", "field", "largest", "unit"),
    [
        (Payload, "mass", 1e6, "kg"),
        (Payload, "x", 10.0, "m"),
        (Payload, "y", 10.0, "m"),
        (Payload, "height", 10.0, "m"),
        (Tyres, "mass", 1e6, "kg"),
        (Tyres, "width", 10.0, "m"),
        (Caster, "x", 10.0, "m"),
        (Caster, "radius", 10.0, "m"),
        (SkidSteer, "wheelbase", 10.0, "m"),
        (Motor, "rotor_inertia", 1e6, "kg m^2"),
    ],
)
def test_what_is_larger_is_in_another_unit(part, field, largest, unit):
    assert getattr(part(**{field: largest}), field) == largest
    with refused(ValueError, f"{part.__name__}.{field}", unit):
        part(**{field: 1.001 * largest})


def test_a_robot_carries_nothing_unless_it_is_said():
    assert dataclasses.asdict(Payload()) == {"mass": 0.0, "x": 0.0, "y": 0.0, "height": 0.0}


@pytest.mark.parametrize("part", [Tyres, Caster, Motor, Servo, WheelEncoder, Payload, Tolerances, SkidSteer])
def test_a_field_that_a_part_does_not_have_is_named(part):
    with refused(ValueError, part.__name__, "wigth"):
        part(wigth=1.0)


def test_tolerances_come_from_the_robots_file(tmp_path):
    path = tmp_path / "own.toml"
    path.write_text(
        "left_radius = 0.03\nright_radius = 0.03\ntrack_width = 0.15\n\n[tolerances]\nradius_ratio = 0.002\n"
    )
    robot = dd.Robot.load(path)
    assert dataclasses.asdict(robot.tolerances) == {"radius": 0.01, "radius_ratio": 0.002, "track_width": 0.01}
    assert robot.to_toml().endswith("[tolerances]\nradius_ratio = 0.002\n")
    assert Tolerances(radius=0).radius == 0.0
    assert type(Tolerances(radius=0).radius) is float
    with refused(ValueError, "Tolerances.radius = -0.1"):
        Tolerances(radius=-0.1)
    with refused(ValueError, "Tolerances.track_width = 1 of the value: must be at most 0.5"):
        Tolerances(track_width=1.0)


def test_parts_are_ideal_unless_it_is_said():
    tyres, caster, motor = Tyres(), Caster(), Motor()
    assert (tyres.rolling_resistance, tyres.shape, tyres.stiffness) == (0.0, "crowned", None)
    assert (caster.kind, caster.friction, caster.trail, caster.angle) == ("ball", 0.0, None, 0.0)
    assert (motor.stall_torque, motor.no_load_speed, motor.gain_ratio) == (None, None, 1.0)


def test_parts_that_are_not_ideal_are_read_back_from_a_file(tmp_path):
    robot = dd.Robot.load("ct_bot").replace(
        tyres={"rolling_resistance": 0.01, "shape": "cylinder", "stiffness": 2e4},
        caster={"kind": "swivel", "trail": 0.01, "angle": -1.0},
        motor={"stall_torque": 0.1, "no_load_speed": 15.0, "gain_ratio": 0.9},
        servo={"law": "voltage"},
    )
    robot.save(tmp_path / "robot.toml")
    assert dd.Robot.load(tmp_path / "robot.toml") == robot
    with refused(KeyError, "shape", "crowned, cylinder"):
        Tyres(shape="round")
