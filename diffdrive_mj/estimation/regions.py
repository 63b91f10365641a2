"""Regions that hold a position with a stated probability: the ellipse of a covariance, the banana of a noisy heading.

The error of a robot that drives on a noisy heading is normal in exponential coordinates xi, pose = mean exp(xi), long
after it has ceased to be so in x and y: seen from above it is a banana. Both regions are the same where the noise is
small.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj import _checks as checks
from diffdrive_mj import _covariances as covariances
from diffdrive_mj import se2
from diffdrive_mj._checks import Array
from diffdrive_mj.errors import InvalidValue

# Headings that are tried, over so many deviations to each side, and how often the best of them is looked at closer.
_HEADINGS, _WIDE, _CLOSER = 41, 6.0, 3


def threshold(level: float) -> float:
    """Return the squared Mahalanobis distance within which a normal position lies with a probability.

    ```
    q = -2 ln(1 - p)
    ```

    Args:
        level: p, such as 0.95.

    Returns:
        q, the quantile of chi-squared with two degrees of freedom.

    Raises:
        InvalidValue: not between 0 and 1.

    Example:
        >>> round(dd.estimation.regions.threshold(0.95), 3)
        5.991
    """
    share = checks.positive("level", level)
    if share >= 1:
        raise InvalidValue(f"level = {share:g}: must be below 1")
    return -2 * math.log1p(-share)


def ellipse(mean: ArrayLike, covariance: ArrayLike, level: float = 0.95, points: int = 181) -> Array:
    """Compute the outline of the ellipse that holds the position with a probability, if that is normal.

    ```
    (p - m)^T C^-1 (p - m) = -2 ln(1 - level)
    ```

    Args:
        mean: m (..., 2) [m], or poses (..., 3), of which x and y are taken.
        covariance: C (..., 2, 2) [m^2], or those of poses (..., 3, 3).
        level: the probability.
        points: of the outline; the last is the first again.

    Returns:
        (..., points, 2) [m].

    Raises:
        InvalidType: not numbers.
        InvalidValue: shapes that do not fit, a matrix that is no covariance, a level that is no probability.

    Example:
        >>> dd.estimation.regions.ellipse((1.0, 0.0), np.diag([0.04, 0.01]), 0.95).max(axis=0).round(3)
        array([1.49 , 0.245])
    """
    center, stated = checks.array("mean", mean, "K"), covariances.covariance("covariance", covariance)
    if center.shape[-1] not in (2, 3) or stated.shape[-1] not in (2, 3):
        raise InvalidValue(f"mean {center.shape} and covariance {stated.shape}: must be those of positions or of poses")
    # A singular covariance has a root all the same: its ellipse is a line.
    values, axes = np.linalg.eigh(stated[..., :2, :2])
    root = axes * np.sqrt(np.maximum(values, 0.0))[..., None, :]
    angle = np.linspace(0, math.tau, checks.whole("points", points, least=4))
    circle = math.sqrt(threshold(level)) * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    return np.asarray(center[..., None, :2] + circle @ np.swapaxes(root, -1, -2))


def squared_distance(positions: ArrayLike, pose: ArrayLike, covariance: ArrayLike) -> Array:
    """Compute how far positions are from a pose, in its covariance of exponential coordinates: the banana's measure.

    ```
    d^2 = min over theta of xi^T C^-1 xi,    xi = log(pose^-1 (x, y, theta))
    ```

    with the heading that goes best with each position. Where the noise is small this is the squared Mahalanobis
    distance of the ellipse; the region d^2 < `threshold(level)` is the banana.

    Args:
        positions: (..., 2) [m].
        pose: (3,) [m, m, rad], where xi is zero.
        covariance: C (3, 3), of xi.

    Returns:
        (...), without a unit.

    Raises:
        InvalidType: not numbers.
        InvalidValue: shapes that do not fit, or a matrix that is no covariance or is singular.

    References:
        Long, Wolfe, Mashner, Chirikjian 2012.

    Example:
        A robot with a heading known to 0.3 rad has driven 1 m. To the left the likely places curve back:

        >>> covariance = np.array([[1e-4, 0, 0], [0, 0.0301, 0.045], [0, 0.045, 0.09]])
        >>> from diffdrive_mj.estimation.regions import squared_distance
        >>> squared_distance([(1.0, 0.4), (0.9, 0.4)], (1.0, 0.0, 0.0), covariance).round(1)
        array([19.5,  6.5])
    """
    at, center = checks.array("positions", positions, 2), checks.vector("pose", pose, 3)
    stated = covariances.covariance("covariance", covariance, 3)
    if stated.ndim != 2:
        raise InvalidValue(f"covariance has shape {stated.shape}: must be (3, 3)")
    if covariances.least_eigenvalue(stated) < covariances.ROUNDING:
        raise InvalidValue("covariance: must not be singular, as it is before the robot has driven")
    seen = se2.rotate(at - center[:2], -center[2])
    deviation = math.sqrt(stated[2, 2])
    heading, step = np.zeros(seen.shape[:-1]), min(_WIDE * deviation, math.pi)
    for _ in range(1 + _CLOSER):
        tried = heading[..., None] + step * np.linspace(-1, 1, _HEADINGS)
        xi = se2.log(
            np.concatenate([np.broadcast_to(seen[..., None, :], (*tried.shape, 2)), tried[..., None]], axis=-1)
        )
        squares = covariances.squared(xi, stated)
        best = np.argmin(squares, axis=-1)[..., None]
        heading = np.take_along_axis(tried, best, axis=-1)[..., 0]
        step *= 4 / _HEADINGS
    return np.asarray(np.take_along_axis(squares, best, axis=-1)[..., 0])
