"""How sure a fit is: the covariance of its parameters, where residuals go on along a drive as those of real robots do.

The parameters are scaled so that the information of all drives and of what was believed is one: sum H_d + P = 1, with
H_d = J_d^T J_d of drive d. Its residuals r_d pull the parameters by its score s_d = J_d^T r_d. The jackknife leaves out
one of n drives after the other,

```
delta_d = (1 - H_d)^-1 s_d        C = (n - 1) / n sum delta_d delta_d^T
```

which holds whatever residuals of the same drive have to do with each other. C is widened in the directions in which
independent residuals, or for few drives stretches of them, leave more: a few drives may agree by chance. Of one or two
drives there are the stretches alone. These are not independent, so that deviations from them are doubled. What ticks of
the encoder do to the parameters is added to what independent residuals leave (`_ticks`).

Disjoint halves of eight recordings of a real robot, of three to eight drives, differ by a chi-square of 0.65 to 0.77
per degree of freedom on average, depending on how they start; if independent residuals were relied on, of 450 to 1200.
Disjoint pairs of drives differ by 0.8 to 1.7 in the median.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

from diffdrive_mj._checks import Array

# From so many drives on their scatter alone decides; from so many it does beside independent residuals; and from so
# many, beside stretches too, if residuals are seen to go on along them.
_MANY_DRIVES, _ENOUGH_DRIVES, _FEW_DRIVES = 15, 5, 3
# Stretches of few drives, together, and how much larger deviations of one or two drives are than these show.
_STRETCHES, _ROUGHLY = 10, 2.0
# How improbable the scores of independent residuals must be for these not to be taken as such.
_CHANCE = 0.001
# What a part leaves to the others at least: without it the rest may show nothing of a parameter.
_LEFT = 1e-6

Part = tuple[Array, Array]  # derivatives (N, P) and residuals (N,)


@dataclass(frozen=True, eq=False)
class Uncertainty:
    """A covariance (P, P), and from the scatter of how many parts it is; of none where residuals are independent."""

    covariance: Array
    parts: int
    rough: bool


def uncertainty(
    jacobian: Array, residuals: Array, lengths: Sequence[int], prior_std: Array, variance: float, by_ticks: Array
) -> Uncertainty:
    """The covariance of the parameters.

    Args:
        jacobian: weighted (M, k, P), k components of the poses of all drives, without the prior's rows.
        residuals: (M, k).
        lengths: how many poses each drive has.
        prior_std: of what was believed (P,).
        variance: of the residuals, one where their scales are right.
        by_ticks: what the ticks of the encoder leave beside that (P, P).
    """
    relative = np.concatenate([jacobian.reshape(-1, len(prior_std)) * prior_std, np.eye(len(prior_std))])
    unit = np.linalg.inv(np.linalg.qr(relative, mode="r"))  # to parameters of information one
    scaled = (jacobian * prior_std) @ unit
    edges = np.cumsum([0, *lengths])
    drives = [_part(scaled, residuals, np.arange(a, b)) for a, b in itertools.pairwise(edges)]
    spread = prior_std[:, None] * unit
    inverse = np.linalg.inv(spread)
    covariance, parts, rough = _scaled(scaled, residuals, edges, drives, variance, inverse @ by_ticks @ inverse.T)
    return Uncertainty(spread @ covariance @ spread.T, parts, rough)


def _scaled(
    jacobian: Array, residuals: Array, edges: Array, drives: Sequence[Part], variance: float, by_ticks: Array
) -> tuple[Array, int, bool]:
    """The covariance of the scaled parameters, of how many parts, and whether it is rough."""
    by_noise = _independent(jacobian, variance)
    independent = by_noise + by_ticks
    if len(drives) >= _MANY_DRIVES:
        return _jackknife(drives), len(drives), False
    if len(drives) >= _ENOUGH_DRIVES:
        return _not_below(independent, _jackknife(drives)), len(drives), False
    count = -(-_STRETCHES // len(drives))
    rows = [part for a, b in itertools.pairwise(edges) for part in np.array_split(np.arange(a, b), min(count, b - a))]
    stretches = [_part(jacobian, residuals, part) for part in rows]
    if not any(_go_on(parts, variance) for parts in (stretches, drives)):
        return independent, 0, False
    if len(drives) < _FEW_DRIVES:
        least = _ROUGHLY**2 * by_noise + by_ticks
        return _not_below(least, _ROUGHLY**2 * _jackknife(stretches)), len(stretches), True
    return _not_below(_not_below(independent, _jackknife(stretches)), _jackknife(drives)), len(stretches), False


def _part(jacobian: Array, residuals: Array, rows: Array) -> Part:
    return jacobian[rows].reshape(-1, jacobian.shape[-1]), residuals[rows].ravel()


def _go_on(parts: Sequence[Part], variance: float) -> bool:
    """Whether the scores of parts are larger than independent residuals have them."""
    size, freedom = 0.0, -parts[0][0].shape[1]
    for block, rows in parts:
        score, information = block.T @ rows, block.T @ block
        size += float(score @ np.linalg.pinv(information, rcond=1e-9, hermitian=True) @ score)
        freedom += int(np.linalg.matrix_rank(information, rtol=1e-9, hermitian=True))
    return freedom > 0 and size > variance * float(stats.chi2.isf(_CHANCE, freedom))


def _independent(jacobian: Array, variance: float) -> Array:
    """The covariance if residuals are independent."""
    columns = jacobian.reshape(-1, jacobian.shape[-1])
    information = columns.T @ columns
    # The rest is the prior's, which is not a measurement: its share does not shrink with the residuals.
    return np.asarray(variance * information + np.eye(len(information)) - information)


def _jackknife(parts: Sequence[Part]) -> Array:
    """The covariance from what leaving out each part moves the parameters by."""
    moves = []
    for block, rows in parts:
        shares, directions = np.linalg.eigh(block.T @ block)
        moves.append(directions @ (directions.T @ (block.T @ rows) / np.maximum(1 - shares, _LEFT)))
    return np.asarray((len(parts) - 1) / len(parts) * np.transpose(moves) @ np.array(moves))


def _not_below(least: Array, covariance: Array) -> Array:
    """A covariance, widened in those directions in which it is below the least one."""
    root = np.linalg.cholesky(least)
    inverse = np.linalg.inv(root)
    ratios, directions = np.linalg.eigh(inverse @ covariance @ inverse.T)
    widened = root @ directions
    return np.asarray((widened * np.maximum(ratios, 1.0)) @ widened.T)
