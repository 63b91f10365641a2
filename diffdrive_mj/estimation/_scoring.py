"""The variances of both wheels that explain the errors of stretches, by restricted likelihood.

The errors r have the covariance C(a, b), linear in the variances a and b of the wheels, and are off by G d besides,
where d is what is wrong with the radii and the track. Whatever d is, the variances satisfy

```
r^T P C_i P r = tr(P C_i),    C_i = dC/di,    i = a, b
P = C^-1 - C^-1 G (G^T C^-1 G)^-1 G^T C^-1
```

(Patterson and Thompson 1971), which Fisher's scoring solves.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from diffdrive_mj._checks import Array
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.estimation._stretches import Stretches

_STEPS = 200
# Below what part of their deviations steps end.
_DONE = 1e-6
# A variance that is none: beside that of the other wheel, by itself [m] (a micrometre on a metre), and beside its own
# deviation.
_NONE, _NOTHING, _LOST = 1e-6, 1e-12, 1e-3


def scored(pieces: list[Stretches], variances: Array) -> tuple[Array, Array, tuple[Array, Array]]:
    """The variances that explain the errors, by Fisher's scoring, their covariance, and what else is off."""
    last, part = np.zeros(2), 1.0
    for _ in range(_STEPS):
        score, information, *off = _sums(pieces, variances)
        step = _after(variances, score, information) - variances
        # Where the errors say less than is expected of them, whole steps go back and forth.
        part = part / 2 if step @ information @ last < 0 else part
        last, variances = step, variances + part * step
        spread = np.asarray(np.linalg.inv(information), dtype=np.float64)
        if np.all(np.abs(step) < _DONE * np.sqrt(np.diag(spread))):
            return variances, spread, (off[0], off[1])
    raise InvalidValue(f"drives: the noise is not found in {_STEPS} steps; give more drives")


def is_none(variances: Array, deviations: Array) -> NDArray[np.bool_]:
    """Which of the variances (2,) are held at next to nothing."""
    return np.asarray((variances < _LOST * deviations) | (variances <= _floor(variances)))


def _floor(variances: Array) -> float:
    """The variance that counts as none beside the other."""
    return max(_NONE * float(variances.max()), _NOTHING)


def _after(variances: Array, score: Array, information: Array) -> Array:
    """The variances after a step of Fisher's scoring; one that would become negative is held at next to nothing."""
    floor = _floor(variances)
    after: Array = variances + np.linalg.solve(information, score)
    if after.min() < floor:
        held = int(np.argmin(after))
        other = 1 - held
        after[held] = floor
        known = score[other] - information[other, held] * (floor - variances[held])
        after[other] = variances[other] + known / information[other, other]
    return np.maximum(after, floor)


def start(pieces: list[Stretches]) -> Array:
    """Equal variances that explain the headings."""
    found = sum(float(np.sum(piece.errors[2::3] ** 2)) for piece in pieces)
    unit = sum(float(np.trace(part[2::3, 2::3])) for piece in pieces for part in piece.growth)
    return np.full(2, max(found / unit, 1e-12))


def _sums(pieces: list[Stretches], variances: Array) -> tuple[Array, Array, Array, Array]:
    """The score and the information of both variances, and what of radii and track is off, with its information."""
    normal, moment = np.zeros((3, 3)), np.zeros(3)
    whitened = []
    for piece in pieces:
        inverse = np.linalg.inv(piece.covariance(variances))
        errors, slopes = piece.errors, inverse @ piece.by_parameters
        normal += piece.by_parameters.T @ slopes
        moment += slopes.T @ errors
        whitened.append((inverse, errors, slopes))
    spread = np.linalg.pinv(normal, rcond=1e-12, hermitian=True)
    off = spread @ moment
    score, information = np.zeros(2), np.zeros((2, 2))
    inner = np.zeros((2, 3, 3))
    for piece, (inverse, errors, slopes) in zip(pieces, whitened, strict=True):
        left = inverse @ errors - slopes @ off
        for i, growth in enumerate(piece.growth):
            inner[i] += slopes.T @ growth @ slopes
            score[i] += left @ growth @ left - np.sum(inverse * growth)
            for j, other in enumerate(piece.growth):
                both = growth @ inverse @ other
                information[i, j] += np.sum((inverse @ growth) * (inverse @ other).T)
                information[i, j] -= 2 * np.sum(spread * (slopes.T @ both @ slopes))
    for i in range(2):
        score[i] += np.sum(spread * inner[i])
        for j in range(2):
            information[i, j] += np.sum((spread @ inner[i]) * (spread @ inner[j]).T)
    return score / 2, information / 2, off, normal
