"""Where a robot is after pieces of a path in which it turns little: a Taylor series in kappa, g and the heading.

A piece from -1 to 1, with theta_m and e_m at its middle and h, e_h from there to its end, adds

```
w / 2 integral of e^(i (theta_m + e_m + t (h + e_h))) dt,    w = kappa dS + g dD / 4
```

to F. Its series takes three means: of e^(i h t), of it times t, and of it times t^2.
"""

from __future__ import annotations

import math
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from diffdrive_mj._checks import Array
from diffdrive_mj.estimation._robot_box import RobotBox
from diffdrive_mj.estimation._series import Complex, Series, symmetric
from diffdrive_mj.estimation._wheel_path import WheelPath, turning, way

C = TypeVar("C", np.float64, np.complex128)
_UNIT = 2.0**-53


class ShortPieces:
    """The short pieces of a path, for the robots of a box.

    Args:
        path: of wheel angles.
        box: of robots.
    """

    def __init__(self, path: WheelPath, box: RobotBox) -> None:
        self._last = path.ends - 1
        at = turning(path.short)
        # A row each for kappa, g and the heading, or for kappa and g alone.
        self._middle, self._half = at.mean(axis=1).T, np.diff(at, axis=1)[:, 0].T / 2
        self._way = np.diff(way(path.short), axis=1)[:, 0].T
        self._terms = _terms(float(np.abs(box.physical(box.corners)[1] @ self._half).max(initial=0.0)))
        # What is cubed between two ends is at most the mean of their cubes.
        cubes = np.einsum("sej,sek,sel->sjkl", *[np.abs(at)] * 3) / 2
        size = np.abs(self._way)
        if len(self._last) == 1:
            self._sizes = np.tensordot(size, cubes, axes=1)[..., None]
        else:
            self._sizes = np.cumsum(np.einsum("is,sjkl->ijkls", size, cubes), axis=-1)[..., self._last]

    def value(self, center: Array) -> Complex:
        """F of robots (N, 3): (N, K)."""
        mean = _means(center @ self._half, self._terms)[0]
        pieces: Complex = center[:, :2] @ self._way * mean * np.exp(1j * (center @ self._middle))
        return self._to_ends(pieces)

    def series(self, center: Array) -> Series:
        """F and its derivatives about robots (N, 3)."""
        mean, first, second = (
            part * np.exp(1j * (center @ self._middle)) for part in _means(center @ self._half, self._terms)
        )
        ahead = center[:, :2] @ self._way
        by_heading = [1j * mean * self._middle[j] - first * self._half[j] for j in (0, 1)]
        slope = [ahead * by_heading[j] + mean * self._way[j] for j in (0, 1)]
        bend = [
            self._way[j] * by_heading[k] + self._way[k] * by_heading[j]
            - ahead * (mean * (self._middle[j] * self._middle[k]) + second * (self._half[j] * self._half[k])
                       + 1j * first * (self._middle[j] * self._half[k] + self._half[j] * self._middle[k]))
            for j, k in ((0, 0), (0, 1), (1, 1))
        ]  # fmt: skip
        rows: Complex = np.stack([ahead * mean, *slope, *bend])
        return symmetric(self._to_ends(rows))

    def rest(self, center: Array, width: Array) -> Array:
        """What third powers and above of deviations up to `width` (N, 3) add to F at most (N, K)."""
        squares = np.einsum("ijlmk,nl,nm->nkij", self._sizes, width, width)
        cubes = np.einsum("ni,nj,nkij->nk", np.abs(center[:, :2]), width, squares)
        found: Array = cubes / 6 + np.einsum("ni,nki->nk", width[:, :2], squares[..., 2]) / 2
        return found

    def _to_ends(self, pieces: NDArray[C]) -> NDArray[C]:
        """Sums of what each piece adds (..., S), up to the ends (..., K)."""
        if len(self._last) == 1:
            return pieces.sum(axis=-1, keepdims=True)
        found: NDArray[C] = np.cumsum(pieces, axis=-1)[..., self._last]
        return found


def _terms(half: float) -> int:
    """How many terms of the series of `_means` leave out less than rounding does, up to a half turn [rad]."""
    count = 1
    while half ** (2 * count) / math.factorial(2 * count + 1) > _UNIT / 8:
        count += 1
    return count


def _means(half: Array, terms: int) -> tuple[Array, Array, Array]:
    """The means over t from -1 to 1 of e^(i half t) times 1, t / i and t^2.

    Each is a series in half^2 whose signs alternate and whose terms fall: what is left out is less than the next one.
    """
    square = half**2
    mean, first, second = (np.zeros_like(half) for _ in range(3))
    for n in reversed(range(terms)):
        sign = (-1) ** n
        mean = mean * square + sign / math.factorial(2 * n + 1)
        first = first * square + sign * (2 * n + 2) / math.factorial(2 * n + 3)
        second = second * square + sign / (math.factorial(2 * n) * (2 * n + 3))
    return mean, first * half, second
