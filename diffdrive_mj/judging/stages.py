"""An odometry in stages, so that any of them can be done wrong on purpose: from readings to answers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from diffdrive_mj._checks import Array
from diffdrive_mj.judging.readings import Mask, held, shortest
from diffdrive_mj.judging.tasks import Task

Change = Callable[[Array], Array]


@dataclass(frozen=True, eq=False)
class Stages:
    """Say what of an odometry is done in another way than the right one; what is None is done rightly.

    Args:
        counts: which readings are taken in (T,).
        wheels: what is read (K, 2), of the readings that are taken in.
        steps: the wheels' steps (K - 1, 2), of the readings' differences, in their unit.
        radii: left and right [m].
        motion: distances and turns, each (K - 1,), of the right ones and the seconds between readings.
        path: poses (K, 3), of distances and turns (K - 1, 2) and the pose that it starts from.
        start: the pose (3,) that it starts from.
        answer: what is answered (T, 3), of the poses.

    Example:
        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> task = Task("ahead", robot, [0.0, 1.0], [(0, 0), (10, 10)])
        >>> Stages().solve(task)[-1].tolist(), Stages(wheels=lambda read: -read).solve(task)[-1].tolist()
        ([1.0, 0.0, 0.0], [-1.0, 0.0, 0.0])
    """

    counts: Mask | None = None
    wheels: Change | None = None
    steps: Change | None = None
    radii: tuple[float, float] | None = None
    motion: Callable[[Array, Array, Array], tuple[Array, Array]] | None = None
    path: Callable[[Array, Array], Array] | None = None
    start: Array | None = None
    answer: Change | None = None

    def solve(self, task: Task) -> Array:
        """Answer a task (T, 3); all of it is NaN where the motion is not finite."""
        motion, start = self.moved(task), task.start if self.start is None else self.start
        if not np.isfinite(motion).all():
            return np.full((len(task.t), 3), np.nan)
        poses = held((self.path or arcs)(motion, start), self.counting(task))
        return poses if self.answer is None else self.answer(poses)

    def moved(self, task: Task) -> Array:
        """Distances [m] and turns [rad] between the readings that are taken in (K - 1, 2)."""
        counts = self.counting(task)
        read = task.raw[counts] if self.wheels is None else self.wheels(task.raw[counts])
        steps = np.diff(read, axis=0)
        steps = shortest(steps, task.bits) if self.steps is None else self.steps(steps)
        left, right = (steps * task.unit_angle * (self.radii or task.radii)).T
        motion = (left + right) / 2, (right - left) / task.robot.track_width
        with np.errstate(divide="ignore", invalid="ignore"):  # times that stand still
            return np.stack(self.motion(*motion, np.diff(task.t[counts])) if self.motion else motion, axis=-1)

    def counting(self, task: Task) -> Mask:
        """Which readings are taken in (T,)."""
        return task.counting if self.counts is None else self.counts

    def and_(self, other: Stages) -> Stages | None:
        """What both do in another way, this one first; None where only one of them can."""
        mine, theirs = self._changed(), other._changed()
        both = {**mine, **theirs}
        for name in mine.keys() & theirs.keys():
            if name not in ("wheels", "motion", "answer"):
                return None
            both[name] = _one_after_the_other(mine[name], theirs[name])
        return Stages(**both)

    def _changed(self) -> dict[str, Any]:
        own = {stage.name: getattr(self, stage.name) for stage in fields(self)}
        return {name: change for name, change in own.items() if change is not None}


def _one_after_the_other(first: Callable[..., Any], second: Callable[..., Any]) -> Callable[..., Any]:
    """Of changes of readings or answers, and of changes of motion, which also get the seconds."""

    def both(*given: Array) -> Any:
        return second(first(*given)) if len(given) == 1 else second(*first(*given), given[-1])

    return both


def arcs(motion: Array, start: Array) -> Array:
    """Follow exact arcs, as `odometry.accumulate` does; thousands of paths are tried, and none is checked.

    Args:
        motion: distances and turns (K - 1, 2) [m, rad].
        start: (3,).

    Returns:
        Poses (K, 3).

    Example:
        >>> arcs(np.array([[2.0, 0.0]]), np.zeros(3))[-1].tolist()
        [2.0, 0.0, 0.0]
    """
    length, half = motion[:, 0] * np.sinc(motion[:, 1] / (2 * np.pi)), motion[:, 1] / 2
    poses = np.empty((len(motion) + 1, 3))
    poses[0], poses[1:, 2] = start, motion[:, 1]
    np.cumsum(poses[:, 2], out=poses[:, 2])
    along = poses[:-1, 2] + half
    poses[1:, 0], poses[1:, 1] = length * np.cos(along), length * np.sin(along)
    np.cumsum(poses[:, :2], axis=0, out=poses[:, :2])
    return poses
