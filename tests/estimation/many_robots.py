"""Where many robots end on one drive, by arithmetic that shares no code with the package."""

from __future__ import annotations

import numpy as np


def paths(angles, left, right, track, heading=0.0):
    """Positions of N robots at every sample (N, T), as complex numbers [m]."""
    step = np.diff(np.asarray(angles, dtype=float), axis=0)
    left, right, track, heading = np.broadcast_arrays(*map(np.atleast_1d, (left, right, track, heading)))
    way_left, way_right = left[:, None] * step[:, 0], right[:, None] * step[:, 1]
    turn = (way_right - way_left) / track[:, None]
    before = heading[:, None] + np.cumsum(turn, axis=1) - turn
    still = np.abs(turn) < 1e-5
    safe = np.where(still, 1.0, turn)
    arc = np.where(still, 1 + 0.5j * turn - turn**2 / 6, (np.exp(1j * safe) - 1) / (1j * safe))
    moved = np.cumsum((way_left + way_right) / 2 * arc * np.exp(1j * before), axis=1)
    return np.concatenate([np.zeros((len(moved), 1)), moved], axis=1)


def drifts(angles, believed, lengths, heading=0.0, anywhere=False):
    """How far robots of lengths (N, 3) end from where the believed one does (N,), or are at most."""
    true = paths(angles, *np.asarray(lengths).T, heading)
    off = np.abs(true - paths(angles, believed.left_radius, believed.right_radius, believed.track_width))
    return off.max(axis=1) if anywhere else off[:, -1]


def lengths_of(robot, radius, ratio, track):
    """Left radius, right radius and track width (N, 3) of a robot whose three numbers are off by parts (N,)."""
    mean, rho = robot.mean_radius * (1 + radius), robot.radius_ratio * (1 + ratio)
    left = 2 * mean / (1 + rho)
    return np.stack([left, rho * left, robot.track_width * (1 + track)], axis=-1)
