"""A judge of rolling on any ground: a wheel that does not slip turns by the way of its hub over its radius.

The way in space, without what the hub goes along its own axle while the robot rolls from side to side.
"""

from __future__ import annotations

import numpy as np


def rolled_and_gone(recording):
    """How far each wheel of equal, level wheels rolled, and how far its hub went in space (2,) [m]."""
    robot = recording.robot
    w, x, y, z = recording.attitude.T
    left = np.stack([2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)], axis=-1)
    middle = np.column_stack([recording.truth[:, :2], recording.height])
    hubs = [middle + side * robot.track_width / 2 * left for side in (1, -1)]
    axle = (left[1:] + left[:-1]) / 2
    steps = [np.diff(hub, axis=0) for hub in hubs]
    gone = np.array([np.linalg.norm(step - (step * axle).sum(axis=1)[:, None] * axle, axis=1).sum() for step in steps])
    pitch = np.arcsin(2 * (w * y - x * z))  # an encoder reads the wheel against the body
    return robot.left_radius * (recording.wheel_angles[-1] + pitch[-1] - pitch[0]), gone
