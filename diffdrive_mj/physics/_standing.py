"""Where robots may start on a floor that is not the same everywhere."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from diffdrive_mj._checks import Array
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.physics._motion import heading
from diffdrive_mj.physics._mujoco import mujoco
from diffdrive_mj.physics.skidding import wheel_places
from diffdrive_mj.physics.tilt import resting_tilt
from diffdrive_mj.robot import Robot
from diffdrive_mj.world import World


def refuse_start(world: World, robots: Sequence[Robot], models: Sequence[mujoco.MjModel], positions: Array) -> None:
    """Refuse robots that start on a cable, or off the level part of a rough floor.

    Args:
        world: its cables and its rough floor.
        robots: N.
        models: theirs.
        positions: (N, nq), at time zero.
    """
    for k, (robot, model, qpos) in enumerate(zip(robots, models, positions, strict=True)):
        if world.rough is not None:
            contacts = _contacts(robot, qpos)
            reach = world.rough.level - np.hypot(*(contacts - world.rough.start).T).max()
            if reach < 0:
                raise InvalidValue(
                    f"start: robot {k} ({robot.name}) has a contact {-reach:.3g} m outside the level circle of the "
                    "rough floor; start it there, or give RoughFloor another start or a larger level"
                )
            sides = np.array([world.rough.x, world.rough.y])
            inside = np.minimum(contacts - sides[:, 0], sides[:, 1] - contacts).min()
            if inside < world.rough.wavelength:
                raise InvalidValue(
                    f"start: robot {k} ({robot.name}) has a contact {world.rough.wavelength - inside:.3g} m too near "
                    "to the rough floor's edge, or beyond it, where it goes down; start it farther inside, or give "
                    "RoughFloor a larger x or y"
                )
        if world.cables and (cable := _lies_on(model, qpos)):
            raise InvalidValue(f"start: robot {k} ({robot.name}) stands on World.cables[{cable}]; start it beside it")


def _contacts(robot: Robot, qpos: Array) -> Array:
    """Where its wheels and its caster, or its four wheels, touch a level floor (3, 2) or (4, 2) [m]."""
    half, theta = resting_tilt(robot).track_width / 2, float(heading(qpos[3:7]))
    turn = np.array([(np.cos(theta), np.sin(theta)), (-np.sin(theta), np.cos(theta))])
    own = wheel_places(robot) if robot.skids else np.array([(0, half), (0, -half), (robot.caster.x, 0)])
    return own @ turn + qpos[:2]


def _lies_on(model: mujoco.MjModel, qpos: Array) -> str:
    """The number of a cable that it touches; empty if it touches none."""
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    mujoco.mj_forward(model, data)
    for contact in data.contact:
        for geom in contact.geom:
            if model.geom(int(geom)).name.startswith("cable"):
                return model.geom(int(geom)).name.removeprefix("cable").partition("_")[0]
    return ""
