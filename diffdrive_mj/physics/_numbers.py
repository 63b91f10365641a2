"""A model in full, for the same engine in another language: its structure as XML, and every number with all digits.

MjSpec writes six digits. Whoever reads the XML checks that what it has compiled is this model, field by field, and then
puts these numbers in the place of its own.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.physics._mujoco import mujoco
from diffdrive_mj.physics.model import compile_model, model_spec
from diffdrive_mj.robot import Robot
from diffdrive_mj.solver import Physics
from diffdrive_mj.world import World

# What the physics of a robot on a plane reads; the rest is for the eye, or for kinds that no robot here has.
_KINDS = ("qpos", "body_", "jnt_", "dof_", "geom_", "site_", "pair_", "actuator_", "sensor_")
# Of the whole numbers, those that say what is what: they are compared, and never replaced.
_STRUCTURE = (
    "body_parentid", "body_jntadr", "body_dofadr", "jnt_type", "jnt_qposadr", "jnt_dofadr", "geom_type", "geom_bodyid",
    "geom_contype", "geom_conaffinity", "pair_dim", "pair_geom1", "pair_geom2", "actuator_trntype", "actuator_trnid",
    "actuator_dyntype", "actuator_gaintype", "actuator_biastype", "actuator_actadr", "sensor_type", "sensor_dim",
    "sensor_adr", "sensor_objid", "sensor_refid",
)  # fmt: skip
# Fields that 3.14 does not have, all zero in these models.
_NEWER = ("jnt_springyield",)


def full_model(robot: Robot, physics: Physics, world: World) -> dict[str, Any]:
    """A robot's model as JSON: `xml`, `numbers`, `structure`, `option` and `statistic`, each a field's values by name.

    Raises:
        InvalidValue: a robot that cannot stand, as `compile_model` does; or one with a part that takes more than the
            engine to drive: motors with limits, whose servos are looked after, or a swivel caster.
    """
    if robot.motor.stall_torque is not None or robot.caster.kind != "ball":
        raise InvalidValue(
            f"robot {robot.name}: the page drives robots whose motors have no limits and whose caster is a ball; "
            "`simulate` drives any"
        )
    model = compile_model(robot, physics, world)
    fields = {name: getattr(model, name) for name in dir(model) if name.startswith(_KINDS)}
    numbers = {name: value for name, value in fields.items() if getattr(value, "dtype", None) == np.float64}
    assert not any(numbers.pop(name).any() for name in _NEWER)
    statistic = {"meaninertia": float(model.stat.meaninertia)}
    return {
        "xml": _xml(robot, physics, world, model),
        "numbers": {name: value.ravel().tolist() for name, value in numbers.items() if value.size},
        "structure": {name: fields[name].ravel().tolist() for name in _STRUCTURE},
        "option": {name: _plain(getattr(model.opt, name)) for name in dir(model.opt) if name[0] != "_"},
        "statistic": statistic,
    }


def _xml(robot: Robot, physics: Physics, world: World, model: mujoco.MjModel) -> str:
    spec = model_spec(robot, physics, world)
    spec.comment = ""
    for body in spec.bodies:
        least, middle, most = np.argsort(body.inertia)
        a, b, c = body.inertia[[least, middle, most]]
        if a + b - c < 1e-5 * c:  # six digits of a flat body's moments may break a + b >= c, which MuJoCo wants
            body.inertia[middle] *= 1 + 3e-5
    for pair in spec.pairs:
        pair.margin = float(model.pair(pair.name).margin[0])
    for actuator in spec.actuators:
        actuator.ctrlspec = 0  # or MjSpec writes an attribute that older readers do not know
    return str(spec.to_xml())


def _plain(value: Any) -> Any:
    return value.tolist() if isinstance(value, np.ndarray) else value
