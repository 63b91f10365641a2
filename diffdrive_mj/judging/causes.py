"""Why an odometry is wrong, in words: which well-known mistake, made on purpose, answers as it does."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from diffdrive_mj import se2
from diffdrive_mj._checks import Array
from diffdrive_mj.judging._fits import digits, fitted
from diffdrive_mj.judging.mistakes import mistakes_on
from diffdrive_mj.judging.stages import Stages
from diffdrive_mj.judging.tasks import Task

# A mistake explains an answer that it comes this many times as close to as the right poses do; two at once need more.
_EXPLAINED, _BOTH_EXPLAINED = 50.0, 1000.0
# How many mistakes, those that come closest, are tried together with any other.
_NEAREST = 8
# Explanations that are as good as the best one.
_AS_GOOD = 3.0


def likely_reason(task: Task, poses: Array) -> str:
    """Say what is most likely wrong with poses that are not those of exact odometry.

    Args:
        task: that was solved.
        poses: as answered (T, 3) [m, m, rad].

    Returns:
        The mistake, and what cures it; "" if none that is known explains the poses.

    Example:
        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> t = np.arange(0.0, 10.0, 0.1)
        >>> task = Task("bend", robot, t, np.stack([5 * t, 6 * t], axis=-1), start=(1.0, 2.0, 0.5))
        >>> likely_reason(task, dd.odometry.integrate(task.wheel_angles, robot))
        'the start pose is forgotten: begin at x, y and theta of the header'
    """
    return next(iter(likely_reasons(task, poses)), "")


def likely_reasons(task: Task, poses: Array) -> tuple[str, ...]:
    """Say all that explains poses equally well, the plainest first: on a straight line many mistakes look alike.

    Args:
        task: that was solved.
        poses: as answered (T, 3) [m, m, rad].

    Returns:
        The mistakes; empty if none that is known explains the poses.

    Example:
        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> task = Task("ahead", robot, [0.0, 1.0, 2.0], [(0, 0), (10, 10), (20, 20)])
        >>> for reason in likely_reasons(task, task.expected * (2, 2, 1))[:2]:
        ...     print(reason)
        wheels roll 2 times the right way (diameters for radii)
        distances are 2 times the right ones (a sum where the mean belongs)
    """
    right = task.expected
    wrong = distance_between(task, poses, right)
    made = mistakes_on(task)
    single = [(_off(task, poses, stages.solve(task)), words) for words, stages in made.items()]
    single += [(_off(task, poses, answer), words) for words, answer in fitted(task, poses, Stages())]
    best = min(off for off, _ in single)
    if best <= task.allowed:
        return _good(single, wrong / _EXPLAINED, task)
    if (poses == poses[0]).all() and not (right == right[0]).all():
        return ("all answers are the same pose: take each reading in",)
    if said := digits(poses):
        return (said,)
    both = _good(list(_pairs(task, poses, made, single)), min(best / _EXPLAINED, wrong / _BOTH_EXPLAINED), task)
    return both or _good(single, wrong / _EXPLAINED, task)


def _good(found: list[tuple[float, str]], most: float, task: Task) -> tuple[str, ...]:
    """The words of what comes closest, and of what comes as close but for rounding."""
    best = min((off for off, _ in found), default=np.inf)
    if not best < most:
        return ()
    return tuple(words for off, words in found if off <= min(most, max(_AS_GOOD * best, task.allowed)))


def _pairs(
    task: Task, poses: Array, made: dict[str, Stages], single: list[tuple[float, str]]
) -> Iterator[tuple[float, str]]:
    """Two mistakes at once: those that come closest alone, each with any other."""
    nearest = [words for _, words in sorted(single) if words in made][:_NEAREST]
    for k, first in enumerate(nearest):
        for second, stages in made.items():
            both = made[first].and_(stages) if second not in nearest[: k + 1] else None
            if both is not None:
                yield _off(task, poses, both.solve(task)), f"{first}; and {second}"
    # What goes with a factor may be far from the answers without it.
    for first, stages in made.items():
        if first in nearest or stages.path is not None or stages.radii is not None:
            for words, answer in fitted(task, poses, stages):
                yield _off(task, poses, answer), f"{first}; and {words}"


def _off(task: Task, poses: Array, answer: Array) -> float:
    return distance_between(task, poses, answer) if np.isfinite(answer).all() else np.inf


def reason_of_failure(task: Task, reading: int | None) -> str:
    """Say why an odometry raised or answered no numbers at a reading.

    Args:
        task: on which it did.
        reading: the index of the reading; None where it is not known.

    Returns:
        The mistake, and what cures it; "" unless a reading that does not count came before.

    Example:
        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> reason_of_failure(Task("still", robot, [0.0, 0.0], [(0, 0), (1, 1)]), 1)
        'a reading that does not count is taken in (its time is not later than the one before): hold the pose'
    """
    bad = np.flatnonzero(~task.counting[: 0 if reading is None else reading + 1])
    if not bad.size:
        return ""
    lost = not np.isfinite([task.t[bad[-1]], *task.raw[bad[-1]]]).all()
    what = "it is not a number" if lost else "its time is not later than the one before"
    return f"a reading that does not count is taken in ({what}): hold the pose"


def distance_between(task: Task, a: Array, b: Array) -> float:
    """How far two paths are apart at most [m]; a heading counts as the way of a wheel about the axle's midpoint.

    Example:
        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> task = Task("still", robot, [0.0, 1.0], np.zeros((2, 2)))
        >>> distance_between(task, np.zeros((2, 3)), [(0, 0, 0), (0, 0.1, 2 * np.pi)])
        0.1
    """
    gap = np.asarray(a) - np.asarray(b)
    turn = np.abs(se2.wrap_angle(gap[:, 2])) * task.robot.track_width / 2
    return float(np.hypot(np.hypot(gap[:, 0], gap[:, 1]), turn).max())
