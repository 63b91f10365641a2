"""Plots of paths and errors. Each function draws data into an `Axes` and returns it.

Curves differ by line style and marker as well as by colour, so that they can be distinguished in black and white; the
ground truth is always the broad grey band.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from diffdrive_mj._checks import Array, array
from diffdrive_mj.metrics import drift, travelled
from diffdrive_mj.report import marks
from diffdrive_mj.report.figures import WIDTH, figure, legend_below, map_beside_two, panel

__all__ = [
    "PREDICTION", "STYLES", "TRUTH", "WIDTH", "coloured_path", "convergence", "errors", "figure", "legend_below",
    "panel", "paths", "plane", "style", "summary", "tidy",
]  # fmt: skip

# Okabe and Ito's colours, which colour-blind readers can distinguish, each with its own dashes and marker.
STYLES: tuple[dict[str, Any], ...] = (
    {"color": "#D55E00", "linestyle": "-", "marker": "o"},
    {"color": "#0072B2", "linestyle": "--", "marker": "s"},
    {"color": "#009E73", "linestyle": "-.", "marker": "^"},
    {"color": "#CC79A7", "linestyle": (0, (1, 1)), "marker": "D"},
    {"color": "#56B4E9", "linestyle": (0, (5, 1, 1, 1, 1, 1)), "marker": "v"},
    {"color": "#000000", "linestyle": (0, (3, 3)), "marker": "x"},
)
TRUTH: dict[str, Any] = {"color": "0.72", "linewidth": 6, "solid_capstyle": "round", "zorder": 1}
PREDICTION: dict[str, Any] = {"color": "black", "linewidth": 0.9, "linestyle": ":", "zorder": 4}


def style(index: int) -> dict[str, Any]:
    """Look up line style, marker and colour of a curve.

    Args:
        index: of the curve in the legend, from 0.

    Returns:
        Keyword arguments for `Axes.plot`.

    Example:
        >>> dd.plots.style(1)["color"]
        '#0072B2'
    """
    return {**STYLES[index % len(STYLES)], "linewidth": 1.7, "markersize": 5}


def paths(ax: Axes, truth: ArrayLike | None, estimates: Mapping[str, ArrayLike], *, truth_label: str = "truth") -> Axes:
    """Draw paths in the plane, with equal aspect; the start and the ends are marked with their headings.

    Args:
        ax: to draw into.
        truth: (T, 3) [m, m, rad], or None.
        estimates: by label, (T, 3) each [m, m, rad].
        truth_label: in the legend.

    Returns:
        The axes.

    Raises:
        InvalidValue: poses of another shape, or values that are not finite.

    Example:
        >>> made, ax = dd.plots.figure("A finding")
        >>> path = dd.se2.exp([(0, 0, 0), (1, 0, 0.5), (2, 0, 1)])
        >>> dd.plots.paths(ax, path, {"odometry": path}).get_xlabel()
        'x [m]'
    """
    if truth is not None:
        poses = array("truth", truth, "T", 3)
        ax.plot(poses[:, 0], poses[:, 1], label=truth_label, **TRUTH)
        marks.heading(ax, poses[-1], "0.45")
    first: Array | None = None if truth is None else poses
    for index, (label, estimate) in enumerate(estimates.items()):
        poses = array(label, estimate, "T", 3)
        look = style(index)
        ax.plot(poses[:, 0], poses[:, 1], label=label, markevery=(0.15, 0.2), **look)
        marks.heading(ax, poses[-1], look["color"])
        first = poses if first is None else first
    if first is not None:
        ax.plot(*first[0, :2], "o", color="black", markersize=8, markerfacecolor="white", zorder=5, label="start")
        marks.heading(ax, first[0], "black")
    return _legend(plane(ax))


def coloured_path(ax: Axes, truth: ArrayLike, estimate: ArrayLike, error: ArrayLike) -> Axes:
    """Draw an estimate's path in the plane, coloured by how far it is off, over that of the truth.

    Args:
        ax: to draw into.
        truth: (T, 3) [m, m, rad].
        estimate: (T, 3) [m, m, rad].
        error: (T,), its position error [m].

    Returns:
        The axes.

    Raises:
        InvalidValue: arrays of other shapes, or values that are not finite.

    Example:
        >>> made, ax = dd.plots.figure("A finding")
        >>> path = dd.se2.exp([(0, 0, 0), (1, 0, 0.5), (2, 0, 1)])
        >>> dd.plots.coloured_path(ax, path, path, [0.0, 0.01, 0.02]).get_xlabel()
        'x [m]'
    """
    true, poses, off = array("truth", truth, "T", 3), array("estimate", estimate, "T", 3), array("error", error, "T")
    ax.plot(true[:, 0], true[:, 1], label="ground truth", **TRUTH)
    pieces = np.stack([poses[:-1, :2], poses[1:, :2]], axis=1)
    line = LineCollection(pieces.tolist(), cmap="viridis", linewidths=2.2, zorder=3)
    line.set_array(1e3 * (off[:-1] + off[1:]) / 2)
    ax.add_collection(line)
    ax.plot(*true[0, :2], "o", color="black", markersize=8, markerfacecolor="white", zorder=5, label="start")
    ax.figure.colorbar(line, ax=ax, label="position error [mm]", shrink=0.8)
    return _legend(plane(ax))


def plane(ax: Axes) -> Axes:
    """Make axes a map: equal scales, a grid, labels.

    Args:
        ax: the axes, with what they show.

    Returns:
        The axes.

    Example:
        >>> plane(figure("A finding")[1]).get_aspect()
        1.0
    """
    ax.set_aspect("equal", adjustable="datalim")
    ax.margins(0.1)
    ax.locator_params(nbins=6)
    ax.set(xlabel="x [m]", ylabel="y [m]")
    return tidy(ax)


def tidy(ax: Axes) -> Axes:
    """Give axes a pale grid behind the data and no frame above and to the right.

    Args:
        ax: the axes.

    Returns:
        The axes.

    Example:
        >>> tidy(figure("A finding")[1]).spines["top"].get_visible()
        False
    """
    ax.grid(visible=True, color="0.9", linewidth=0.8)
    ax.set_axisbelow(True)
    for side in ("top", "right"):
        ax.spines[side].set_visible(False)
    return ax


def errors(
    ax: Axes,
    along: ArrayLike,
    values: Mapping[str, ArrayLike],
    *,
    predicted: Mapping[str, ArrayLike] | None = None,
    xlabel: str = "distance driven [m]",
    ylabel: str = "position error [mm]",
    scale: float = 1e3,
    log: bool = False,
    name_ends: bool = True,
) -> Axes:
    """Draw errors along a drive.

    Args:
        ax: to draw into.
        along: (T,), the distance [m] or the time [s] of each sample.
        values: by label, (T,) each, in SI units.
        predicted: what a formula predicts, by the label of its curve, (T,) each, in SI units.
        xlabel: with its unit.
        ylabel: with its unit.
        scale: from SI to the unit of ylabel.
        log: whether the error axis is logarithmic.
        name_ends: whether to write the last value at the end of each curve.

    Returns:
        The axes.

    Example:
        >>> made, ax = dd.plots.figure("A finding")
        >>> dd.plots.errors(ax, [0.0, 1.0], {"odometry": [0.0, 0.002]}).lines[0].get_ydata()
        array([0., 2.])
    """
    for index, (label, value) in enumerate(values.items()):
        ax.plot(along, scale * np.asarray(value), label=label, markevery=(0.05 + 0.03 * index, 0.15), **style(index))
    _predict(ax, along, predicted, scale)
    ax.set(xlabel=xlabel, ylabel=ylabel, yscale="log" if log else "linear")
    ax.margins(x=0.02)
    if name_ends:
        marks.ends(ax, [(style(k)["color"], scale * np.asarray(value)[-1]) for k, value in enumerate(values.values())])
    return _legend(tidy(ax))


def _predict(ax: Axes, along: ArrayLike, predicted: Mapping[str, ArrayLike] | None, scale: float) -> None:
    """Draw predictions, all of them under one label."""
    for index, value in enumerate((predicted or {}).values()):
        ax.plot(along, scale * np.asarray(value), label=None if index else "predicted", **PREDICTION)


def convergence(
    ax: Axes,
    rates: ArrayLike,
    values: Mapping[str, ArrayLike],
    *,
    orders: Mapping[str, float] | None = None,
    predicted: Mapping[str, ArrayLike] | None = None,
    xlabel: str = "odometry rate [Hz]",
    ylabel: str = "largest position error [mm]",
    scale: float = 1e3,
) -> Axes:
    """Draw errors against a rate or a number of samples, both logarithmic: an order is a slope.

    Args:
        ax: to draw into.
        rates: (N,) [Hz], or numbers of samples.
        values: by label, (N,) each, in SI units.
        orders: of convergence as measured, by label; written into the legend.
        predicted: what a formula predicts, by the label of its curve, (N,) each, in SI units.
        xlabel: with its unit.
        ylabel: with its unit.
        scale: from SI to the unit of ylabel.

    Returns:
        The axes.

    Example:
        >>> made, ax = dd.plots.figure("A finding")
        >>> dd.plots.convergence(ax, [1, 10], {"euler": [0.1, 0.01]}, orders={"euler": 1.0}).get_xscale()
        'log'
    """
    for index, (label, value) in enumerate(values.items()):
        order = (orders or {}).get(label)
        named = label if order is None else f"{label}: order {order:.2f}"
        ax.plot(rates, scale * np.asarray(value), label=named, **style(index))
    _predict(ax, rates, predicted, scale)
    ax.set(xscale="log", yscale="log", xlabel=xlabel, ylabel=ylabel)
    return _legend(tidy(ax))


def summary(title: str, t: ArrayLike, truth: ArrayLike, estimates: Mapping[str, ArrayLike]) -> Figure:
    """Draw one look at a drive: the paths, the position error against distance, the heading error against time.

    Args:
        title: the question or the finding.
        t: (T,) [s].
        truth: (T, 3) [m, m, rad].
        estimates: by label, (T, 3) each [m, m, rad].

    Returns:
        The figure; `savefig` writes it.

    Raises:
        InvalidValue: shapes that do not fit, or values that are not finite.

    Example:
        >>> path = dd.se2.exp([(0, 0, 0), (1, 0, 0.5), (2, 0, 1)])
        >>> len(dd.plots.summary("A finding", [0.0, 1.0, 2.0], path, {"odometry": path}).axes)
        3
    """
    drifts = {label: drift(truth, estimate) for label, estimate in estimates.items()}
    along = travelled(truth)
    made, left, upper, lower = map_beside_two(title)
    paths(left, truth, estimates)
    errors(upper, along, {label: off.position_error for label, off in drifts.items()})
    headings = {label: off.heading_error for label, off in drifts.items()}
    errors(lower, t, headings, xlabel="time [s]", ylabel="heading error [deg]", scale=180 / np.pi)
    legend_below(made, left, upper, lower)
    return made


def _legend(ax: Axes) -> Axes:
    ax.legend(frameon=True, framealpha=0.9, edgecolor="0.9", fontsize=9.5)
    return ax
