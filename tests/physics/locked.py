"""Robots whose wheels are locked, and the mechanics in closed form that they must obey."""

from __future__ import annotations

import copy
import math

import mujoco
import numpy as np

import diffdrive_mj as dd
from diffdrive_mj.physics.model import compile_model

GRAVITY = 9.81


def locked(robot: dd.Robot, friction: float, physics: dd.Physics) -> mujoco.MjModel:
    """The robot with brakes on: servos that do nothing, and rotors that nothing turns."""
    model = copy.copy(compile_model(robot, physics, dd.World(friction=friction)))
    for side in ("left", "right"):
        model.dof_armature[model.joint(side).dofadr[0]] = 1e9
    model.actuator_gainprm[:] = model.actuator_biasprm[:] = 0
    return model


def deceleration(robot: dd.Robot, friction: float, way: float = 1.0) -> float:
    """How fast friction on the wheels alone slows a sliding robot, way = 1 driving forward [m/s^2].

    The caster carries N of the weight M g, its lever x, the centre of mass at c and h: N x = M (g c + way a h), and
    M a = friction (M g - N).
    """
    c, h = center_of_mass(robot)
    x = robot.caster.x
    return friction * GRAVITY * (1 - c / x) / (1 + way * friction * h / x)


def slope(robot: dd.Robot, friction: float) -> float:
    """The slope, as a tangent, on which a braked robot that faces uphill begins to slide: M g tan = M a, uphill."""
    return deceleration(robot, friction, way=-1.0) / GRAVITY


def center_of_mass(robot: dd.Robot) -> tuple[float, float]:
    """Forward of the axle and above the floor [m], of a robot with independent axles."""
    c = robot.body_mass * robot.center_of_mass_x / robot.mass
    wheels = robot.tyres.mass * (robot.left_radius + robot.right_radius)
    return c, (robot.body_mass * robot.center_of_mass_height + wheels) / robot.mass


def tilt_the_floor(model: mujoco.MjModel, tangent: float, seconds: float) -> mujoco.MjData:
    """Turn gravity slowly by a slope ahead of the robot, uphill; the data at its end."""
    data = mujoco.MjData(model)
    steps = round(seconds / model.opt.timestep)
    for angle in np.linspace(0, math.atan(tangent), steps):
        model.opt.gravity[:] = -GRAVITY * np.array([math.sin(angle), 0, math.cos(angle)])
        mujoco.mj_step(model, data)
    return data
