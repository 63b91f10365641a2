"""Where the camera stands at each frame, and where in the picture it shows a point.

Angles are as MuJoCo's free camera has them: the azimuth is the direction in which the camera looks, the elevation
negative where it looks down.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from diffdrive_mj._checks import Array
from diffdrive_mj.report.filming._take import Take

CAMERAS = ("follow", "above", "oblique", "both")
# Fields of view [deg]: a wider one shows depth, a narrower one keeps lengths comparable.
_WIDE, _NARROW = 38.0, 22.0
_DOWN = -32.0
# How far around the robot the following camera still keeps the ghosts in the picture, in sizes of the robot.
_FAR = 6.0


@dataclass(frozen=True, eq=False)
class View:
    """A camera along the frames of a film.

    Attributes:
        position: (F, 3) [m].
        distance: (F,) to what it looks at [m].
        azimuth, elevation: (F,) [deg].
        fovy: vertical field of view [deg].
    """

    position: Array
    distance: Array
    azimuth: Array
    elevation: Array
    fovy: float

    def axes(self) -> tuple[Array, Array, Array]:
        """The directions to the right, up and forward (F, 3)."""
        return _axes(self.azimuth, self.elevation)

    def target(self) -> Array:
        """What it looks at (F, 3) [m]."""
        return self.position + self.distance[:, None] * self.axes()[2]

    def project(self, points: Array, size: tuple[int, int]) -> Array:
        """Where a picture of a size shows points (F, N, 3): pixels to the right and down (F, N, 2)."""
        seen = points - self.position[:, None]
        right, up, forward = (np.einsum("fnk,fk->fn", seen, axis) for axis in self.axes())
        scale = size[1] / 2 / np.tan(np.radians(self.fovy / 2))
        return np.stack([size[0] / 2 + scale * right / forward, size[1] / 2 - scale * up / forward], axis=-1)


def view(camera: str, wholes: Sequence[Take], seen: Take, aspect: float) -> View:
    """A camera by its name, for pictures of an aspect ratio, width / height; drives beside each other share one."""
    if camera == "follow":
        return follow(seen, aspect)
    return (above if camera == "above" else oblique)(wholes, len(seen.t), aspect)


def follow(seen: Take, aspect: float) -> View:
    """Keep the robot, and the ghosts that are near, in the picture; the direction stays, so that turns show."""
    size, count = seen.size, len(seen.t)
    places = [seen.truth[:, :2]]
    for poses in seen.ghosts.values():
        away = (poses - seen.truth)[:, :2]
        reach = np.maximum(np.hypot(*away.T), 1e-12)[:, None]
        places.append(places[0] + away * np.minimum(1.0, _FAR * size / reach))
    points = np.concatenate([_surroundings(place, 2.0 * size, seen.height) for place in places], axis=1)
    azimuth = np.full(count, np.degrees(seen.truth[0, 2]) + 40.0)
    return _fitted(points, azimuth, np.full(count, _DOWN), aspect, _WIDE)


def above(wholes: Sequence[Take], count: int, aspect: float) -> View:
    """See the whole drive from above, x to the right or up, whichever shows it larger."""
    return _still(_drives(wholes), count, [(90.0, -90.0), (0.0, -90.0)], aspect, _NARROW)


def oblique(wholes: Sequence[Take], count: int, aspect: float) -> View:
    """See the whole drive obliquely from above, from the side that shows it largest."""
    start = float(np.degrees(wholes[0].truth[0, 2]))
    sides = [(start + turn, -48.0) for turn in (65.0, 30.0, -30.0, -65.0, 115.0, -115.0)]
    return _still(_drives(wholes), count, sides, aspect, _NARROW)


def _drives(wholes: Sequence[Take]) -> Array:
    """Points around everything that drives cover (1, N, 3) [m]."""
    paths = [path for whole in wholes for path in (whole.truth, *whole.ghosts.values())]
    places = np.concatenate([path[:: max(1, len(path) // 200), :2] for path in paths] + [p[-1:, :2] for p in paths])
    size, height = (max(getattr(whole, side) for whole in wholes) for side in ("size", "height"))
    return _surroundings(places, size, height).reshape(1, -1, 3)


def _still(points: Array, count: int, sides: list[tuple[float, float]], aspect: float, fovy: float) -> View:
    """The nearest of some cameras that do not move; the first where another gains little."""
    views = [_fitted(points, np.array([a]), np.array([e]), aspect, fovy) for a, e in sides]
    distances = [float(view.distance[0]) * (1.0 if k == 0 else 1.15) for k, view in enumerate(views)]
    best = views[int(np.argmin(distances))]
    azimuth, elevation, distance = (np.repeat(x, count) for x in (best.azimuth, best.elevation, best.distance))
    return View(np.repeat(best.position, count, axis=0), distance, azimuth, elevation, fovy)


def _surroundings(places: Array, radius: float, height: float) -> Array:
    """The corners of boxes around places on the floor (N, 2): (N, 8, 3) [m]."""
    corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (0, 1)]) * (0.8 * radius, 0.8 * radius, 1)
    corners[:, 2] *= height
    return np.pad(places, ((0, 0), (0, 1)))[:, None] + corners


def _axes(azimuth: Array, elevation: Array) -> tuple[Array, Array, Array]:
    a, e = np.radians(azimuth), np.radians(elevation)
    forward = np.stack([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)], axis=-1)
    right = np.stack([np.sin(a), -np.cos(a), np.zeros_like(a)], axis=-1)
    return right, np.cross(right, forward), forward


def _fitted(points: Array, azimuth: Array, elevation: Array, aspect: float, fovy: float) -> View:
    """The nearest camera of some directions that has all of the points (F, N, 3) in its picture.

    A point is in the picture if it is on the inner side of the four planes through the camera, of slopes tan(fov / 2).
    """
    axes = _axes(azimuth, elevation)
    right, up, forward = (np.einsum("fnk,fk->fn", points, axis) for axis in axes)
    slope_up = np.tan(np.radians(fovy / 2)) * 0.94  # room at the borders
    slope_right = slope_up * aspect
    middle, backs = [], []
    for across, slope in ((right, slope_right), (up, slope_up)):
        high, low = (across - slope * forward).max(axis=1), (-across - slope * forward).max(axis=1)
        middle.append((high - low) / 2)
        backs.append(-(high + low) / (2 * slope))
    back = np.minimum(*backs)
    position = middle[0][:, None] * axes[0] + middle[1][:, None] * axes[1] + back[:, None] * axes[2]
    distance = (forward.min(axis=1) + forward.max(axis=1)) / 2 - back
    return View(position, distance, azimuth, elevation, fovy)
