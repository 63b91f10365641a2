"""The robot as a MuJoCo model: `models/diffdrive.xml` with a robot's own numbers.

The XML holds the structure, this module the numbers. The frame of the body "robot" sits on the axle, above the midpoint
of the wheels' contacts, so that its pose is the pose that odometry is about.
"""

from __future__ import annotations

import functools
import math

import numpy as np
from numpy.typing import NDArray

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj._resources import MODELS
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.physics._looks import dress
from diffdrive_mj.physics._mujoco import mujoco
from diffdrive_mj.physics.effects import EFFECTS
from diffdrive_mj.physics.mechanics import body_box, box_inertia, box_lift, gravity, resting_loads
from diffdrive_mj.physics.servo import servo_gains
from diffdrive_mj.physics.skidding import wheel_loads
from diffdrive_mj.physics.tilt import resting_tilt
from diffdrive_mj.robot import Robot
from diffdrive_mj.solver import Physics
from diffdrive_mj.world import GRAVITY, World

XML = MODELS / "diffdrive.xml"
# What touches the floor, as the model names it, in the order of the loads: without skid steer and with it.
CONTACTS = (
    {"left": "left wheel", "right": "right wheel", "caster": "caster"},
    {"left": "left front wheel", "right": "right front wheel"}
    | {"left_rear": "left rear wheel", "right_rear": "right rear wheel"},
)
_QUARTER_TURN_ABOUT_X = (math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0)


def compile_model(
    robot: Robot,
    physics: Physics = Physics(),  # noqa: B008
    world: World = World(),  # noqa: B008
) -> mujoco.MjModel:
    """Compile the model of a robot; do not edit it, others get the same one.

    Args:
        robot: with its sizes and masses.
        physics: how it is solved.
        world: its floor; what changes on the way, patches and pushes, is not in the model.

    Raises:
        InvalidValue: a robot with a turning gain, which is a belief of odometry alone; one that cannot stand; or one
            whose masses and sizes are out of MuJoCo's range.
        InvalidType: not a robot, not physics, not a world.

    Example:
        >>> compile_model(Robot.load("ct_bot")).opt.timestep
        0.002
    """
    checks.instance("robot", robot, Robot)
    checks.instance("physics", physics, Physics)
    checks.instance("world", world, World)
    return _compiled(robot, physics, _bare(world))


@functools.lru_cache(maxsize=16)
def _bare(world: World) -> World:
    """What of a world is in the model."""
    return world.replace(name="", patches=(), pushes=())


@functools.lru_cache(maxsize=128)  # a few hundred kilobytes each
def _compiled(robot: Robot, physics: Physics, world: World) -> mujoco.MjModel:
    if robot.turning_gain:
        raise InvalidValue(
            f"Robot.turning_gain = {robot.turning_gain:g}: must be 0 for a robot that drives in physics, where the "
            "contacts decide how it turns; odometry may believe in one"
        )
    loads = static_loads(robot, world)
    spec = model_spec(robot, physics, world)
    try:
        model = spec.compile()
    except ValueError as error:
        reason = " ".join(str(error).removeprefix("Error: ").split())
        raise InvalidValue(
            f"robot {robot.name}: MuJoCo cannot build it ({reason}); check its masses and sizes"
        ) from None
    if physics.balanced_contacts:
        _balance(model, physics, dict(zip(CONTACTS[robot.skids], loads.tolist(), strict=True)))
    return model


def model_spec(
    robot: Robot,
    physics: Physics = Physics(),  # noqa: B008
    world: World = World(),  # noqa: B008
) -> mujoco.MjSpec:
    """`models/diffdrive.xml` with the numbers of a robot and a world; balancing its contacts takes a compiled model.

    Args:
        robot: as for `compile_model`.
        physics: as for `compile_model`.
        world: as for `compile_model`.

    Example:
        >>> spec = model_spec(Robot.load("ct_bot"))
        >>> spec.body("robot").mass
        0.48
    """
    checks.instance("robot", robot, Robot)
    checks.instance("physics", physics, Physics)
    checks.instance("world", world, World)
    spec = _template().copy()
    _set_options(spec, physics)
    _set_body(spec, robot)
    _set_wheel(spec, robot, physics, "left", robot.track_width / 2, robot.left_radius)
    _set_wheel(spec, robot, physics, "right", -robot.track_width / 2, robot.right_radius)
    _set_contacts(spec, physics, world.friction)
    dress(spec, robot)
    for effect in EFFECTS:
        effect(spec, robot, world, physics)
    return spec


def suited(robot: Robot, physics: Physics | None = None) -> Physics:
    """Return the physics that is asked for, or else what suits a robot: soft contacts where its wheels slide.

    Args:
        robot: with skid steer or without.
        physics: that is asked for.

    Example:
        >>> suited(Robot.load("ct_bot")) == Physics()
        True
    """
    if physics is not None:
        return checks.instance("physics", physics, Physics)
    return Physics.skidding() if checks.instance("robot", robot, Robot).skids else Physics()


def static_loads(robot: Robot, world: World = World()) -> Array:  # noqa: B008
    """Return what the left wheel, the right wheel and the caster, or the four wheels, carry at rest (3,) or (4,) [N].

    Args:
        robot: the true robot, its axle's tilt included.
        world: its gravity; on a slope the mean over all headings, which is what gravity across the floor makes of it.

    Raises:
        InvalidValue: one of them carries nothing, so that the robot cannot stand.

    Example:
        >>> print(static_loads(Robot.load("matched")))
        [16.677 16.677 11.772]
    """
    across = -float(gravity(world)[2])
    checks.instance("robot", robot, Robot)
    loads = wheel_loads(robot) * (across / GRAVITY) if robot.skids else resting_loads(robot, world)
    for load, contact in zip(loads.tolist(), CONTACTS[robot.skids].values(), strict=True):
        if load <= 0:
            raise InvalidValue(
                f"robot {robot.name}: cannot stand, its {contact} would carry {load:.3g} N at rest; the centre of mass "
                "must lie within the triangle of the contacts"
            )
    return loads


