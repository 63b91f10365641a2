"""Pictures made small enough to be part of a page."""

from __future__ import annotations

import base64
import io
import warnings
from dataclasses import dataclass
from pathlib import Path

from PIL import Image

# A page shows them at half of this width, on fine screens at all of it [pixels].
_WIDTH = 1440
# A picture of more is not opened: nobody has drawn it for a page [pixels].
_LARGEST = 30_000_000


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
    is still too much, as with photographs, they lose detail.

    Raises:
        ValueError, OSError: not a picture, or one too large to open.
    """
    with warnings.catch_warnings(action="ignore", category=Image.DecompressionBombWarning), Image.open(path) as opened:
        if opened.width * opened.height > _LARGEST:
            raise ValueError(f"{opened.width} x {opened.height} pixels")
        picture = _on_white(opened)
    fine = _scaled(picture, _WIDTH)
    size = (fine.width + 1) // 2, (fine.height + 1) // 2
    for attempt in ("lossless", 80, 50, 25):
        for scale in (1.0,) if attempt == "lossless" else (1.0, 0.6, 0.35):
            source = _webp(_scaled(fine, round(scale * fine.width)), None if attempt == "lossless" else int(attempt))
            if len(source) <= most:
                return Shrunk(source, *size)
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


def _webp(picture: Image.Image, quality: int | None) -> str:
    written = io.BytesIO()
    if quality is None:
        few = picture.quantize(64, dither=Image.Dither.NONE).convert("RGB")
        few.save(written, "WEBP", lossless=True, quality=30, method=2)
    else:
        picture.save(written, "WEBP", quality=quality, method=4)
    return f"data:image/webp;base64,{base64.b64encode(written.getvalue()).decode()}"
