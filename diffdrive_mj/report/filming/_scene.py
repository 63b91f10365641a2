"""What one picture holds, as plain data that goes to the process which draws it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from diffdrive_mj._checks import Array
from diffdrive_mj.report.filming import _ground
from diffdrive_mj.report.filming._cameras import View
from diffdrive_mj.report.filming._take import Take
from diffdrive_mj.report.filming._trails import corners
from diffdrive_mj.robot import Robot
from diffdrive_mj.se2 import wrap_angle

Rgb = tuple[float, float, float]
# The robot's own blue, as models/diffdrive.xml has it; and for ghosts colours that stand off from it.
TRUE: Rgb = (0.16, 0.34, 0.55)
GHOSTS: tuple[Rgb, ...] = (
    (0.95, 0.46, 0.05), (0.00, 0.62, 0.45), (0.80, 0.40, 0.65), (0.90, 0.75, 0.10), (0.30, 0.70, 0.90)
)  # fmt: skip
LINK: Rgb = (0.45, 0.47, 0.50)


@dataclass(frozen=True, eq=False)
class Actor:
    """A robot that is seen, or its ghost.

    Attributes:
        poses: (F, 3) [m, m, rad].
        wheel_angles: (F, 2) [rad].
        ghost: its colour; None for the robot itself.
        apart: (F,), from 0 where a ghost is at the robot's own place to 1 where it stands beside it.
        stance: (F, 5), its height [m] and its attitude as a quaternion; None where it stands level on the floor.
        fork: (F,) [rad], of a swivel caster, from where it was at the start; None where it is not known.
    """

    poses: Array
    wheel_angles: Array
    ghost: Rgb | None = None
    apart: Array = field(default_factory=lambda: np.ones(1))
    stance: Array | None = None
    fork: Array | None = None


@dataclass(frozen=True, eq=False)
class Trail:
    """A path on the floor, drawn as far as it has been driven.

    Attributes:
        points: (N, 2) [m].
        times: (N,) at which it comes there [s].
        tips: (F, 2), where it ends at each frame [m].
        width: [m].
        height: above the floor [m].
        colour: of it.
    """

    points: Array
    times: Array
    tips: Array
    width: float
    height: float
    colour: Rgb


@dataclass(frozen=True, eq=False)
class Link:
    """A thin line on the floor from a robot to its ghost: ends (F, 2, 2) [m]."""

    ends: Array
    width: float
    height: float
    colour: Rgb = LINK


@dataclass(frozen=True, eq=False)
class Scene:
    """A picture, or what one camera sees along a film.

    Attributes:
        robot: what all actors look like.
        actors: robots and ghosts.
        trails: on the floor.
        links: on the floor.
        ground: what lies on the floor.
        square: the side of the floor's squares [m].
        levels: of the deepest hollow, where the floor around lies, and of the highest crest, above which all is drawn
            that lies on the floor [m].
        shade: how high shadows lie, on what is on the floor and below lines and trails [m].
        view: the camera, frame by frame.
        times: (F,) [s].
        size: width and height [pixel].
    """

    robot: Robot
    actors: tuple[Actor, ...]
    trails: tuple[Trail, ...]
    links: tuple[Link, ...]
    ground: tuple[_ground.Shape, ...]
    square: float
    levels: tuple[float, float]
    shade: float
    view: View
    times: Array
    size: tuple[int, int]


@dataclass(frozen=True)
class Job:
    """Scenes that are drawn beside each other, frame by frame; `smooth` is how often finer they are drawn first."""

    scenes: tuple[Scene, ...] = field(default=())
    smooth: int = 1

    @property
    def frames(self) -> int:
        """How many."""
        return len(self.scenes[0].times)


def square_side(size: float) -> float:
    """The side of the floor's squares for a robot of a size: 1, 2 or 5 times a power of ten [m]."""
    wanted = 1.3 * size
    power = 10.0 ** math.floor(math.log10(wanted))
    return next(step * power for step in (5.0, 2.0, 1.0) if step * power <= wanted)


def moving(whole: Take, seen: Take, view: View, size: tuple[int, int]) -> Scene:
    """The robot and its ghosts as they drive."""
    return _scene(whole, seen, [seen], view, size)


def standing(whole: Take, seen: Take, view: View, size: tuple[int, int]) -> Scene:
    """The robot and its ghosts at several times in one picture."""
    poses = np.stack([seen.truth, *seen.ghosts.values()])
    apart = poses[:, :, None] - poses[:, None]
    apart[..., 2] = wrap_angle(apart[..., 2]) * whole.size
    near = np.abs(apart).max(axis=0) < 0.1 * whole.size
    # Back at an earlier place: two robots in one would only flicker.
    places = [k for k in range(len(seen.t)) if not near[k, k + 1 :].all(axis=-1).any()]
    return _scene(whole, whole.at(whole.t[-1:]), [seen.at(seen.t[k : k + 1]) for k in places], view, size)


def _scene(whole: Take, seen: Take, standing: list[Take], view: View, size: tuple[int, int]) -> Scene:
    """The trails as far as they are seen, and robots with their ghosts where they stand."""
    unit, side = whole.size, square_side(whole.size)
    # OpenGL counts in single precision: what is far from the origin is drawn near it, on the same squares of the floor.
    x, y = (-2 * side * np.round(whole.truth[0, :2] / (2 * side))).tolist()
    whole, seen, standing = whole.moved(x, y), seen.moved(x, y), [take.moved(x, y) for take in standing]
    view = replace(view, position=view.position + np.array((x, y, 0.0)))
    shapes = _ground.ground(whole.world, unit)
    actors = [Actor(take.truth, take.wheel_angles, stance=take.stance, fork=take.fork) for take in standing]
    links = []
    for take in standing:
        for poses, distance, colour in zip(take.ghosts.values(), take.apart.values(), GHOSTS, strict=False):
            actors.append(Actor(poses, take.wheel_angles, colour, np.minimum(1.0, distance / unit), fork=take.fork))
            ends = np.stack([take.truth[:, :2], poses[:, :2]], axis=1)
            links.append(Link(ends, 0.02 * unit, 0.009 * unit))
    paths = [(TRUE, whole.truth, seen.truth)]
    paths += [(GHOSTS[k], whole.ghosts[name], poses) for k, (name, poses) in enumerate(seen.ghosts.items())]
    trails = [_trail(whole.t, path, tips, colour, unit, k) for k, (colour, path, tips) in enumerate(paths)]
    return Scene(
        robot=whole.robot,
        actors=tuple(actors),
        trails=tuple(trails),
        links=tuple(links),
        ground=tuple(shape.moved(x, y) for shape in shapes),
        square=side,
        levels=_ground.levels(shapes),
        shade=0.0085 * unit,
        view=view,
        times=seen.t,
        size=size,
    )


def _trail(t: Array, path: Array, tips: Array, colour: Rgb, unit: float, index: int) -> Trail:
    """The later ones are narrower and higher, so that each shows where two coincide."""
    kept = corners(path[:, :2], 0.003 * unit)
    width = unit * 0.1 * 0.5**index
    return Trail(path[kept, :2], t[kept], tips[:, :2], width, unit * (0.012 + 0.004 * index), colour)
