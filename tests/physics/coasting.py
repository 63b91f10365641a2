"""Robots whose motors are off, and the mechanics in closed form that they must obey."""

from __future__ import annotations

import copy
import math

import mujoco
import numpy as np

import diffdrive_mj as dd
from diffdrive_mj.errors import DiffdriveError
from diffdrive_mj.physics.model import compile_model


def random_robots(count: int, seed: int) -> list[dd.Robot]:
    """Robots of 0.3 to 80 kg, wheels of 2 to 25 cm, that stand on independent axles."""
    generator = np.random.default_rng(seed)

    def between(low: float, high: float) -> float:
        return float(np.exp(generator.uniform(math.log(low), math.log(high))))

    found: list[dd.Robot] = []
    while len(found) < count:
        radius, ratio, track = between(0.02, 0.25), generator.uniform(0.8, 1.25), between(0.08, 1.2)
        mean = radius * (1 + ratio) / 2
        caster = -generator.uniform(0.3, 0.7) * track
        try:
            robot = dd.Robot(
                left_radius=radius,
                right_radius=radius * ratio,
                track_width=track,
                body_mass=between(0.3, 80.0),
                center_of_mass_x=caster * generator.uniform(0.15, 0.6),
                center_of_mass_height=mean * generator.uniform(0.5, 1.2),
                caster={"x": caster, "radius": 0.25 * mean},
            )
            compile_model(robot)
        except DiffdriveError:
            continue
        found.append(robot)
    return found


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
