"""The picture of an attribution: how large each cause's part is, and the error at the end put together from them."""

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
        ['Parts, which add up to the error', 'At the end, one after the other']
    """
    made, (bars, chain) = figure(found.title, columns=2, size=(WIDTH, 3.9), widths=(1.25, 1.0))
    _bars(bars, found)
    _chain(chain, found)
    return made


def _bars(ax: Axes, found: Attribution) -> None:
    """The size of each part, beside it what the cause does alone."""
    places = np.arange(len(found.causes))
    alone = np.hypot(found.alone[:, 0], found.alone[:, 1])
    colours = [plots.style(k)["color"] for k in places.tolist()]
    # What rounding leaves is not worth a decade of the axis.
    least = 1e-5 * max(float(found.sizes.max()), 1e-12)
    ax.barh(
        places, 1e3 * np.where(found.sizes > least, found.sizes, 0), left=1e3 * least / 3, color=colours, height=0.6
    )
    ax.plot(1e3 * np.where(alone > least, alone, np.nan), places, "|", color="black", markersize=14, label="alone")
    right = 1e3 * np.maximum.reduce([found.sizes, alone, np.full_like(alone, least)])
    for place, size, end in zip(places.tolist(), found.sizes.tolist(), right.tolist(), strict=True):
        ax.annotate(quantity(size, "m"), (end, place), (9, 0), textcoords="offset points", va="center")
    ax.set(xscale="log", yticks=places, yticklabels=found.causes, xlabel="part of the final position error [mm]")
    ax.set_xlim(1e3 * least / 2, 12 * max(float(right.max()), 1e-9))
    ax.invert_yaxis()
    plots.tidy(ax).grid(visible=False, axis="y")
    ax.legend(loc="lower right", frameon=False, fontsize=9.5)
    panel(ax, "Parts, which add up to the error")


def _chain(ax: Axes, found: Attribution) -> None:
    """Arrows from the true end to the believed one, a part each."""
    corners = 1e3 * np.vstack([(0.0, 0.0), np.cumsum(found.parts[:, :2], axis=0)])
    reach = max(float(np.ptp(corners, axis=0).max()), 1e-9)
    for k, (start, end) in enumerate(itertools.pairwise(corners)):
        if np.hypot(*(end - start)) > _SMALLEST * reach:
            arrow = {
                "arrowstyle": "-|>",
                "color": plots.style(k)["color"],
                "linewidth": 2.2,
                "shrinkA": 0,
                "shrinkB": 0,
            }
            ax.annotate("", end, start, arrowprops=arrow)
    for point, name, marker in ((corners[0], "robot", "s"), (corners[-1], "odometry", "o")):
        ax.plot(*point, marker, color="black", markersize=7, markerfacecolor="white", label=name, zorder=5)
    ax.plot(*corners.T, alpha=0)
    plots.plane(ax)
    ax.margins(0.15)
    ax.set(xlabel="x [mm]", ylabel="y [mm]")
    ax.legend(loc="best", frameon=True, framealpha=0.9, edgecolor="0.9", fontsize=9.5)
    panel(ax, "At the end, one after the other")
