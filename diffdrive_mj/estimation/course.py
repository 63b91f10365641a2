"""The course of a robot without a compass, from two position fixes and the distance driven between them (001).

The vector w = PHI_1 - PHI_0 points where a straight drive went. Its direction is a bearing (k in 001: from +y,
clockwise, in [0, 2 pi)) or a yaw (REP-103: from +x, counter-clockwise); yaw = pi / 2 - k. Whether the drive was
straight, epsilon = abs(norm(w) - travelled) can hardly tell: see `smallest_visible_bend`. A fix is off by an
isotropic Gaussian of standard deviation `fix_noise` on each axis, so that w is off by sqrt(2) times as much.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import ArrayLike, NDArray

from diffdrive_mj import _checks as checks
from diffdrive_mj import se2
from diffdrive_mj._checks import Array, array, broadcast, not_negative_array, positive_array
from diffdrive_mj._text import span
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.estimation.course_noise import direction_std

SIGMAS = 3.0
# Fixes without noise still agree with an odometer no better than this, relative to the distance.
_AGREEMENT = 1e-6
# 1 - sinc(x) = x^2 / 3! - x^4 / 5! + ..., whose digits the difference would lose; to the last of them for x <= pi.
_SHORTENING = np.array([0.0, *((-1) ** n / math.factorial(2 * n + 3) for n in range(15))])
_SHORTENING_SLOPE = polynomial.polyder(_SHORTENING)


def bearing_of(vector: ArrayLike) -> Array:
    """The compass bearing of a vector, k = atan2(x, y).

    Args:
        vector: (..., 2) [m], of any length but zero.

    Returns:
        (...) [rad], clockwise from +y, in [0, 2 pi).

    Raises:
        InvalidValue: a vector of length zero, which has no direction.
    """
    x, y = _components("vector", vector)
    return _around(np.arctan2(x, y))


def bearing_by_arccos(vector: ArrayLike) -> Array:
    """The bearing as 001 has it: k = arccos(y / norm(w)), and 360 degrees - k where x < 0.

    It loses half the digits near 0 and 180 degrees, where the cosine is flat; `bearing_of` does not.

    Args, Returns, Raises: as of `bearing_of`.

    Source: 001, Berechnung des Kurses.
    """
    x, y = _components("vector", vector)
    enclosed = np.arccos(np.clip(y / np.hypot(x, y), -1.0, 1.0))
    return _around(np.where(x < 0, -enclosed, enclosed))


def yaw_of(vector: ArrayLike) -> Array:
    """The yaw of a vector, atan2(y, x).

    Args, Raises: as of `bearing_of`.

    Returns:
        (...) [rad], counter-clockwise from +x, in (-pi, pi].
    """
    x, y = _components("vector", vector)
    return se2.wrap_angle(np.arctan2(y, x))


def yaw_from_bearing(bearing: ArrayLike) -> Array:
    """The yaw pi / 2 - k (...) [rad], in (-pi, pi], of a bearing k (...) [rad]."""
    return se2.wrap_angle(np.pi / 2 - array("bearing", bearing))


def bearing_from_yaw(yaw: ArrayLike) -> Array:
    """The bearing pi / 2 - yaw (...) [rad], in [0, 2 pi), of a yaw (...) [rad]."""
    return _around(np.pi / 2 - array("yaw", yaw))


def missing_angle(yaw: ArrayLike, position: ArrayLike, goal: ArrayLike) -> Array:
    """The turn on the spot after which a robot faces its goal, by the shorter way.

    Args:
        yaw: of the robot (...) [rad].
        position: of the robot (..., 2) [m].
        goal: (..., 2) [m].

    Returns:
        (...) [rad], counter-clockwise, in (-pi, pi].

    Raises:
        InvalidValue: the robot stands on its goal.

    Source: 001, Die Betrachtung der Ausgangssituation and Berechnung des Kurses.
    """
    yaw, position, goal = array("yaw", yaw), array("position", position, 2), array("goal", goal, 2)
    broadcast(yaw=yaw, position=position[..., 0], goal=goal[..., 0])
    return se2.wrap_angle(yaw_of(_between("position", position, "goal", goal)) - yaw)


@dataclass(frozen=True, eq=False)
class Course:
    """Where a robot heads after a straight drive. Leading dimensions are those of the drives.

    Attributes:
        bearing: (...) [rad], clockwise from +y, in [0, 2 pi).
        yaw: (...) [rad], counter-clockwise from +x, in (-pi, pi].
        baseline: norm(w), the distance between the fixes (...) [m].
        travelled: the distance driven, from the odometer (...) [m].
        epsilon: abs(baseline - travelled) (...) [m].
        threshold: the largest epsilon that passes for straight (...) [m].
        fix_noise: of each fix on each axis (...) [m].
    """

    bearing: Array
    yaw: Array
    baseline: Array
    travelled: Array
    epsilon: Array
    threshold: Array
    fix_noise: Array

    @property
    def straight(self) -> NDArray[np.bool_]:
        """Whether epsilon passes (...); a bend below `smallest_visible_bend` passes too."""
        return self.epsilon <= self.threshold

    @property
    def std(self) -> Array:
        """The standard deviation of the course that the fixes' noise leads to (...) [rad], exact.

        The length of a straight drive is the odometer's, which knows it better than the fixes do.
        """
        return direction_std(self.fix_noise, np.where(self.straight, self.travelled, self.baseline))

    def __str__(self) -> str:
        bent, drives = np.sum(~self.straight), np.size(self.straight)
        verdict = ("NOT straight" if drives == 1 else f"{bent} of {drives} NOT straight") if bent else "straight"
        bearing, yaw, std = (span(np.degrees(value), "deg") for value in (self.bearing, self.yaw, self.std))
        baseline, travelled = span(self.baseline, "m"), span(self.travelled, "m")
        epsilon, threshold = (span(value, "mm", 1e3) for value in (self.epsilon, self.threshold))
        return (
            f"bearing   {bearing}, yaw {yaw}, standard deviation {std}\n"
            f"baseline  {baseline} between the fixes, {travelled} driven\n"
            f"epsilon   {epsilon}, allowed {threshold}: {verdict}"
        )


def from_fixes(
    first: ArrayLike,
    second: ArrayLike,
    travelled: ArrayLike,
    *,
    fix_noise: ArrayLike,
    threshold: ArrayLike | None = None,
) -> Course:
    """The course from the fixes before and after a drive straight ahead, and the distance driven.

    w = PHI_1 - PHI_0,  k = atan2(x_w, y_w),  epsilon = abs(norm(w) - travelled)

    Args:
        first, second: PHI_0 and PHI_1 (..., 2) [m].
        travelled: (...) [m], positive; who drives in reverse heads the other way.
        fix_noise: standard deviation of a fix on each axis (...) [m].
        threshold: the largest epsilon that passes for straight (...) [m]; three standard deviations of epsilon,
            3 sqrt(2) fix_noise, if not given.

    Returns:
        The course; whether the path passed for straight is its `straight`.

    Raises:
        InvalidValue: fixes that coincide, a distance that is not positive, a negative noise or threshold, shapes
            that do not fit, or values that are not finite.

    Source: 001, Berechnung des Kurses.
    """
    start, end = array("first", first, 2), array("second", second, 2)
    driven, noise = positive_array("travelled", travelled), not_negative_array("fix_noise", fix_noise)
    given = None if threshold is None else not_negative_array("threshold", threshold)
    names = {"first": start[..., 0], "second": end[..., 0], "travelled": driven, "fix_noise": noise}
    shape = broadcast(**names, **({} if given is None else {"threshold": given}))
    limit = np.maximum(SIGMAS * math.sqrt(2) * noise, _AGREEMENT * driven) if given is None else given
    w = _between("first", start, "second", end)
    baseline = np.hypot(w[..., 0], w[..., 1])
    values = (bearing_of(w), yaw_of(w), baseline, driven, np.abs(baseline - driven), limit, noise)
    return Course(*(np.broadcast_to(value, shape)[()] for value in values))


def chord_shortening(bend: ArrayLike, travelled: ArrayLike) -> Array:
    """How much shorter the chord of an arc is than the arc: w (1 - sinc(beta / 2)), about w beta^2 / 24.

    The heading at the arc's end is beta / 2 off the chord's direction, which passes for the course.

    Args:
        bend: beta, how far the heading turns along the path (...) [rad], at most a full circle.
        travelled: the arc's length w (...) [m].

    Returns:
        (...) [m], all digits of it.

    Source: the exact chord of 000, equation 1.7; the flaw is that of 001's epsilon.
    """
    beta, length = array("bend", bend), positive_array("travelled", travelled)
    broadcast(bend=beta, travelled=length)
    if (np.abs(beta) > 2 * np.pi).any():
        raise InvalidValue(f"bend = {np.abs(beta).max():g} rad: must be at most a full circle, 2 pi")
    return length * polynomial.polyval((beta / 2) ** 2, _SHORTENING)


def smallest_visible_bend(fix_noise: ArrayLike, travelled: ArrayLike, sigmas: float = SIGMAS) -> Array:
    """The smallest bend that epsilon sees: the one that shortens the chord by three standard deviations of epsilon.

    w (1 - sinc(beta / 2)) = 3 sqrt(2) fix_noise,  beta about sqrt(72 sqrt(2) fix_noise / w)

    Half the paths that bend so far pass for straight all the same, and nearly all that bend half as far.

    Args:
        fix_noise: standard deviation of a fix on each axis (...) [m].
        travelled: w (...) [m].
        sigmas: how many standard deviations of epsilon, sqrt(2) fix_noise each, the threshold is.

    Returns:
        beta (...) [rad], infinite where not even a full circle is seen.
    """
    noise, length = not_negative_array("fix_noise", fix_noise), positive_array("travelled", travelled)
    broadcast(fix_noise=noise, travelled=length)
    lost = checks.positive("sigmas", sigmas) * math.sqrt(2) * noise / length
    wanted = np.minimum(lost, 1.0)
    # Newton for (beta / 2)^2 from below: the shortening is concave in it, so that no step overshoots.
    squared = 6 * wanted
    for _ in range(8):
        gap = wanted - polynomial.polyval(squared, _SHORTENING)
        squared = squared + gap / polynomial.polyval(squared, _SHORTENING_SLOPE)
    return np.where(lost > 1, np.inf, 2 * np.sqrt(squared))[()]


def hidden_course_error(fix_noise: ArrayLike, travelled: ArrayLike, sigmas: float = SIGMAS) -> Array:
    """How far off the course at the end of a path that epsilon takes for straight may be: beta / 2, at most pi.

    Args, Returns: as of `smallest_visible_bend`; (...) [rad].
    """
    return np.minimum(smallest_visible_bend(fix_noise, travelled, sigmas) / 2, np.pi)


def _components(name: str, vector: ArrayLike) -> tuple[Array, Array]:
    """The x and y of vectors, each of which has a direction."""
    vector = array(name, vector, 2)
    x, y = vector[..., 0], vector[..., 1]
    if ((x == 0) & (y == 0)).any():
        raise InvalidValue(f"{name} has length zero: must have a direction")
    return x, y


def _between(name_a: str, a: Array, name_b: str, b: Array) -> Array:
    """The vectors from a to b, each of which has a direction."""
    w = b - a
    coincide = (w == 0).all(axis=-1)
    if coincide.any():
        where = np.broadcast_to(a, w.shape)[coincide][0]
        raise InvalidValue(f"{name_a} and {name_b} coincide at ({where[0]:g}, {where[1]:g}) m: no direction between")
    return w


def _around(angle: Array) -> Array:
    """The same direction in [0, 2 pi)."""
    turned = np.mod(angle, 2 * np.pi)
    # A tiny negative angle rounds up to the whole turn.
    return np.where(turned < 2 * np.pi, turned, 0.0)[()]
