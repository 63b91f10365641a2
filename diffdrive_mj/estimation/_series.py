"""A Taylor series to second order of where a robot is, by kappa, g and its heading at the start."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Complex = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class Series:
    """F = value + slope d + d bend d, of N robots at K ends.

    Attributes:
        value: (N, K).
        slope: (3, N, K).
        bend: (3, 3, N, K), symmetric.
    """

    value: Complex
    slope: Complex
    bend: Complex

    def __add__(self, other: Series) -> Series:
        return Series(self.value + other.value, self.slope + other.slope, self.bend + other.bend)


def symmetric(parts: Complex) -> Series:
    """The series of F and its derivatives by kappa and g: F, two of first order, three of second (6, N, K).

    To turn the start is to multiply by e^(i d): the derivatives by the heading follow.
    """
    value, by_kappa, by_g, twice_kappa, mixed, twice_g = parts
    bend: Complex = np.array([
        [twice_kappa, mixed, 1j * by_kappa], [mixed, twice_g, 1j * by_g], [1j * by_kappa, 1j * by_g, -value],
    ])  # fmt: skip
    slope: Complex = np.array([by_kappa, by_g, 1j * value])
    return Series(value, slope, bend / 2)
