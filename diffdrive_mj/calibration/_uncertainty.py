"""How sure a fit is: the covariance of its parameters, where residuals go on along a drive as those of real robots do.

With the information H = sum J_d^T J_d + P, P that of the prior, the residuals r_d of drive d pull the parameters by
its score s_d = J_d^T r_d; without them the parameters were another robot's. The jackknife leaves out one of n drives
after the other,

```
delta_d = (H - J_d^T J_d)^-1 s_d        C = (n - 1) / n sum delta_d delta_d^T
```

which holds whatever residuals of the same drive have to do with each other. C is widened in the directions in which
independent residuals, or for few drives stretches of them, leave more: a few drives may agree by chance.
Of one or two drives there are the stretches alone: these are not independent, so that the outcome is rough.

On halves of the real recordings in `docs/references.md`, started in all three ways, the outcomes differ by a chi-square
of CHI per degree of freedom on average; by 450 to 1200 with independent residuals.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from diffdrive_mj._checks import Array

# From so many drives on, their scatter decides; from so many if residuals are seen to be correlated.
_ENOUGH_DRIVES, _FEW_DRIVES = 5, 3
# Stretches of few drives, together.
_STRETCHES = 10
# Residuals that are correlated by more from one pose to the next do not count as independent.
_CORRELATED = 0.5


@dataclass(frozen=True, eq=False)
class Uncertainty:
    """A covariance (P, P), and from the scatter of how many parts it is; of none where residuals are independent."""

    covariance: Array
    parts: int
    rough: bool


def uncertainty(
    jacobian: Array, residuals: Array, lengths: Sequence[int], prior: Array, variance: float
) -> Uncertainty:
    """The covariance of the parameters.

    Args:
        jacobian: weighted (M, k, P), k components of the poses of all drives, without the prior's rows.
        residuals: (M, k).
        lengths: how many poses each drive has.
        prior: information of what was believed (P, P).
        variance: of the residuals, one where their scales are right.
    """
    edges = np.cumsum([0, *lengths])
    drives = [np.arange(a, b) for a, b in itertools.pairwise(edges)]
    independent = _independent(jacobian, prior, variance)
    if len(drives) < _ENOUGH_DRIVES and _correlation([residuals[rows] for rows in drives]) < _CORRELATED:
        return Uncertainty(independent, 0, rough=False)
    parts, least = drives, independent
    if len(drives) < _ENOUGH_DRIVES:
        count = -(-_STRETCHES // len(drives))
        parts = [rows for drive in drives for rows in np.array_split(drive, min(count, len(drive)))]
        least = _not_below(independent, _jackknife(jacobian, residuals, parts, prior))
    rough = len(drives) < _FEW_DRIVES
    covariance = least if rough else _not_below(least, _jackknife(jacobian, residuals, drives, prior))
    return Uncertainty(covariance, len(parts), rough)


def _correlation(pieces: Sequence[Array]) -> float:
    """How alike the residuals (M, k) of two poses in a row are, from -1 to 1."""
    long = [piece for piece in pieces if len(piece) > 10]
    if not long:
        return 0.0
    size = np.mean(np.concatenate(long) ** 2)
    together = np.concatenate([piece[:-1] * piece[1:] for piece in long])
    return float(together.mean() / size) if size > 0 else 0.0


def _independent(jacobian: Array, prior: Array, variance: float) -> Array:
    """The covariance if residuals are independent."""
    columns = jacobian.reshape(-1, jacobian.shape[-1])
    information = columns.T @ columns
    inverse = np.linalg.inv(information + prior)
    # The prior is not a measurement: its share does not shrink with the residuals.
    return inverse @ (variance * information + prior) @ inverse


def _jackknife(jacobian: Array, residuals: Array, parts: Sequence[NDArray[np.intp]], prior: Array) -> Array:
    """The covariance from what leaving out each part, its rows, moves the parameters by."""
    blocks = [(jacobian[rows].reshape(-1, len(prior)), residuals[rows].ravel()) for rows in parts]
    information = prior + sum(block.T @ block for block, _ in blocks)
    moves = np.stack([np.linalg.solve(information - block.T @ block, block.T @ rows) for block, rows in blocks])
    return np.asarray((len(parts) - 1) / len(parts) * moves.T @ moves)


def _not_below(least: Array, covariance: Array) -> Array:
    """A covariance, widened in those directions in which it is below the least one."""
    root = np.linalg.cholesky(least)
    inverse = np.linalg.inv(root)
    ratios, directions = np.linalg.eigh(inverse @ covariance @ inverse.T)
    widened = root @ directions
    return np.asarray((widened * np.maximum(ratios, 1.0)) @ widened.T)
