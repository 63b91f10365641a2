"""How wheel noise spreads the turn of a step with a turning gain, which is not linear in the wheels' ways.

The turn is X (1 + c |X| b / 2 / (|D| + |X| b / 2)) for the distance D and the turn X without gain, which are Gaussian.
The quadrature runs over both. Where the noise may turn the distance round, as on the spot, it is split at D = 0, where
the turn's slope jumps.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from diffdrive_mj._checks import Array
from diffdrive_mj.kinematics import body_twist
from diffdrive_mj.robot import Robot

# How many steps are computed together: what stays in the processor's cache.
_TOGETHER = 8192
# Nodes over a Gaussian, and on each side of a split, which ends so many deviations away.
_NODES, _SIDE_NODES, _FAR = 5, 12, 7.0


def noisy_turns(increments: Array, var_distance: Array, covariance: Array, var_turn: Array, robot: Robot) -> Array:
    """By how much the mean of a step's turn moves, and the variances and the covariance that it has with a gain.

    Args:
        increments: of the wheels (S, 2) [rad].
        var_distance: of the distance (S,) [m^2].
        covariance: of the distance and of the turn without gain (S,) [m rad].
        var_turn: of the latter (S,) [rad^2].
        robot: with a turning gain.

    Returns:
        (4, S): the mean's shift [rad], the variance of the distance, the covariance, the variance of the turn.
    """
    found = np.zeros((4, len(increments)))
    sigma = np.sqrt(var_distance)
    along = np.divide(covariance, sigma, out=np.zeros_like(sigma), where=sigma > 0)
    across = np.sqrt(np.maximum(var_turn - along**2, 0.0))
    distance = body_twist(increments, robot)[:, 0]
    split = np.abs(distance) < _FAR * sigma
    for some, sides in ((~split, False), (split, True)):
        rows = np.flatnonzero(some & (var_turn > 0))
        for first in range(0, len(rows), _TOGETHER):
            part = rows[first : first + _TOGETHER]
            zero = -distance[part] / sigma[part] if sides else None
            found[:, part] = _integrated(increments[part], sigma[part], along[part], across[part], zero, robot)
    return found


def _integrated(
    increments: Array, sigma: Array, along: Array, across: Array, zero: Array | None, robot: Robot
) -> Array:
    """The same for some steps, all of which are split at `zero` deviations of the distance, or none."""
    exact = body_twist(increments, robot)
    shift, squares = np.zeros(len(exact)), np.zeros((3, len(exact)))
    half, radii = robot.track_width / 2, (robot.left_radius, robot.right_radius)
    for z, odds in _gaussian() if zero is None else _sides(zero):
        for other, weight in _gaussian():
            further, turned = sigma * z, along * z + across * other
            ways = np.stack([further - half * turned, further + half * turned], axis=-1)
            off = body_twist(increments + ways / radii, robot) - exact
            chance = odds * weight
            shift += chance * off[:, 1]
            squares += chance * np.stack([off[:, 0] ** 2, off[:, 0] * off[:, 1], off[:, 1] ** 2])
    squares[2] -= shift**2
    return np.concatenate([shift[None], squares])


def _gaussian() -> Iterator[tuple[float, float]]:
    """Nodes and weights over a standard normal."""
    nodes, weights = np.polynomial.hermite_e.hermegauss(_NODES)
    yield from zip(nodes.tolist(), (weights / weights.sum()).tolist(), strict=True)


def _sides(zero: Array) -> Iterator[tuple[Array, Any]]:
    """Nodes and weights over a standard normal on both sides of a place (S,)."""
    nodes, weights = np.polynomial.legendre.leggauss(_SIDE_NODES)
    for end in (-_FAR, _FAR):
        length = end - zero
        for node, weight in zip((1 + nodes) / 2, weights / 2, strict=True):
            z = zero + length * node
            yield z, weight * np.abs(length) * np.exp(-(z**2) / 2) / np.sqrt(2 * np.pi)
