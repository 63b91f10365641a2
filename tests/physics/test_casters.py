"""Casters that drag and casters that swivel: their forces and their kinematics in closed form, and what they cost."""

from __future__ import annotations

import math
import warnings

import mujoco
import numpy as np
import pytest
from helpers import refused

import diffdrive_mj as dd
from diffdrive_mj.errors import PhysicsWarning
from diffdrive_mj.judging.standards import ANY_FLOOR, STANDARD_MANEUVERS, residual
from diffdrive_mj.physics.mechanics import fork_trail
from diffdrive_mj.physics.model import compile_model, static_loads
from diffdrive_mj.robot import presets

PRESETS = tuple(dd.Robot.load(name) for name in presets())


def with_caster(robot, **fields):
    return robot.replace(caster={"x": robot.caster.x, "radius": robot.caster.radius, **fields})


def swivelling(robot, angle=0.0, **fields):
    return with_caster(robot, kind="swivel", angle=angle, **fields)


def driven(robot, commands, world=dd.World()):
    """A drive whose warnings are looked for elsewhere."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PhysicsWarning)
        return dd.simulate(robot, commands, world=world)


def droop(robot, rates, seconds=6.0):
    """By how much a P servo's wheels fall short, as torques at the end of a ramp to constant rates (2,) [N m]."""
    damping = [-float(compile_model(robot).actuator(f"{side}_servo").biasprm[2]) for side in ("left", "right")]
    ramp = np.minimum(np.arange(round(100 * seconds)) / 200, 1)[:, None]
    recording = dd.simulate(robot, dd.Commands(0.01, ramp * rates))
    turned = recording.wheel_angles[-1] - recording.wheel_angles[-101]
    return damping * (rates - turned)


@pytest.mark.parametrize("robot", PRESETS, ids=lambda robot: robot.name)
@pytest.mark.parametrize("friction", [0.1, 0.4])
def test_a_dragging_ball_holds_a_robot_back_by_friction_times_load(robot, friction):
    """On a straight both wheels pull half of mu N, whatever their radii; of the load at rest, since all acts on the
    floor."""
    robot = with_caster(robot, friction=friction).replace(servo={"law": "P"})
    radii = np.array([robot.left_radius, robot.right_radius])
    on_caster = robot.body_mass * 9.81 * robot.center_of_mass_x / robot.caster.x
    torques = droop(robot, 0.3 / radii)
    assert torques / radii == pytest.approx(np.full(2, friction * on_caster / 2), rel=0.01)


@pytest.mark.parametrize("name", ["matched", "turtlebot3_burger", "optiodom"])
def test_a_dragging_ball_holds_a_spin_back_by_its_lever(name):
    """mu N at the caster's distance from the axle, against the wheels' forces at half of the track."""
    friction, robot = 0.2, dd.Robot.load(name)
    robot = with_caster(robot, friction=friction).replace(servo={"law": "P"})
    rates = np.array([-1.0, 1.0]) * 0.5 * robot.track_width / 2 / robot.left_radius  # half a radian a second
    on_caster = robot.body_mass * 9.81 * robot.center_of_mass_x / robot.caster.x
    expected = friction * on_caster * abs(robot.caster.x) / robot.track_width * robot.left_radius
    left, right = droop(robot, rates)
    assert (right - left) / 2 == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize("robot", PRESETS, ids=lambda robot: robot.name)
def test_a_dragging_ball_costs_odometry_little(robot):
    """Within 2 ppm: the wheels pull, and slip a little in proportion."""
    for name in ("straight", "square", "arc", "figure eight"):
        dragging = with_caster(robot, friction=0.2)
        recording = driven(dragging, STANDARD_MANEUVERS[name](dragging))
        assert not recording.lift
        # On unequal hubs that pitch, wheels press against each other, and are said to slip.
        assert robot.name == "mismatched" or not recording.events
        assert residual(recording, dragging).position < 2.0


@pytest.mark.parametrize("robot", PRESETS, ids=lambda robot: robot.name)
@pytest.mark.parametrize("angle", [0.0, 1.0, -2.0])
def test_a_swivel_caster_stands_where_its_wheel_touches(robot, angle):
    """Moments about the axle and the middle line; at rest nothing moves, nor turns the fork."""
    robot = swivelling(robot, angle)
    trail = fork_trail(robot)
    x, y = robot.caster.x - trail * math.cos(angle), -trail * math.sin(angle)
    model = compile_model(robot)
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, nstep=500)
    left, right, caster = (data.sensor(f"{name}_contact").data[0] for name in ("left", "right", "caster"))
    weight = robot.mass * 9.81
    assert caster == pytest.approx(robot.body_mass * 9.81 * robot.center_of_mass_x / x, rel=1e-6)
    assert left + right + caster == pytest.approx(weight, rel=1e-6)
    assert (right - left) * robot.track_width / 2 == pytest.approx(caster * y, rel=1e-5, abs=1e-9 * weight)
    assert static_loads(robot) == pytest.approx((left, right, caster), rel=1e-6)
    assert np.abs(data.qvel).max() < 1e-9


@pytest.mark.parametrize("angle", [0.3, -1.5, 2.8])
@pytest.mark.parametrize("name", ["arc", "square", "figure eight"])
def test_the_fork_trails_as_rolling_says(name, angle):
    """a' = -omega - (v sin a - omega x cos a) / trail, from the true poses: the wheel does not slip sideways."""
    robot = swivelling(dd.Robot.load("matched"), angle)
    recording = dd.simulate(robot, STANDARD_MANEUVERS[name](robot), sample_rate=500.0)
    motion = dd.se2.log(dd.se2.between(recording.truth[:-1], recording.truth[1:]))
    v, omega, trail, x = motion[:, 0], motion[:, 2], fork_trail(robot), robot.caster.x
    a, expected = angle, [angle]
    for way, turn in zip(v.tolist(), omega.tolist(), strict=True):
        for _ in range(4):
            half = a + (-turn - (way * math.sin(a) - turn * x * math.cos(a)) / trail) / 8
            a += (-turn - (way * math.sin(half) - turn * x * math.cos(half)) / trail) / 4
        expected.append(a)
    assert recording.caster_angle == pytest.approx(np.array(expected), abs=0.03)
    assert np.ptp(recording.caster_angle) > 0.2


