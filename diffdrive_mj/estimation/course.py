"""The course of a robot without a compass, from two position fixes and the distance driven between them.

The vector w = PHI_1 - PHI_0 points where a straight drive went. Its direction is a bearing (k in [Petersen 2013]: from
+y, clockwise, in [0, 2 pi)) or a yaw (from +x, counter-clockwise, in (-pi, pi]); yaw = pi / 2 - k. That the drive was
straight, epsilon = |norm(w) - travelled| can hardly show: see `straightness`. A fix is off by an isotropic Gaussian of
standard deviation `fix_noise` on each axis, so that w is off by sqrt(2) times as much.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from diffdrive_mj import se2
from diffdrive_mj._checks import Array, array, broadcast, not_negative_array, positive_array
from diffdrive_mj._text import span
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.estimation.course_noise import direction_std
from diffdrive_mj.estimation.straightness import SIGMAS

# Fixes without noise still agree with an odometer no better than this, relative to the distance.
_AGREEMENT = 1e-6


def bearing_of(vector: ArrayLike) -> Array:
    """Compute the compass bearing of a vector, k = atan2(x, y).

    Args:
        vector: (..., 2) [m], of any length but zero.

    Returns:
        (...) [rad], clockwise from +y, in [0, 2 pi).

    Raises:
        InvalidValue: a vector of length zero, which has no direction.

    Example:
        >>> np.degrees(dd.course.bearing_of([[0, 1], [1, 0], [-1, 0]]))  # north, east, west
        array([  0.,  90., 270.])
    """
    x, y = _components("vector", vector)
    return _full_circle(np.arctan2(x, y))


def bearing_by_arccos(vector: ArrayLike) -> Array:
    """Compute the bearing as it is printed: k = arccos(y / norm(w)), and 360 degrees - k where x < 0.

    It loses half the digits near 0 and 180 degrees, where the cosine is flat; `bearing_of` does not.

    Args:
        vector: (..., 2) [m], of any length but zero.

    Returns:
        (...) [rad], clockwise from +y, in [0, 2 pi).

    Raises:
        InvalidValue: a vector of length zero, which has no direction.

    References:
        [Petersen 2013], Berechnung des Kurses.

    Example:
        >>> float(dd.course.bearing_by_arccos((1e-9, 1.0))), float(dd.course.bearing_of((1e-9, 1.0)))
        (0.0, 1e-09)
    """
    x, y = _components("vector", vector)
    enclosed = np.arccos(np.clip(y / np.hypot(x, y), -1.0, 1.0))
    return _full_circle(np.where(x < 0, -enclosed, enclosed))


def yaw_of(vector: ArrayLike) -> Array:
    """Compute the yaw of a vector, atan2(y, x).

    Args:
        vector: (..., 2) [m], of any length but zero.

    Returns:
        (...) [rad], counter-clockwise from +x, in (-pi, pi].

    Raises:
        InvalidValue: a vector of length zero, which has no direction.

    Example:
        >>> np.degrees(dd.course.yaw_of([[0, 1], [1, 0], [-1, 0]]))
        array([ 90.,   0., 180.])
    """
    x, y = _components("vector", vector)
    return se2.wrap_angle(np.arctan2(y, x))


def yaw_from_bearing(bearing: ArrayLike) -> Array:
    """Turn a compass bearing into a yaw, pi / 2 - k.

    Args:
        bearing: k (...) [rad], clockwise from +y.

    Returns:
        (...) [rad], counter-clockwise from +x, in (-pi, pi].

    Example:
        >>> float(np.degrees(dd.course.yaw_from_bearing(np.radians(270.0))))
        180.0
    """
    return se2.wrap_angle(np.pi / 2 - array("bearing", bearing))


def bearing_from_yaw(yaw: ArrayLike) -> Array:
    """Turn a yaw into a compass bearing, pi / 2 - yaw.

    Args:
        yaw: (...) [rad], counter-clockwise from +x.

    Returns:
        (...) [rad], clockwise from +y, in [0, 2 pi).

    Example:
        >>> float(np.degrees(dd.course.bearing_from_yaw(np.radians(180.0))))
        270.0
    """
    return _full_circle(np.pi / 2 - array("yaw", yaw))


def missing_angle(yaw: ArrayLike, position: ArrayLike, goal: ArrayLike) -> Array:
    """Compute the turn on the spot after which a robot faces its goal, by the shorter way.

    Args:
        yaw: of the robot (...) [rad].
        position: of the robot (..., 2) [m].
        goal: (..., 2) [m].

    Returns:
        (...) [rad], counter-clockwise, in (-pi, pi].

    Raises:
        InvalidValue: the robot stands on its goal.

    References:
        [Petersen 2013], Die Betrachtung der Ausgangssituation and Berechnung des Kurses.

    Example:
        >>> float(np.degrees(dd.course.missing_angle(0.0, (0, 0), (0, 5))))
        90.0
    """
    yaw, position, goal = array("yaw", yaw), array("position", position, 2), array("goal", goal, 2)
    broadcast(yaw=yaw, position=position[..., 0], goal=goal[..., 0])
    return se2.wrap_angle(yaw_of(_between("position", position, "goal", goal)) - yaw)


@dataclass(frozen=True, eq=False)
class Course:
    """Says where a robot heads after a straight drive. Leading dimensions are those of the drives.

    Attributes:
        bearing: (...) [rad], clockwise from +y, in [0, 2 pi).
        yaw: (...) [rad], counter-clockwise from +x, in (-pi, pi].
        baseline: norm(w), the distance between the fixes (...) [m].
        travelled: the distance driven, from the odometer (...) [m].
        epsilon: |baseline - travelled| (...) [m].
        threshold: the largest epsilon that is accepted as straight (...) [m].
        fix_noise: standard deviation of each fix on each axis (...) [m].

    Example:
        >>> print(dd.course.from_fixes((0, 0), (3, 4), 5.01, fix_noise=0.01))
        bearing   36.87 deg, yaw 53.13 deg, standard deviation 0.1617 deg
        baseline  5 m between the fixes, 5.01 m driven
        epsilon   10 mm, allowed 42.43 mm: straight
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
        """Whether epsilon is accepted (...); so it is for bends below `straightness.smallest_visible_bend`."""
        return self.epsilon <= self.threshold

    @property
    def std(self) -> Array:
        """The exact standard deviation of the course due to the fixes' noise (...) [rad].

        For a straight drive the odometer's distance is used, which is better known than that between the fixes.
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
    """Compute the course from the fixes before and after a drive straight ahead, and the distance driven.

    ```
    w = PHI_1 - PHI_0        k = atan2(x_w, y_w)        epsilon = |norm(w) - travelled|
    ```

    Args:
        first: PHI_0, the fix before the drive (..., 2) [m].
        second: PHI_1, the fix after it (..., 2) [m].
        travelled: the distance driven (...) [m], positive; when reversing, the heading is opposite to the course.
        fix_noise: standard deviation of a fix on each axis (...) [m].
        threshold: the largest epsilon that is accepted as straight (...) [m]; three standard deviations of epsilon,
            3 sqrt(2) fix_noise, if not given.

    Returns:
        The course, and whether the path was accepted as straight.

    Raises:
        InvalidValue: fixes that coincide, a distance that is not positive, a negative noise or threshold, shapes
            that do not fit, or values that are not finite.

    References:
        [Petersen 2013], Berechnung des Kurses.

    Example:
        >>> course = dd.course.from_fixes((0, 0), (0, 1), 1.0, fix_noise=0.01)
        >>> float(np.degrees(course.yaw)), bool(course.straight)
        (90.0, True)
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


def _full_circle(angle: Array) -> Array:
    """The same direction in [0, 2 pi)."""
    turned = np.mod(angle, 2 * np.pi)
    # A tiny negative angle rounds up to the whole turn.
    return np.where(turned < 2 * np.pi, turned, 0.0)[()]
