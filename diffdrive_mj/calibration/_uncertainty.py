"""How sure a fit is: the covariance of its parameters, where residuals go on along a drive as those of real robots do.

With the information H = sum J_d^T J_d + P, P that of the prior, the residuals r_d of drive d pull the parameters by
its score s_d = J_d^T r_d; without them the parameters were another robot's. The jackknife leaves out one of n drives
after the other,

```
delta_d = (H - J_d^T J_d)^-1 s_d        C = (n - 1) / n sum delta_d delta_d^T
```

which holds whatever residuals of the same drive have to do with each other. Where there are too few drives, stretches
of them take their place: these are not independent, so that the outcome is rough. C is widened where independent
residuals alone would leave more, so that a few drives that agree by chance do not count as certainty.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from diffdrive_mj._checks import Array

# From so many drives on, their scatter decides; from so many if residuals are seen to be correlated.
_ENOUGH_DRIVES, _FEW_DRIVES = 5, 3
# Stretches of one or two drives, together.
_STRETCHES = 10
# Residuals that are correlated by more from one pose to the next do not count as independent.
_CORRELATED = 0.5


@dataclass(frozen=True, eq=False)
class Uncertainty:
    """A covariance (P, P), and from the scatter of how many parts it is; of none where residuals are independent."""

    covariance: Array
    parts: int
    rough: bool


def uncertainty(jacobian: Array, residuals: Array, lengths: Sequence[int], prior: Array, variance: float) -> Uncertainty:
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
    rough = len(drives) < _FEW_DRIVES
    count = -(-_STRETCHES // len(drives)) if rough else 1
    parts = [rows for drive in drives for rows in np.array_split(drive, min(count, len(drive)))]
    scattered = _jackknife([(jacobian[rows], residuals[rows]) for rows in parts], prior)
    return Uncertainty(_not_below(independent, scattered), len(parts), rough)


def _correlation(pieces: Sequence[Array]) -> float:
    """How alike the residuals (M, k) of two poses in a row are, from -1 to 1."""
    long = [piece for piece in pieces if len(piece) > 10]
    if not long:
        return 0.0
    together = np.concatenate([piece[:-1] * piece[1:] for piece in long])
    return float(together.mean() / np.mean(np.concatenate(long) ** 2))


def _independent(jacobian: Array, prior: Array, variance: float) -> Array:
    """The covariance if residuals are independent; the prior's share does not shrink with them: it is no measurement."""
    columns = jacobian.reshape(-1, jacobian.shape[-1])
    information = columns.T @ columns
    inverse = np.linalg.inv(information + prior)
    return inverse @ (variance * information + prior) @ inverse


def _jackknife(parts: Sequence[tuple[Array, Array]], prior: Array) -> Array:
    """The covariance from what leaving out each part moves the parameters by."""
    width = len(prior)
    shares = [(block.reshape(-1, width), rows.ravel()) for block, rows in parts]
    information = prior + sum(block.T @ block for block, _ in shares)
    moves = np.stack([np.linalg.solve(information - block.T @ block, block.T @ rows) for block, rows in shares])
    return np.asarray((len(parts) - 1) / len(parts) * moves.T @ moves)


def _not_below(least: Array, covariance: Array) -> Array:
    """A covariance, widened in those directions in which it is below the least one."""
    root = np.linalg.cholesky(least)
    inverse = np.linalg.inv(root)
    ratios, directions = np.linalg.eigh(inverse @ covariance @ inverse.T)
    widened = root @ directions
    return np.asarray((widened * np.maximum(ratios, 1.0)) @ widened.T)
