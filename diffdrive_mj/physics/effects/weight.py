"""Gravity, and a slope as gravity that is not across the floor."""

from __future__ import annotations

import math

import numpy as np

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj.physics._mujoco import mujoco
from diffdrive_mj.robot import Robot
from diffdrive_mj.solver import Physics
from diffdrive_mj.world import World


def gravity(world: World) -> Array:
    """Return the acceleration of what falls freely, in the world's axes, two of which lie in the floor (3,) [m/s^2].

    ```
    g (-sin(a) cos(d), -sin(a) sin(d), -cos(a))
    ```

    with the slope's angle a and the direction d in which it rises.

    Args:
        world: its gravity and its slope.

    Example:
        >>> print(gravity(World()))
        [ 0.    0.   -9.81]
    """
    checks.instance("world", world, World)
    angle, direction = (0.0, 0.0) if world.slope is None else (world.slope.angle, world.slope.direction)
    along = -math.sin(angle) * np.array([math.cos(direction), math.sin(direction)])
    return world.gravity * np.array([*(along + 0.0), -math.cos(angle)])


def pull(spec: mujoco.MjSpec, robot: Robot, world: World, physics: Physics) -> None:
    """Let the world's gravity act.

    Args:
        spec: of any robot.
        robot: that it is.
        world: its gravity and its slope.
        physics: how it is solved.

    Example:
        >>> from diffdrive_mj.physics.model import compile_model
        >>> print(compile_model(Robot.load("ct_bot"), world=World(gravity=1.62)).opt.gravity)
        [ 0.    0.   -1.62]
    """
    spec.option.gravity = gravity(world)
