"""How well two fixes determine the course between them, and after how long a drive they determine it best.

A fix is off by an isotropic Gaussian of standard deviation `fix_noise` on each axis, so that the vector between two
is off by sqrt(2) times as much. Its direction is the course of a straight drive. Where the heading is a random walk
along the drive, the course at its end is another.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ndtr

from diffdrive_mj._checks import Array, array, broadcast, not_negative_array, positive_array

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(64)


def first_order_std(fix_noise: ArrayLike, baseline: ArrayLike) -> Array:
    """Compute the standard deviation of the course to first order, sqrt(2) fix_noise / w.

    It is low by a part (fix_noise / w)^2 of itself: 1 % where fix_noise / w = 0.1. Above that use `direction_std`.

    Args:
        fix_noise: standard deviation of a fix on each axis (...) [m].
        baseline: the true distance w between the fixes (...) [m].

    Returns:
        (...) [rad].

    Raises:
        InvalidValue: negative noise, or a baseline that is not positive.

    Example:
        >>> round(float(np.degrees(dd.course_noise.first_order_std(0.01, 1.0))), 2)
        0.81
    """
    noise, length = not_negative_array("fix_noise", fix_noise), positive_array("baseline", baseline)
    broadcast(fix_noise=noise, baseline=length)
    return math.sqrt(2) * noise / length


def direction_density(angle: ArrayLike, fix_noise: ArrayLike, baseline: ArrayLike) -> Array:
    """Compute the density of the course's error: the direction of a displaced isotropic Gaussian (projected normal).

    ```
    p(t) = exp(-a^2 / 2) / (2 pi) + a cos(t) phi(a sin(t)) Phi(a cos(t))        a = w / (sqrt(2) fix_noise)
    ```

    with the density phi and the distribution function Phi of the standard normal.

    Args:
        angle: the error t (...) [rad], in [-pi, pi].
        fix_noise: standard deviation of a fix on each axis (...) [m], positive.
        baseline: the true distance w between the fixes (...) [m].

    Returns:
        (...) [1/rad].

    Raises:
        InvalidValue: noise or a baseline that is not positive.

    References:
        Mardia and Jupp 2000, projected normal distributions.

    Example:
        Where the noise drowns the baseline, every direction is equally likely:

        >>> dd.course_noise.direction_density([0.0, 3.0], 1.0, 1e-9) * 2 * np.pi
        array([1., 1.])
    """
    t = array("angle", angle)
    noise, length = positive_array("fix_noise", fix_noise), positive_array("baseline", baseline)
    broadcast(angle=t, fix_noise=noise, baseline=length)
    return _density(t, length / (math.sqrt(2) * noise))


def _density(angle: Array, ratio: Array) -> Array:
    along, across = ratio * np.cos(angle), ratio * np.sin(angle)
    bell = np.exp(-(across**2) / 2) / math.sqrt(2 * math.pi)
    return np.exp(-(ratio**2) / 2) / (2 * np.pi) + along * bell * ndtr(along)


def direction_std(fix_noise: ArrayLike, baseline: ArrayLike) -> Array:
    """Compute the exact standard deviation of the course, from the integral of t^2 p(t) over the circle.

    Args:
        fix_noise: standard deviation of a fix on each axis (...) [m].
        baseline: the true distance w between the fixes (...) [m].

    Returns:
        (...) [rad]; pi / sqrt(3), that of a blind guess, where the noise drowns the baseline.

    Raises:
        InvalidValue: negative noise, or a baseline that is not positive.

    Example:
        >>> np.degrees(dd.course_noise.direction_std(0.01, [1.0, 0.1, 0.01])).round(2)
        array([ 0.81,  8.19, 75.29])
    """
    first_order = np.asarray(first_order_std(fix_noise, baseline))
    # Below 1e-8 the first order is exact to the last digit.
    ratio = 1 / np.maximum(first_order, 1e-8)
    edge = np.minimum(np.pi / 2, 10 / ratio)
    bounds = np.stack([np.zeros_like(edge), edge, np.full_like(edge, np.pi)])
    half, middle = np.diff(bounds, axis=0) / 2, (bounds[1:] + bounds[:-1]) / 2
    t = middle[..., None] + half[..., None] * _NODES
    second_moment = 2 * (half * (t**2 * _density(t, ratio[..., None]) @ _WEIGHTS)).sum(axis=0)
    return np.where(first_order < 1e-8, first_order, np.sqrt(second_moment))[()]


def end_std(fix_noise: ArrayLike, baseline: ArrayLike, random_walk: ArrayLike) -> Array:
    """Compute the standard deviation of the course at a drive's end if the heading is a random walk, to first order.

    ```
    variance = 2 fix_noise^2 / w^2 + q w / 3
    ```

    The heading W has the variance q s after s metres. The chord shows its mean over the drive, the robot keeps its
    last value: W(w) - mean W = integral of (s / w) dW, of variance q w / 3.

    Args:
        fix_noise: standard deviation of a fix on each axis (...) [m].
        baseline: w (...) [m].
        random_walk: q, by how much the variance of the heading grows along a drive (...) [rad^2/m].

    Returns:
        (...) [rad].

    Raises:
        InvalidValue: negative noise or random walk, or a baseline that is not positive.

    Example:
        >>> np.degrees(dd.course_noise.end_std(0.01, [0.5, 1.0, 2.0], np.radians(1.0) ** 2)).round(2)
        array([1.67, 0.99, 0.91])
    """
    q, length = not_negative_array("random_walk", random_walk), positive_array("baseline", baseline)
    broadcast(random_walk=q, baseline=length, fix_noise=array("fix_noise", fix_noise))
    return np.hypot(first_order_std(fix_noise, length), np.sqrt(q * length / 3))


def best_baseline(fix_noise: ArrayLike, random_walk: ArrayLike) -> Array:
    """Compute the baseline after which the course is known best, where `end_std` is least.

    ```
    w = (12 fix_noise^2 / q)^(1/3)
    ```

    Args:
        fix_noise: standard deviation of a fix on each axis (...) [m], positive.
        random_walk: q, by how much the variance of the heading grows along a drive (...) [rad^2/m], positive: without
            it, longer is always better.

    Returns:
        (...) [m].

    Raises:
        InvalidValue: noise or a random walk that is not positive.

    Example:
        >>> round(float(dd.course_noise.best_baseline(0.01, np.radians(1.0) ** 2)), 2)
        1.58
    """
    noise, q = positive_array("fix_noise", fix_noise), positive_array("random_walk", random_walk)
    broadcast(fix_noise=noise, random_walk=q)
    return np.cbrt(12 * noise**2 / q)
