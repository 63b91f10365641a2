"""Rolling resistance: what turning a loaded wheel costs, as friction in its joint.

Rolling friction of the contact itself (MuJoCo's `condim` 6) would make the wheel's angle and the robot's way disagree.
"""

from __future__ import annotations

import numpy as np

from diffdrive_mj._checks import Array
from diffdrive_mj.physics._mujoco import mujoco
from diffdrive_mj.physics.mechanics import resting_loads
from diffdrive_mj.robot import Robot
from diffdrive_mj.solver import Physics
from diffdrive_mj.world import World

# As hard as MuJoCo allows: a wheel at rest creeps by less than a micrometre in ten seconds.
_HARDEST = (0.9999, 0.9999, 0.001, 0.5, 2)


def resisting_torques(robot: Robot, world: World) -> Array:
    """Return the torque that turning each wheel costs (2,) [N m], left then right; at rest it holds as much.

    ```
    (c_tyre + c_floor) N r
    ```

    with the load N that the wheel carries at rest and its radius r; how a slope or an acceleration shifts load between
    the wheels and the caster is left out.

    Args:
        robot: its tyres, masses and radii.
        world: its floor, gravity and slope.

    Raises:
        InvalidType: not a robot, or not a world.

    References:
        The coefficient is the usual one of vehicle dynamics, force over load.

    Example:
        >>> soft = Robot.load("mismatched").replace(tyres={"rolling_resistance": 0.02})
        >>> print(resisting_torques(soft, World()))  # of 16.677 N a wheel
        [0.0334 0.0304]
    """
    loads = np.maximum(resting_loads(robot, world)[:2], 0)
    coefficient = robot.tyres.rolling_resistance + world.rolling_resistance
    return coefficient * loads * np.array([robot.left_radius, robot.right_radius])


def resist(spec: mujoco.MjSpec, robot: Robot, world: World, physics: Physics) -> None:
    """Let each wheel's joint resist.

    Args:
        spec: a robot's model, which is changed.
        robot: its tyres and loads.
        world: its floor.
        physics: its time step.

    Example:
        >>> from diffdrive_mj.physics.model import model_spec
        >>> spec = model_spec(Robot.load("mismatched"), world=World(rolling_resistance=0.02))
        >>> print(f"{spec.joint('left').frictionloss:.4f} N m")
        0.0334 N m
    """
    if robot.tyres.rolling_resistance + world.rolling_resistance == 0:
        return
    for side, torque in zip(("left", "right"), resisting_torques(robot, world).tolist(), strict=True):
        joint = spec.joint(side)
        joint.frictionloss = torque
        joint.solref_friction = (0, -1 / physics.timestep)
        joint.solimp_friction = _HARDEST
