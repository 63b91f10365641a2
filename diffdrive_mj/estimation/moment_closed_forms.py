"""Closed forms of the pose's mean and covariance for a robot that drives evenly: straight, along an arc, on the spot.

They are the limit of short steps, and subtract numbers that are nearly equal where the noise is small: to read, to
teach and to check the recursion with.
"""

from __future__ import annotations

import numpy as np

from diffdrive_mj import _checks as checks
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.estimation._of_wheels import variances
from diffdrive_mj.estimation._placed import Spread, size
from diffdrive_mj.estimation.moments import PoseMoments
from diffdrive_mj.estimation.wheel_noise import WheelNoise


def even_motion(distance: float, turn: float, track_width: float, noise: WheelNoise) -> PoseMoments:
    """Compute where a robot is that drives evenly from the origin, whose wheels' ways are random walks.

    With the variances V of the turn and V_D of the distance at the end, c their covariance,

    ```
    z = V / 2 - i turn        y = 2 V - 2 i turn        g = distance + ic / 2        f(z) = (1 - e^(-z)) / z
    E p      = g f(z)
    E |p|^2  = 2 Re(g^2 (1 - f(z)) / z) + V_D
    E p^2    = 2 g (g + ic) (f(z) - f(y)) / (y - z) + V_D f(y)
    cov(theta, p) = i V g (f(z) - e^(-z)) / z + c f(z)
    ```

    Straight ahead, with equal wheels, E p is (b^2 / k^2) (1 - exp(-k^2 L / b^2)); on the spot it is zero.

    Args:
        distance: of the axle's midpoint [m].
        turn: counter-clockwise [rad].
        track_width: b [m].
        noise: of the wheels.

    Returns:
        Mean and covariance at the end, as of a drive of a single sample: (1, 3) and (1, 3, 3).

    Raises:
        InvalidValue: a track that is not positive, a motion without noise.
        InvalidType: not numbers, not the noise of wheels.

    Example:
        >>> noise = dd.WheelNoise(left=0.005, right=0.005)
        >>> ahead = even_motion(200.0, 0.0, 0.4, noise)
        >>> theory = 0.4**2 / 0.005**2 * (1 - np.exp(-(0.005**2) * 200 / 0.4**2))
        >>> round(ahead.mean[0, 0].item(), 3), round(theory.item(), 3)
        (196.907, 196.907)
        >>> even_motion(0.0, np.pi, 0.4, noise).sigma.round(4).tolist()
        [[0.002, 0.002, 0.014]]
    """
    length, turned = checks.number("distance", distance), checks.number("turn", turn)
    track = checks.positive("track_width", track_width)
    checks.instance("noise", noise, WheelNoise)
    ways = abs(length - track * turned / 2), abs(length + track * turned / 2)
    var_distance, c, variance = variances(noise.left**2 * ways[0], noise.right**2 * ways[1], track)
    if variance < checks.SMALLEST:
        raise InvalidValue("noise: must not leave the motion without noise")
    z, y, g = variance / 2 - 1j * turned, 2 * variance - 2j * turned, length + 0.5j * c
    at_z, at_y = _mean_factor(z), _mean_factor(y)
    place = g * at_z
    mean, covariance = np.empty((1, 3)), np.empty((1, 3, 3))
    Spread(
        place,
        turned,
        2 * g * (g + 1j * c) * (at_z - at_y) / (y - z) + var_distance * at_y - place**2,
        2 * (g**2 * (1 - at_z) / z).real + var_distance - size(place),
        1j * variance * g * (at_z - np.exp(-z)) / z + c * at_z,
        variance,
    ).write(mean, covariance)
    return PoseMoments(mean, covariance)


def _mean_factor(z: complex) -> complex:
    """(1 - e^(-z)) / z."""
    return complex(-np.expm1(-z) / z)
