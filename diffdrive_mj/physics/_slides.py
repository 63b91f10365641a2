"""How far wheels slide that have lost their grip."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from diffdrive_mj.physics._mujoco import mujoco
from diffdrive_mj.physics._probes import Steps
from diffdrive_mj.physics.tilt import level_twin
from diffdrive_mj.robot import Robot


class SlideProbe:
    """How far the wheels' contacts move otherwise than the wheels roll.

    Args:
        model: of any of the robots.
        robots: N.
    """

    def __init__(self, model: mujoco.MjModel, robots: Sequence[Robot]) -> None:
        twins = [level_twin(robot) for robot in robots]
        self._radii = np.array([(twin.left_radius, twin.right_radius) for twin in twins])
        self._half_tracks = np.array([(-twin.track_width / 2, twin.track_width / 2) for twin in twins])
        self._columns = [int(model.joint(side).qposadr[0]) for side in ("left", "right")]
        self._before = np.zeros((len(robots), 1, 2))
        self.slide = np.zeros((len(robots), 2))

    def read(self, steps: Steps, slipping: NDArray[np.bool_]) -> None:
        """Add up what the wheels slide in the steps (N, S, 2) in which they slip; each step comes once, in order."""
        angles = steps.states[..., self._columns]
        before, self._before = self._before, angles[:, -1:].copy()
        runs = np.flatnonzero(slipping.any(axis=(1, 2)))
        if not runs.size:
            return
        rolled = np.diff(np.concatenate([before[runs], angles[runs]], axis=1), axis=1) * self._radii[runs, None]
        poses = steps.poses[runs]
        (dx, dy, turned), heading = np.moveaxis(np.diff(poses, axis=1), -1, 0), poses[..., 2]
        middle = (heading[:, 1:] + heading[:, :-1]) / 2
        along, across = dx * np.cos(middle) + dy * np.sin(middle), dy * np.cos(middle) - dx * np.sin(middle)
        moved = along[..., None] + turned[..., None] * self._half_tracks[runs, None]
        slid = np.hypot(moved - rolled, across[..., None])
        self.slide[runs] += (slid * slipping[runs]).sum(axis=1)
