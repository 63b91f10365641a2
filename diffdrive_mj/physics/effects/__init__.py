"""What a world and a robot's parts add to the model; an effect is a file with one function, listed in `EFFECTS`.

Each edits the specification before it is compiled, and does nothing where the world and the robot are ideal.
"""

from __future__ import annotations

from typing import Protocol

from diffdrive_mj.physics._mujoco import mujoco
from diffdrive_mj.physics.effects import (
    cables,
    casters,
    motors,
    rolling_resistance,
    rough_floor,
    skid_steer,
    soft_tyres,
    weight,
)
from diffdrive_mj.robot import Robot
from diffdrive_mj.solver import Physics
from diffdrive_mj.world import World


class Effect(Protocol):
    """What edits a model's specification; it has the robot's own numbers and the floor's friction by then.

    Example:
        >>> all(callable(effect) for effect in EFFECTS)
        True
    """

    def __call__(self, spec: mujoco.MjSpec, robot: Robot, world: World, physics: Physics) -> None:
        """Add one effect."""


# In this order: a body is lowered before its caster is put on the floor, and contacts are softened once all masses are
# in place. Skid steer doubles the wheels as they are by then. Terrain comes last: it is touched by whatever touches the
# floor by then.
EFFECTS: tuple[Effect, ...] = (
    weight.pull,
    rolling_resistance.resist,
    motors.drive,
    soft_tyres.lower,
    casters.drag,
    casters.swivel,
    soft_tyres.soften,
    skid_steer.four_wheels,
    cables.lay,
    rough_floor.lay,
)
