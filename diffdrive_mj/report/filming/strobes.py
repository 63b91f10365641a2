"""Strobe pictures: a whole drive in one still, for papers."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj._files import as_path
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.report.filming import _encoders, _scene, _shooting
from diffdrive_mj.report.filming._captions import Entry, finding, legend
from diffdrive_mj.report.filming._sheet import Group, Sheet
from diffdrive_mj.report.filming._shooting import Shown
from diffdrive_mj.report.filming._take import Believed, Take
from diffdrive_mj.report.filming.films import Film

_CAMERAS = ("oblique", "above")
_MOST_TIMES = 24


def strobe(
    recording: Shown,
    believed: Believed,
    path: str | Path,
    *,
    times: int | Sequence[float] = 6,
    camera: str = "oblique",
    size: tuple[int, int] = (1600, 1000),
) -> Film:
    """Draw a drive in one picture: the robot and its ghosts at several times, and both trails.

    The title says how far each ghost is from the robot in the end.

    Args:
        recording: of one robot; or a `Drive` of a log, seen at its true poses, which looks like the first robot that is
            believed; or several by their titles, which are shown beside each other.
        believed: the robot that the odometry takes it for; or a list of such robots; or a mapping from names to robots
            or to poses (T, 3) [m, m, rad] at the recorded times, those of the true poses of a `Drive`.
        path: of the file, .png or .webp.
        times: how many, evenly along the path, start and end among them; or the times themselves [s].
        camera: "oblique" or "above".
        size: width and height [pixel].

    Returns:
        What was written.

    Raises:
        UnknownName: another camera or ending.
        InvalidValue: a recording of several runs or of fewer than two samples, true poses more than a second apart,
            poses that are not finite, a size or times out of range, or a path that cannot be written.
        InvalidType: not a recording, or not a belief.
        RenderingFailed: OpenGL cannot be used, or the process that draws died or hangs; nothing is written then.

    Example:
        >>> robot = dd.Robot.load("mismatched")
        >>> recording = dd.simulate(robot, dd.maneuvers.straight(robot, speed=0.5, distance=1.0))
        >>> dd.strobe(recording, robot, "paper.png", times=1)
        Traceback (most recent call last):
        ...
        diffdrive_mj.errors.InvalidValue: times = 1: must be at least 2
    """
    target = as_path("path", path)
    checks.member("camera", camera, _CAMERAS)
    checks.member("ending of a picture", target.suffix.lower(), _encoders.PICTURES)
    size = _shooting.checked_size(size)
    takes = _shooting.takes_of(recording, believed)
    groups = [
        Group(finding(take, title), take, take.at(_times(take, times)), (camera,)) for title, take in takes.items()
    ]
    sheet = Sheet(groups, size, _caption)
    job = _scene.Job(_shooting.scenes(groups, sheet, _scene.standing), _shooting.finer(size))
    with _shooting.written(target, job, sheet) as (new, sheets):
        _encoders.write_picture(new, next(sheets))
    return Film(target, 1, size, 0.0)


def _caption(whole: Take, seen: Take, _: int) -> list[Entry]:
    return legend(whole, seen)


def _times(take: Take, times: int | Sequence[float]) -> Array:
    """The times themselves, or some that are evenly apart along the path, where a turn on the spot counts too."""
    if not isinstance(times, Sequence | np.ndarray):
        count = checks.whole("times", times, least=2)
        if count > _MOST_TIMES:
            raise InvalidValue(f"times = {count}: must be at most {_MOST_TIMES}")
        turned = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(take.truth[:, 2])))])
        along = take.travelled + take.size * turned
        # A robot at rest passes no place; the times let its samples increase all the same.
        along = along + 1e-9 * (take.t - take.t[0])
        return np.interp(np.linspace(0, along[-1], count), along, take.t)
    moments = checks.array("times", times, "N")
    if moments.ndim != 1 or len(moments) > _MOST_TIMES:
        raise InvalidValue(f"times has shape {moments.shape}: must be (N,), at most {_MOST_TIMES} of them")
    outside = moments[(moments < take.t[0]) | (moments > take.t[-1])]
    if len(outside):
        raise InvalidValue(f"times has {outside[0]:g} s: must be on the drive, {take.t[0]:g} to {take.t[-1]:g} s")
    return moments
