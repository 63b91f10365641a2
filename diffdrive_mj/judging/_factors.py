"""Distances, turns and wheels that are wrong by a factor, and what a factor is known for."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

import numpy as np

from diffdrive_mj import se2
from diffdrive_mj._checks import Array
from diffdrive_mj.judging.tasks import Task


def rims_of(task: Task, poses: Array, turned: Array, motion: Array) -> tuple[Array, Array]:
    """How far each wheel has rolled from pose to pose, as answered and as it did (K - 1, 2) [m]."""
    along, sides = poses[:-1, 2] + turned / 2, np.array((-0.5, 0.5)) * task.robot.track_width
    ahead = (np.diff(poses[:, :2], axis=0) * np.stack([np.cos(along), np.sin(along)], axis=-1)).sum(axis=-1)
    distance = ahead / se2.sinc(turned / 2)
    return distance[:, None] + turned[:, None] * sides, motion[:, :1] + motion[:, 1:] * sides


def motion_of(task: Task, rims: Array) -> Array:
    """Distances and turns (K - 1, 2) of wheels that roll so far."""
    return np.stack([rims.sum(axis=1) / 2, np.diff(rims, axis=1)[:, 0] / task.robot.track_width], axis=-1)


def by_factors(task: Task, poses: Array, turned: Array, motion: Array) -> Iterator[tuple[str, Array]]:
    """Distances and turns, or wheels, that are all wrong by a factor, as of diameters for radii or a track left out."""
    length = np.hypot(*np.diff(poses[:, :2], axis=0).T)
    turn = ratio(turned, motion[:, 1])
    # Steps are chords, or as long as arcs.
    fars = [ratio(length, np.abs(motion[:, 0] * chord)) for chord in (se2.sinc(turn * motion[:, 1] / 2), 1.0)]
    # On a straight line turns tell nothing.
    turns = (fars[0], 1.0) if np.abs(motion[:, 1]).max() < 1e-9 else (turn,)
    for far, turn in itertools.product(fars, turns):
        words = []
        if abs(far - 1) > 1e-6 and math.isclose(far, turn, rel_tol=1e-6):
            words.append(f"wheels roll {_times(far)} times the right way{_known(far, _of_wheels(task))}")
        else:
            if far == 0:
                words.append("distances are lost")
            elif abs(far - 1) > 1e-6:
                words.append(f"distances are {_times(far)} times the right ones{_known(far, _OF_DISTANCES)}")
            if turn == 0:
                words.append("turns are lost")
            elif abs(turn - 1) > 1e-6:
                known = _known(turn, _of_turns(task), _as_track(task, turn))
                words.append(f"turns are {_times(turn)} times the right ones{known}")
        if words and (far or turn):
            yield " and ".join(words), motion * (far, turn)
    seen, rims = rims_of(task, poses, turned, motion)
    left, right = ratio(seen[:, 0], rims[:, 0]), ratio(seen[:, 1], rims[:, 1])
    if not math.isclose(left, right, rel_tol=1e-6):
        parts = [
            f"the {side} wheel rolls {_times(factor)} times the right way{_known(factor, _of_wheels(task))}"
            for side, factor in (("left", left), ("right", right))
            if abs(factor - 1) > 1e-6
        ]
        yield " and ".join(parts), motion_of(task, rims * (left, right))


def ratio(measured: Array, true: Array) -> float:
    """What multiple of true values the measured ones are, as most of them say."""
    seen = np.abs(true) > 1e-3 * np.abs(true).max(initial=0.0)
    return float(np.median(measured[seen] / true[seen])) if seen.any() else 1.0


_OF_DISTANCES = {2.0: "a sum where the mean belongs", 0.5: "half of the mean"}


def _of_wheels(task: Task) -> dict[float, str]:
    a_tick = 2 * math.pi / task.ticks_per_revolution
    return {
        2.0: "diameters for radii", 0.5: "half of the radii", 1 / math.pi: "pi is missing",
        1 / (2 * math.pi): "2 pi is missing", 1 / a_tick: "ticks for radians", a_tick: "radians for ticks",
        1 / task.robot.left_radius: "the wheel radius is missing",
        1 / task.robot.right_radius: "the wheel radius is missing",
        1 / task.robot.mean_radius: "the wheel radius is missing", 4.0: "edges of an encoder are counted four times",
        0.25: "one of an encoder's four edges is counted", 180 / math.pi: "degrees for radians", 1e3: "mm for m",
        100.0: "cm for m", math.pi / 180: "radians for degrees", -1.0: "the sign is wrong",
        3.14 / math.pi: "pi is taken for 3.14", math.pi / 3.14: "pi is taken for 3.14",
        22 / 7 / math.pi: "pi is taken for 22 / 7", math.pi / (22 / 7): "pi is taken for 22 / 7",
    }  # fmt: skip


def _of_turns(task: Task) -> dict[float, str]:
    track = task.robot.track_width
    return {
        2.0: "half of the track width for the whole", 0.5: "the track width twice", track: "the track width is missing",
        180 / math.pi: "degrees for radians", -1.0: "the sign is wrong",
    }  # fmt: skip


def _as_track(task: Task, turn: float) -> str:
    """A factor of turns near one, as that of a track width."""
    taken, right = (f"{track:.4g} m" for track in (task.robot.track_width / turn, task.robot.track_width))
    return f"a track width of {taken}, where {right} is right" if 0.6 < turn < 1.6 and taken != right else ""


def _known(factor: float, known: dict[float, str], otherwise: str = "") -> str:
    words = next((words for value, words in known.items() if abs(factor / value - 1) < 1e-4), otherwise)
    return f" ({words})" if words else ""


def _times(factor: float) -> str:
    """A factor to four digits, or six where it is nearly one."""
    return f"{factor:.4g}" if abs(factor - 1) > 1e-3 else f"{factor:.6g}"
