"""Refining a robot's parameters, and how sure they are.

The covariance comes from the derivatives and the residuals. Where residuals are correlated from pose to pose it is
larger: the sums of the scores over stretches of the drives say by how much.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from diffdrive_mj._checks import Array
from diffdrive_mj.calibration._problem import Problem

# The turning gain is freed when it is this many standard deviations from zero.
SIGNIFICANT = 4.0
# Residuals that are correlated by more from one pose to the next do not count as independent.
_CORRELATED = 0.5


@dataclass(frozen=True, eq=False)
class Fit:
    """Where a refinement ended.

    Attributes:
        parameters: all of them (4,), the P free ones first.
        covariance: of the free ones (P, P).
        residuals: weighted (N,).
        condition: of the problem in relative units.
        outliers: how many poses of each drive lie far off.
        spreads: root mean square of each drive's residuals.
        uncorrelated: whether residuals of two poses in a row have little to do with each other.
        details: further figures by name.
    """

    parameters: Array
    covariance: Array
    residuals: Array
    condition: float
    outliers: list[int]
    spreads: list[float]
    uncorrelated: bool
    details: dict[str, float]

    @property
    def free(self) -> Array:
        """The free parameters (P,)."""
        return self.parameters[: len(self.covariance)]

    @property
    def std(self) -> Array:
        """Standard deviations of the free parameters (P,)."""
        return np.sqrt(np.diag(self.covariance))


def refine(problem: Problem, guess: Array, count: int) -> Fit:
    """Refine the first parameters, positions, headings and outliers weighted by what they leave over.

    Args:
        problem: whose scales and weights are set.
        guess: (4,), from which to start.
        count: how many parameters are free.
    """
    x = guess[:count]
    for _ in range(5):
        x = problem.solve(x)
        if problem.reweigh(x):
            break
    return _fit(problem, x)


def gain_is_promising(problem: Problem, parameters: Array) -> bool:
    """Whether a single step of the turning gain too, from a fit without it, suggests a fit of its own."""
    jacobian = problem.jacobian(parameters)
    inverse = np.linalg.inv(jacobian.T @ jacobian)
    step = inverse @ (jacobian.T @ problem.residuals(parameters))
    return bool(abs(step[3]) > SIGNIFICANT / 2 * np.sqrt(inverse[3, 3]))


def _fit(problem: Problem, x: Array) -> Fit:
    drives, width, count = problem.drives, problem.components, len(x)
    jacobian = problem.jacobian(x)
    measured = problem.residuals(x)[:-count]
    freedom = max(len(measured) - count - problem.per_drive * len(drives), 1)
    variance = max(1.0, float(measured @ measured) / freedom)
    inverse = np.linalg.inv(jacobian.T @ jacobian)
    # The prior is not a measurement: its share does not shrink with the residuals.
    prior = np.diag(1 / problem.prior_std[:count] ** 2)
    covariance = inverse @ (variance * (jacobian.T @ jacobian - prior) + prior) @ inverse
    edges = np.cumsum([0, *(len(drive.truth) * width for drive in drives)])
    pieces = [measured[a:b].reshape(-1, width) for a, b in itertools.pairwise(edges)]
    uncorrelated = _correlation(pieces) < _CORRELATED
    if not uncorrelated:
        scores = (jacobian[:-count] * measured[:, None]) @ inverse
        covariance = covariance * max(1.0, _inflation(scores, edges, width, variance * np.diag(inverse)))
    singular = np.linalg.svd(jacobian[:-count] * problem.prior_std[:count], compute_uv=False)
    details = {"position_residual_m": float(problem.scale[0])}
    if width == 3:
        details["heading_residual_rad"] = float(problem.scale[2])
    if problem.has_clock_offset:
        details["clock_offset_s"] = float(np.mean(problem.clock_offsets))
    return Fit(
        parameters=problem.completed(x),
        covariance=covariance,
        residuals=measured,
        condition=float(singular[0] / singular[-1]) if singular[-1] > 0 else float("inf"),
        outliers=[int(np.count_nonzero(weights < 0.5)) for weights in problem.weights],
        spreads=[float(np.sqrt(np.mean(piece**2))) for piece in pieces],
        uncorrelated=uncorrelated,
        details=details,
    )


def _correlation(pieces: Sequence[Array]) -> float:
    """How alike the residuals (M, k) of two poses in a row are, from -1 to 1."""
    long = [piece for piece in pieces if len(piece) > 10]
    if not long:
        return 0.0
    size = np.mean(np.concatenate(long) ** 2)
    together = np.concatenate([piece[:-1] * piece[1:] for piece in long])
    return float(together.mean() / size) if size > 0 else 0.0


def _inflation(scores: Array, edges: Array, width: int, variances: Array) -> float:
    """How much larger the variances of correlated residuals are, by sums of the scores over tenths of each drive."""
    sums = []
    for a, b in itertools.pairwise(edges):
        sums += [piece.sum(axis=0) for piece in np.array_split(scores[a:b], min(10, (b - a) // width))]
    return float(np.mean(np.sum(np.square(sums), axis=0) / variances))
