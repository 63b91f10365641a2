"""Well-known mistakes of odometry: what to say of each, with its cure, and the stages of an odometry that makes it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from diffdrive_mj import se2
from diffdrive_mj._checks import Array
from diffdrive_mj.judging._mistakes_of_readings import of_readings
from diffdrive_mj.judging.readings import shortest
from diffdrive_mj.judging.stages import Stages
from diffdrive_mj.judging.tasks import Task
from diffdrive_mj.odometry import accumulate

_DEGREE = math.pi / 180


def mistakes_on(task: Task) -> dict[str, Stages]:
    """Make the mistakes that can show on a task.

    Args:
        task: on which they are made.

    Returns:
        The stages by what to say of them, from the plainest on.

    Example:
        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> next(iter(mistakes_on(Task("ahead", robot, [0.0, 1.0], [(0, 0), (10, 10)]))))
        'steps are taken along the heading before them (Euler): use the exact arc'
    """
    return {**_PATHS, **dict(_starts(task)), **_WHEELS, **dict(_numbers(task)), **_MOTIONS, **_ANSWERS,
            **of_readings(task)}  # fmt: skip


def _of_arc(turn: Array) -> Array:
    return 1.0 + 0.0 * turn


def _of_chord(turn: Array) -> Array:
    return se2.sinc(turn / 2)


def _along(direction: Callable[[Array, Array], Array], length: Callable[[Array], Array] = _of_chord) -> Stages:
    """Steps along directions that go by the heading before them and the turn, as long as so much of the arc."""

    def path(motion: Array, start: Array) -> Array:
        distance, turn = motion.T
        heading = start[2] + np.concatenate([[0.0], np.cumsum(turn)])
        along = direction(heading[:-1], turn)
        far = distance * length(turn)
        steps = np.stack([far * np.cos(along), far * np.sin(along)], axis=-1)
        return np.column_stack([start[:2] + np.cumsum(np.vstack([np.zeros(2), steps]), axis=0), heading])

    return Stages(path=path)


_PATHS = {
    "steps are taken along the heading before them (Euler): use the exact arc": _along(
        lambda before, turn: before, length=_of_arc
    ),
    "steps are chords as long as their arcs (midpoint): use the exact arc": _along(
        lambda before, turn: before + turn / 2, length=_of_arc
    ),
    "steps are taken along the heading after them: use the exact arc": _along(
        lambda before, turn: before + turn, length=_of_arc
    ),
    "steps are taken along the mean of the directions before and after them (trapezoid): use the exact arc": _along(
        lambda before, turn: before + turn / 2, length=lambda turn: np.cos(turn / 2)
    ),
    "headings on both sides of 180 degrees are averaged: add half of the turn to the heading before": _along(
        lambda before, turn: (se2.wrap_angle(before) + se2.wrap_angle(before + turn)) / 2
    ),
    "headings on both sides of zero degrees are averaged: add half of the turn to the heading before": _along(
        lambda before, turn: (before % (2 * math.pi) + (before + turn) % (2 * math.pi)) / 2
    ),
    "sine and cosine are exchanged: x takes the cosine of theta, y the sine": _along(
        lambda before, turn: math.pi / 2 - before - turn / 2
    ),
    "y grows to the right: it grows to the left": _along(lambda before, turn: -before - turn / 2),
    "sine and cosine get degrees: give them radians": _along(lambda before, turn: (before + turn / 2) / _DEGREE),
}


def _starts(task: Task) -> Iterator[tuple[str, Stages]]:
    """Where the path begins."""
    for words, kept in {
        "the start pose is forgotten: begin at x, y and theta of the header": (0, 0, 0),
        "the heading at the start is forgotten": (1, 1, 0),
        "the position at the start is forgotten": (0, 0, 1),
        "the heading at the start is taken for degrees": (1, 1, _DEGREE),
    }.items():
        yield words, Stages(start=task.start * kept)
    yield (
        "the path is not turned by the heading at the start: begin with that heading",
        Stages(start=np.zeros(3), answer=lambda poses: poses + task.start),
    )
    left, right = shortest(task.raw[task.counting][0], task.bits) * task.unit_angle * task.radii
    first = np.array([((left + right) / 2, (right - left) / task.robot.track_width)])
    yield (
        "the first reading is taken for motion since zero: it is where the wheels begin",
        Stages(start=accumulate(first, "arc", task.start)[-1]),
    )
    for words, own in {
        "the heading is not carried from step to step: add each turn to it": task.start[2],
        "steps are taken along their own turn alone: add it to the heading before": 0.0,
    }.items():
        yield words, _along(lambda before, turn, own=own: own + turn / 2, length=_of_arc)  # type: ignore[misc]


def _mixed(left: tuple[int, int], right: tuple[int, int]) -> Stages:
    """Wheels that are read as sums of the true ones."""
    return Stages(wheels=lambda read: read @ np.array([left, right], dtype=float).T)


_WHEELS = {
    "left and right are swapped": _mixed((0, 1), (1, 0)),
    "the left wheel counts backwards": _mixed((-1, 0), (0, 1)),
    "the right wheel counts backwards": _mixed((1, 0), (0, -1)),
    "both wheels count backwards": _mixed((-1, 0), (0, -1)),
    "the left wheel is read for both": _mixed((1, 0), (1, 0)),
    "the right wheel is read for both": _mixed((0, 1), (0, 1)),
    "the left wheel's readings are one behind the right one's": Stages(
        wheels=lambda read: np.column_stack([np.concatenate([read[:1, 0], read[:-1, 0]]), read[:, 1]])
    ),
    "the right wheel's readings are one behind the left one's": Stages(
        wheels=lambda read: np.column_stack([read[:, 0], np.concatenate([read[:1, 1], read[:-1, 1]])])
    ),
    "readings are taken in single precision: keep them in double precision": Stages(
        wheels=lambda read: read.astype(np.float32).astype(np.float64)
    ),
}


def _numbers(task: Task) -> Iterator[tuple[str, Stages]]:
    """Mistakes that go by the robot's numbers."""
    left, right = task.radii
    if left != right:
        mean = (left + right) / 2
        for words, radii in {
            "both wheels are taken for the left one: their radii differ": (left, left),
            "both wheels are taken for the right one: their radii differ": (right, right),
            "both wheels are taken for the mean one: their radii differ": (mean, mean),
            "the radii of left and right are exchanged": (right, left),
        }.items():
            yield words, Stages(radii=radii)
    turn, ticks = 2 * math.pi / task.unit_angle, task.ticks_per_revolution
    for what, unit in {"turns": turn, "radians": 1.0 / task.unit_angle, "degrees": turn / 360}.items():
        yield (
            f"what the wheels have turned is cut to whole {what} (integer division): keep the fraction",
            Stages(wheels=lambda read, unit=unit: unit * np.trunc(read / unit)),  # type: ignore[misc]
        )
    if task.unit_angle != 1.0 and ticks != int(ticks):
        yield (
            "the ticks of a turn are cut to a whole number: keep the fraction",
            Stages(radii=(left * ticks / int(ticks), right * ticks / int(ticks))),
        )
    half = task.robot.track_width / 2
    for words, change in {
        "the way of the left wheel is taken for the robot's: take the mean": lambda ds, turn, dt: (
            ds - turn * half,
            turn,
        ),
        "the way of the right wheel is taken for the robot's: take the mean": lambda ds, turn, dt: (
            ds + turn * half,
            turn,
        ),
    }.items():
        yield words, Stages(motion=change)

    def cut_rims(ds: Array, turn: Array, dt: Array) -> tuple[Array, Array]:
        left, right = (np.trunc(way * 1e3) / 1e3 for way in (ds - turn * half, ds + turn * half))
        return (left + right) / 2, (right - left) / half / 2

    yield (
        "each way of a wheel is cut to whole millimetres: keep the rest for the next reading",
        Stages(motion=cut_rims),
    )


