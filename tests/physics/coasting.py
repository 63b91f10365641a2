"""Robots whose motors are off, and the mechanics in closed form that they must obey."""

from __future__ import annotations

import copy

import mujoco
import numpy as np

import diffdrive_mj as dd
from diffdrive_mj.physics.model import compile_model


def coasting(robot: dd.Robot, world: dd.World = dd.World(), physics: dd.Physics = dd.Physics()) -> mujoco.MjModel:
    """The robot with its motors off: servos that do nothing."""
    model = copy.copy(compile_model(robot, physics, world))
    model.actuator_gainprm[:] = model.actuator_biasprm[:] = 0
    return model


def wheel_loads(robot: dd.Robot, gravity: float) -> np.ndarray:
    """What each wheel carries at rest on independent axles, by the lever of the caster alone (2,) [N]."""
    mass = robot.body_mass + 2 * robot.tyres.mass
    on_caster = robot.body_mass * robot.center_of_mass_x / robot.caster.x
    return np.full(2, (mass - on_caster) * gravity / 2)


def stop_force(robot: dd.Robot, model: mujoco.MjModel, forces: np.ndarray) -> float:
    """How fast forces at the wheels' rims slow a robot that rolls straight [m/s^2]."""
    inert = robot.body_mass + 2 * robot.tyres.mass
    for side, radius in (("left", robot.left_radius), ("right", robot.right_radius)):
        rotor = float(model.dof_armature[model.joint(side).dofadr[0]])
        inert += robot.tyres.mass / 2 + rotor / radius**2
    return float(forces.sum() / inert)
