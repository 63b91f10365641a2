"""Skid steer: the two wheels of the model become the front ones, and two more behind turn with them, as on a belt."""

from __future__ import annotations

from diffdrive_mj.physics._mujoco import mujoco
from diffdrive_mj.robot import Robot
from diffdrive_mj.solver import Physics
from diffdrive_mj.world import World

# What of a wheel's geoms a copy of it has too; `conaffinity` and `contype` are off in the model.
_SHAPE = ("type", "size", "pos", "quat", "group", "material", "rgba", "mass")
# Of the belt, as a constraint: what part of the two wheels' difference it takes out in a step, and how hard it is.
_STIFFNESS, _DAMPING, _IMPEDANCE = 0.25, 1.0, 0.9999


def four_wheels(spec: mujoco.MjSpec, robot: Robot, world: World, physics: Physics) -> None:
    """Let a robot with skid steer stand on four wheels, two a side that one motor drives.

    Args:
        spec: with the robot's two wheels, on which all other effects have worked.
        robot: with skid steer, or without: then nothing changes.
        world: not looked at.
        physics: its time step.

    Example:
        >>> robot = Robot(left_radius=0.165, right_radius=0.165, track_width=0.57, skid_steer={"wheelbase": 0.51})
        >>> [joint.name for joint in dd.model.model_spec(robot).joints]
        ['base', 'left', 'right', 'left_rear', 'right_rear']
    """
    if not robot.skids:
        return
    for part in (
        spec.pair("caster_floor"),
        spec.sensor("caster_contact"),
        spec.geom("caster"),
        spec.geom("caster_leg"),
    ):
        spec.delete(part)
    for side in ("left", "right"):
        _double(spec, side, robot.skid_steer.wheelbase / 2, physics.timestep)


def _double(spec: mujoco.MjSpec, side: str, half: float, timestep: float) -> None:
    front = spec.body(f"{side}_wheel")
    x, y, z = front.pos
    front.pos = (x + half, y, z)
    rear = spec.body("robot").add_body(name=f"{side}_rear_wheel", pos=(x - half, y, z))
    rear.mass, rear.inertia, rear.ipos, rear.explicitinertial = front.mass, front.inertia, front.ipos, True
    joint, drag = (
        spec.joint(side),
        rear.add_joint(name=f"{side}_rear", type=mujoco.mjtJoint.mjJNT_HINGE, axis=(0, 1, 0)),
    )
    drag.frictionloss, drag.damping = joint.frictionloss, joint.damping
    for geom in front.geoms:
        copy = rear.add_geom(name=geom.name.replace(side, f"{side}_rear"))
        for field in _SHAPE:
            setattr(copy, field, getattr(geom, field))
        copy.alt.type, copy.alt.euler = geom.alt.type, geom.alt.euler
        copy.contype = copy.conaffinity = 0
    belt = spec.add_equality(
        name=f"{side}_belt",
        type=mujoco.mjtEq.mjEQ_JOINT,
        objtype=mujoco.mjtObj.mjOBJ_JOINT,
        name1=f"{side}_rear",
        name2=side,
        solref=(-_STIFFNESS / timestep**2, -_DAMPING / timestep),
        solimp=(_IMPEDANCE, _IMPEDANCE, 0.001, 0.5, 2),
    )
    belt.data[:5] = (0, 1, 0, 0, 0)
    pair = spec.pair(f"{side}_floor")
    spec.add_pair(
        name=f"{side}_rear_floor",
        geomname1="floor",
        geomname2=f"{side}_rear_tyre",
        condim=pair.condim,
        friction=pair.friction,
        solref=pair.solref,
        solreffriction=pair.solreffriction,
        solimp=pair.solimp,
        margin=pair.margin,
        gap=pair.gap,
    )
    sensor = spec.sensor(f"{side}_contact")
    spec.add_sensor(
        name=f"{side}_rear_contact",
        type=sensor.type,
        objtype=sensor.objtype,
        objname="floor",
        reftype=sensor.reftype,
        refname=f"{side}_rear_tyre",
        intprm=sensor.intprm,
        datatype=sensor.datatype,
        needstage=sensor.needstage,
        dim=sensor.dim,
    )
