"""Animated WebP, read back by Pillow, which shares no code with the writer."""

import struct

import numpy as np
import pytest
from PIL import Image

from diffdrive_mj.report.filming._webp import MARK, write_animation


def frames(count, size=(64, 48)):
    """A red square that wanders over a grey floor."""
    for k in range(count):
        picture = np.full((size[1], size[0], 3), 128, dtype=np.uint8)
        picture[10:26, 3 + k : 19 + k] = (220, 20, 20)
        yield Image.fromarray(picture)


@pytest.mark.parametrize("count", [2, 30])
def test_every_frame_comes_back(tmp_path, count):
    path = tmp_path / "film.webp"
    write_animation(path, frames(count), 24.0)
    with Image.open(path) as film:
        assert (film.n_frames, film.size, film.info["loop"]) == (count, (64, 48), 0)
        times = []
        for k, frame in enumerate(frames(count)):
            film.seek(k)
            film.load()
            times.append(film.info["duration"])
            difference = np.abs(np.asarray(film.convert("RGB"), dtype=int) - np.asarray(frame, dtype=int))
            assert difference.mean() < 3
            assert np.asarray(film.convert("RGB"))[18, 11 + k, 0] > 180
    assert sum(times) == round(1000 * count / 24)  # no drift by rounding
    assert set(times) <= {41, 42}


def test_the_length_in_the_file_is_its_own(tmp_path):
    path = tmp_path / "film.webp"
    write_animation(path, frames(3), 10.0)
    content = path.read_bytes()
    assert struct.unpack("<I", content[4:8])[0] == len(content) - 8
    assert MARK.encode() in content


def test_what_does_not_change_is_not_stored_again(tmp_path):
    still, moving = tmp_path / "still.webp", tmp_path / "moving.webp"
    noise = np.random.default_rng(0).integers(0, 255, (20, 480, 640, 3), dtype=np.uint8)
    write_animation(still, (Image.fromarray(noise[0]) for _ in noise), 10.0)
    write_animation(moving, map(Image.fromarray, noise), 10.0)
    assert still.stat().st_size < moving.stat().st_size / 10
    with Image.open(still) as film:
        assert film.n_frames == 20
