"""From what is asked for to sheets that are drawn: checks that films and strobe pictures share, and the work."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from pathlib import Path

from PIL import Image

from diffdrive_mj import _checks as checks
from diffdrive_mj._files import made_whole
from diffdrive_mj._progress import progress
from diffdrive_mj._text import one_line, shown
from diffdrive_mj.drive import Drive
from diffdrive_mj.errors import InvalidType, InvalidValue
from diffdrive_mj.recording import Recording
from diffdrive_mj.report.filming import _cameras
from diffdrive_mj.report.filming._cameras import View
from diffdrive_mj.report.filming._renderer import pictures
from diffdrive_mj.report.filming._scene import Job, Scene
from diffdrive_mj.report.filming._sheet import Group, Sheet
from diffdrive_mj.report.filming._take import Believed, Take

# Sides of a sheet [pixel], and drives beside each other.
_LEAST, _LARGEST, _MOST_BESIDE = 96, 4096, 4
Shown = Recording | Drive | Mapping[str, Recording | Drive]


def takes_of(recording: Shown, believed: Believed) -> dict[str, Take]:
    """The drives by their titles; a drive alone has none."""
    if not isinstance(recording, Mapping):
        return {"": Take.of(recording, believed)}
    if not 1 <= len(recording) <= _MOST_BESIDE:
        raise InvalidValue(f"recording has {len(recording)} drives: must be 1 to {_MOST_BESIDE} beside each other")
    return {one_line(checks.string("title", title)): Take.of(one, believed) for title, one in recording.items()}


def checked_size(size: tuple[int, int]) -> tuple[int, int]:
    """Width and height that can be drawn."""
    if not isinstance(size, list | tuple) or len(size) != 2:
        raise InvalidType(f"size = {shown(size)}: must be (width, height) in pixels")
    width, height = (checks.whole(f"size[{k}]", side, least=_LEAST) for k, side in enumerate(size))
    if max(width, height) > _LARGEST:
        raise InvalidValue(f"size = {width} x {height}: must be at most {_LARGEST} x {_LARGEST} pixels")
    return width, height


def finer(size: tuple[int, int]) -> int:
    """How often finer a still picture is drawn than it gets; not beyond what memory holds."""
    return 2 if max(size) <= _LARGEST // 2 else 1


def scenes(
    groups: Sequence[Group], sheet: Sheet, scene: Callable[[Take, Take, View, tuple[int, int]], Scene]
) -> tuple[Scene, ...]:
    """What is drawn for each panel of a sheet."""
    made, widths, wholes = [], iter(sheet.widths), [group.whole for group in groups]
    for group in groups:
        for camera in group.cameras:
            size = (next(widths), sheet.height)
            view = _cameras.view(camera, wholes, group.seen, size[0] / size[1])
            made.append(scene(group.whole, group.seen, view, size))
    return tuple(made)


@contextmanager
def written(path: Path, job: Job, sheet: Sheet) -> Iterator[tuple[Path, Iterator[Image.Image]]]:
    """Give the path of a file to write, which takes the place of `path` in the end, and the sheets as they are drawn.

    Raises:
        InvalidValue: the path cannot be written; nothing has been drawn then.
        RenderingFailed: the sheets cannot be drawn.
    """
    if path.is_dir():
        raise InvalidValue(f"{path}: cannot be written (it is a folder)")
    with made_whole(path) as new, closing(_sheets(path, job, sheet)) as sheets:
        yield new, sheets


def _sheets(path: Path, job: Job, sheet: Sheet) -> Generator[Image.Image, None, None]:
    with progress(path.name, job.frames, " frames") as advance, closing(pictures(job)) as drawn:
        for k, panels in enumerate(drawn):
            yield sheet.frame(panels, k)
            advance(1)
