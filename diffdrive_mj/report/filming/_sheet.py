"""The sheet that a film is shown on: panels beside each other, a title above them, a caption below."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont

from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.report.filming._captions import Entry
from diffdrive_mj.report.filming._take import Take

_LEAST = 32  # sides of a panel [pixel]
_INK, _PAPER = (40, 42, 46), (255, 255, 255)
Captioner = Callable[[Take, Take, int], list[Entry]]


@dataclass(frozen=True, eq=False)
class Group:
    """A drive on the sheet: its panels have one title and one caption.

    Attributes:
        title: "" for none.
        whole: the drive.
        seen: at the frames.
        cameras: a panel each.
    """

    title: str
    whole: Take
    seen: Take
    cameras: tuple[str, ...]


class Sheet:
    """Says how large the panels are, and puts drawn panels onto paper.

    Attributes:
        size: of the sheet [pixel].
        panels: widths of the panels, and their height [pixel].
    """

    def __init__(self, groups: Sequence[Group], size: tuple[int, int], captioner: Captioner) -> None:
        """Lay it out: what is written keeps its place in every frame.

        Args:
            groups: from left to right.
            size: width and height of the sheet [pixel].
            captioner: what is written below a group at a frame.
        """
        self.size, self._groups, self._captioner = size, groups, captioner
        (width, height), count = size, sum(len(group.cameras) for group in groups)
        edges = [round(k * width / count) for k in range(count + 1)]
        self.widths = [right - left for left, right in itertools.pairwise(edges)]
        self._edges = edges
        starts = [sum(len(group.cameras) for group in groups[:k]) for k in range(len(groups) + 1)]
        self._columns = [(edges[a], edges[b]) for a, b in itertools.pairwise(starts)]
        self._titles = [self._wrapped(group.title, k) for k, group in enumerate(groups)]
        self._places = [self._flow(k) for k in range(len(groups))]
        lines = max(len(title) for title in self._titles)
        self._top = lines * self._line + self._pad if lines else 0
        rows = 1 + max(row for places in self._places for _, row in places)
        self._bottom = rows * self._line + self._pad
        self.height = height - self._top - self._bottom
        if min(self.height, *self.widths) < _LEAST:
            raise InvalidValue(
                f"size = {width} x {height}: leaves pictures of {min(self.widths)} x {max(self.height, 0)} pixels; "
                f"must be larger, so that they are at least {_LEAST} x {_LEAST}"
            )

    @cached_property
    def _font_size(self) -> int:
        return max(9, round(min(self.size[1] / 31, self.size[0] / len(self._groups) / 21)))

    @cached_property
    def _fonts(self) -> tuple[ImageFont.FreeTypeFont, ImageFont.FreeTypeFont]:
        """The font of captions and that of titles: those that Matplotlib brings."""
        import matplotlib as mpl

        folder = Path(mpl.get_data_path()) / "fonts" / "ttf"
        plain, bold = (str(folder / f"DejaVuSans{kind}.ttf") for kind in ("", "-Bold"))
        return ImageFont.truetype(plain, self._font_size), ImageFont.truetype(bold, self._font_size)

    @property
    def _line(self) -> int:
        return round(1.45 * self._font_size)

    @property
    def _pad(self) -> int:
        return round(0.5 * self._font_size)

    def frame(self, panels: Image.Image, k: int) -> Image.Image:
        """The sheet with drawn panels, beside each other in one picture, and what is written at a frame."""
        sheet = self._paper.copy()
        sheet.paste(panels, (0, self._top))
        draw = ImageDraw.Draw(sheet)
        gap = max(1, self._font_size // 6)
        for edge in self._edges[1:-1]:
            draw.rectangle((edge - gap, self._top, edge + gap - 1, self._top + self.height), fill=_PAPER)
        base = self._top + self.height + self._pad // 2
        for group, places in zip(self._groups, self._places, strict=True):
            for entry, (x, row) in zip(self._captioner(group.whole, group.seen, k), places, strict=True):
                self._write(draw, entry, x, base + row * self._line)
        return sheet

    @cached_property
    def _paper(self) -> Image.Image:
        paper = Image.new("RGB", self.size, _PAPER)
        draw = ImageDraw.Draw(paper)
        for (left, _), title in zip(self._columns, self._titles, strict=True):
            for row, text in enumerate(title):
                place = (left + self._pad, self._pad // 2 + row * self._line)
                draw.text(place, text, fill=_INK, font=self._fonts[1])
        return paper

    def _write(self, draw: ImageDraw.ImageDraw, entry: Entry, x: int, y: int) -> None:
        if entry.colour is not None:
            colour = tuple(round(255 * part) for part in entry.colour)
            spot = 0.8 * self._font_size
            top = y + 0.25 * self._font_size
            draw.rectangle((x, top, x + spot, top + spot), fill=colour)
            x += round(1.3 * self._font_size)
        draw.text((x, y), entry.text, fill=_INK, font=self._fonts[0])

    def _flow(self, index: int) -> list[tuple[int, int]]:
        """Where each entry of a group's caption stands: pixels from the left, and row."""
        group, (left, right) = self._groups[index], self._columns[index]
        x, row, places = left + self._pad, 0, []
        for entry in self._widest(group):
            width = round(self._fonts[0].getlength(entry.text)) + (entry.colour is not None) * round(
                1.3 * self._font_size
            )
            if x > left + self._pad and x + width > right - self._pad:
                x, row = left + self._pad, row + 1
            places.append((x, row))
            x += width + round(1.4 * self._font_size)
        return places

    def _widest(self, group: Group) -> list[Entry]:
        """The caption with each of its entries as wide as it gets."""
        count = len(group.seen.t)
        samples = [self._captioner(group.whole, group.seen, k) for k in {0, count // 2, count - 1}]
        return [max(entries, key=lambda entry: len(entry.text)) for entries in zip(*samples, strict=True)]

    def _wrapped(self, title: str, index: int) -> list[str]:
        left, right = self._columns[index]
        lines: list[str] = []
        for word in title.split():
            longer = f"{lines[-1]} {word}" if lines else word
            if lines and self._fonts[1].getlength(longer) <= right - left - 2 * self._pad:
                lines[-1] = longer
            else:
                lines.append(word)
        return lines
