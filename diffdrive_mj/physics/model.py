"""The robot as a MuJoCo model: `models/diffdrive.xml` with a robot's own numbers.

The XML holds the structure, this module the numbers. The frame of the body "robot" sits on the axle, above the midpoint
of the wheels' contacts, so that its pose is the pose that odometry is about.
"""

from __future__ import annotations

import functools
import math

import mujoco
import numpy as np
from numpy.typing import NDArray

from diffdrive_mj._resources import MODELS
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.physics.servo import servo_gains
from diffdrive_mj.physics.tilt import resting_tilt
from diffdrive_mj.robot import Robot
from diffdrive_mj.solver import Physics

XML = MODELS / "diffdrive.xml"
_QUARTER_TURN_ABOUT_X = (math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0)
_MASS_PER_VOLUME_OF_A_BODY = 350.0


@functools.lru_cache(maxsize=1024)
def compile_model(
    robot: Robot,
    physics: Physics = Physics(),  # noqa: B008
    friction: tuple[float, float] = (1.0, 1.0),
) -> mujoco.MjModel:
    """The compiled model of a robot; do not edit it, others get the same one.

    Args:
        robot, physics: whose numbers it gets.
        friction: coefficients of the floor under the left and the right wheel.

    Raises:
        InvalidValue: a robot with a turning gain, which is a belief of odometry alone.
    """
    if robot.turning_gain:
        raise InvalidValue(
            f"Robot.turning_gain = {robot.turning_gain:g}: must be 0 for a robot that drives in physics, where the "
            "contacts decide how it turns; odometry may believe in one"
        )
    spec = _template().copy()
    _set_options(spec, physics)
    _set_body(spec, robot)
    _set_wheel(spec, robot, physics, "left", robot.track_width / 2, robot.left_radius)
    _set_wheel(spec, robot, physics, "right", -robot.track_width / 2, robot.right_radius)
    _set_contacts(spec, physics, friction)
    return spec.compile()


@functools.cache
def _template() -> mujoco.MjSpec:
    return mujoco.MjSpec.from_file(str(XML))


def _set_options(spec: mujoco.MjSpec, physics: Physics) -> None:
    spec.option.timestep = physics.timestep
    spec.option.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{physics.integrator.upper()}")
    spec.option.cone = getattr(mujoco.mjtCone, f"mjCONE_{physics.cone.upper()}")
    spec.option.tolerance = physics.tolerance


def _set_body(spec: mujoco.MjSpec, robot: Robot) -> None:
    at = resting_tilt(robot)
    height = at.height + at.offset * math.tan(at.roll)
    body = spec.body("robot")
    body.pos = (0, 0, height)
    body.quat = (math.cos(at.roll / 2), math.sin(at.roll / 2), 0, 0)
    body.mass = robot.body_mass + robot.payload.mass
    body.ipos = robot.loaded_center_of_mass - np.array([0, 0, height])
    # A box that spans axle and caster, as wide as fits between the wheels and as high as its mass asks for.
    length = abs(robot.caster.x) + robot.mean_radius
    width = max(robot.track_width - 1.5 * robot.tyres.width, robot.track_width / 2)
    thickness = min(robot.body_mass / (_MASS_PER_VOLUME_OF_A_BODY * length * width), length)
    box = np.array([length, width, thickness])
    _set_inertia(body, robot, robot.body_mass / 12 * (np.sum(box**2) - box**2))
    front = math.copysign(1, -robot.caster.x)
    lift = max(0.3 * robot.mean_radius, thickness / 2 - 0.8 * robot.mean_radius)  # well above the floor
    center = np.array([(robot.caster.x + front * robot.mean_radius) / 2, 0, lift])
    chassis = spec.geom("chassis")
    chassis.pos, chassis.size = center, box / 2
    nose = spec.geom("nose")
    nose.pos = center + np.array([length / 2, 0, 0])
    nose.size = box * (0.02, 0.15, 0.25)
    caster = spec.geom("caster")
    caster.pos = (robot.caster.x, 0, (robot.caster.radius - height) / math.cos(at.roll))
    caster.size = (robot.caster.radius, 0, 0)
    spec.site("axle").size = (0.08 * height, 0, 0)


def _set_inertia(body: mujoco.MjsBody, robot: Robot, of_body: NDArray[np.float64]) -> None:
    """About the common centre of mass of the body and its payload, a point mass (parallel axis theorem)."""
    load = robot.payload
    arm = np.array([load.x - robot.center_of_mass_x, load.y, load.height - robot.center_of_mass_height])
    reduced = load.mass * robot.body_mass / (load.mass + robot.body_mass)
    inertia = np.diag(of_body) + reduced * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    body.inertia = of_body
    if load.mass:
        body.inertia = (0, 0, 0)
        body.fullinertia = (*np.diag(inertia), inertia[0, 1], inertia[0, 2], inertia[1, 2])


def _set_wheel(spec: mujoco.MjSpec, robot: Robot, physics: Physics, side: str, y: float, radius: float) -> None:
    wheel = spec.body(f"{side}_wheel")
    at = resting_tilt(robot)
    wheel.pos = (0, y - at.offset / math.cos(at.roll), radius - at.height if robot.axle == "independent" else 0)
    wheel.mass = robot.tyres.mass
    spin_inertia = robot.tyres.mass * radius**2 / 2
    across = spin_inertia / 2 + robot.tyres.mass * robot.tyres.width**2 / 12
    wheel.inertia = (across, spin_inertia, across)
    tyre = spec.geom(f"{side}_tyre")
    if physics.wheel_shape == "cylinder":
        tyre.type = mujoco.mjtGeom.mjGEOM_CYLINDER
        tyre.size = (radius, robot.tyres.width / 2, 0)
        tyre.quat = _QUARTER_TURN_ABOUT_X
    else:
        tyre.size = (radius, robot.tyres.width / 2, radius)
    gains = servo_gains(robot, physics, radius)
    spec.joint(side).armature = gains.armature
    speed, angle = spec.actuator(f"{side}_servo"), spec.actuator(f"{side}_integral")
    speed.gainprm[0], speed.biasprm[2] = gains.proportional, -gains.proportional
    angle.gainprm[0], angle.biasprm[1] = gains.integral, -gains.integral


def _set_contacts(spec: mujoco.MjSpec, physics: Physics, friction: tuple[float, float]) -> None:
    under = dict(zip(("left_floor", "right_floor"), friction, strict=True))
    touching, deep = physics.contact_impedance
    for pair in spec.pairs:
        pair.solref = (physics.contact_time * physics.timestep, 1)
        pair.solimp = (touching, deep, 0.001, 0.5, 2)
        if pair.name in under:
            pair.friction = (under[pair.name], under[pair.name], 0, 0, 0)
            damping = physics.friction_damping
            pair.solreffriction = (0, 0) if damping is None else (0, -damping / physics.timestep)
