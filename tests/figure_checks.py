"""What a picture must be like, read from its geometry: legible at 800 pixels, nothing cut off, nothing over the data.

`problems` draws a figure and lists what is wrong with it, a line each; an empty list is a pass.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.text import Text
from matplotlib.transforms import Bbox

WIDEST = 10.0  # [inch]
SHOWN, SMALLEST = 800, 10  # the width at which pages show a picture, and the height of its text then [pixels]
NOTHING = (None, "None", "none", " ", "")  # a line style or a marker that draws nothing
WITHOUT_UNIT = ("[", "/", " per ", "number of", "share of")  # a label with one of them has its unit, or none


def check_layout(figure: Figure) -> None:
    """Fail for a picture that has a problem."""
    assert problems(figure) == []


def problems(figure: Figure) -> list[str]:
    """What is wrong with a picture."""
    figure.draw_without_rendering()  # the layout is settled by drawing
    figure.draw_without_rendering()
    return [*_frame(figure), *_texts(figure), *(p for ax in figure.axes for p in (*_covered(ax), *_labels(ax)))]


def _frame(figure: Figure) -> Iterator[str]:
    if figure.get_figwidth() > WIDEST:
        yield f"{figure.get_figwidth():g} inches wide: at most {WIDEST:g}"
    if not figure.get_suptitle():
        yield "no title"


def _texts(figure: Figure) -> Iterator[str]:
    texts = list(_shown(figure))
    for text in texts:
        height = text.get_fontsize() / 72 * SHOWN / figure.get_figwidth()
        if height < SMALLEST:
            yield f"{_name(text)} is {height:.1f} pixels high at {SHOWN}: at least {SMALLEST}"
        box = _box(text)
        if min(box.x0, box.y0, figure.bbox.width - box.x1, figure.bbox.height - box.y1) < -1:
            yield f"{_name(text)} is cut off"
    for a, b in itertools.combinations(texts, 2):
        if _overlap(_box(a), _box(b), slack=1):
            yield f"{_name(a)} and {_name(b)} overlap"


def _covered(ax: Axes) -> Iterator[str]:
    legend = ax.get_legend()
    boxes = [(_name(text), _box(text)) for text in ax.texts if text.get_text() and text.get_visible()]
    boxes += [("the legend", legend.get_frame().get_window_extent())] if legend else []
    for name, box in boxes:
        inside = Bbox.intersection(box, ax.bbox)
        if inside is None:
            continue
        for artist in (*ax.lines, *ax.patches):
            if artist.get_visible() and _reaches(artist, inside):
                yield f"{name} covers {artist.get_label()!r}"
        for points in ax.collections:
            at = points.get_offset_transform().transform(points.get_offsets())
            if len(points.get_offsets()) and points.get_visible() and inside.count_contains(np.ma.filled(at, np.nan)):
                yield f"{name} covers {points.get_label()!r}"


def _reaches(artist: Line2D | Patch, box: Bbox) -> bool:
    """Whether a line with its width, one of its markers, or the edge of a patch is in a box."""
    path = artist.get_transform().transform_path(artist.get_path()).cleaned(remove_nans=True)
    point = artist.get_figure().dpi / 72
    drawn = artist.get_linestyle() not in NOTHING and len(path.vertices)
    if drawn and path.intersects_bbox(box.padded(artist.get_linewidth() / 2 * point), filled=False):
        return True
    # Where only some samples have their marker, the line through them is what counts.
    if isinstance(artist, Patch) or artist.get_marker() in NOTHING or artist.get_markevery() is not None:
        return False
    at = artist.get_transform().transform(artist.get_xydata())
    return bool(box.padded(artist.get_markersize() / 2 * point).count_contains(at))


def _labels(ax: Axes) -> Iterator[str]:
    for name, axis in (("x", ax.xaxis), ("y", ax.yaxis)):
        if not axis.get_visible() or not ax.axison or not any(map(_is_number, _ticks(axis))):
            continue
        label = axis.get_label_text()
        if not label:
            yield f"the {name} axis has no label"
        elif not any(mark in label for mark in WITHOUT_UNIT):
            yield f"the {name} axis has no unit: {label!r}"


def _is_number(text: Text) -> bool:
    return any(character.isdigit() for character in text.get_text()) and not any(
        word.isalpha() and len(word) > 1 for word in text.get_text().replace("mathdefault", "").split()
    )


def _shown(figure: Figure) -> Iterator[Text]:
    """Every text that is drawn; of the ticks, those within the axes."""
    ticks = {id(label) for ax in figure.axes for axis in (ax.xaxis, ax.yaxis) for label in _all_ticks(axis)}
    for text in figure.findobj(Text):
        if text.get_visible() and text.get_text().strip() and id(text) not in ticks:
            yield text
    for ax in figure.axes:
        for axis in (ax.xaxis, ax.yaxis):
            yield from _ticks(axis)


def _all_ticks(axis: Axis) -> list[Text]:
    return [*axis.get_majorticklabels(), *axis.get_minorticklabels()]


def _ticks(axis: Axis) -> Iterator[Text]:
    """The labels of the ticks that are drawn."""
    ax, across = axis.axes, axis.axis_name == "x"
    low, high = (ax.bbox.x0, ax.bbox.x1) if across else (ax.bbox.y0, ax.bbox.y1)
    for tick in (*axis.get_major_ticks(), *axis.get_minor_ticks()):
        label, at = tick.label1, ax.transData.transform((tick.get_loc(), tick.get_loc()))[0 if across else 1]
        if axis.get_visible() and label.get_visible() and label.get_text().strip() and low - 1 <= at <= high + 1:
            yield label


def _box(text: Text) -> Bbox:
    """Where a text is, without the arrow that an annotation may have."""
    return Text.get_window_extent(text)


def _overlap(a: Bbox, b: Bbox, slack: float) -> bool:
    across, up = min(a.x1, b.x1) - max(a.x0, b.x0), min(a.y1, b.y1) - max(a.y0, b.y0)
    return across > slack and up > slack


def _name(text: Text) -> str:
    return repr(text.get_text())