def _cut(cut: Callable[[Array], Array], distance: float, turn: float) -> Stages:
    """Steps whose distance and turn are whole numbers of something, or not cut where that is zero."""
    return Stages(
        motion=lambda ds, dtheta, dt: (
            cut(ds / distance) * distance if distance else ds,
            cut(dtheta / turn) * turn if turn else dtheta,
        )
    )


_MOTIONS = {
    "it turns clockwise where the wheels turn it counter-clockwise: theta is (right - left) / track": Stages(
        motion=lambda ds, turn, dt: (ds, -turn)
    ),
    "backwards is taken for forwards: distances have a sign": Stages(motion=lambda ds, turn, dt: (np.abs(ds), turn)),
    "a turn is its arc tangent, a formula for small angles: it is (right - left) / track": Stages(
        motion=lambda ds, turn, dt: (ds, np.arctan(turn))
    ),
    "a turn is its sine, a formula for small angles: it is (right - left) / track": Stages(
        motion=lambda ds, turn, dt: (ds, np.sin(turn))
    ),
    "a turn is its tangent: it is (right - left) / track": Stages(motion=lambda ds, turn, dt: (ds, np.tan(turn))),
    "each turn is cut to whole degrees: keep the rest for the next reading": _cut(np.trunc, 0, _DEGREE),
    "each turn is rounded to whole degrees: keep the rest for the next reading": _cut(np.round, 0, _DEGREE),
    "each distance is cut to whole millimetres: keep the rest for the next reading": _cut(np.trunc, 1e-3, 0),
    "each distance is rounded to whole millimetres: keep the rest for the next reading": _cut(np.round, 1e-3, 0),
}


def _scaled(x: float, y: float, theta: float) -> Stages:
    """Answers in other units, or of other signs."""
    return Stages(answer=lambda poses: poses * (x, y, theta))


def _shifted(by: int) -> Stages:
    """Answers that come later by some readings; the first or the last stays."""
    return Stages(answer=lambda poses: poses[np.clip(np.arange(len(poses)) - by, 0, len(poses) - 1)])


_ANSWERS = {
    "each pose is that of the reading before: take a reading in, then answer": _shifted(1),
    "each pose is that of the reading after": _shifted(-1),
    "headings have the wrong sign": _scaled(1, 1, -1),
    "x has the wrong sign": _scaled(-1, 1, 1),
    "y has the wrong sign": _scaled(1, -1, 1),
    "x and y are exchanged": Stages(answer=lambda poses: poses[:, [1, 0, 2]]),
    "headings are bearings, clockwise from y: give theta, counter-clockwise from x": Stages(
        answer=lambda poses: np.column_stack([poses[:, :2], math.pi / 2 - poses[:, 2]])
    ),
}