def pairs_of(model: mujoco.MjModel, geom: str) -> NDArray[np.intp]:
    """Find the contact pairs of a shape of the robot: with the floor, and with what lies on it.

    Args:
        model: of a robot in a world.
        geom: the shape's name.

    Returns:
        (n,), their numbers.

    Example:
        >>> model = compile_model(Robot.load("ct_bot"))
        >>> [model.pair(number).name for number in pairs_of(model, "left_tyre")]
        ['left_floor']
    """
    number = checks.instance("model", model, mujoco.MjModel).geom(checks.string("geom", geom)).id
    return np.flatnonzero((model.pair_geom1 == number) | (model.pair_geom2 == number))


@functools.cache
def _template() -> mujoco.MjSpec:
    spec = mujoco.MjSpec.from_file(str(XML))
    for key in list(spec.keys):
        spec.delete(key)  # they are for the viewer
    return spec


def _balance(model: mujoco.MjModel, physics: Physics, loads: dict[str, float]) -> None:
    """Let each contact act above the floor by what it would sink under its load, but for those that are to sink.

    At rest a contact of impedance d, stiffness k and regularisation R sinks by R load d / k.
    """
    for name, load in loads.items():
        geom = "caster" if name == "caster" else f"{name}_tyre"
        body = int(model.geom(geom).bodyid[0])
        if model.pair(f"{geom.removesuffix('_tyre')}_floor").solimp[0] < physics.contact_impedance[0]:
            continue
        for pair in pairs_of(model, geom).tolist():  # with the floor, and with what lies on it
            impedance, stiffness = float(model.pair_solimp[pair, 0]), -float(model.pair_solref[pair, 0])
            compliance = (1 - impedance) / impedance * float(model.body_invweight0[body, 0])
            model.pair_margin[pair] = compliance * load * impedance / stiffness


def _set_options(spec: mujoco.MjSpec, physics: Physics) -> None:
    spec.option.timestep = physics.timestep
    spec.option.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{physics.integrator.upper()}")
    spec.option.cone = getattr(mujoco.mjtCone, f"mjCONE_{physics.cone.upper()}")
    spec.option.impratio = physics.friction_impedance
    spec.option.tolerance = physics.tolerance


def _set_body(spec: mujoco.MjSpec, robot: Robot) -> None:
    at = resting_tilt(robot)
    height = at.height + at.offset * math.tan(at.roll)
    body = spec.body("robot")
    body.pos = (0, 0, height)
    body.quat = (math.cos(at.roll / 2), math.sin(at.roll / 2), 0, 0)
    body.mass = robot.body_mass + robot.payload.mass
    body.ipos = robot.loaded_center_of_mass - np.array([0, 0, height])
    box = body_box(robot)
    _set_inertia(body, robot, box_inertia(robot.body_mass, box))
    front = math.copysign(1, -robot.caster.x)
    x = 0.0 if robot.skids else (robot.caster.x + front * robot.mean_radius) / 2
    center = (x, 0.0, box_lift(robot))
    chassis = spec.geom("chassis")
    chassis.pos, chassis.size = center, box / 2
    caster = spec.geom("caster")
    caster.pos = (robot.caster.x, 0, (robot.caster.radius - height) / math.cos(at.roll))
    caster.size = (robot.caster.radius, 0, 0)


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
    if robot.tyres.shape == "cylinder":
        tyre.type = mujoco.mjtGeom.mjGEOM_CYLINDER
        tyre.size = (radius, robot.tyres.width / 2, 0)
        tyre.quat = _QUARTER_TURN_ABOUT_X
    else:
        tyre.size = (radius, robot.tyres.width / 2, radius)
    gains = servo_gains(robot, physics, radius)
    spec.joint(side).armature = gains.armature
    speed = spec.actuator(f"{side}_servo")
    speed.gainprm[0], speed.biasprm[2] = gains.feedforward, -gains.damping
    speed.ctrllimited = speed.forcelimited = mujoco.mjtLimited.mjLIMITED_FALSE
    speed.ctrlrange = speed.forcerange = (0, 0)
    spring = spec.add_actuator(
        name=f"{side}_integral",
        target=side,
        trntype=mujoco.mjtTrn.mjTRN_JOINT,
        dyntype=mujoco.mjtDyn.mjDYN_INTEGRATOR,
        gaintype=mujoco.mjtGain.mjGAIN_FIXED,
        biastype=mujoco.mjtBias.mjBIAS_AFFINE,
    )
    spring.gainprm[0], spring.biasprm[1] = gains.integral, -gains.integral


def _set_contacts(spec: mujoco.MjSpec, physics: Physics, friction: float) -> None:
    touching, deep = physics.contact_impedance
    dt = physics.timestep
    for pair in spec.pairs:
        if pair.name == "chassis_floor":
            continue
        pair.solref = (-physics.contact_stiffness / dt**2, -physics.contact_damping / dt)
        pair.solimp = (touching, deep, 0.001, 0.5, 2)
        pair.margin = 0  # until it is balanced
        if pair.name != "caster_floor":
            pair.friction = (friction, friction, 0, 0, 0)
            damping = physics.friction_damping
            pair.solreffriction = (0, 0) if damping is None else (0, -damping / dt)
