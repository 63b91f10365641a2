"""Pictures made small enough to be part of a page."""

from __future__ import annotations

import base64
import io
import math
import warnings
from dataclasses import dataclass
from pathlib import Path

from PIL import Image

# A page shows them at half of this width, on fine screens at all of it [pixels].
_WIDTH = 1440
# A picture of more is not opened: nobody has drawn it for a page [pixels].
_LARGEST = 30_000_000
# A picture of more colours is no plot; one narrower than this shows nothing [pixels].
_COLOURS, _NARROWEST = 30_000, 160


@dataclass(frozen=True)
class Shrunk:
    """A picture for a page.

    Attributes:
        source: a data URL.
        width: at which it is shown [pixels].
        height: likewise.
    """

    source: str
    width: int
    height: int


def shrunk(path: Path, most: int) -> Shrunk | None:
    """A picture in at most so many bytes, as fine as they allow; None where that is too few to see anything.

    Plots have few colours: with 64 of them, lossless, they take a quarter of their file and look the same. Where that
    is still too much, and of photographs, it is their detail that goes, and then their size.

    Raises:
        ValueError, OSError: not a picture, or one too large to open.
    """
    with warnings.catch_warnings(action="ignore", category=Image.DecompressionBombWarning), Image.open(path) as opened:
        if opened.width * opened.height > _LARGEST:
            raise ValueError(f"{opened.width} x {opened.height} pixels")
        picture = _scaled(_on_white(opened), _WIDTH)
    size = (picture.width + 1) // 2, (picture.height + 1) // 2
    source = _plot(picture) if picture.getcolors(_COLOURS) else _photograph(picture, 80)
    for _ in range(4):
        if len(source) <= most:
            return Shrunk(source, *size)
        # Files grow with the area.
        width = int(min(picture.width, 0.9 * picture.width * math.sqrt(most / len(source))))
        if width < _NARROWEST:
            break
        picture = picture if width > 0.8 * picture.width else _scaled(picture, width)
        source = _photograph(picture, 50)
    return None


def _on_white(picture: Image.Image) -> Image.Image:
    """What is see-through shows the paper of a plot."""
    colours = picture.convert("RGBA")
    paper = Image.new("RGBA", colours.size, "white")
    return Image.alpha_composite(paper, colours).convert("RGB")


def _scaled(picture: Image.Image, width: int) -> Image.Image:
    if picture.width <= width:
        return picture
    return picture.resize((width, max(1, round(picture.height * width / picture.width))), Image.Resampling.LANCZOS)


def _plot(picture: Image.Image) -> str:
    few = picture.quantize(64, dither=Image.Dither.NONE).convert("RGB")
    return _webp(few, lossless=True, quality=30, method=2)


def _photograph(picture: Image.Image, quality: int) -> str:
    return _webp(picture, quality=quality, method=4)


def _webp(picture: Image.Image, **options: int) -> str:
    written = io.BytesIO()
    picture.save(written, "WEBP", **options)
    return f"data:image/webp;base64,{base64.b64encode(written.getvalue()).decode()}"
