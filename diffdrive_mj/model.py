"""The robot as a MuJoCo model: `models/diffdrive.xml` with a robot's own numbers.

The XML holds the structure, this module the numbers. The frame of the body "robot" sits at the midpoint of the
two wheel centres, so that its pose is the pose that odometry is about.
"""

from __future__ import annotations

import functools
import math

import mujoco
import numpy as np

from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.resources import MODELS
from diffdrive_mj.robot import Robot
from diffdrive_mj.world import Physics, World

XML = MODELS / "diffdrive.xml"
_QUARTER_TURN_ABOUT_X = (math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0)
_MASS_PER_VOLUME_OF_A_BODY = 350.0


@functools.lru_cache(maxsize=1024)
def compile_model(robot: Robot, world: World = World(), physics: Physics = Physics()) -> mujoco.MjModel:  # noqa: B008
    """The compiled model of a robot; do not edit it, others get the same one.

    Raises:
        InvalidValue: a servo too stiff for the time step.
    """
    spec = _template().copy()
    _set_options(spec, physics)
    _set_body(spec, robot)
    for side, y, radius in (("left", 1, robot.left_radius), ("right", -1, robot.right_radius)):
        _set_wheel(spec, robot, physics, side, y * robot.track_width / 2, radius)
    _set_contacts(spec, world, physics)
    return spec.compile()


@functools.cache
def _template() -> mujoco.MjSpec:
    return mujoco.MjSpec.from_file(str(XML))


def _set_options(spec: mujoco.MjSpec, physics: Physics) -> None:
    spec.option.timestep = physics.timestep
    spec.option.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{physics.integrator.upper()}")
    spec.option.cone = getattr(mujoco.mjtCone, f"mjCONE_{physics.cone.upper()}")
    spec.option.tolerance = physics.tolerance


def tilt(robot: Robot) -> float:
    """The roll of a robot whose unequal wheels sit on one straight axle [rad], positive to the right side.

    The centres are a track width apart and a radius above the floor each, the wheels being thin:
    tan(roll) = (r_l - r_r) / b to second order. A robot hung level does not tilt.
    """
    if robot.hanging == "level":
        return 0.0
    return math.asin((robot.left_radius - robot.right_radius) / robot.track_width)


def _set_body(spec: mujoco.MjSpec, robot: Robot) -> None:
    height = robot.mean_radius
    body = spec.body("robot")
    body.pos = (0, 0, height)
    body.quat = (math.cos(tilt(robot) / 2), math.sin(tilt(robot) / 2), 0, 0)
    body.mass = robot.body_mass
    body.ipos = (robot.center_of_mass_x, 0, robot.center_of_mass_height - height)
    # A box that spans axle and caster, as wide as fits between the wheels and as high as its mass asks for.
    length = abs(robot.caster_x) + robot.mean_radius
    width = max(robot.track_width - 1.5 * robot.wheel_width, robot.track_width / 2)
    thickness = min(robot.body_mass / (_MASS_PER_VOLUME_OF_A_BODY * length * width), length)
    box = np.array([length, width, thickness])
    body.inertia = robot.body_mass / 12 * (np.sum(box**2) - box**2)
    front = math.copysign(1, -robot.caster_x)
    center = np.array([(robot.caster_x + front * robot.mean_radius) / 2, 0, 0.3 * robot.mean_radius])
    chassis = spec.geom("chassis")
    chassis.pos, chassis.size = center, box / 2
    nose = spec.geom("nose")
    nose.pos = center + np.array([length / 2, 0, 0])
    nose.size = box * (0.02, 0.15, 0.25)
    caster = spec.geom("caster")
    caster.pos = (robot.caster_x, 0, robot.caster_radius - height)
    caster.size = (robot.caster_radius, 0, 0)
    spec.site("axle").size = (0.08 * height, 0, 0)


def _set_wheel(spec: mujoco.MjSpec, robot: Robot, physics: Physics, side: str, y: float, radius: float) -> None:
    wheel = spec.body(f"{side}_wheel")
    wheel.pos = (0, y, radius - robot.mean_radius if robot.hanging == "level" else 0)
    wheel.mass = robot.wheel_mass
    spin_inertia = robot.wheel_mass * radius**2 / 2
    across = spin_inertia / 2 + robot.wheel_mass * robot.wheel_width**2 / 12
    wheel.inertia = (across, spin_inertia, across)
    tyre = spec.geom(f"{side}_tyre")
    if physics.wheel_shape == "cylinder":
        tyre.type = mujoco.mjtGeom.mjGEOM_CYLINDER
        tyre.size = (radius, robot.wheel_width / 2, 0)
        tyre.quat = _QUARTER_TURN_ABOUT_X
    else:
        tyre.size = (radius, robot.wheel_width / 2, radius)
    armature, gain = servo(robot, physics, radius)
    spec.joint(side).armature = armature
    actuator = spec.actuator(f"{side}_servo")
    actuator.gainprm[0] = gain
    actuator.biasprm[2] = -gain


def servo(robot: Robot, physics: Physics, radius: float) -> tuple[float, float]:
    """Reflected rotor inertia [kg m^2] and stiffness [N m s/rad] at a wheel of some radius.

    With stiffness and inertias in proportion to the radius squared, both wheels follow the ground speed that
    they are told with one time constant, and a compensated robot speeds up along its line.
    """
    matched = robot.servo_gains == "matched"
    scale = (radius / robot.mean_radius) ** 2 if matched else 1.0
    armature = robot.rotor_inertia * scale
    limiting_radius = radius if matched else min(robot.left_radius, robot.right_radius)
    inertia = robot.wheel_mass * limiting_radius**2 / 2 + armature
    stiffest = physics.servo_stiffness * inertia / physics.timestep
    if math.isinf(robot.servo_stiffness):
        return armature, stiffest
    gain = robot.servo_stiffness * scale
    allowed = 1.5 / physics.servo_stiffness * stiffest / scale
    if physics.integrator in ("Euler", "RK4") and robot.servo_stiffness > allowed:
        raise InvalidValue(
            f"Robot.servo_stiffness = {robot.servo_stiffness:g} N m s/rad: must be at most {allowed:.4g} "
            f"for a time step of {physics.timestep:g} s, or a free wheel diverges"
        )
    return armature, gain


def _set_contacts(spec: mujoco.MjSpec, world: World, physics: Physics) -> None:
    touching, deep = physics.contact_impedance
    for pair in spec.pairs:
        pair.solref = (physics.contact_time * physics.timestep, 1)
        pair.solimp = (touching, deep, 0.001, 0.5, 2)
        if pair.name != "caster_floor":
            pair.friction = (world.friction, world.friction, 0, 0, 0)
            damping = physics.friction_damping
            pair.solreffriction = (0, 0) if damping is None else (0, -damping / physics.timestep)
