"""How a drive starts: what of its first pose is estimated, and its path as seen from there.

The first pose is that of the first true one. What is not estimated of it is pinned to the truth, so that it is no
measurement.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from diffdrive_mj import se2
from diffdrive_mj._checks import Array
from diffdrive_mj.estimation.derivatives import Trajectory

Start = Literal["estimated", "position", "truth"]

# Which of x, y, theta of the first pose are estimated.
FREE: dict[Start, list[int]] = {"estimated": [0, 1, 2], "position": [2], "truth": []}


def from_first_pose(path: Trajectory) -> Trajectory:
    """A path and its derivatives as seen from its first pose, wherever that is."""
    first = path.poses[0]
    poses = se2.between(first, path.poses)

    def moved(derivative: Array) -> Array:
        # The frame, the first pose, moves and turns too.
        change = derivative - derivative[..., :1, :]
        at = se2.rotate(change[..., :2], -first[2])
        turning = derivative[..., :1, 2]
        at[..., 0] += turning * poses[:, 1]
        at[..., 1] -= turning * poses[:, 0]
        return np.concatenate([at, change[..., 2:]], axis=-1)

    return Trajectory(poses, moved(path.by_parameters), moved(path.velocity))


def first_pose(truth: Array, path: Trajectory, *, laid_over: bool) -> Array:
    """The first pose (3,): the true one, or with the heading that lays the path over the true positions as a whole."""
    pose = truth[0].copy()
    if laid_over:
        at, true = path.poses[:, :2], truth[:, :2] - truth[0, :2]
        pose[2] = np.arctan2((at[:, 0] * true[:, 1] - at[:, 1] * true[:, 0]).sum(), (at * true).sum())
    return pose


def by_first_pose(path: Trajectory, pose: Array) -> Array:
    """Derivatives of the poses of a path, laid at its first pose, by x, y and theta of that pose (M, 3, 3)."""
    moved = se2.rotate(path.poses[:, :2], pose[2])
    result = np.tile(np.eye(3), (len(moved), 1, 1))
    result[:, 0, 2], result[:, 1, 2] = -moved[:, 1], moved[:, 0]
    return result
