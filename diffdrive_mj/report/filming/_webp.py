"""Animated WebP, frame by frame: Pillow compresses each picture, and this puts them into one file.

Pillow's own writer wants all frames at once. Of each frame only the rectangle that has changed is stored. The format is
that of https://developers.google.com/speed/webp/docs/riff_container: chunks of a name, a length and an even number of
bytes.
"""

from __future__ import annotations

import io
import struct
from collections.abc import Iterator
from pathlib import Path

from PIL import Image, ImageChops

_QUALITY, _METHOD = 78, 2  # of 100, and of 0 (fast) to 6 (small)
_REFRESH = 25  # every so many frames whole ones, which wipe off what compression has left beside moving things
_ANIMATION, _HAS_XMP, _NO_BLENDING = 0x02, 0x04, 0x02

# By what program a file is, as every format has its place for it.
MARK = "diffdrive_mj"
XMP = (
    '<x:xmpmeta xmlns:x="adobe:ns:meta/"><rdf:RDF xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#">'
    f'<rdf:Description xmlns:xmp="http://ns.adobe.com/xap/1.0/" xmp:CreatorTool="{MARK}"/></rdf:RDF></x:xmpmeta>'
).encode()


def write_animation(path: Path, frames: Iterator[Image.Image], fps: float) -> None:
    """Write frames as an animation that repeats for ever.

    Args:
        path: of the file, which is made.
        frames: of one size.
        fps: frames per second; each ends at a whole millisecond.
    """
    with path.open("xb") as file:
        file.write(b"RIFF\0\0\0\0WEBP")  # the length is known at the end
        before = None
        for k, frame in enumerate(frames):
            if before is None:
                canvas = struct.pack("<B3x", _ANIMATION | _HAS_XMP) + _24(frame.width - 1) + _24(frame.height - 1)
                file.write(_chunk(b"VP8X", canvas) + _chunk(b"ANIM", struct.pack("<IH", 0xFFFFFFFF, 0)))
            box = _changed(before if k % _REFRESH else None, frame)
            milliseconds = round(1000 * (k + 1) / fps) - round(1000 * k / fps)
            file.write(_chunk(b"ANMF", _frame_header(box, milliseconds) + _compressed(frame.crop(box))))
            before = frame
        file.write(_chunk(b"XMP ", XMP))
        length = file.tell()
        file.seek(4)
        file.write(struct.pack("<I", length - 8))


def _changed(before: Image.Image | None, frame: Image.Image) -> tuple[int, int, int, int]:
    """The rectangle in which two frames differ, from an even place on."""
    box = (0, 0, *frame.size) if before is None else ImageChops.difference(before, frame).getbbox()
    left, top, right, bottom = box or (0, 0, 2, 2)
    return left - left % 2, top - top % 2, right, bottom


def _frame_header(box: tuple[int, int, int, int], milliseconds: int) -> bytes:
    left, top, right, bottom = box
    places = (left // 2, top // 2, right - left - 1, bottom - top - 1, milliseconds)
    # Where a frame is stored it covers the one before.
    return b"".join(map(_24, places)) + bytes([_NO_BLENDING])


def _compressed(picture: Image.Image) -> bytes:
    """The chunk of a picture's pixels, which is all that its own file holds after its head of 12 bytes."""
    written = io.BytesIO()
    picture.save(written, "WEBP", quality=_QUALITY, method=_METHOD)
    return written.getvalue()[12:]


def _chunk(name: bytes, content: bytes) -> bytes:
    return name + struct.pack("<I", len(content)) + content + b"\0" * (len(content) % 2)


def _24(number: int) -> bytes:
    return struct.pack("<I", number)[:3]
