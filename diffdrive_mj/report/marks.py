"""Marks in a plot: headings, robots seen from above, dimensions, notes, and the values at the ends of curves."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Polygon
from numpy.typing import ArrayLike

from diffdrive_mj import se2
from diffdrive_mj._checks import Array, array
from diffdrive_mj.robot import Robot

NOTE: dict[str, Any] = {"color": "0.3", "fontsize": 9.5}


def heading(ax: Axes, pose: ArrayLike, color: str) -> None:
    """Draw an arrow along the heading of a pose, of one length on paper whatever the scale.

    Args:
        ax: to draw into.
        pose: (3,) [m, m, rad].
        color: of the arrow.

    Example:
        >>> heading(dd.plots.figure("A finding")[1], (0.0, 0.0, 0.5), "black")
    """
    x, y, theta = array("pose", pose, 3).tolist()
    # An annotation's arrow runs from its text to its point, so the head is at the text's end.
    arrow = {"arrowstyle": "<|-", "color": color, "linewidth": 1.6, "shrinkA": 0, "shrinkB": 0}
    tip = (22 * np.cos(theta), 22 * np.sin(theta))
    ax.annotate("", xy=(x, y), xytext=tip, textcoords="offset points", arrowprops=arrow, zorder=6)


def robot_from_above(ax: Axes, robot: Robot, pose: ArrayLike, *, enlarged: float = 1.0, color: str = "0.25") -> None:
    """Draw a robot as seen from above: its wheels, and its body from a little ahead of the axle back to the caster.

    Args:
        ax: to draw into, of equal aspect.
        robot: whose sizes are drawn.
        pose: (3,) [m, m, rad], of the axle's midpoint.
        enlarged: how many times larger than it is.
        color: of wheels and outline.

    Example:
        >>> made, ax = dd.plots.figure("A finding")
        >>> robot_from_above(ax, dd.Robot.load("matched"), (0.0, 0.0, 0.0))
        >>> len(ax.patches)
        3
    """
    at = array("pose", pose, 3)
    half, front = robot.track_width / 2, 0.6 * robot.mean_radius
    inner, back = half - robot.tyres.width, robot.caster.x - np.sign(robot.caster.x) * -robot.caster.radius
    body = [(front, inner), (back, 0.6 * inner), (back, -0.6 * inner), (front, -inner), (1.8 * front, 0)]
    axles = [0.0]
    if robot.skids:
        end = robot.skid_steer.wheelbase / 2
        body = [(end, inner), (-end, inner), (-end, -inner), (end, -inner), (end + 0.8 * front, 0)]
        axles = [end, -end]
    parts = [(body, {"facecolor": "white", "linewidth": 1.2})]
    for side, radius in ((1, robot.left_radius), (-1, robot.right_radius)):
        rims = (side * half - robot.tyres.width / 2, side * half + robot.tyres.width / 2)
        for axle in axles:
            ends = (axle - radius, axle + radius, axle + radius, axle - radius)
            parts.append((list(zip(ends, np.repeat(rims, 2), strict=True)), {}))
    for corners, look in parts:
        placed = at[:2] + enlarged * se2.rotate(corners, at[2])
        ax.add_patch(Polygon(placed, closed=True, **{"edgecolor": color, "facecolor": color, "zorder": 5, **look}))


def dimension(ax: Axes, start: ArrayLike, end: ArrayLike, text: str, *, side: str = "right") -> None:
    """Draw a line with arrows at both ends, and what it measures beside its middle.

    Args:
        ax: to draw into.
        start: (2,), in the axes' units.
        end: (2,), in the axes' units.
        text: the measure with its unit.
        side: of the line, "left", "right" or "above".

    Example:
        >>> made, ax = dd.plots.figure("A finding")
        >>> dimension(ax, (0, 0), (0, 7.8), "7.8 m")
        >>> ax.texts[-1].get_text()
        '7.8 m'
    """
    a, b = array("start", start, 2), array("end", end, 2)
    arrow = {"arrowstyle": "<|-|>", "color": NOTE["color"], "linewidth": 1.0, "shrinkA": 0, "shrinkB": 0}
    ax.annotate("", xy=b.tolist(), xytext=a.tolist(), arrowprops=arrow, zorder=4)
    offset, aligned = {"right": ((7, 0), "left"), "left": ((-7, 0), "right"), "above": ((0, 9), "center")}[side]
    note(ax, text, (a + b) / 2, offset, horizontalalignment=aligned, verticalalignment="center")


def note(ax: Axes, text: str, place: ArrayLike, offset: tuple[float, float] = (0, 0), **look: str | float) -> None:
    """Write a remark beside a place.

    Args:
        ax: to write into.
        text: of one line or several.
        place: (2,), in the axes' units.
        offset: of the text from the place, right and up [points].
        look: properties of the text.

    Example:
        >>> made, ax = dd.plots.figure("A finding")
        >>> note(ax, "10 degrees a step", (5.7, 1.0))
    """
    x, y = array("place", place, 2).tolist()
    ax.annotate(text, (x, y), xytext=offset, textcoords="offset points", **{**NOTE, **look})


def slippery(ax: Axes, x: tuple[float, float], y: tuple[float, float], text: str = "slippery") -> None:
    """Shade a rectangle of the floor on which wheels slip, and say so to its right.

    Args:
        ax: a map, into which to draw.
        x: from and to [m].
        y: from and to [m].
        text: of one line or several.

    Example:
        >>> made, ax = dd.plots.figure("A finding")
        >>> slippery(ax, (0.0, 1.0), (0.0, 1.0), "wet")
        >>> ax.texts[0].get_text()
        'wet'
    """
    (low, high), (near, far) = x, y
    ax.fill([low, high, high, low], [near, near, far, far], color="0.9", zorder=0)
    note(ax, text, (high, far - 0.2 * (far - near)), (4, 0))


def ends(ax: Axes, values: Sequence[tuple[str, float]]) -> None:
    """Write the last value of each curve to the right of the axes, at its height, but never two over each other.

    Args:
        ax: whose y limits are final; they are kept.
        values: colour of each curve, and its value in the axes' unit.

    Example:
        >>> made, ax = dd.plots.figure("A finding")
        >>> ends(ax, [("red", 0.52), ("blue", 0.521)])
        >>> low, high = sorted(text.xy[1] for text in ax.texts)
        >>> high - low > 0.03
        True
    """
    ax.set_ylim(ax.get_ylim())
    levels = np.array([(0.0, value) for _, value in values])
    heights = ax.transAxes.inverted().transform(ax.transData.transform(levels))[:, 1]
    order = np.argsort(heights, kind="stable")
    inches = ax.get_window_extent().height / ax.figure.dpi
    placed = _apart(np.clip(heights[order], 0, 1), 1.3 * NOTE["fontsize"] / 72 / inches)
    for index, height in zip(order.tolist(), placed.tolist(), strict=True):
        color, value = values[index]
        ax.annotate(
            _short(value), (1.015, height), xycoords="axes fraction", **{**NOTE, "color": color, "va": "center"}
        )


def _short(value: float) -> str:
    """Three digits, or one where a power of ten is needed."""
    if 1e-3 <= abs(value) < 1e3 or value == 0:
        return f"{value:.3g}"
    return f"{value:.0f}" if 1e3 <= abs(value) < 1e5 else f"{value:.0e}"


def _apart(heights: Array, gap: float) -> Array:
    """Increasing heights between 0 and 1, moved up and then down until they are a gap apart."""
    placed = heights.copy()
    for k in range(1, len(placed)):
        placed[k] = max(placed[k], placed[k - 1] + gap)
    top = 1.0
    for k in reversed(range(len(placed))):
        placed[k] = top = min(placed[k], top)
        top -= gap
    return placed
