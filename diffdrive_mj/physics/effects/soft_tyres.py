"""Soft tyres: contacts that sink under the wheel's load, and wheels that roll on a smaller radius.

MuJoCo's contact is a spring whose point lies midway in the penetration: a wheel that sinks by h rolls on r - h/2.
"""

from __future__ import annotations

import math

import numpy as np

from diffdrive_mj._checks import Array
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.physics._mujoco import mujoco
from diffdrive_mj.physics.mechanics import resting_loads
from diffdrive_mj.physics.tilt import resting_tilt
from diffdrive_mj.robot import Robot
from diffdrive_mj.solver import Physics
from diffdrive_mj.world import World

# Of a contact: less, and contacts chatter; more, and bounces are much slower than a tyre's.
_IMPEDANCE = 0.9
_DAMPING_RATIO = math.sqrt(0.5)
# How much harder friction is made, since a softer contact is softer along the floor too. With all that it is softer by,
# wheels whose hubs are at unequal heights press against each other when the robot pitches.
_HARDER_FRICTION = 100.0
# Of the radius; beyond, no tyre is a linear spring.
_DEEPEST = 0.25


def sinks(robot: Robot, world: World) -> Array:
    """Return how far the tyres give way at rest (2,) [m], left then right.

    ```
    h = N / k
    ```

    Args:
        robot: its tyres, of the stiffness k, and the loads N of its wheels.
        world: its gravity, and its slope as in `mechanics.resting_loads`.

    Raises:
        InvalidType: not a robot, or not a world.

    Example:
        >>> soft = Robot.load("mismatched").replace(tyres={"stiffness": 40_000})
        >>> print(1000 * sinks(soft, World()))  # mm, under 16.677 N
        [0.4169 0.4169]
    """
    loads, stiffness = resting_loads(robot, world)[:2], robot.tyres.stiffness
    return np.zeros(2) if stiffness is None else loads / stiffness


def rolling_radii(robot: Robot, world: World) -> Array:
    """Return the radii on which the wheels roll (2,) [m], left then right, under their loads at rest.

    ```
    r - h / 2
    ```

    with what the tyre gives way, h. Real tyres roll on r - h/3 to r - h, by how they are built.

    Args:
        robot: its radii, tyres and loads.
        world: its gravity and slope.

    Raises:
        InvalidType: not a robot, or not a world.

    Example:
        >>> soft = Robot.load("mismatched").replace(tyres={"stiffness": 40_000})
        >>> print(1000 * rolling_radii(soft, World()))  # mm
        [99.7915 90.7915]
    """
    sunk = sinks(robot, world)
    return np.array([robot.left_radius, robot.right_radius]) - sunk / 2


def lower(spec: mujoco.MjSpec, robot: Robot, world: World, physics: Physics) -> None:
    """Lower the body by what its tyres give way; it is as level at rest as on rigid ones.

    Args:
        spec: a robot's model on rigid tyres, which is changed.
        robot: its tyres.
        world: its gravity.
        physics: is not read.

    Raises:
        InvalidValue: a robot that would sink onto its chassis, or by more than a quarter of a wheel's radius.

    Example:
        >>> from diffdrive_mj.physics.model import model_spec
        >>> soft = Robot.load("mismatched").replace(tyres={"stiffness": 40_000})
        >>> print(f"{1000 * (model_spec(soft).body('robot').pos[2] - 0.0955):.3f} mm")
        -0.417 mm
    """
    if robot.tyres.stiffness is None:
        return
    sunk = sinks(robot, world)
    _lower(spec, robot, sunk)
    _refuse_to_drag(spec, robot, sunk)


def soften(spec: mujoco.MjSpec, robot: Robot, world: World, physics: Physics) -> None:
    """Let the wheels' contacts give way; all masses of the model are in place by then.

    Args:
        spec: a robot's model with hard contacts, which is changed.
        robot: its tyres.
        world: is not read.
        physics: how hard contacts are at most.

    Example:
        >>> from diffdrive_mj.physics.model import model_spec
        >>> soft = Robot.load("mismatched").replace(tyres={"stiffness": 40_000})
        >>> print(model_spec(soft).pair("left_floor").solimp[:2])
        [0.9 0.9]
    """
    if robot.tyres.stiffness is None:
        return
    model = spec.copy().compile()
    impedance = 0.0
    for side in ("left", "right"):
        pair = spec.pair(f"{side}_floor")
        # The contact's own inverse inertia, as MuJoCo estimates it; what a contact sinks by is load (1 - d) / d of it.
        inverse = float(model.body_invweight0[model.body(f"{side}_wheel").id, 0])
        hardest = physics.contact_stiffness / physics.timestep**2
        impedance = min(max(_IMPEDANCE, 1 - hardest / (robot.tyres.stiffness * inverse)), physics.contact_impedance[0])
        stiffness = min(robot.tyres.stiffness * inverse * (1 - impedance), hardest)
        damping = min(2 * _DAMPING_RATIO * math.sqrt(stiffness), physics.contact_damping / physics.timestep)
        pair.solref, pair.solimp = (-stiffness, -damping), (impedance, impedance, 0.001, 0.5, 2)
    rigid = physics.contact_impedance[0]
    spec.option.impratio *= min((1 - impedance) / impedance * rigid / (1 - rigid), _HARDER_FRICTION)


def _lower(spec: mujoco.MjSpec, robot: Robot, sunk: Array) -> None:
    """Lower the body by what its wheels sink; independent hubs and the caster are set to where that leaves it level."""
    body, turned, drop = spec.body("robot"), np.empty(4), float(sunk.mean())
    roll = float(sunk[1] - sunk[0]) / resting_tilt(robot).track_width if robot.axle == "rigid" else 0.0
    for side, depth in zip(("left", "right"), sunk.tolist(), strict=True):
        hub = spec.body(f"{side}_wheel")
        if robot.axle == "independent":
            hub.pos = (*hub.pos[:2], hub.pos[2] + drop - depth)
    mujoco.mju_mulQuat(turned, np.array([math.cos(roll / 2), math.sin(roll / 2), 0, 0]), np.array(body.quat))
    body.pos, body.quat = (*body.pos[:2], body.pos[2] - drop), turned
    caster, up = spec.geom("caster"), _up(turned)
    caster.pos = (*caster.pos[:2], (robot.caster.radius - body.pos[2] - up[1] * caster.pos[1]) / up[2])


def _up(quaternion: Array) -> Array:
    """The world's vertical in a body's axes (3,)."""
    axes = np.empty(9)
    mujoco.mju_quat2Mat(axes, quaternion)
    return axes[6:]


def _refuse_to_drag(spec: mujoco.MjSpec, robot: Robot, sunk: Array) -> None:
    body, chassis = spec.body("robot"), spec.geom("chassis")
    up = _up(np.array(body.quat))
    lowest = body.pos[2] + up @ np.array(chassis.pos) - np.abs(up) @ np.array(chassis.size)
    side = int(np.argmax(sunk))
    if lowest > 0 and (sunk < _DEEPEST * np.array([robot.left_radius, robot.right_radius])).all():
        return
    why = "its chassis lies on the floor" if lowest <= 0 else "that is more than a quarter of its radius"
    raise InvalidValue(
        f"robot {robot.name}: Tyres.stiffness = {robot.tyres.stiffness:g} N/m lets its {('left', 'right')[side]} wheel "
        f"sink by {1000 * sunk[side]:.3g} mm: {why}"
    )
