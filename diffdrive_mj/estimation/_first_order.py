"""The covariance of the pose to first order, for comparison with the exact one and where it is enough.

An error d of the distance and w of the turn of step k moves the pose after a later step T by

    e^(i theta_k) dc/dd d + (e^(i theta_k) dc/dw + i (p_T - p_(k + 1))) w    and turns it by w

with the chord c of the step, whose derivatives are those of `derivatives.chord`. All that belongs to T stands outside
the sums over the steps, which are running sums then.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from diffdrive_mj._checks import Array
from diffdrive_mj.estimation._placed import Spread, size
from diffdrive_mj.estimation.derivatives import Motion, chord
from diffdrive_mj.estimation.noise import Steps

Complex = NDArray[np.complex128]


def linearised(steps: Steps, slopes: tuple[Array, Array] | None = None) -> Spread:
    """Compute the covariance of the pose to first order.

    Args:
        steps: of drives, with their noise (..., S).
        slopes: how distances and turns (R, ..., S) change with each of R independent unknowns of variance one, the same
            along the whole drive.

    Returns:
        The covariance at every sample.

    Example:
        After 4 m straight ahead whose turns are off by 0.01 rad in each metre:

        >>> ahead, none = np.ones(4), np.zeros(4)
        >>> found = linearised(Steps(ahead, none, none, none, np.full(4, 1e-4)))
        >>> found.variance[-1].round(6).item(), found.with_heading[-1].imag.round(6).item()
        (0.0004, 0.0008)
    """
    shape = steps.distance.shape
    # The distance and the turn of a step are what its chord is differentiated by.
    by_either = np.broadcast_to(np.eye(2)[..., None], (2, 2, steps.distance.size))
    chords = chord(Motion(steps.distance.ravel(), steps.turn.ravel(), *by_either))
    heading = _summed(steps.turn)
    direction = np.exp(1j * (heading[..., :-1] + chords.half_turn.reshape(shape)))
    place = _summed(chords.length.reshape(shape) * direction)
    slope = chords.d_length + 1j * chords.length * chords.d_half_turn
    by_distance = slope[0].reshape(shape) * direction
    by_turn = slope[1].reshape(shape) * direction - 1j * place[..., 1:]

    variance = _summed(steps.var_turn)
    along = _summed(by_distance * steps.covariance + by_turn * steps.var_turn)
    square = _summed(
        by_distance**2 * steps.var_distance + 2 * by_distance * by_turn * steps.covariance + by_turn**2 * steps.var_turn
    )
    crossed = (by_distance * by_turn.conj()).real
    spread = _summed(
        size(by_distance) * steps.var_distance + 2 * crossed * steps.covariance + size(by_turn) * steps.var_turn
    )
    lever = 1j * place
    found = Spread(
        place,
        heading,
        square + 2 * lever * along + lever**2 * variance,
        spread + 2 * (lever * along.conj()).real + size(lever) * variance,
        along + lever * variance,
        variance,
    )
    return found if slopes is None else _with_unknowns(found, by_distance, by_turn, *slopes)


def _with_unknowns(found: Spread, by_distance: Complex, by_turn: Complex, d_distance: Array, d_turn: Array) -> Spread:
    """The covariance with what is unknown along the whole drive."""
    turned = _summed(d_turn)
    moved = _summed(by_distance * d_distance + by_turn * d_turn) + 1j * found.place * turned
    return found._replace(
        square=found.square + (moved**2).sum(axis=0),
        spread=found.spread + size(moved).sum(axis=0),
        with_heading=found.with_heading + (moved * turned).sum(axis=0),
        variance=found.variance + (turned**2).sum(axis=0),
    )


def _summed(values: Any) -> Any:
    """Sums of the steps, from zero on."""
    return np.concatenate([np.zeros_like(values[..., :1]), np.cumsum(values, axis=-1)], axis=-1)
