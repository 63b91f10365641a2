"""The picture of an attribution: how large each cause's part is, and the path with its error put together from them."""

from __future__ import annotations

import itertools

import numpy as np
from matplotlib.axes import Axes

from diffdrive_mj._text import quantity
from diffdrive_mj.estimation.attribution import Attribution
from diffdrive_mj.report import plots
from diffdrive_mj.report.experiment import Report
from diffdrive_mj.report.figures import WIDTH, Picture, figure, panel

_SMALLEST = 1e-3  # part of the error below which an arrow cannot be seen
_TIMES = [mantissa * 10**power for power in range(10) for mantissa in (1, 2, 5)]


def reported(found: Attribution) -> Report:
    """Make an attribution a report, with its picture.

    Args:
        found: of `attribute`.

    Example:
        >>> robot = dd.Robot.load("matched")
        >>> recording = dd.simulate(robot, dd.maneuvers.straight(robot, speed=0.5, distance=1.0))
        >>> list(reported(dd.attribute(recording, robot)).pictures)
        ['attribution']
    """
    question = "Of the final error of odometry, how much is whose?"
    _, _, rows = str(found).partition("\n\n")
    pictures = {"attribution": attributed(found)}
    return Report(question, found.title, rows, [], metrics=found.as_dict(), pictures=pictures)


def attributed(found: Attribution) -> Picture:
    """Draw the parts of a final error as bars, and as arrows from where the robot is to where it believes it is.

    Args:
        found: of `attribute`.

    Returns:
        The figure; its title is the finding.

    Example:
        >>> robot = dd.Robot.load("matched")
        >>> recording = dd.simulate(robot, dd.maneuvers.straight(robot, speed=0.5, distance=1.0))
        >>> made = attributed(dd.attribute(recording, robot.replace(left_radius=0.1001)))
        >>> [ax.get_title(loc="left") for ax in made.axes]
        ['Parts, which add up to the error', 'The path, and its error 200 times as large']
    """
    made, (bars, chain) = figure(found.title, columns=2, size=(WIDTH, 3.9), widths=(1.25, 1.0))
    _bars(bars, found)
    _chain(chain, found)
    return made


def _bars(ax: Axes, found: Attribution) -> None:
    """The size of each part, beside it what the cause does alone."""
    of, unit, scale = ("heading", "deg", 180 / np.pi) if found.on_the_spot else ("position", "mm", 1e3)
    places, sizes, alone = np.arange(len(found.causes)), scale * found.sizes, scale * found.sizes_alone
    colours = [plots.style(k)["color"] for k in places.tolist()]
    # What rounding leaves is not worth a decade of the axis.
    least = 1e-5 * max(float(sizes.max()), 1e-9)
    ax.barh(places, np.where(sizes > least, sizes, 0), left=least / 3, color=colours, height=0.6)
    ax.plot(np.where(alone > least, alone, np.nan), places, "|", color="black", markersize=14, label="alone")
    right = np.maximum.reduce([sizes, alone, np.full_like(alone, least)])
    for place, size, end in zip(places.tolist(), sizes.tolist(), right.tolist(), strict=True):
        words = f"{size:.3g} deg" if found.on_the_spot else quantity(size / scale, "m")
        ax.annotate(words, (end, place), (9, 0), textcoords="offset points", va="center")
    ax.set(xscale="log", yticks=places, yticklabels=found.causes, xlabel=f"part of the final {of} error [{unit}]")
    ax.set_xlim(least / 2, 12 * max(float(right.max()), 1e-6))
    ax.invert_yaxis()
    plots.tidy(ax).grid(visible=False, axis="y")
    ax.legend(loc="lower right", frameon=False, fontsize=9.5)
    panel(ax, "Parts, which add up to the error")


def _chain(ax: Axes, found: Attribution) -> None:
    """The path, and from its end to the believed one an arrow for each part, drawn larger where they are small."""
    path = np.zeros((1, 2)) if found.truth is None else found.truth[:, :2]
    corners = np.vstack([(0.0, 0.0), np.cumsum(found.parts[:, :2], axis=0)])
    reach, extent = (max(float(np.ptp(points, axis=0).max()), 1e-12) for points in (corners, path))
    # At most half of the path's size, in steps of 1, 2, 5 and 10.
    times = max((step for step in _TIMES if 2 * step * reach <= extent), default=1)
    unit, scale = ("m", 1.0) if max(extent, reach) > 0.1 else ("mm", 1e3)
    chain = scale * (path[-1] + times * corners)
    ax.plot(*(scale * path.T), color="0.7", linewidth=2, zorder=1)
    for k, (start, end) in enumerate(itertools.pairwise(chain)):
        if np.hypot(*(end - start)) > _SMALLEST * scale * times * reach:
            look = {"color": plots.style(k)["color"], "linewidth": 2.2, "shrinkA": 0, "shrinkB": 0}
            ax.annotate("", end, start, arrowprops={"arrowstyle": "-|>", **look})
    for point, name, marker in ((chain[0], "robot", "s"), (chain[-1], "odometry", "o")):
        ax.plot(*point, marker, color="black", markersize=7, markerfacecolor="white", label=name, zorder=5)
    ax.plot(*chain.T, alpha=0)
    plots.plane(ax)
    ax.margins(0.15)
    ax.set(xlabel=f"x [{unit}]", ylabel=f"y [{unit}]")
    ax.legend(loc="best", frameon=True, framealpha=0.9, edgecolor="0.9", fontsize=9.5)
    panel(ax, "The path, and its error" + (f" {times} times as large" if times > 1 else ""))
