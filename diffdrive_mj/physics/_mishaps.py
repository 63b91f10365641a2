"""What a recording shows of a drive that went wrong: robots that got stuck, or left the rough floor."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.ndimage import maximum_filter1d, minimum_filter1d

from diffdrive_mj._checks import Array
from diffdrive_mj.commands import Commands
from diffdrive_mj.physics.tilt import resting_tilt
from diffdrive_mj.robot import Robot
from diffdrive_mj.world import World

# A robot is stuck where, for so long [s], it stays within less than this share of the way over which its wheels are
# told to move, back and forth or not, and which is longer than this part of a radius.
_LONG, _SHARE, _LEAST = 1.0, 0.1, 0.1
# More than sums in another order differ by.
_ROUNDING = 1e-9


def stuck_times(t: Array, truth: Array, robots: Sequence[Robot], commands: Sequence[Commands]) -> Array:
    """From when on each robot was stuck (N,) [s]; nan if it never was.

    Args:
        t: (T,) [s].
        truth: (N, T, 3) [m, m, rad].
        robots: N, as they are.
        commands: N, as driven.
    """
    found = np.full(len(robots), np.nan)
    begins = int(np.count_nonzero(t + _LONG <= t[-1] + 1e-9))
    if not begins:
        return found
    samples = len(t) - begins + 1  # of which the first and the last are so long apart
    tracks = [resting_tilt(robot).track_width for robot in robots]
    told: dict[int, tuple[Array, Array]] = {}
    for k, (robot, poses, track, driven) in enumerate(zip(robots, truth, tracks, commands, strict=True)):
        way = _went(poses, track)
        if id(driven) not in told:
            turned = _turned(t, driven)
            told[id(driven)] = turned, _apart(turned, samples).copy(order="F")
        turned, spans = told[id(driven)]
        radii, least = np.array([robot.left_radius, robot.right_radius]), _LEAST * robot.mean_radius
        # Whoever is as far away after that time as it had to go is not stuck, and most are: the rest is looked at.
        about = np.maximum(*(radii[:, None] * spans.T))
        away = np.maximum(*np.abs(way[samples - 1 :] - way[:begins]).T)
        if not ((about > (1 - _ROUNDING) * least) & (away < (1 + _ROUNDING) * _SHARE * about)).any():
            continue
        asked, got = (_apart(of, samples).max(axis=1) for of in (radii * turned, way))
        stuck = (asked > least) & (got < _SHARE * asked)
        if stuck.any():
            found[k] = t[stuck.argmax()]
    return found


def edge_times(t: Array, truth: Array, world: World) -> Array:
    """When each robot, whose poses are (N, T, 3), left the rough floor (N,) [s]; nan if it did not."""
    if world.rough is None:
        return np.full(len(truth), np.nan)
    left = ~world.rough.contains(truth[..., :2])
    return np.where(left.any(axis=1), t[left.argmax(axis=1)], np.nan)


def _apart(way: Array, samples: int) -> Array:
    """How far apart some samples in a row of a way (T, 2) lie at most, for each row of them."""
    highest, lowest = (
        of(way, samples, axis=0, mode="nearest", origin=-(samples // 2)) for of in (maximum_filter1d, minimum_filter1d)
    )
    apart: Array = (highest - lowest)[: len(way) - samples + 1]
    return apart


def _turned(t: Array, driven: Commands) -> Array:
    """How far the wheels were told to turn by some times (T, 2) [rad]."""
    angles = driven.wheel_angles
    edges = driven.period * np.arange(len(angles))
    return np.stack([np.interp(t, edges, side) for side in angles.T], axis=-1)


def _went(poses: Array, track_width: float) -> Array:
    """How far the wheels' contacts went along the robot's heading (T, 2) [m], forward counted as positive."""
    x, y, theta = poses.T.copy()  # through contiguous memory
    turn = np.diff(theta)
    mean = theta[:-1] + turn / 2
    along = np.diff(x) * np.cos(mean) + np.diff(y) * np.sin(mean)
    across = turn * track_width / 2
    went = np.zeros((2, len(theta)))
    np.cumsum(along - across, out=went[0, 1:])
    np.cumsum(along + across, out=went[1, 1:])
    return went.T
