"""How wheels, caster and chassis touch what lies on the floor: as they touch the floor, but softer.

A wheel that rolls over a crest leaves it in every step by v^2 dt^2 / (2 R), since a step goes along the tangent, and a
contact that has lost its wheel holds it no more: the servo spins it up within a step. The contact keeps it where the
wheel sinks in by more than that, about (1 - impedance) / stiffness g dt^2: on the hard floor, which is flat, 8 nm, and
here some ten micrometres, which is enough up to v^2 / R of about g / 2.
"""

from __future__ import annotations

from diffdrive_mj.physics._mujoco import mujoco
from diffdrive_mj.solver import Physics

# The sensor of what lies under the chassis.
GROUNDED = "chassis_grounded"
_IMPEDANCE, _STIFFNESS = 0.9, 0.25
# Of what touches a wheel at once, so many contacts are recorded, those with the largest forces.
_RECORDED, _BY_FORCE = 4, 2


def touch(spec: mujoco.MjSpec, physics: Physics, geom: str) -> None:
    """Let a shape of the world touch all that the floor touches.

    Args:
        spec: with all the pairs of the floor, each with its numbers.
        physics: whose contacts are softened.
        geom: the name of the shape.
    """
    for floor in list(spec.pairs):
        if floor.geomname1 != "floor":
            continue
        pair = spec.add_pair(name=floor.name.replace("floor", geom), geomname1=geom, geomname2=floor.geomname2)
        for number in ("condim", "friction", "solref", "solreffriction", "solimp"):
            setattr(pair, number, getattr(floor, number))
        if floor.geomname2 != "chassis":
            touching, deep, *rest = floor.solimp
            pair.solimp = (min(touching, _IMPEDANCE), min(deep, _IMPEDANCE), *rest)
            stiffness, damping = floor.solref
            pair.solref = (max(stiffness, -_STIFFNESS / physics.timestep**2), damping)


def record_all_contacts(spec: mujoco.MjSpec) -> None:
    """Let the sensors of the contacts record whatever wheels, caster and chassis touch, not the floor alone.

    A chassis that touches the floor has fallen; one that touches what lies on it has not, and gets a sensor of its own.
    """
    if any(sensor.name == GROUNDED for sensor in spec.sensors):
        return
    kind, anything = mujoco.mjtSensor.mjSENS_CONTACT, mujoco.mjtObj.mjOBJ_UNKNOWN
    for sensor in spec.sensors:
        if sensor.type == kind and sensor.refname != "chassis":
            sensor.objtype, sensor.objname = anything, ""
            sensor.intprm[1:3] = _BY_FORCE, _RECORDED
    spec.add_sensor(
        name=GROUNDED,
        type=kind,
        objtype=anything,
        reftype=mujoco.mjtObj.mjOBJ_GEOM,
        refname="chassis",
        intprm=spec.sensor("chassis_contact").intprm,
    )
