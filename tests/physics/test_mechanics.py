"""The forces on the contacts: rigid-body mechanics against the engine's contacts and against levers."""

import numpy as np
import pytest

import diffdrive_mj as dd
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.physics import _probes, mechanics
from diffdrive_mj.physics.limits import needed_grip
from diffdrive_mj.physics.mechanics import contact_forces
from diffdrive_mj.physics.model import compile_model, static_loads
from diffdrive_mj.physics.tilt import level_twin

GRAVITY = 9.81
PRESETS = ("matched", "mismatched", "ct_bot", "optiodom", "turtlebot3_burger")
ROBOTS = {
    **{name: dd.Robot.load(name) for name in PRESETS},
    "rigid axle": dd.Robot.load("mismatched").replace(axle="rigid", left_radius=0.07),
    "laden": dd.Robot.load("matched").replace(payload=dd.Payload(mass=1.5, x=-0.1, y=0.05, height=0.2)),
}


def engine_forces(robot, commands, monkeypatch):
    """The recording, loads of the three contacts (S, 3) and tangential forces of the wheels (S, 2) at every step."""
    forces = []
    read = _probes.GripProbe.read

    def keep(self, steps):
        forces.append(steps.forces[0])
        read(self, steps)

    monkeypatch.setattr(_probes.GripProbe, "read", keep)
    recording = dd.simulate(robot, commands, sample_rate=500.0)
    model = compile_model(robot)
    columns = [int(model.sensor(f"{name}_contact").adr[0]) for name in ("left", "right", "caster")]
    rows = np.concatenate(forces)
    pull = np.stack([np.hypot(rows[:, c + 1], rows[:, c + 2]) for c in columns[:2]], axis=-1)
    return recording, rows[:, columns], pull


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("maneuver", ["straight", "arc", "spin"])
def test_the_engines_contacts_carry_what_mechanics_says(name, maneuver, monkeypatch):
    """Over tenths of a second, at the twist and acceleration that the wheels really have."""
    robot = ROBOTS[name]
    twin = level_twin(robot)
    size = robot.track_width
    options = {
        "straight": {"speed": 2 * size, "distance": 6 * size, "ramp": 1.0},
        "arc": {"speed": size, "distance": 3 * size, "radius": 1.5 * size, "ramp": 1.0},
        "spin": {"turns": 0.4, "yaw_rate": 1.5, "ramp": 1.0},
    }[maneuver]
    commands = getattr(dd.maneuvers, maneuver)(twin, **options)
    recording, loads, pull = engine_forces(robot, commands, monkeypatch)
    rates = np.diff(recording.wheel_angles, axis=0) / 0.002
    twists = dd.kinematics.body_twist(rates, twin)
    change = np.diff(twists, axis=0) / 0.002
    for begin in (0.3, 0.6, 1.2):
        span = slice(round(begin / 0.002), round(begin / 0.002) + 50)
        said = contact_forces(robot, twists[span], change[span])
        assert loads[span.start + 1 : span.stop + 1].mean(axis=0) == pytest.approx(
            said.load.mean(axis=0), abs=2e-3 * robot.mass * GRAVITY
        )
        assert pull[span.start + 1 : span.stop + 1].mean(axis=0) == pytest.approx(
            said.pull.mean(axis=0), abs=2e-3 * robot.mass * GRAVITY
        )


def test_the_loads_at_rest_are_the_levers():
    """M g = N_l + N_r + N_c with N_c c = M_b g x_b, the wheels standing on the axle."""
    robot = dd.Robot.load("matched")
    left, right, caster = static_loads(robot)
    assert caster == pytest.approx(robot.body_mass * GRAVITY * 0.06 / 0.2)
    assert left == pytest.approx(right)
    assert left + right + caster == pytest.approx(robot.mass * GRAVITY)


def test_the_friction_that_a_straight_start_needs():
    """2 T = M a, and the wheels hand (M h a + J dw/dt) / c of their load to the caster."""
    robot = dd.Robot.load("matched")
    forces = contact_forces(robot, (0.3, 0.0), (1.0, 0.0))
    assert forces.pull == pytest.approx([robot.mass / 2] * 2)
    body, wheels = robot.body_mass * robot.center_of_mass_height, 2 * robot.tyres.mass * 0.1
    spin = 2 * robot.tyres.mass * 0.1**2 / 2 / 0.1
    shift = (body + wheels + spin) / 0.2
    rest = static_loads(robot)
    assert forces.load[2] == pytest.approx(rest[2] + shift)
    assert forces.load[:2] == pytest.approx(rest[:2] - shift / 2)
    assert forces.friction_need == pytest.approx(forces.pull / forces.load[:2])


def test_what_turns_left_one_way_turns_right_the_other():
    robot = dd.Robot.load("mismatched")
    mirrored = robot.replace(left_radius=robot.right_radius, right_radius=robot.left_radius)
    one = contact_forces(robot, (0.5, 1.0), (0.3, 2.0))
    other = contact_forces(mirrored, (0.5, -1.0), (0.3, -2.0))
    assert one.load[[0, 1, 2]] == pytest.approx(other.load[[1, 0, 2]])
    assert one.pull == pytest.approx(other.pull[::-1])


def test_needed_grip_grows_with_the_acceleration():
    robot = dd.Robot.load("matched")
    needs = [needed_grip(robot, dd.maneuvers.straight(robot, speed=1.0, ramp=ramp)) for ramp in (2.0, 1.0, 0.5)]
    assert [need.max() for need, _ in needs] == sorted(need.max() for need, _ in needs)
    assert needs[0][1] > needs[2][1] > 0
    assert needs[1][0].max() == pytest.approx(
        contact_forces(robot, (0.5, 0.0), (1.0, 0.0)).friction_need.max(), rel=1e-6
    )


@pytest.mark.parametrize(("radii", "wheel"), [((0.10, 0.15), "right"), ((0.15, 0.10), "left")])
def test_a_robot_whose_axle_leans_too_far_to_stand_is_refused(radii, wheel):
    left, right = radii
    robot = dd.Robot(
        left_radius=left, right_radius=right, track_width=0.2, axle="rigid", center_of_mass_height=0.6, name="tall"
    )
    drive = dd.maneuvers.straight(robot, distance=1.0)
    with pytest.raises(InvalidValue, match=f"robot tall: cannot stand, its {wheel} wheel would carry -"):
        dd.simulate(robot, drive)
    assert (static_loads(robot.replace(center_of_mass_height=0.15)) > 0).all()


def test_no_load_needs_infinite_friction():
    forces = mechanics.ContactForces(np.array([0.0, 2.0, 1.0]), np.array([1.0, 1.0]), np.array(0.0))
    assert forces.friction_need.tolist() == [np.inf, 0.5]
