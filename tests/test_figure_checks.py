"""The checks of pictures: each sees what it is for, and a good picture passes."""

import numpy as np
import pytest
from figure_checks import check_layout, problems

from diffdrive_mj.report import marks, plots

X = np.linspace(0.0, 1.0, 50)


def good():
    figure, ax = plots.figure("A finding", size=(8.0, 4.0))
    ax.plot(X, X, label="curve")
    ax.set(xlabel="distance [m]", ylabel="error [mm]", ylim=(0, 2))
    return figure, ax


def test_a_good_picture_passes():
    figure, ax = good()
    marks.note(ax, "above the curve", (0.3, 1.0))
    ax.legend(loc="upper left")
    check_layout(figure)


def bad(change):
    """What is said of the good picture once it is changed."""
    figure, ax = good()
    change(figure, ax)
    return problems(figure)


def marked(draw):
    """A text over something else that is drawn, with the label "it"."""

    def change(figure, ax):
        draw(ax)
        marks.note(ax, "text", (0.2, 1.5), ha="center", va="center")

    return change


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda figure, ax: figure.set_figwidth(12), "12 inches wide"),
        (lambda figure, ax: figure.suptitle(""), "no title"),
        (lambda figure, ax: ax.set_xlabel("distance [m]", fontsize=7), "'distance [m]' is 9.7 pixels high"),
        (lambda figure, ax: ax.tick_params(labelsize=5), "pixels high"),
        (lambda figure, ax: ax.legend(loc="upper left", fontsize=6), "'curve' is 8.3 pixels high"),
        (lambda figure, ax: figure.suptitle("A long finding " * 12, wrap=False), "is cut off"),
        (lambda figure, ax: ax.set_xlabel(""), "the x axis has no label"),
        (lambda figure, ax: ax.set_ylabel("error"), "the y axis has no unit"),
        (lambda figure, ax: ax.legend(loc="lower left"), "the legend covers 'curve'"),
        (lambda figure, ax: marks.note(ax, "on the curve", (0.5, 0.5)), "'on the curve' covers 'curve'"),
        (lambda figure, ax: [marks.note(ax, t, (0.1, 1.5)) for t in ("one", "two")], "'one' and 'two' overlap"),
        (lambda figure, ax: ax.set_xticks(np.linspace(0, 1, 40)), "overlap"),
        (marked(lambda ax: ax.scatter(0.2, 1.5, label="it")), "'text' covers 'it'"),
        (marked(lambda ax: ax.plot(0.2, 1.5, "o", label="it")), "'text' covers 'it'"),
        (marked(lambda ax: ax.axhline(1.5, label="it")), "'text' covers 'it'"),
        (marked(lambda ax: ax.bar(0.2, 1.5)), "'text' covers '_nolegend_'"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_said(change, said):
    assert any(said in problem for problem in bad(change)), bad(change)


def test_words_on_an_axis_need_no_label():
    figure, ax = good()
    ax.set_ylabel("")
    ax.set_yticks([0, 1], ["first way", "second way"])
    check_layout(figure)
