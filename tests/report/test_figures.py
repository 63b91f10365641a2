"""Figures: sizes, titles above the left edge, one legend below, and what notebooks show."""

import io

import matplotlib.image
import numpy as np
import pytest

from diffdrive_mj.report import figures
from diffdrive_mj.report.figures import WIDTH, figure, legend_below, panel


@pytest.mark.parametrize(("columns", "rows", "shape"), [(1, 1, ()), (2, 1, (2,)), (1, 2, (2,)), (2, 2, (2, 2))])
def test_a_figure_is_as_wide_as_a_page_or_two_thirds_of_it_and_higher_with_rows(columns, rows, shape):
    made, axes = figure("A finding", columns, rows)
    assert np.shape(axes) == shape
    width, height = made.get_size_inches()
    assert width == pytest.approx(WIDTH if columns > 1 else 0.7 * WIDTH)
    assert 3.9 * rows < height < 3.9 * rows + 1  # room for the title


def test_columns_are_as_wide_as_asked_and_sizes_as_given():
    made, (left, right) = figure("A finding", columns=2, size=(8.0, 3.0), widths=(3, 1))
    made.canvas.draw()
    assert tuple(made.get_size_inches()) == (8.0, 3.0)
    assert left.get_position().width == pytest.approx(3 * right.get_position().width, rel=0.05)


def test_titles_stand_at_the_left_in_a_hierarchy():
    made, ax = figure("A finding")
    panel(ax, "On ice")
    ax.plot([0, 1], [0, 1], label="odometry")
    legend_below(made, ax)
    made.canvas.draw()
    title, part = made._suptitle, ax._left_title
    assert (part.get_text(), ax.get_title(loc="center")) == ("On ice", "")
    edge = made.bbox.width
    assert 0 < title.get_window_extent().x0 < 0.02 * edge
    (legend,) = made.legends
    size = legend.get_texts()[0].get_fontsize()
    assert title.get_fontsize() > part.get_fontsize() > size
    assert title.get_fontweight() == "bold"
    # At 800 pixels a figure of full width shows 800 / 9.6 of them an inch.
    assert size * 800 / WIDTH / 72 >= 10
    assert not legend.get_frame_on()
    assert legend.get_window_extent().y1 < ax.get_window_extent().y0
    assert legend.get_window_extent().x0 < 0.05 * edge


@pytest.mark.parametrize(("columns", "lines"), [(4, 2), (2, 3)])
def test_a_legend_has_as_many_columns_as_asked(columns, lines):
    made, ax = figure("A finding", columns=1, size=(9.6, 4.0))
    for name in "abcde":
        ax.plot([0, 1], label=name)
    legend_below(made, ax, columns=columns)
    made.canvas.draw()
    heights = {round(text.get_window_extent().y0) for text in made.legends[0].get_texts()}
    assert len(heights) == lines
    legend_below(made, ax)
    assert made.legends[-1]._ncols == 4


def test_a_notebook_shows_a_figure_at_a_hundred_dots_an_inch():
    made, _ = figure("A finding", size=(3.0, 2.0))
    pixels = matplotlib.image.imread(io.BytesIO(made._repr_png_()), format="png")
    assert pixels.shape[:2] == (200, 300)


def test_the_outermost_ticks_labels_have_room():
    made, ax = figures.figure("A finding")
    ax.plot([0, 1000], [0, 1])
    ax.set_xlim(0, 1000)
    made.canvas.draw()
    last = max((text.get_window_extent() for text in ax.get_xticklabels()), key=lambda box: box.x1)
    assert last.x1 <= made.bbox.width
