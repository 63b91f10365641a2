"""What rounding does to a path: the errors of counters over the random phases in which they start, to first order.

A counter that was filled by the phase U reads floor(n + U) for an exact n: too much by 1 - a where U >= 1 - a, too
little by a elsewhere, a being the fraction of n. All readings of one drive share U, so that a weighted sum of them
takes one value for each range of U between two of the fractions: its whole distribution is known.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj.robot import Robot
from diffdrive_mj.sensors.encoder import Encoder


@dataclass(frozen=True, eq=False)
class Counter:
    """A counter along a drive, and what one count too many would do to dead reckoning.

    Args:
        exact: what it should read (K,), not rounded [counts].
        distance: that a count stands for [m].
        heading: that a count stands for [rad].

    Example:
        The left wheel's encoder, with ticks of 1 mm on a track of 0.4 m:

        >>> Counter(exact=[0.0, 10.3, 20.6], distance=0.0005, heading=-0.001 / 0.4).heading
        -0.0025
    """

    exact: ArrayLike
    distance: float
    heading: float


@dataclass(frozen=True)
class EndError:
    """How far off dead reckoning is at the end of a path, over random phases.

    Attributes:
        position: root mean square [m].
        heading: root mean square [rad].
        position_kurtosis: E e^4 / (E e^2)^2 of its size.
        heading_kurtosis: E e^4 / (E e^2)^2 of its size.

    Example:
        A single half count comes out right or wrong by half a count, never by anything else: the smallest kurtosis.

        >>> gyro = Counter(exact=[0.0, 0.5], distance=0.0, heading=0.01)
        >>> round(end_error([(0, 0, 0), (1, 0, 0)], [gyro]).heading_kurtosis, 9)
        1.0
    """

    position: float
    heading: float
    position_kurtosis: float
    heading_kurtosis: float


def even_phases(runs: int, rng: np.random.Generator) -> Array:
    """Return phases (runs, 2) of two counters, evenly spread over the unit square, shifted at random.

    A lattice of the plastic number: each phase by itself is uniform, and a few runs show what many random ones do.

    Args:
        runs: how many.
        rng: the source of the randomness.

    Returns:
        (runs, 2) [counts], 0 to 1.

    Example:
        >>> even_phases(3, np.random.default_rng(0)).shape
        (3, 2)
    """
    return (np.arange(runs)[:, None] * (0.7548776662466927, 0.5698402909980532) + rng.random(2)) % 1


def wheel_counters(encoder: Encoder, robot: Robot, wheel_angles: ArrayLike) -> list[Counter]:
    """Return the counters of both wheels' encoders along a drive.

    Args:
        encoder: of both wheels.
        robot: the robot that dead reckoning believes in.
        wheel_angles: ideal ones at the readings (K, 2) [rad].

    Returns:
        The left wheel's counter and the right one's.

    Example:
        >>> robot = Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> left, right = wheel_counters(Encoder(ticks_per_revolution=100, sample_rate=10), robot, [[0, 0], [1, 1]])
        >>> print(f"{left.distance:.4f} m, {left.heading:.4f} rad")
        0.0031 m, -0.0157 rad
    """
    checks.instance("encoder", encoder, Encoder)
    counts = checks.array("wheel_angles", wheel_angles, "K", 2).T / encoder.tick_angle
    rolled, turned = encoder.distance_per_tick(robot) / 2, encoder.heading_per_tick(robot)
    return [Counter(*each) for each in zip(counts, rolled, turned, strict=True)]


def summed_errors(exact: ArrayLike, weights: ArrayLike) -> tuple[Array, Array]:
    """Return the values that weighted sums of one counter's errors take, and how often they do.

    ```
    sum_k w_k (floor(n_k + U) - n_k),  U uniform in [0, 1)
    ```

    Args:
        exact: n (K,), what the counter should read [counts].
        weights: w (K, F), what an error of one count at each reading does to each of F figures.

    Returns:
        The values (K + 1, F), zero in the mean, and their probabilities (K + 1,).

    Raises:
        InvalidValue: shapes that do not fit.

    Example:
        >>> values, probability = summed_errors([0.25], [[1.0]])
        >>> print(values[:, 0], probability)
        [ 0.75 -0.25] [0.25 0.75]
    """
    counts, factors = checks.array("exact", exact, "K"), checks.array("weights", weights, np.shape(exact)[-1], "F")
    fraction = counts - np.floor(counts)
    order = np.argsort(fraction)
    fraction, factors = fraction[order], factors[order]
    # For 1 - U between two fractions the readings with the larger ones have been counted up.
    up = np.concatenate([np.cumsum(factors[::-1], axis=0)[::-1], np.zeros_like(factors[:1])])
    return up - fraction @ factors, np.diff(fraction, prepend=0.0, append=1.0)


def end_error(path: ArrayLike, counters: Sequence[Counter]) -> EndError:
    """Return how far off dead reckoning from counters is at the last of their readings.

    ```
    dp = sum_k e_k (u_(k - 1) - u_k) + d_k J (p_(k + 1) - p_(k - 1)) / 2,  dtheta = d_K
    ```

    for errors e of the distance so far and d of the heading at reading k, u_k being the direction of step k and J a
    quarter turn. The counters' phases are independent of each other.

    Args:
        path: true poses at the readings (K, 3) [m, m, rad].
        counters: that distance and heading are made of.

    Returns:
        Root mean squares and kurtosis, of the position and of the heading.

    Raises:
        InvalidValue: shapes that do not fit.

    Example:
        >>> straight = [(0, 0, 0), (1, 0, 0), (2, 0, 0)]
        >>> gyro = Counter(exact=[0, 0.5, 0.5], distance=0.0, heading=0.01)
        >>> error = end_error(straight, [gyro])
        >>> print(f"{error.position:.4f} m, {error.heading:.4f} rad")
        0.0075 m, 0.0050 rad
    """
    poses = checks.array("path", path, "K", 3)
    step = np.diff(poses, axis=0)
    middle = poses[:-1, 2] + step[:, 2] / 2
    by_distance, by_heading = np.zeros((2, len(poses), 3))
    along = np.stack([np.cos(middle), np.sin(middle)], axis=-1)
    across = np.stack([-step[:, 1], step[:, 0]], axis=-1) / 2
    for sign, part in ((1, slice(1, None)), (-1, slice(-1))):
        by_distance[part, :2] += sign * along
        by_heading[part, :2] += across
    by_heading[-1, 2] = 1.0
    # Of the position and of the heading, of x, y and theta.
    parts = np.stack([np.diag([1.0, 1.0, 0.0]), np.diag([0.0, 0.0, 1.0])])
    squares, fourth, covariances = np.zeros(2), np.zeros(2), np.zeros((2, 3, 3))
    for counter in counters:
        values, odds = summed_errors(counter.exact, counter.distance * by_distance + counter.heading * by_heading)
        size = np.stack([(values[:, :2] ** 2).sum(axis=1), values[:, 2] ** 2])
        covariance = parts @ (values.T * odds @ values) @ parts
        # E |a + b|^4 = E |a|^4 + E |b|^4 + 2 E |a|^2 E |b|^2 + 4 E (a . b)^2 for independent a and b.
        fourth += size**2 @ odds + 2 * squares * (size @ odds) + 4 * (covariances * covariance).sum(axis=(1, 2))
        squares, covariances = squares + size @ odds, covariances + covariance
    kurtosis = np.divide(fourth, squares**2, out=np.full(2, 3.0), where=squares > 0)
    return EndError(*(float(value) for value in (*np.sqrt(squares), *kurtosis)))
