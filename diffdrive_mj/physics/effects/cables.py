"""Cables on the floor."""

from __future__ import annotations

import itertools

import numpy as np

from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.physics._mujoco import mujoco
from diffdrive_mj.physics.effects._terrain import record_all_contacts, touch
from diffdrive_mj.robot import Robot
from diffdrive_mj.solver import Physics
from diffdrive_mj.world import World


def lay(spec: mujoco.MjSpec, robot: Robot, world: World, physics: Physics) -> None:
    """Lay the world's cables on the floor, as capsules with as much of them below it as their height leaves.

    On a rough floor a cable is a chain of them, which follows it.

    Args:
        spec: with all that touches the floor.
        robot: whose wheels must get over them.
        world: its cables.
        physics: its contacts.

    Raises:
        InvalidValue: a cable that meets a wheel at its hub or above.

    Example:
        >>> from diffdrive_mj.physics.model import compile_model
        >>> world = World(cables=({"x": 1.0, "y": (-0.5, 0.5), "height": 0.005},))
        >>> print(compile_model(Robot.load("ct_bot"), world=world).geom("cable0").pos)
        [1.     0.     0.0025]
    """
    for k, cable in enumerate(world.cables):
        smallest = min(robot.left_radius, robot.right_radius)
        if cable.height >= smallest + cable.radius:
            raise InvalidValue(
                f"World.cables[{k}].height = {cable.height:g} m: meets a wheel of robot {robot.name}, of radius "
                f"{smallest:g} m, at its hub or above, so that no friction lifts it; must be below "
                f"{smallest + cable.radius:g} m for a cable of that radius"
            )
        points = cable.course(world.rough)
        for piece, ends in enumerate(itertools.pairwise(points)):
            name = f"cable{k}" if len(points) == 2 else f"cable{k}_{piece}"
            spec.worldbody.add_geom(
                name=name,
                type=mujoco.mjtGeom.mjGEOM_CAPSULE,
                fromto=np.concatenate(ends),
                size=(cable.radius, 0, 0),
                material="tyre",
            )
            touch(spec, physics, name)
    if world.cables:
        record_all_contacts(spec)
