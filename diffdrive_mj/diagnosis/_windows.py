"""Motions over windows of about a second, in which wheels and truth are compared.

A motion is (forward, left, b / 2 times the turn) in the frame of the window's start, all in metres.
"""

from __future__ import annotations

import numpy as np

from diffdrive_mj import se2
from diffdrive_mj._checks import Array
from diffdrive_mj.robot import Robot

WINDOW = 1.0  # [s]
_LONGEST = 1.5  # [s]; truth that is sparser shows nothing of what happened in between.


def windows(clock: Array) -> Array:
    """Indices of pairs of samples (N, 2), the second the first one at least WINDOW later; windows overlap.

    Args:
        clock: the samples' times (M,) [s].
    """
    first = np.arange(len(clock))
    last = np.searchsorted(clock, clock + WINDOW - 1e-6)
    there = last < len(clock)
    pairs = np.stack([first[there], last[there]], axis=-1)
    return pairs[clock[pairs[:, 1]] - clock[pairs[:, 0]] <= _LONGEST]


def motions(poses: Array, pairs: Array, robot: Robot) -> Array:
    """Forward, left and b / 2 times the turn over each window (N, 3) [m].

    Args:
        poses: (M, 3) [m, m, rad].
        pairs: of `windows` (N, 2).
        robot: of track width b.
    """
    turned = np.concatenate([[0.0], np.cumsum(se2.wrap_angle(np.diff(poses[:, 2])))])
    motion = se2.between(poses[pairs[:, 0]], poses[pairs[:, 1]])
    motion[:, 2] = (turned[pairs[:, 1]] - turned[pairs[:, 0]]) * robot.track_width / 2
    return motion


def size(moved: Array) -> Array:
    """How large motions are (N,) [m]."""
    return np.sqrt((moved**2).sum(axis=1))


def misfit(a: Array, b: Array) -> float:
    """How much of the motion two have not in common: 0 to 2."""
    larger = np.maximum(size(a), size(b)).sum()
    return float(size(a - b).sum() / larger) if larger else 0.0
