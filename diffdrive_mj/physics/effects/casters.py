"""Casters that are more than a frictionless ball: one that drags on the floor, and a wheel in a fork that swivels."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.physics._mujoco import mujoco
from diffdrive_mj.physics.mechanics import fork_trail, resting_loads
from diffdrive_mj.robot import Robot
from diffdrive_mj.solver import Physics
from diffdrive_mj.world import World

# MuJoCo's friction cone throws up what slides, by as much as it is sped up along its way, where the contact is hard (an
# impedance near 1). A soft one is a spring and a damper that hardly notices: in parts of a step, as `Physics` has them.
_IMPEDANCE, _STIFFNESS, _DAMPING, _SLIP, _HARDER_FRICTION = 0.01, 0.4, 0.7, 0.1, 10.0
_POINTS = 6
# Of a swivel caster: shares of the body's mass, and half the wheel's width over its radius.
_WHEEL_SHARE, _FORK_SHARE, _HALF_WIDTH = 0.01, 0.005, 0.35


def drag(spec: mujoco.MjSpec, robot: Robot, world: World, physics: Physics) -> None:
    """Let a ball rub on the floor, with a force of the coefficient times its load against its motion.

    Args:
        spec: a robot's model with a frictionless ball, which is changed.
        robot: its caster and loads.
        world: its gravity.
        physics: its time step.

    Example:
        >>> from diffdrive_mj.physics.model import model_spec
        >>> spec = model_spec(Robot.load("matched").replace(caster={"friction": 0.2}))
        >>> print(spec.pair("caster_floor").friction[:2])
        [0.2 0.2]
    """
    if robot.caster.kind != "ball" or robot.caster.friction == 0:
        return
    pair, caster, dt = spec.pair("caster_floor"), spec.geom("caster"), physics.timestep
    estimated, inverse = _inverse_inertias(spec.copy().compile(), robot)
    # A heightfield touches a ball in several points, each of them a spring and a damper.
    stiffness, damping = (part / (1 if world.rough is None else _POINTS) for part in (_STIFFNESS, _DAMPING))
    sink = float(resting_loads(robot, world)[2]) * inverse * (1 - _IMPEDANCE) * dt**2 / stiffness
    caster.pos = (*caster.pos[:2], caster.pos[2] - sink)
    share = estimated / inverse
    pair.condim, pair.friction = 3, (robot.caster.friction, robot.caster.friction, 0, 0, 0)
    pair.solref, pair.solimp = (-share * stiffness / dt**2, -share * damping / dt), (*[_IMPEDANCE] * 2, 0.001, 0.5, 2)
    pair.solreffriction = (0, -_SLIP * _IMPEDANCE / dt)  # which MuJoCo divides by the impedance
    spec.option.impratio *= _HARDER_FRICTION


def _inverse_inertias(model: mujoco.MjModel, robot: Robot) -> tuple[float, float]:
    """What a vertical force at the caster accelerates [1/kg], as MuJoCo takes it for the whole body, and exactly."""
    data, body = mujoco.MjData(model), int(model.body("robot").id)
    mujoco.mj_forward(model, data)
    lever, moved = np.empty((3, model.nv)), np.empty((1, model.nv))
    mujoco.mj_jac(model, data, lever, None, data.geom("caster").xpos, body)
    mujoco.mj_solveM(model, data, moved, lever[2:])
    return float(model.body_invweight0[body, 0]), float(moved[0] @ lever[2])


def swivel(spec: mujoco.MjSpec, robot: Robot, world: World, physics: Physics) -> None:
    """Put a wheel in a fork that turns about the vertical in the place of the ball.

    Args:
        spec: a robot's model with a ball, which is changed.
        robot: its caster.
        world: is not read; the caster has the wheels' friction.
        physics: is not read.

    Raises:
        InvalidValue: a caster that reaches through the floor or the wheels' axle.

    Example:
        >>> from diffdrive_mj.physics.model import model_spec
        >>> spec = model_spec(Robot.load("matched").replace(caster={"kind": "swivel", "angle": 0.5}))
        >>> spec.joint("caster_fork").type.name
        'mjJNT_HINGE'
    """
    if robot.caster.kind != "swivel":
        return
    body, caster, trail = spec.body("robot"), robot.caster, fork_trail(robot)
    spec.delete(spec.geom("caster"))
    angle, half = caster.angle, _HALF_WIDTH * caster.radius
    wheel_mass, fork_mass = _WHEEL_SHARE * robot.body_mass, _FORK_SHARE * robot.body_mass
    height = _hub_height(body, robot, trail, half)
    fork = body.add_body(
        name="caster_fork",
        pos=(caster.x, 0, height),
        quat=(math.cos(angle / 2), 0, 0, math.sin(angle / 2)),
        mass=fork_mass,
        ipos=(0, 0, 0),
        inertia=np.full(3, fork_mass * max(trail, caster.radius) ** 2),
        explicitinertial=True,
    )
    fork.add_joint(name="caster_fork", type=mujoco.mjtJoint.mjJNT_HINGE, axis=(0, 0, 1))
    across = wheel_mass * (caster.radius**2 / 4 + half**2 / 3)
    wheel = fork.add_body(
        name="caster_wheel",
        pos=(-trail, 0, 0),
        mass=wheel_mass,
        ipos=(0, 0, 0),
        inertia=(across, wheel_mass * caster.radius**2 / 2, across),
        explicitinertial=True,
    )
    wheel.add_joint(name="caster_wheel", type=mujoco.mjtJoint.mjJNT_HINGE, axis=(0, 1, 0))
    wheel.add_geom(
        spec.find_default("tyre"),
        name="caster",
        size=(caster.radius, half, caster.radius),
    )
    _dress(spec, fork, wheel, robot, trail, half)
    _lighten(body, robot, trail, height)
    pair, wheels = spec.pair("caster_floor"), spec.pair("left_floor")
    pair.condim, pair.friction, pair.solreffriction = 3, wheels.friction, wheels.solreffriction


def _hub_height(body: mujoco.MjsBody, robot: Robot, trail: float, half: float) -> float:
    """Where in the body's axes the caster's hub is, so that its wheel touches the floor at rest [m]."""
    axes = np.empty(9)
    mujoco.mju_quat2Mat(axes, np.array(body.quat))
    up, a = axes[6:], robot.caster.angle
    axle = float(up @ (-math.sin(a), math.cos(a), 0))
    depth = math.hypot(robot.caster.radius * math.sqrt(1 - axle**2), half * axle)
    x, y = robot.caster.x - trail * math.cos(a), -trail * math.sin(a)
    return float((depth - body.pos[2] - up[0] * x - up[1] * y) / up[2])


def _lighten(body: mujoco.MjsBody, robot: Robot, trail: float, height: float) -> None:
    """Take the caster's mass out of the body's, so that the robot weighs what it weighs, and where, at the start."""
    a, caster = robot.caster.angle, robot.caster
    masses = np.array([_FORK_SHARE, _WHEEL_SHARE]) * robot.body_mass
    along = np.array([0.0, -trail])
    places = np.stack([caster.x + along * math.cos(a), along * math.sin(a), np.full(2, height)], axis=-1)
    whole = float(body.mass)
    body.ipos = (whole * np.array(body.ipos) - masses @ places) / (whole - masses.sum())
    body.mass = whole - masses.sum()


def _dress(
    spec: mujoco.MjSpec, fork: mujoco.MjsBody, wheel: mujoco.MjsBody, robot: Robot, trail: float, half: float
) -> None:
    """The wheel as a disc with a mark, and the fork's cheeks and stem."""
    radius, look, disc = robot.caster.radius, spec.find_default("look"), spec.find_default("disc")
    box, leg = mujoco.mjtGeom.mjGEOM_BOX, spec.geom("caster_leg")
    wheel.add_geom(disc, name="caster_disc", size=(radius, half, 0))
    wheel.add_geom(
        look, name="caster_mark", type=box, pos=(0, 0, radius / 2), size=(radius / 8, 1.05 * half, radius / 2.2)
    )
    top = 1.15 * radius
    for side, y in (("left", 1.4 * half), ("right", -1.4 * half)):
        fork.add_geom(
            look, name=f"caster_cheek_{side}", type=box, material="metal",
            pos=(-trail / 2, y, top / 2), size=((trail + radius / 2) / 2, half / 5, top / 2),
        )  # fmt: skip
    fork.add_geom(
        look, name="caster_yoke", type=box, material="metal",
        pos=(-trail / 2, 0, top), size=((trail + radius / 2) / 2, 1.6 * half, radius / 8),
    )  # fmt: skip
    stem = max(float(leg.pos[2] + leg.size[1]) - fork.pos[2] - top, radius / 4)
    leg.pos, leg.size = (robot.caster.x, 0, fork.pos[2] + top + stem / 2), (radius / 3, stem / 2, 0)


def one_kind(robots: Sequence[Robot]) -> None:
    """See that robots that are driven together have casters of one kind, and so models of one layout.

    Args:
        robots: to be driven in one batch.

    Raises:
        InvalidValue: they have not.

    Example:
        >>> one_kind([Robot.load("matched"), Robot.load("ct_bot")])
    """
    kinds = {robot.caster.kind for robot in robots}
    if len(kinds) > 1:
        raise InvalidValue("robot: ball and swivel casters cannot be driven in one batch; simulate each kind by itself")
