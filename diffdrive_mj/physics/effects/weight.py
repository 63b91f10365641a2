"""Gravity, and a slope as gravity that is not across the floor."""

from __future__ import annotations

from diffdrive_mj.physics._mujoco import mujoco
from diffdrive_mj.physics.mechanics import gravity
from diffdrive_mj.robot import Robot
from diffdrive_mj.solver import Physics
from diffdrive_mj.world import World


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
