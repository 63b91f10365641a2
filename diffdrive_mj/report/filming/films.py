"""Films of a drive: the robot, and the ghost of where it believes it is."""

from __future__ import annotations

import base64
import functools
import html
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj._files import as_path
from diffdrive_mj._text import quantity
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.report.filming import _cameras, _encoders, _scene, _shooting
from diffdrive_mj.report.filming._captions import caption
from diffdrive_mj.report.filming._sheet import Group, Sheet
from diffdrive_mj.report.filming._shooting import Shown
from diffdrive_mj.report.filming._take import Believed, Take

_MOST_FRAMES = 20_000


@dataclass(frozen=True)
class Film:
    """Says what has been written; a notebook shows it.

    Attributes:
        path: of the file.
        frames: how many; 1 for a picture.
        size: width and height [pixel].
        seconds: how long it runs.

    Example:
        >>> print(Film(Path("film.webp"), 250, (640, 480), 10.0))
        film.webp: 250 frames of 640 x 480, 10 s
    """

    path: Path
    frames: int
    size: tuple[int, int]
    seconds: float

    def __str__(self) -> str:
        width, height = self.size
        if self.frames == 1:
            return f"{self.path}: {width} x {height}"
        return f"{self.path}: {self.frames} frames of {width} x {height}, {self.seconds:.3g} s"

    def _repr_html_(self) -> str:
        ending = self.path.suffix.lower()[1:]
        if not self.path.is_file():
            return f"<p>{html.escape(str(self))} (no longer there)</p>"
        data = base64.b64encode(self.path.read_bytes()).decode()
        if ending == "mp4":
            return f'<video controls loop src="data:video/mp4;base64,{data}"></video>'
        return f'<img alt="{html.escape(str(self), quote=True)}" src="data:image/{ending};base64,{data}">'


def film(
    recording: Shown,
    believed: Believed,
    path: str | Path,
    *,
    camera: str = "follow",
    size: tuple[int, int] = (640, 480),
    fps: float = 25.0,
    speed: float = 1.0,
    time: float | None = None,
) -> Film:
    """Film a drive: the robot as it drove, and translucent ghosts of where odometry believed it to be.

    The wheels turn as recorded. Below the pictures stand the time, the speed ratio k (left rate / right rate) where it
    is the same along the whole drive, and how far each ghost is from the robot. It is drawn by OpenGL in a process of
    its own, without a screen.

    Args:
        recording: of one robot; or a `Drive` of a log, seen at its true poses, which looks like the first robot that is
            believed; or several by their titles, which are shown beside each other.
        believed: the robot that the odometry takes it for; or a list of such robots; or a mapping from names to robots
            or to poses (T, 3) [m, m, rad] at the recorded times, those of the true poses of a `Drive`.
        path: of the file: .webp for an animation, .mp4 if ffmpeg is installed, .png for a single picture.
        camera: "follow"; "above" or "oblique", which see the whole drive; or "both", follow and above.
        size: width and height [pixel].
        fps: frames per second of the film.
        speed: how many seconds of the drive pass in a second of the film.
        time: of a single picture [s]; by default the end of the drive.

    Returns:
        What was written.

    Raises:
        UnknownName: another camera or ending.
        InvalidValue: a recording of several runs or of fewer than two samples, true poses more than a second apart,
            poses that are not finite, a size, rate or time out of range, or a path that cannot be written.
        InvalidType: not a recording, or not a belief.
        MissingFile: an .mp4 without ffmpeg.
        RenderingFailed: OpenGL cannot be used, or the process that draws died or hangs; nothing is written then.

    Example:
        >>> robot = dd.Robot.load("mismatched")
        >>> recording = dd.simulate(robot, dd.maneuvers.straight(robot, speed=0.5, distance=1.0))
        >>> believed = robot.replace(right_radius=robot.left_radius)  # takes the wheels for equal
        >>> dd.film(recording, believed, "film.avi")
        Traceback (most recent call last):
        ...
        diffdrive_mj.errors.UnknownName: unknown ending of a film '.avi': choose from .mp4, .png, .webp
    """
    target = as_path("path", path)
    checks.member("camera", camera, _cameras.CAMERAS)
    ending = checks.member("ending of a film", target.suffix.lower(), (*_encoders.FILMS, ".png"))
    size, fps, speed = _shooting.checked_size(size), _checked_rate(fps), checks.positive("speed", speed)
    still = ending == ".png"
    if time is not None and not still:
        raise InvalidValue(f"time = {time!r}: is that of a single picture, whose path ends on .png")
    takes = _shooting.takes_of(recording, believed)
    times = [_moment(take, time) for take in takes.values()] if still else _moments([*takes.values()], fps, speed)
    cameras = ("follow", "above") if camera == "both" else (camera,)
    groups = [
        Group(title, take, take.at(when), cameras) for (title, take), when in zip(takes.items(), times, strict=True)
    ]
    _encoders.refuse_missing_encoder(target)
    sheet = Sheet(groups, size, functools.partial(caption, speed=1.0 if still else speed))
    job = _scene.Job(_shooting.scenes(groups, sheet, _scene.moving), _shooting.finer(size) if still else 1)
    with _shooting.written(target, job, sheet) as (new, sheets):
        if still:
            _encoders.write_picture(new, next(sheets))
        else:
            _encoders.write_film(new, sheets, fps)
    count = len(times[0])
    return Film(target, count, size, 0.0 if still else count / fps)


def _checked_rate(fps: float) -> float:
    rate = checks.positive("fps", fps)
    if not 0.1 <= rate <= 120:
        raise InvalidValue(f"fps = {rate:g}: must be between 0.1 and 120 frames per second")
    return rate


def _moment(take: Take, time: float | None) -> Array:
    """The time of a single picture."""
    first, last = float(take.t[0]), float(take.t[-1])
    when = last if time is None else checks.number("time", time)
    if not first <= when <= last:
        raise InvalidValue(f"time = {when:g} s: must be on the drive, {first:g} to {last:g} s")
    return np.array([when])


def _moments(takes: list[Take], fps: float, speed: float) -> list[Array]:
    """The times of the frames in each drive; one that is over sooner waits at its end."""
    longest = max(float(take.t[-1] - take.t[0]) for take in takes)
    count = longest * fps / speed
    if count < 1:
        raise InvalidValue(
            f"fps = {fps:g}, speed = {speed:g}: leave a single frame of a drive of {quantity(longest, 's')}; must be a "
            f"larger fps, or a speed of at most {longest * fps:.3g}"
        )
    if count > _MOST_FRAMES:
        raise InvalidValue(
            f"a drive of {longest:g} s has {count:.3g} frames: must be at most {_MOST_FRAMES}; film recording.during"
            "(start, end), or with a larger speed"
        )
    since = np.arange(int(count + 1e-9) + 1) * speed / fps
    return [np.minimum(take.t[0] + since, take.t[-1]) for take in takes]
