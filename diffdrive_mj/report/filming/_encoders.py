"""Frames into a file: an animated WebP, an MP4 through ffmpeg, or a single picture."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from PIL import Image, PngImagePlugin

from diffdrive_mj._signals import held
from diffdrive_mj.errors import MissingFile, RenderingFailed
from diffdrive_mj.report.filming._webp import MARK, XMP, write_animation

__all__ = ["FILMS", "MARK", "PICTURES", "refuse_missing_encoder", "write_film", "write_picture"]

FILMS, PICTURES = (".webp", ".mp4"), (".png", ".webp")


def refuse_missing_encoder(path: Path) -> None:
    """Say before the work that a film cannot be encoded.

    Raises:
        MissingFile: there is no ffmpeg for an .mp4.
    """
    if path.suffix.lower() == ".mp4" and not shutil.which("ffmpeg"):
        raise MissingFile(f"{path}: .mp4 needs ffmpeg, which is not installed; a film named .webp needs none")


def write_film(path: Path, frames: Iterator[Image.Image], fps: float) -> None:
    """Write an animation.

    Raises:
        RenderingFailed: ffmpeg failed.
    """
    (_write_mp4 if path.suffix.lower() == ".mp4" else write_animation)(path, frames, fps)


def write_picture(path: Path, picture: Image.Image) -> None:
    """Write a single picture without loss."""
    if path.suffix.lower() == ".webp":
        picture.save(path, "WEBP", lossless=True, xmp=XMP)
    else:
        software = PngImagePlugin.PngInfo()
        software.add_text("Software", MARK)
        picture.save(path, "PNG", optimize=True, pnginfo=software)


def _write_mp4(path: Path, frames: Iterator[Image.Image], fps: float) -> None:
    first = next(frames)
    size = f"{first.width}x{first.height}"
    command = [
        "ffmpeg", "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s", size,
        "-r", f"{fps:.6f}", "-i", "-", "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p",
        "-metadata", f"comment={MARK}", "-movflags", "+faststart", "-f", "mp4", str(path.absolute()),
    ]  # fmt: skip
    with tempfile.TemporaryFile() as said, held() as let_go:
        process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=said, start_new_session=True
        )
        try:
            let_go()
            assert process.stdin is not None
            with suppress(OSError), process.stdin as pipe:  # where it has died, its status says so
                pipe.write(first.tobytes())
                for frame in frames:
                    pipe.write(frame.tobytes())
            status = process.wait()
        finally:
            process.kill()
            process.wait()
        if status:
            said.seek(0)
            lines = said.read().decode(errors="replace").strip().splitlines()
            raise RenderingFailed(
                f"ffmpeg ended with exit status {status} ({lines[-1] if lines else 'and said nothing'}); "
                "a film named .webp needs no ffmpeg"
            )
