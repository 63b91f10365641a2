"""Why an odometry is wrong, in words: which well-known mistake, made on purpose, answers as it does."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from diffdrive_mj import se2
from diffdrive_mj._checks import Array
from diffdrive_mj.judging.tasks import Task
from diffdrive_mj.kinematics import body_twist
from diffdrive_mj.odometry import accumulate, integrate

# A mistake explains an answer that it comes this many times as close to as the right poses do.
_EXPLAINED = 50.0


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
    if np.array_equal(poses.astype(np.float32), poses):
        return "the answers are in single precision: add up in double precision"
    wrong = distance_between(task, poses, task.expected)
    best, words = wrong / _EXPLAINED, ""
    for said, answer in _mistakes(task, poses):
        off = distance_between(task, poses, answer)
        if off < best:
            best, words = off, said
    return words


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


def _mistakes(task: Task, poses: Array) -> Iterator[tuple[str, Array]]:
    """What each mistake answers to a task, from the plainest on."""
    robot, start, angles = task.robot, task.start, task.wheel_angles
    motion = body_twist(np.diff(angles, axis=0), robot)

    def along(steps: Array, first: Array = start, method: str = "arc") -> Array:
        return accumulate(steps, method, first)  # type: ignore[arg-type]

    yield "steps are taken along the heading before them (Euler): use the exact arc", along(motion, method="euler")
    yield "steps are chords as long as their arcs (midpoint): use the exact arc", along(motion, method="midpoint")
    yield "the start pose is forgotten: begin at x, y and theta of the header", along(motion, np.zeros(3))
    yield "the heading at the start is forgotten", along(motion, start * (1, 1, 0))
    yield "the position at the start is forgotten", along(motion, start * (0, 0, 1))
    flips: dict[str, Callable[[Array], Array]] = {
        "left and right are swapped": lambda a: a[:, ::-1],
        "the left wheel counts backwards": lambda a: a * (-1, 1),
        "the right wheel counts backwards": lambda a: a * (1, -1),
        "both wheels count backwards": lambda a: -a,
    }
    for words, flip in flips.items():
        yield words, integrate(flip(angles), robot, start=start)
    yield (
        "it turns clockwise where the wheels turn it counter-clockwise: theta is (right - left) / track",
        along(motion * (1, -1)),
    )
    left, right = robot.left_radius, robot.right_radius
    if left != right:
        for words, radius in (("left", left), ("right", right), ("mean", (left + right) / 2)):
            same = robot.replace(left_radius=radius, right_radius=radius)
            yield f"both wheels are taken for the {words} one: their radii differ", integrate(angles, same, start=start)
        exchanged = robot.replace(left_radius=right, right_radius=left)
        yield "the radii of left and right are exchanged", integrate(angles, exchanged, start=start)
    yield "each pose is that of the reading before: take a reading in, then answer", _shifted(task.expected, 1)
    yield "each pose is that of the reading after", _shifted(task.expected, -1)
    yield "headings are in degrees: give radians", task.expected * (1, 1, 180 / math.pi)
    yield from _factors(task, poses, motion)


def _shifted(poses: Array, by: int) -> Array:
    """Poses that come later by some readings; the first or the last stays."""
    index = np.clip(np.arange(len(poses)) - by, 0, len(poses) - 1)
    return poses[index]


def _factors(task: Task, poses: Array, motion: Array) -> Iterator[tuple[str, Array]]:
    """Distances and turns that are all wrong by a factor, as of diameters for radii, or a track that is left out."""
    turned, length = se2.wrap_angle(np.diff(poses[:, 2])), np.hypot(*np.diff(poses[:, :2], axis=0).T)
    turn = _ratio(turned, motion[:, 1])
    far = _ratio(length, np.abs(motion[:, 0] * se2.sinc(turn * motion[:, 1] / 2)))
    words = []
    if abs(far - 1) > 1e-6 and abs(far / turn - 1) < 1e-6:
        words.append(f"wheels roll {far:.4g} times too far{_known(far, _of_wheels(task))}")
    else:
        if abs(far - 1) > 1e-6:
            words.append(f"distances are {far:.4g} times too long{_known(far, _OF_DISTANCES)}")
        if abs(turn - 1) > 1e-6:
            words.append(f"turns are {turn:.4g} times too large{_known(turn, _of_turns(task))}")
    if words:
        yield " and ".join(words), accumulate(motion * (far, turn), "arc", task.start)


def _ratio(measured: Array, true: Array) -> float:
    """What multiple of true values the measured ones are, as most of them say."""
    seen = np.abs(true) > 1e-3 * np.abs(true).max(initial=0.0)
    return float(np.median(measured[seen] / true[seen])) if seen.any() else 1.0


_OF_DISTANCES = {2.0: "a sum where the mean belongs", 0.5: "half of the mean"}


def _of_wheels(task: Task) -> dict[float, str]:
    a_tick = 2 * math.pi / task.ticks_per_revolution
    return {
        2.0: "diameters for radii", 0.5: "half of the radii", 1 / math.pi: "pi is missing",
        1 / (2 * math.pi): "2 pi is missing", 1 / a_tick: "ticks for radians", a_tick: "radians for ticks",
        1 / task.robot.mean_radius: "the wheel radius is missing",
    }  # fmt: skip


def _of_turns(task: Task) -> dict[float, str]:
    track = task.robot.track_width
    return {
        2.0: "half of the track width for the whole", 0.5: "the track width twice", track: "the track width is missing",
        180 / math.pi: "degrees for radians", -1.0: "the sign is wrong",
    }  # fmt: skip


def _known(factor: float, known: dict[float, str]) -> str:
    for value, words in known.items():
        if abs(factor / value - 1) < 1e-3:
            return f" ({words})"
    return ""
