"""Mistakes with a number in them, which the answers tell: factors, thresholds, points off the axle, digits."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from diffdrive_mj import se2
from diffdrive_mj._checks import Array
from diffdrive_mj.judging._factors import by_factors, motion_of, ratio, rims_of
from diffdrive_mj.judging.readings import held
from diffdrive_mj.judging.stages import Stages, arcs
from diffdrive_mj.judging.tasks import Task

# An answer that stands still or has few values shows no digits.
_FEW = 5


def digits(poses: Array) -> str:
    """Say what digits the answers have; "" if all of them."""
    for size, words in ((1.0, "metres"), (0.01, "centimetres"), (1e-3, "millimetres")):
        if _multiples(poses[:, :2], size):
            return f"x and y come in whole {words}: answer with all digits"
    if _multiples(poses[:, 2:] - poses[0, 2], math.radians(1.0)):
        return "headings come in whole degrees: keep the rest of each turn, and answer with all digits"
    for columns, words in ((slice(3), "the answers are"), (slice(2), "x and y are"), (slice(2, 3), "theta is")):
        # But for the start, which is told in double precision.
        single = np.mean(poses[:, columns].astype(np.float32) == poses[:, columns]) > 0.9
        if single and len(np.unique(poses[:, columns].round(9), axis=0)) >= _FEW:
            return f"{words} in single precision: add up in double precision"
    return ""


def _multiples(values: Array, size: float) -> bool:
    """Whether values (T, ...) are whole numbers of a size, and enough of them to tell."""
    whole = np.round(values / size)
    return bool(np.abs(values / size - whole).max() < 1e-6) and len(np.unique(whole, axis=0)) >= _FEW


def fitted(task: Task, poses: Array, stages: Stages) -> Iterator[tuple[str, Array]]:
    """What mistakes with a number in them answer, the number being that which fits the poses.

    Args:
        task: that was solved.
        poses: as answered (T, 3).
        stages: what is done in another way besides.

    Returns:
        The words, and the answers (T, 3).
    """
    counts, motion, otherwise = stages.counting(task), stages.moved(task), stages.solve(task)
    if np.count_nonzero(counts) < 3 or not np.isfinite(otherwise).all():
        return
    yield from _units(poses, otherwise)
    yield from _standing(task, poses, otherwise, stages)
    if stages.answer is not None:
        return
    start, path = task.start if stages.start is None else stages.start, stages.path or arcs
    answered, seconds = poses[counts], np.diff(task.t[counts])
    turned = se2.wrap_angle(np.diff(answered[:, 2]))  # known but for whole turns
    for words, changed in (
        *by_factors(task, answered, turned, motion),
        *_periods(answered, turned, motion, seconds),
        *_lost(task, answered, turned, motion, seconds),
    ):
        yield words, held(path(changed, start), counts)
    yield _begun(answered[0]), held(path(motion, answered[0]), counts)
    if stages.path is None:
        for words, answer in (
            *_thresholds(answered, turned, motion, start),
            *_off_the_axle(answered, path(motion, start)),
        ):
            yield words, held(answer, counts)


def _begun(pose: Array) -> str:
    return "it begins at x = {:.4g} m, y = {:.4g} m, theta = {:.4g} rad: begin at the pose of the header".format(*pose)


_UNITS = {
    "headings are in degrees: give radians": (1, 180 / math.pi),
    "headings are in turns: give radians": (1, 0.5 / math.pi),
    "x and y are in millimetres: give metres": (1e3, 1),
    "x and y are in centimetres: give metres": (100, 1),
    "x and y are in inches: give metres": (1 / 0.0254, 1),
    "x and y are in feet: give metres": (1 / 0.3048, 1),
}


def _units(poses: Array, right: Array) -> Iterator[tuple[str, Array]]:
    """Answers in other units; headings may wrap in theirs."""
    for words, (length, angle) in _UNITS.items():
        turns = np.round((poses[:, 2] / angle - right[:, 2]) / (2 * math.pi)) if angle != 1 else 0.0
        theta = right[:, 2] + 2 * math.pi * turns
        yield words, np.column_stack([right[:, :2] * length, theta * angle])


def _standing(task: Task, poses: Array, right: Array, stages: Stages) -> Iterator[tuple[str, Array]]:
    """Answers that are those before, of readings that are not taken in, or though they are."""
    again = np.concatenate([[False], (np.diff(poses, axis=0) == 0).all(axis=1)])
    missed = again & np.concatenate([[False], (np.diff(right, axis=0) != 0).any(axis=1)])
    if not missed.any():
        return
    count = f"{np.count_nonzero(missed)} of {len(poses)}"
    yield f"{count} answers are those before: answer each reading", held(right[~again], ~again)
    if stages.counts is None and np.count_nonzero(task.counting & ~missed) > 1:
        answer = replace(stages, counts=task.counting & ~missed).solve(task)
        yield f"{count} readings are not taken in, though their times are later than those before", answer


def _lost(task: Task, poses: Array, turned: Array, motion: Array, seconds: Array) -> Iterator[tuple[str, Array]]:
    """Motion of wheels that is left out: of long steps, of small ones, or of others."""
    seen, rims = rims_of(task, poses, turned, motion)
    lost = (np.abs(seen) < 1e-9 * np.abs(rims).max()) & (np.abs(rims) > 1e-6 * np.abs(rims).max())
    if not lost.any() or lost.all(axis=0).any():
        return
    size, rows = np.abs(rims), lost.any(axis=1)
    if seconds[rows].min() > seconds[~rows].max(initial=0.0):
        which = f"across missing readings, {seconds[rows].min():.3g} s and more,"
    elif size[lost].max() < size[~lost].min(initial=np.inf, where=size[~lost] > 1e-6 * size.max()):
        which = f"of wheels that roll by {size[lost].max():.3g} m and less"
    else:
        which = f"of {np.count_nonzero(rows)} of {len(rows)} steps"
    yield f"the motion {which} is lost: let the next reading take it", motion_of(task, rims * ~lost)


def _periods(poses: Array, turned: Array, motion: Array, seconds: Array) -> Iterator[tuple[str, Array]]:
    """Speeds that are multiplied by the same period at every step."""
    if not (seconds > 0).all():
        return
    rates = motion / seconds[:, None]
    period = ratio(np.hypot(*np.diff(poses[:, :2], axis=0).T), np.abs(rates[:, 0] * se2.sinc(turned / 2)))
    yield (
        f"a fixed period of {period:.4g} s is taken for the time between readings: take the difference of their times",
        rates * period,
    )


def _thresholds(poses: Array, turned: Array, motion: Array, start: Array) -> Iterator[tuple[str, Array]]:
    """Arcs that are right but where a step turns by little: driven straight, or lost in rounding."""
    length, turn = motion.T
    moved = se2.rotate(np.diff(poses[:, :2], axis=0), -poses[:-1, 2])
    arcs = np.stack([np.cos(turn / 2), np.sin(turn / 2)], axis=-1) * (length * se2.sinc(turn / 2))[:, None]
    rounding = 1e-14 * (1 + np.abs(poses).max())
    wrong = np.hypot(*(moved - arcs).T) > rounding
    if not wrong.any() or np.abs(turned - turn).max() > rounding:
        return
    most = float(np.abs(turn[wrong]).max())
    cure = "the chord is distance sin(turn / 2) / (turn / 2), at any turn but zero"
    below = np.abs(turn) <= most
    for kind, along in (("straight on", 0.0), ("along chords as long as their arcs", 0.5)):
        plain = length[:, None] * np.stack([np.cos(along * turn), np.sin(along * turn)], axis=-1)
        yield (
            f"steps that turn by {most:.1g} rad and less are driven {kind}: {cure}",
            _chained(np.where(below[:, None], plain, arcs), turn, start),
        )
    share = np.hypot(*moved.T) / np.maximum(np.abs(length), rounding)
    irregular = np.mean(np.abs(np.diff(share)) > 0.1) > 0.1
    if 0 < most < 1e-3 and (wrong.mean() < 0.9 or (most < 1e-7 and irregular)):
        yield (
            f"steps that turn by {most:.1g} rad and less are lost in rounding, divided by their turn: {cure}",
            _chained(np.where(wrong[:, None], moved, arcs), turn, start),
        )


def _chained(moved: Array, turn: Array, start: Array) -> Array:
    """Poses (K, 3) along steps that are given in the frame of the pose before."""
    theta = start[2] + np.concatenate([[0.0], np.cumsum(turn)])
    steps = se2.rotate(moved, theta[:-1])
    return np.column_stack([start[:2] + np.cumsum(np.vstack([np.zeros(2), steps]), axis=0), theta])


def _off_the_axle(poses: Array, right: Array) -> Iterator[tuple[str, Array]]:
    """Positions of a point that the robot carries elsewhere than between its wheels."""
    cosine, sine = np.cos(right[:, 2]), np.sin(right[:, 2])
    carried = np.stack([np.stack([cosine, -sine], axis=-1), np.stack([sine, cosine], axis=-1)], axis=1)
    for moved in (carried, carried - carried[0]):
        point = np.linalg.lstsq(moved.reshape(-1, 2), (poses - right)[:, :2].ravel(), rcond=None)[0]
        if np.hypot(*point) < 1e-6:
            continue
        yield (
            f"positions are of a point {_plain(point[0])} m ahead and {_plain(point[1])} m to the left of the axle's "
            "middle: give those of the middle",
            np.column_stack([right[:, :2] + moved @ point, right[:, 2]]),
        )


def _plain(number: float) -> str:
    return f"{round(number, 9) + 0.0:.4g}"
