"""Uncertainty drawn on a map: ellipses along a path, and the banana of a noisy heading."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from diffdrive_mj import _checks as checks
from diffdrive_mj import se2
from diffdrive_mj._checks import Array
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.estimation import regions as shapes
from diffdrive_mj.report.plots import style

# How fine the grid is on which a banana's outline is followed, along each side of its box.
_GRID = 121


def ellipses(
    ax: Axes, means: ArrayLike, covariances: ArrayLike, level: float = 0.95, *, label: str | None = None, **look: Any
) -> Axes:
    """Draw the ellipses of some positions.

    Args:
        ax: a map, into which to draw.
        means: (..., 2) [m], or poses (..., 3).
        covariances: (..., 2, 2) [m^2], or those of poses (..., 3, 3).
        level: the probability with which each holds its position.
        label: in the legend.
        look: properties of the lines.

    Returns:
        The axes.

    Example:
        >>> made, ax = dd.plots.figure("A finding")
        >>> len(ellipses(ax, np.zeros((2, 3)), np.eye(3), label="95 %").lines)
        2
    """
    rings = shapes.ellipse(means, covariances, level)
    return _drawn(ax, rings.reshape(-1, *rings.shape[-2:]), label, style(0), look)


def banana(
    ax: Axes, pose: ArrayLike, covariance: ArrayLike, level: float = 0.95, *, label: str | None = None, **look: Any
) -> Axes:
    """Draw the outline of the region that holds a position whose error is normal in exponential coordinates.

    Args:
        ax: a map, into which to draw.
        pose: (3,) [m, m, rad], where these coordinates are zero.
        covariance: (3, 3), of these coordinates.
        level: the probability.
        label: in the legend.
        look: properties of the lines.

    Returns:
        The axes.

    Example:
        >>> made, ax = dd.plots.figure("A finding")
        >>> covariance = np.array([[1e-4, 0, 0], [0, 0.0301, 0.045], [0, 0.045, 0.09]])
        >>> left, right = banana(ax, (1.0, 0.0, 0.0), covariance).dataLim.intervalx
        >>> bool(left < 0.9 < right < 1.03)
        True
    """
    lines = _outline(checks.vector("pose", pose, 3), np.asarray(covariance), level)
    return _drawn(ax, lines, label, style(1), look)


def uncertain_path(
    ax: Axes,
    means: ArrayLike,
    covariances: ArrayLike,
    *,
    count: int = 8,
    level: float = 0.95,
    label: str | None = None,
    index: int = 0,
) -> Axes:
    """Draw a path with ellipses along it, evenly by its length.

    Args:
        ax: a map, into which to draw.
        means: poses (T, 3) [m, m, rad].
        covariances: of them (T, 3, 3).
        count: of the ellipses.
        level: the probability with which each holds the position.
        label: in the legend.
        index: of the curve in the legend, from 0, which says how it looks.

    Returns:
        The axes.

    Example:
        >>> made, ax = dd.plots.figure("A finding")
        >>> path = dd.se2.exp([(0, 0, 0), (1, 0, 0.5), (2, 0, 1)])
        >>> stated = np.arange(3.0)[:, None, None] * 1e-3 * np.eye(3)
        >>> len(uncertain_path(ax, path, stated, count=2).lines)
        3
    """
    poses, stated = checks.array("means", means, "T", 3), checks.array("covariances", covariances, "T", 3, 3)
    if poses.ndim != 2 or stated.shape != (len(poses), 3, 3):
        raise InvalidValue(
            f"means {poses.shape} and covariances {stated.shape}: must be (T, 3) and (T, 3, 3), of one drive"
        )
    look = style(index)
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(poses[:, :2], axis=0), axis=1))])
    ends = np.linspace(0, way[-1], checks.whole("count", count) + 1)[1:]
    at = np.minimum(np.searchsorted(way, ends - 1e-9 * way[-1]), len(way) - 1)
    ax.plot(poses[:, 0], poses[:, 1], label=label, **{**look, "marker": ""})
    return ellipses(ax, poses[at], stated[at], level, color=look["color"], linestyle="-", linewidth=1.0)


def _drawn(
    ax: Axes, lines: Iterable[Array], label: str | None, usual: Mapping[str, Any], look: Mapping[str, Any]
) -> Axes:
    """The axes with outlines (N, 2) in them, of which one is in the legend."""
    drawn = {**usual, "marker": "", "linewidth": 1.3, **look}
    for k, line in enumerate(lines):
        ax.plot(line[:, 0], line[:, 1], label=None if k else label, **drawn)
    return ax


def _outline(pose: Array, covariance: Array, level: float) -> list[Array]:
    """The lines along which a banana's measure is that of the level."""
    from contourpy import contour_generator

    height = shapes.threshold(level)
    low, high = _box(pose, covariance, height)
    x, y = (np.linspace(a, b, _GRID) for a, b in zip(low, high, strict=True))
    squares = shapes.squared_distance(np.stack(np.meshgrid(x, y), axis=-1), pose, covariance)
    # Roots are nearly straight between the grid's points, where squares are not.
    return [np.asarray(line) for line in contour_generator(x, y, np.sqrt(squares)).lines(height**0.5)]


def _box(pose: Array, covariance: Array, height: float) -> tuple[Array, Array]:
    """A box (2,), (2,) around the region, from points on the ellipsoid of exponential coordinates."""
    azimuth, polar = np.meshgrid(np.linspace(0, 2 * np.pi, 73), np.linspace(0, np.pi, 37))
    sphere = np.stack([np.cos(azimuth) * np.sin(polar), np.sin(azimuth) * np.sin(polar), np.cos(polar)], axis=-1)
    values, axes = np.linalg.eigh(covariance)
    xi = height**0.5 * sphere @ (axes * np.sqrt(np.maximum(values, 0.0))).T
    reached = se2.compose(pose, se2.exp(xi)).reshape(-1, 3)[:, :2]
    room = 0.04 * np.ptp(reached, axis=0)
    return reached.min(axis=0) - room, reached.max(axis=0) + room
