"""Figures: size, title, panels, one legend below. They are made without pyplot: no window, no global state."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

WIDTH = 9.6  # of a figure [inch]: at 800 pixels a page's text of 9 points is 10 pixels high


class Picture(Figure):
    """A figure that notebooks show.

    Example:
        >>> made, ax = figure("Wheels slip")
        >>> made._repr_png_()[1:4]
        b'PNG'
    """

    def _repr_png_(self) -> bytes:
        written = io.BytesIO()
        self.savefig(written, format="png", dpi=100)
        return written.getvalue()


def figure(
    title: str,
    columns: int = 1,
    rows: int = 1,
    size: tuple[float, float] | None = None,
    widths: Sequence[float] | None = None,
) -> tuple[Picture, Any]:
    """Make a figure whose title states the finding.

    Args:
        title: the question or the finding; a long one is wrapped.
        columns: of axes.
        rows: of axes.
        size: width and height [inch].
        widths: of the columns, as ratios.

    Returns:
        The figure, and its axes: an `Axes`, or an array of them if there are several.

    Example:
        >>> made, axes = dd.plots.figure("Wheels slip", columns=2)
        >>> made.get_suptitle(), axes.shape
        ('Wheels slip', (2,))
    """
    made = titled(title, size or (WIDTH if columns > 1 else 0.7 * WIDTH, 3.9 * rows + 0.5))
    return made, made.subplots(rows, columns, width_ratios=widths)


def titled(title: str, size: tuple[float, float]) -> Picture:
    """Make a figure without axes.

    Args:
        title: the question or the finding; a long one is wrapped.
        size: width and height [inch].

    Returns:
        The figure.

    Example:
        >>> titled("Wheels slip", (WIDTH, 4.0)).axes
        []
    """
    made = Picture(figsize=size)
    # Room for half of a tick's label at the end of an axis.
    made.set_layout_engine("constrained", w_pad=0.12, h_pad=0.06)
    FigureCanvasAgg(made)
    made.suptitle(title, x=0.01, ha="left", fontsize=13, fontweight="bold", wrap=True)
    return made


def map_beside_two(title: str) -> tuple[Picture, Axes, Axes, Axes]:
    """Make a figure with a map on the left, and two curves above each other on the right.

    Args:
        title: the question or the finding; a long one is wrapped.

    Returns:
        The figure, the map, the upper curve and the lower one.

    Example:
        >>> made, on_map, upper, lower = map_beside_two("Wheels slip")
        >>> made.axes == [on_map, upper, lower]
        True
    """
    made = titled(title, (WIDTH, 4.6))
    grid = made.add_gridspec(2, 2)
    on_map, upper, lower = (made.add_subplot(grid[place]) for place in ((slice(None), 0), (0, 1), (1, 1)))
    return made, on_map, upper, lower


def panel(ax: Axes, title: str) -> None:
    """Write what a panel shows above it.

    Args:
        ax: the panel.
        title: in a few words.

    Example:
        >>> made, axes = dd.plots.figure("Wheels slip", columns=2)
        >>> panel(axes[0], "On ice")
    """
    ax.set_title(title, loc="left", fontsize=10.5)


def legend_below(made: Figure, *panels: Axes, columns: int = 4) -> None:
    """Replace the legends of panels by one below them, where it covers nothing.

    Args:
        made: the figure.
        panels: whose curves it names, each label once.
        columns: of the legend.

    Example:
        >>> made, ax = dd.plots.figure("A finding")
        >>> legend_below(made, dd.plots.errors(ax, [0.0, 1.0], {"odometry": [0.0, 0.002]}))
        >>> [text.get_text() for text in made.legends[0].get_texts()]
        ['odometry']
    """
    named = {}
    for ax in panels:
        handles, labels = ax.get_legend_handles_labels()
        named.update(dict(zip(labels, handles, strict=True)))
        if legend := ax.get_legend():
            legend.remove()
    made.legend(named.values(), named.keys(), loc="outside lower left", ncols=columns, frameon=False, fontsize=9.5)
