"""What the ticks of an encoder leave open: how far they may move a fit, and what the drives only seem to show.

A reading is off by up to half a tick. That is not noise of the true poses: it turns the robot for one step, so that all
later poses are displaced, by an error that no residual shows as such. Drives redrawn with other rounding errors show
what it does to the parameters, and to the derivatives: where wheels turn alike but for their ticks, as on a straight
line, a derivative that is made of ticks alone is none.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from diffdrive_mj._checks import Array
from diffdrive_mj.calibration._problem import Problem
from diffdrive_mj.drive import Drive

# Steps that differ by less, relative to the largest, are equal up to rounding; and ticks are whole to this part.
_EQUAL, _WHOLE = 1e-9, 0.01
# At more of the steps than this the acceleration changes: by rounding at most, of a planned ramp at its ends.
_UNEVEN = 0.1
# How often the ticks are redrawn; and how many times what they make of a derivative it must be.
_DRAWS, _SHOWN = 32, 5.0
# A counter that shows the same for so many times as long as before and after is that of a wheel at rest.
_REST = 3


def tick(angles: Array) -> float:
    """The resolution of an encoder [rad], from its angles (T,); 0 where they are not on any grid."""
    steps = np.diff(angles)
    sizes = np.sort(steps)
    gaps = np.diff(sizes)
    apart = gaps[gaps > _EQUAL * np.abs(steps).max(initial=0.0)]
    if not len(apart):
        return 0.0
    smallest = float(apart.min())
    counts = np.round(steps / smallest)
    on_grid = bool(np.abs(steps / smallest - counts).max() < _WHOLE)
    uneven = np.count_nonzero(np.diff(counts, 2)) > _UNEVEN * np.count_nonzero(counts)
    return smallest if on_grid and uneven else 0.0


def ticks_of(drives: Sequence[Drive]) -> Array:
    """The resolutions of the encoders of drives (D, 2) [rad]; 0 where there is none."""
    return np.array([[tick(wheel) for wheel in drive.wheel_angles.T] for drive in drives])


def hide(problem: Problem, x: Array, ticks: Array) -> None:
    """Keep a problem from fitting what only the ticks (D, 2) of its drives seem to show about the lengths among x (P,).

    Whether a turning gain is shown is decided by itself (`_gain`).
    """
    problem.shown = None
    if not ticks.any():
        return
    redrawn = problem.on(
        [
            replace(drive, wheel_angles=angles[0], truth_t=drive.clock)
            for drive, angles in zip(problem.drives, _redrawn(problem.drives, ticks, 1), strict=True)
        ]
    )
    jacobian, other = (of.jacobian(x)[: -len(x), :3] * of.prior_std[:3] for of in (problem, redrawn))
    _, directions = np.linalg.eigh(jacobian.T @ jacobian)
    size, by_ticks = (np.linalg.norm(each @ directions, axis=0) for each in (jacobian, other - jacobian))
    shown = directions[:, size >= _SHOWN * by_ticks]
    problem.shown = np.eye(len(x))
    problem.shown[:3, :3] = shown @ shown.T


def spread(problem: Problem, x: Array, ticks: Array) -> Array:
    """The covariance (P, P) that the ticks (D, 2) alone leave in the parameters x (P,)."""
    if not ticks.any():
        return np.zeros((len(x), len(x)))
    jacobian, changes = problem.jacobian(x), []
    for i, angles in enumerate(_redrawn(problem.drives, ticks, _DRAWS)):
        paths = problem.paths(i, x, np.concatenate([problem.drives[i].wheel_angles[None], angles]))
        changes.append(problem.weighted(i, np.moveaxis(paths[1:] - paths[0], 0, -1)).reshape(-1, _DRAWS))
    # What start poses and clock offsets would take up has been taken out of the derivatives.
    pull = jacobian[: -len(x)].T @ np.concatenate(changes)
    moves = np.linalg.solve(jacobian.T @ jacobian, pull)
    return np.asarray(moves @ moves.T / _DRAWS)


def _redrawn(drives: Sequence[Drive], ticks: Array, count: int) -> Iterator[Array]:
    """The wheel angles of each drive with rounding errors added (count, T, 2), always the same ones."""
    rng = np.random.default_rng(0)
    for drive, sizes in zip(drives, ticks, strict=True):
        angles = np.tile(drive.wheel_angles, (count, 1, 1))
        for wheel in np.flatnonzero(sizes):
            counts = np.round(drive.wheel_angles[:, wheel] / sizes[wheel])
            angles[..., wheel] += sizes[wheel] * _errors(counts, rng, count)
        yield angles


def _errors(counts: Array, rng: np.random.Generator, draws: int) -> Array:
    """Rounding errors (draws, T) [ticks]: while a counter shows the same its wheel passes through a tick, or rests."""
    first = np.flatnonzero(np.diff(counts, prepend=np.inf))
    lengths = np.diff(first, append=len(counts))
    beside = np.maximum(np.append(lengths[1:], 1), np.append(1, lengths[:-1]))
    rests, phase = lengths > _REST * beside, rng.random((draws, len(first)))
    run = np.repeat(np.arange(len(first)), lengths)
    passed = (np.arange(len(counts)) - first[run] + phase[:, run]) / lengths[run]
    return np.asarray(np.where(rests[run], phase[:, run], passed) - 0.5)
