"""What the noise of a single step does: the moments of its chord and its turn, in closed form for Gaussian noise.

A step drives D and turns by W, which are Gaussian with the variances V_D and V and the covariance c; d and w are their
means. Its chord, seen from its first heading, is C = D times the integral of e^(iuW) over u from 0 to 1, and

    E e^(iuW) = phi(u) = exp(iuw - u^2 V / 2)        E D e^(iuW) = (d + iuc) phi(u)

Products of two chords are double integrals with a factor e^(uvV), whose power series splits them into products of

    M_m = int u^m phi(u) du        F_m = int u^m (d + iuc) phi(u) du = d M_m + ic M_(m + 1)

Differences of numbers that are nearly equal are taken in the formulas, so that no digits are lost to a small noise. The
formulas hold for arrays as for single numbers: `exp` says which.
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.estimation._placed import size

# What the quadrature and the series may leave out, as a share.
_ROUNDING = 1e-16
# The largest turn of a step, and its largest variance: beyond them nodes become many, and the series loses digits.
_MOST_TURN, _MOST_VARIANCE = 2000.0, 16.0
# How many standard deviations of a turn count as its size.
_DEVIATIONS = 6.0
# Below it neither matters.
_NOTHING = 1e-12


class StepMoments(NamedTuple):
    """The moments of a step, complex but for the last: arrays, or single numbers.

    Attributes:
        turned: a, the mean of e^(iW).
        chord: the mean of C [m].
        chord_turned: the covariance of C and e^(iW), E C e^(iW) - E C E e^(iW) [m].
        chord_turned_back: the same of the conjugate of C [m].
        chord_turn: the covariance of C and W [m rad].
        square: E (C - E C)^2 [m^2].
        spread: E |C - E C|^2 [m^2].
    """

    turned: Any
    chord: Any
    chord_turned: Any
    chord_turned_back: Any
    chord_turn: Any
    square: Any
    spread: Any


class Rule(NamedTuple):
    """How finely the moments are computed: nodes on u from 0 to 1 with their weights, and the terms of the series."""

    nodes: tuple[tuple[float, float], ...]
    terms: int


def rule(turn: float, variance: float) -> Rule:
    """What gives the moments to rounding, for steps with turns up to this size [rad] and this variance [rad^2]."""
    if turn > _MOST_TURN or variance > _MOST_VARIANCE:
        raise InvalidValue(
            f"wheel_angles: a step turns the robot by {turn:.3g} rad, uncertain by {math.sqrt(variance):.3g} rad: must "
            f"be at most {_MOST_TURN:g} and {math.sqrt(_MOST_VARIANCE):g} rad; sample the drive more often"
        )
    return _rule(_doubled(turn), _doubled(variance))


def _doubled(size: float) -> float:
    """The next power of two, so that most steps find their rule made."""
    return math.ldexp(1.0, math.frexp(max(size, _NOTHING))[1])


@functools.lru_cache(maxsize=1024)
def _rule(turn: float, variance: float) -> Rule:
    terms, last = 1, variance
    while last > _ROUNDING:
        terms += 1
        last *= variance / terms
    return Rule(_nodes(_count(turn + _DEVIATIONS * math.sqrt(variance))), terms)


def _count(size: float) -> int:
    """How many nodes integrate e^(iut) for |t| up to a size: their error is s^(2n) (n!)^4 / ((2n + 1) ((2n)!)^3)."""
    count, error = 1, size**2 / 24
    while error > _ROUNDING:
        # The error's quotient from n to n + 1.
        n = count
        error *= size**2 * (n + 1) ** 4 * (2 * n + 1) / ((2 * n + 3) * ((2 * n + 1) * (2 * n + 2)) ** 3)
        count += 1
    return count


@functools.lru_cache(maxsize=64)
def _nodes(count: int) -> tuple[tuple[float, float], ...]:
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return tuple(zip(((1 + nodes) / 2).tolist(), (weights / 2).tolist(), strict=True))


def step_moments(
    distance: Any, turn: Any, var_distance: Any, covariance: Any, var_turn: Any, rule: Rule, exp: Callable[[Any], Any]
) -> StepMoments:
    """The moments of steps by the means of their distance and turn and by these two's variances and covariance."""
    turned = exp(1j * turn - var_turn / 2)
    m = _integrals(turn, var_turn, rule, exp)
    cross = 1j * covariance
    f = [distance * a + cross * b for a, b in itertools.pairwise(m)]
    # The term k = 0 of the series, in which the product of the means has no part.
    chord_turned, back = cross * m[0], cross * m[0].conjugate()
    square = var_distance * m[0] * m[0] + cross * (2 * f[1] * m[0] + cross * m[1] * m[1])
    spread = _spread(m, f, 0, var_distance, covariance)
    power = 1.0  # V^k / k!
    for k in range(1, rule.terms):
        power = power * var_turn / k
        signed = -power if k % 2 else power
        chord_turned = chord_turned + signed * (f[k] + cross * m[k])
        back = back + power * (f[k] + covariance * -1j * m[k]).conjugate()
        square = square + signed * (
            f[k] * f[k] + var_distance * m[k] * m[k] + cross * (2 * f[k + 1] * m[k] + cross * m[k + 1] * m[k + 1])
        )
        spread = spread + power * (size(f[k]) + _spread(m, f, k, var_distance, covariance))
    chord_turn = covariance * m[0] + 1j * var_turn * f[1]
    return StepMoments(turned, f[0], turned * chord_turned, turned * back, chord_turn, square, spread)


def _integrals(turn: Any, var_turn: Any, rule: Rule, exp: Callable[[Any], Any]) -> list[Any]:
    """M_0, M_1, ... as far as the series needs them."""
    parts = [weight * exp(complex(0, u) * turn - u * u / 2 * var_turn) for u, weight in rule.nodes]
    found = [sum(parts)]
    for _ in range(rule.terms + 1):
        parts = [u * part for (u, _), part in zip(rule.nodes, parts, strict=True)]
        found.append(sum(parts))
    return found


def _spread(m: list[Any], f: list[Any], k: int, var_distance: Any, covariance: Any) -> Any:
    """What the noise of the distance adds to the term k of the chord's spread."""
    crossed = 2 * (f[k + 1] * m[k].conjugate()).imag
    return var_distance * size(m[k]) + covariance * (covariance * size(m[k + 1]) - crossed)
