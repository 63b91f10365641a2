"""A robot's MuJoCo model as a file, to open in MuJoCo's viewer or in a program of one's own."""

from __future__ import annotations

import re

import numpy as np

from diffdrive_mj.physics._mujoco import mujoco
from diffdrive_mj.physics.limits import largest_acceleration
from diffdrive_mj.physics.mechanics import gravity
from diffdrive_mj.physics.model import compile_model, model_spec, suited
from diffdrive_mj.physics.skidding import skid_acceleration
from diffdrive_mj.physics.tilt import level_twin
from diffdrive_mj.robot import Robot
from diffdrive_mj.solver import Physics
from diffdrive_mj.world import World

# The keyframe "straight" of the reference robot [m/s], and its mean radius [m].
_SPEED, _RADIUS = 1.5, 0.0955


def to_mjcf(
    robot: Robot,
    physics: Physics | None = None,
    world: World = World(),  # noqa: B008
) -> str:
    """Write a robot on its floor as MJCF, with a slider for the rate of each wheel.

    The servos are plain velocity servos with half of the torque that lifts a contact or makes a wheel slide, so that
    the sliders may jump; on a slope they have as much more as holds the robot. The keyframe "straight" drives at the
    speed to which the reference robot's 1.5 m/s scales with the wheels, and the sliders reach twice as far.
    `models/diffdrive.xml` is this file for the preset "mismatched".

    Args:
        robot: the true robot.
        physics: how it is solved; the file carries its numbers. None is what `simulate` takes.
        world: its floor, but for what changes on the way: patches and pushes.

    Returns:
        The XML; its numbers have six digits, as MjSpec writes them.

    Raises:
        InvalidValue: a robot that cannot stand, or that has a turning gain.

    Example:
        >>> model = mujoco.MjModel.from_xml_string(to_mjcf(Robot.load("turtlebot3_burger")))
        >>> model.actuator("left_servo").name
        'left_servo'
    """
    physics = suited(robot, physics)
    model = compile_model(robot, physics, world)
    spec = model_spec(robot, physics, world)
    spec.modelname = _printable(robot.name)
    spec.comment = _comment(robot)
    for pair in spec.pairs:
        pair.margin = float(model.pair(pair.name).margin[0])
    rolling, speed = level_twin(robot), _SPEED * robot.mean_radius / _RADIUS
    rates = speed / np.array([rolling.left_radius, rolling.right_radius])
    for side, rate in zip(("left", "right"), rates.tolist(), strict=True):
        spec.delete(spec.actuator(f"{side}_integral"))
        servo, torque = spec.actuator(f"{side}_servo"), _torque(robot, model, world, side, speed / rate)
        servo.gainprm[0] = -servo.biasprm[2] + spec.joint(side).damping[0]  # back-EMF of the motor
        servo.ctrlspec = 0  # or MjSpec writes an attribute that older readers do not know
        servo.ctrllimited = servo.forcelimited = mujoco.mjtLimited.mjLIMITED_TRUE
        servo.ctrlrange, servo.forcerange = (-2 * rate, 2 * rate), (-torque, torque)
    for name, ctrl in (("rest", 0 * rates), ("straight", rates)):
        spec.add_key(name=name, qpos=model.qpos0, ctrl=ctrl)
    return spec.to_xml()


def _torque(robot: Robot, model: mujoco.MjModel, world: World, side: str, radius: float) -> float:
    """Half of the torque [N m] with which a wheel, beside the other one, lifts a contact or slides on level floor.

    On a slope as much more as holds it there.
    """
    rotor = float(model.dof_armature[model.joint(side).dofadr[0]])
    spinning = float(model.body(f"{side}_wheel").inertia[1]) + rotor
    if robot.skids:
        spinning += float(model.body(f"{side}_rear_wheel").inertia[1])
        half = skid_acceleration(robot, world.friction) / 2
    else:
        half = largest_acceleration(robot, world.replace(slope=None)) / 2
    return (
        half * (robot.mass * radius / 2 + spinning / radius) + np.hypot(*gravity(world)[:2]) * robot.mass * radius / 2
    )


def _comment(robot: Robot) -> str:
    name = re.sub("-+", "-", _printable(robot.name))
    return (
        f" {name}: radii {robot.left_radius:g} and {robot.right_radius:g} m, track width {robot.track_width:g} m.\n"
        "       Written by diffdrive_mj with six digits a number, as MuJoCo's MjSpec does. The package itself drives\n"
        "       the robot with all digits, and with servos that have an integral part and no limits.\n"
        "       Axes: x forward, y left, z up. In MuJoCo's viewer each slider drives a wheel [rad/s]; the keyframe\n"
        '       "straight" drives. '
    )


def _printable(name: str) -> str:
    return "".join(character for character in name if character.isprintable())
