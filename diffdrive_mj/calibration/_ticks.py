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
# At how many of the steps the acceleration changes, at least: by rounding at most, of a planned ramp at its ends.
_UNEVEN = 0.1
# How often the ticks are redrawn; and how many times what they make of a derivative it must be.
_DRAWS, _SHOWN = 8, 5.0
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


def hide(problem: Problem, x: Array) -> None:
    """Keep a problem from fitting what only the ticks of its drives seem to show about the lengths among x (P,).

    Whether a turning gain is shown is decided by itself (`_gain`).
    """
    problem.shown = None
    for redrawn in _redrawn(problem, 1):
        jacobian, other = (of.jacobian(x)[: -len(x), :3] * of.prior_std[:3] for of in (problem, redrawn))
        _, directions = np.linalg.eigh(jacobian.T @ jacobian)
        size, by_ticks = (np.linalg.norm(each @ directions, axis=0) for each in (jacobian, other - jacobian))
        shown = directions[:, size >= _SHOWN * by_ticks]
        problem.shown = np.eye(len(x))
        problem.shown[:3, :3] = shown @ shown.T


def spread(problem: Problem, x: Array) -> Array:
    """The covariance (P, P) that the ticks alone leave in the parameters x (P,)."""
    moves, residuals, jacobian = np.zeros((len(x), 0)), problem.residuals(x), problem.jacobian(x)
    for redrawn in _redrawn(problem, _DRAWS):
        move = np.linalg.solve(jacobian.T @ jacobian, jacobian.T @ (redrawn.residuals(x) - residuals))
        moves = np.column_stack([moves, move])
    return np.asarray(moves @ moves.T / _DRAWS)


def _redrawn(problem: Problem, count: int) -> Iterator[Problem]:
    """The problem, with rounding errors added to its drives; none if they have no ticks. Always the same ones."""
    rng = np.random.default_rng(0)
    ticks = [[tick(wheel) for wheel in drive.wheel_angles.T] for drive in problem.drives]
    if not np.any(ticks):
        return
    for _ in range(count):
        yield problem.on([_rounded(drive, of, rng) for drive, of in zip(problem.drives, ticks, strict=True)])


def _rounded(drive: Drive, ticks: Sequence[float], rng: np.random.Generator) -> Drive:
    """A drive with rounding errors of up to half a tick added."""
    angles = drive.wheel_angles.copy()
    for wheel, size in enumerate(ticks):
        if size:
            angles[:, wheel] += size * _errors(np.round(angles[:, wheel] / size), rng)
    return replace(drive, wheel_angles=angles, truth_t=drive.clock)


def _errors(counts: Array, rng: np.random.Generator) -> Array:
    """Rounding errors of readings [ticks]: while a counter shows the same the wheel passes through a tick, or rests."""
    first = np.flatnonzero(np.diff(counts, prepend=np.inf))
    lengths = np.diff(first, append=len(counts))
    beside = np.maximum(np.append(lengths[1:], 1), np.append(1, lengths[:-1]))
    rests, phase = lengths > _REST * beside, rng.random(len(first))
    run = np.repeat(np.arange(len(first)), lengths)
    passed = (np.arange(len(counts)) - first[run] + phase[run]) / lengths[run]
    return np.asarray(np.where(rests[run], phase[run], passed) - 0.5)
