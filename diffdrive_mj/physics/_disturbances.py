"""What changes on the way: pushes, at known times, and the floor's friction, where the wheels happen to be.

A push changes between two calls of the engine. The floor is found step by step: `Floor` says which friction each wheel
meets along a piece of drive that was run ahead, and the engine takes back what it ran beyond the first change.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from diffdrive_mj._checks import Array
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.physics.tilt import resting_tilt
from diffdrive_mj.robot import Robot
from diffdrive_mj.world import Push, World


class Pushes:
    """The forces on the robots' centres of mass, step by step; each push gives its whole impulse, however short it is.

    Args:
        pushes: of the world.
        timestep: [s].
    """

    def __init__(self, pushes: Sequence[Push], timestep: float) -> None:
        self._accelerations = np.array([push.acceleration for push in pushes]).reshape(-1, 3)
        begin = np.array([push.start for push in pushes]) / timestep
        end = begin + np.array([push.duration for push in pushes]) / timestep
        # In steps; what is between two of them by rounding alone is at a step.
        self._begin, self._end = (np.where(np.abs(t - np.round(t)) < 1e-6, np.round(t), t) for t in (begin, end))
        edges = np.minimum(np.concatenate([self._begin, self._end]), 2.0**53)
        self._changes = np.unique([np.floor(edges), np.ceil(edges)]).astype(np.int64)

    def __bool__(self) -> bool:
        return bool(self._begin.size)

    def acceleration(self, step: int) -> Array:
        """What all the pushes add up to, in the mean over a step (3,) [m/s^2]."""
        share = np.clip(np.minimum(self._end, step + 1) - np.maximum(self._begin, step), 0.0, 1.0)
        total: Array = share @ self._accelerations
        return total

    def steps_to_change(self, step: int) -> int | None:
        """Steps until a push begins, ends, or has filled a part of a step; None if nothing changes any more."""
        ahead = self._changes[self._changes > step]
        return int(ahead[0]) - step if ahead.size else None


class Floor:
    """The friction under the wheels of robots.

    Args:
        world: its friction and patches.
        robots: N.
        start: (N, 3) [m, m, rad], where their motions begin.
    """

    def __init__(self, world: World, robots: Sequence[Robot], start: Array) -> None:
        if any(robot.skids for robot in robots):
            raise InvalidValue("World.patches: a robot with skid steer drives on a floor of one friction only")
        self._world, self._start = world, start
        self._half_track = np.array([resting_tilt(robot).track_width / 2 for robot in robots])

    def friction(self, poses: Array, runs: NDArray[np.intp]) -> Array:
        """The coefficients (n, S, 2) under the left and the right wheel of some runs.

        Args:
            poses: (n, S, 3), from the place of the start.
            runs: (n,), which they are.
        """
        across = np.stack([-np.sin(poses[..., 2]), np.cos(poses[..., 2])], axis=-1) * self._half_track[runs, None, None]
        middle = poses[..., :2] + self._start[runs, None, :2]
        return self._world.friction_at(np.stack([middle + across, middle - across], axis=-2))
