"""Well-known mistakes with times, with counters that wrap, and with readings that do not count."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from diffdrive_mj._checks import Array
from diffdrive_mj.judging.stages import Stages
from diffdrive_mj.judging.tasks import Task

_HOLD = "hold the pose, and let the next reading take the whole motion"


def of_readings(task: Task) -> dict[str, Stages]:
    """Make the mistakes that can show on the readings of a task.

    Args:
        task: on which they are made.

    Returns:
        The stages by what to say of them, from the plainest on.

    Example:
        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> next(iter(of_readings(Task("ahead", robot, [0.0, 1.0], [(0, 0), (10, 10)]))))
        'steps are speeds: multiply them by the time between readings'
    """
    wraps = {} if task.bits is None else dict(_wraps(task.bits))
    faults = {} if task.counting.all() else dict(_faults(task))
    narrow = {} if task.unit_angle == 1.0 else dict(_narrow())
    return {**_CLOCKS, **dict(_first_stamp(task)), **wraps, **narrow, **faults}


_CLOCKS = {
    "steps are speeds: multiply them by the time between readings": Stages(
        motion=lambda ds, turn, dt: (ds / dt, turn / dt)
    ),
    "a step's turn is its yaw rate: multiply it by the time between readings": Stages(
        motion=lambda ds, turn, dt: (ds, turn / dt)
    ),
    "a step's distance is its speed: multiply it by the time between readings": Stages(
        motion=lambda ds, turn, dt: (ds / dt, turn)
    ),
    "steps are multiplied by the time between readings, which the wheels' angles need not": Stages(
        motion=lambda ds, turn, dt: (ds * dt, turn * dt)
    ),
}


def _first_stamp(task: Task) -> Iterator[tuple[str, Stages]]:
    times = task.t[task.counting][:2]
    if len(times) == 2 and times[0] != 0:
        factor = times[1] / (times[1] - times[0])

        def motion(ds: Array, turn: Array, dt: Array) -> tuple[Array, Array]:
            first = np.where(np.arange(len(dt)) == 0, factor, 1.0)
            return ds * first, turn * first

        yield "the first step is timed from a stamp of zero: time it from the first reading", Stages(motion=motion)


def _wraps(bits: int) -> Iterator[tuple[str, Stages]]:
    """Counters at the ends of their range."""
    whole, half, cure = 2.0**bits, 2.0 ** (bits - 1), f"take steps modulo 2^{bits}, from -2^{bits - 1} on"
    yield f"wraps of the counter are not undone: {cure}", Stages(steps=lambda steps: steps)
    yield (
        f"wraps are undone forwards only: {cure}",
        Stages(steps=lambda steps: np.where(steps < -half, steps + whole, steps)),
    )
    yield (
        f"wraps are undone backwards only: {cure}",
        Stages(steps=lambda steps: np.where(steps > half, steps - whole, steps)),
    )
    yield f"steps are taken for unsigned ones: {cure}", Stages(steps=lambda steps: steps % whole)
    yield f"steps are taken for unsigned ones of 32 bits: {cure}", Stages(steps=lambda steps: steps % 2.0**32)
    yield (
        f"the motion across a wrap is left out: {cure}",
        Stages(steps=lambda steps: np.where(np.abs(steps) > half, 0.0, steps)),
    )
    for other in {8, 15, 16, 24, 31, 32} - {bits}:
        yield f"wraps are undone at {other} bits, the counter has {bits}: {cure}", _undone_at(other)


def _narrow() -> Iterator[tuple[str, Stages]]:
    """Counts that are kept in fewer bits than they need, and differences that are taken as they are."""
    for bits in (8, 16, 32):
        whole = 2.0**bits
        for kind, low in (("unsigned", 0.0), ("signed", -whole / 2)):
            yield (
                f"counts are kept in {bits} bits, {kind}: keep all of their bits",
                Stages(wheels=lambda read, whole=whole, low=low: (read - low) % whole + low, steps=lambda steps: steps),  # type: ignore[misc]
            )


def _undone_at(bits: int) -> Stages:
    half = 2.0 ** (bits - 1)
    return Stages(steps=lambda steps: (steps + half) % (2 * half) - half)


def _faults(task: Task) -> Iterator[tuple[str, Stages]]:
    """Readings that do not count, taken in all the same, or with a motion that is lost."""
    finite = np.isfinite(task.t) & np.isfinite(task.raw).all(axis=-1)
    latest = np.maximum.accumulate(np.where(finite, task.t, -np.inf))
    same = finite & (task.t >= latest)

    def without_stops(ds: Array, turn: Array, dt: Array) -> tuple[Array, Array]:
        return ds * (dt > 0), turn * (dt > 0)

    if (finite > task.counting).any():
        yield f"readings at the time of the one before are taken in: {_HOLD}", Stages(counts=same)
        yield f"readings are taken in whose time is not later than that of the last one: {_HOLD}", Stages(counts=finite)
        for counts in (same, finite):
            yield (
                f"the motion of readings at the time of the one before is lost: {_HOLD}",
                Stages(counts=counts, motion=without_stops),
            )
    across = np.diff(np.flatnonzero(task.counting)) == 1
    yield (
        f"the motion across readings that do not count is lost: {_HOLD}",
        Stages(counts=task.counting, motion=lambda ds, turn, dt: (ds * across, turn * across)),
    )
    if not np.isfinite(task.raw).all():
        zeros = np.isfinite(task.t) & (task.t > np.concatenate([[-np.inf], np.fmax.accumulate(task.t)[:-1]]))
        yield f"readings that are no numbers are taken for zero: {_HOLD}", Stages(counts=zeros, wheels=np.nan_to_num)