@pytest.mark.parametrize("angle", [0.05, -0.05])
def test_backing_up_flips_the_fork_to_the_side_where_it_points(angle):
    robot = swivelling(dd.Robot.load("matched"), angle)
    back = dd.simulate(robot, dd.maneuvers.straight(robot, speed=0.3, distance=-1.0))
    assert back.caster_angle[-1] == pytest.approx(math.copysign(math.pi, angle), abs=1e-3)
    forth = dd.simulate(robot, dd.maneuvers.straight(robot, speed=0.3, distance=1.0))
    assert forth.caster_angle[-1] == pytest.approx(0.0, abs=1e-6)


def test_left_and_right_are_mirrored():
    robots = [swivelling(dd.Robot.load("matched"), angle).replace(servo={"law": "P"}) for angle in (0.7, -0.7)]
    one, other = dd.simulate(robots, dd.maneuvers.straight(robots[0], speed=0.3, distance=-1.0)).runs
    np.testing.assert_allclose(one.truth * (1, -1, -1), other.truth, rtol=0, atol=1e-9)
    np.testing.assert_allclose(one.caster_angle, -other.caster_angle, rtol=0, atol=1e-6)
    assert abs(one.truth[-1, 2]) > 1e-6  # it was kicked


@pytest.mark.parametrize("robot", PRESETS, ids=lambda robot: robot.name)
def test_odometry_does_not_notice_a_swivel_caster(robot):
    """Within the floor of any drive, 1 ppm: the wheels tell of every push."""
    robot = swivelling(robot, 0.8)
    for name, maneuver in STANDARD_MANEUVERS.items():
        recording = dd.simulate(robot, maneuver(robot))
        assert not recording.events, name
        assert residual(recording, robot).position < ANY_FLOOR, name


@pytest.mark.parametrize("caster", [{"friction": 0.2}, {"kind": "swivel", "angle": 1.0}])
def test_all_parts_together_stand_still(caster):
    robot = dd.Robot.load("mismatched").replace(
        caster=caster,
        tyres={"stiffness": 20_000, "rolling_resistance": 0.02},
        payload={"mass": 1.0, "y": 0.05, "height": 0.2},
        motor={"stall_torque": 1.5, "no_load_speed": 20.0, "gain_ratio": 0.9},
    )
    recording = dd.simulate(robot, dd.Commands(1.0, np.zeros((3, 2))), sample_rate=10.0)
    assert np.abs(recording.truth).max() < 1e-9
    assert np.abs(recording.height - recording.height[0]).max() < 1e-9


def test_recordings_keep_the_angle_sample_by_sample():
    robot = swivelling(dd.Robot.load("ct_bot"), 0.5)
    recording = dd.simulate([robot, robot], dd.maneuvers.straight(robot, speed=0.1, distance=0.2))
    assert recording.caster_angle.shape == (2, len(recording.t))
    assert recording.caster_angle[:, 0].tolist() == [0.5, 0.5]
    assert recording.runs[1].during(0.5, 1.0).caster_angle.shape == (51,)
    assert dd.simulate(dd.Robot.load("ct_bot"), recording.commands[0]).caster_angle is None


def test_what_makes_no_sense_is_named():
    with refused(ValueError, "Caster.friction = 0.1", "swivel"):
        dd.Caster(kind="swivel", friction=0.1)
    with refused(ValueError, "Caster.trail"):
        dd.Caster(kind="swivel", trail=0.0)
    with refused(KeyError, "Caster.kind", "ball, swivel"):
        dd.Caster(kind="swivle")
    ball = dd.Robot.load("matched")
    with refused(ValueError, "one batch"):
        dd.simulate([ball, swivelling(ball)], dd.maneuvers.straight(ball, distance=0.1))
    with refused(ValueError, "cannot stand", "right wheel"):
        compile_model(swivelling(dd.Robot.load("matched"), math.pi / 2, trail=1.0))


def test_its_file_for_the_viewer_has_the_fork():
    model = mujoco.MjModel.from_xml_string(dd.to_mjcf(swivelling(dd.Robot.load("matched"), 0.5)))
    assert model.nq == 11
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("straight").id)
    mujoco.mj_step(model, data, nstep=2000)
    assert data.joint("caster_fork").qpos[0] == pytest.approx(-0.5, abs=1e-3)


@pytest.mark.parametrize("caster", [{"friction": 0.2}, {"kind": "swivel", "angle": 0.5}])
@pytest.mark.parametrize("stiffness", [None, 40_000])
def test_parts_and_terrain_go_together(caster, stiffness):
    """Rough floors and cables: the robot stays up and gets there; a ball touches a heightfield in several points."""
    robot = dd.Robot.load("matched").replace(caster=caster, tyres={"stiffness": stiffness})
    straight = dd.maneuvers.straight(robot, speed=0.2, distance=1.0)
    for world in (
        dd.World(rough={"x": (-1, 3), "y": (-1, 1), "rms": 0.001, "wavelength": 0.2}),
        dd.World(cables=({"x": 0.5, "y": (-0.5, 0.5), "height": 0.003},)),
    ):
        recording = driven(robot, straight, world)
        assert recording.upright
        assert recording.truth[-1, 0] == pytest.approx(1.0, abs=0.01)
