"""Mistakes with a number in them, which the answers tell: factors, thresholds, points off the axle, digits."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from diffdrive_mj import se2
from diffdrive_mj._checks import Array
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
    # But for the start, which is told in double precision.
    single = np.mean(poses.astype(np.float32) == poses) > 0.9
    if single and len(np.unique(poses.round(9), axis=0)) >= _FEW:
        return "the answers are in single precision: add up in double precision"
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
    counts, motion = stages.counting(task), stages.moved(task)
    if stages.answer is not None or np.count_nonzero(counts) < 3 or not np.isfinite(motion).all():
        return
    start, path = task.start if stages.start is None else stages.start, stages.path or arcs
    answered, seconds = poses[counts], np.diff(task.t[counts])
    turned = se2.wrap_angle(np.diff(answered[:, 2]))  # known but for whole turns
    for words, changed in (
        *_factors(task, answered, turned, motion),
        *_periods(answered, turned, motion, seconds),
        *_lost(answered, turned, motion, seconds),
    ):
        yield words, held(path(changed, start), counts)
    if stages.path is None:
        for words, answer in (
            *_thresholds(answered, turned, motion, start),
            *_off_the_axle(answered, path(motion, start)),
        ):
            yield words, held(answer, counts)


def _factors(task: Task, poses: Array, turned: Array, motion: Array) -> Iterator[tuple[str, Array]]:
    """Distances and turns, or wheels, that are all wrong by a factor, as of diameters for radii or a track left out."""
    length, half = np.hypot(*np.diff(poses[:, :2], axis=0).T), task.robot.track_width / 2
    turn = _ratio(turned, motion[:, 1])
    # Steps are chords, or as long as arcs.
    for chord in (se2.sinc(turn * motion[:, 1] / 2), 1.0):
        far, words = _ratio(length, np.abs(motion[:, 0] * chord)), []
        if abs(far - 1) > 1e-6 and math.isclose(far, turn, rel_tol=1e-6):
            words.append(f"wheels roll {far:.4g} times too far{_known(far, _of_wheels(task))}")
        else:
            if abs(far - 1) > 1e-6:
                words.append(f"distances are {far:.4g} times too long{_known(far, _OF_DISTANCES)}")
            if abs(turn - 1) > 1e-6:
                known = _known(turn, _of_turns(task), _as_track(task, turn))
                words.append(f"turns are {turn:.4g} times too large{known}")
        if words:
            yield " and ".join(words), motion * (far, turn)
    along = poses[:-1, 2] + turned / 2
    signed = (np.diff(poses[:, :2], axis=0) * np.stack([np.cos(along), np.sin(along)], axis=-1)).sum(axis=-1)
    signed = signed / se2.sinc(turned / 2)
    rims = motion[:, :1] + motion[:, 1:] * (-half, half)
    left, right = _ratio(signed - turned * half, rims[:, 0]), _ratio(signed + turned * half, rims[:, 1])
    if not math.isclose(left, right, rel_tol=1e-6):
        parts = [
            f"the {side} wheel rolls {factor:.4g} times too far{_known(factor, _of_wheels(task))}"
            for side, factor in (("left", left), ("right", right))
            if abs(factor - 1) > 1e-6
        ]
        rims = rims * (left, right)
        yield " and ".join(parts), np.stack([rims.sum(axis=1) / 2, np.diff(rims, axis=1)[:, 0] / half / 2], axis=-1)


def _lost(poses: Array, turned: Array, motion: Array, seconds: Array) -> Iterator[tuple[str, Array]]:
    """Steps without any motion: long ones, small ones, or others."""
    size = np.abs(motion).sum(axis=1)
    lost = (np.abs(np.diff(poses[:, :2], axis=0)).sum(axis=1) + np.abs(turned) == 0) & (size > 0)
    if not lost.any() or lost.all():
        return
    if seconds[lost].min() > seconds[~lost].max():
        which = f"across missing readings, {seconds[lost].min():.3g} s and more,"
    elif size[lost].max() < size[~lost].min():
        which = f"of small steps, up to {np.abs(motion[lost, 0]).max():.3g} m,"
    else:
        which = f"of {np.count_nonzero(lost)} of {len(lost)} steps"
    yield f"the motion {which} is lost: take it from the last reading that was taken in", motion * ~lost[:, None]


def _periods(poses: Array, turned: Array, motion: Array, seconds: Array) -> Iterator[tuple[str, Array]]:
    """Speeds that are multiplied by the same period at every step."""
    if not (seconds > 0).all():
        return
    rates = motion / seconds[:, None]
    period = _ratio(np.hypot(*np.diff(poses[:, :2], axis=0).T), np.abs(rates[:, 0] * se2.sinc(turned / 2)))
    yield (
        f"a fixed period of {period:.4g} s is taken for the time between readings: take the difference of their times",
        rates * period,
    )


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
        1 / task.robot.left_radius: "the wheel radius is missing",
        1 / task.robot.right_radius: "the wheel radius is missing",
        1 / task.robot.mean_radius: "the wheel radius is missing", 4.0: "edges of an encoder are counted four times",
        0.25: "one of an encoder's four edges is counted", 180 / math.pi: "degrees for radians", 1e3: "mm for m",
        100.0: "cm for m", math.pi / 180: "radians for degrees", -1.0: "the sign is wrong",
        3.14 / math.pi: "pi is taken for 3.14", math.pi / 3.14: "pi is taken for 3.14",
    }  # fmt: skip


def _of_turns(task: Task) -> dict[float, str]:
    track = task.robot.track_width
    return {
        2.0: "half of the track width for the whole", 0.5: "the track width twice", track: "the track width is missing",
        180 / math.pi: "degrees for radians", -1.0: "the sign is wrong",
    }  # fmt: skip


def _as_track(task: Task, turn: float) -> str:
    """A factor of turns near one, as that of a track width."""
    track = task.robot.track_width
    return f"a track width of {track / turn:.4g} m, where {track:.4g} m is right" if 0.6 < turn < 1.6 else ""


def _known(factor: float, known: dict[float, str], otherwise: str = "") -> str:
    words = next((words for value, words in known.items() if abs(factor / value - 1) < 1e-4), otherwise)
    return f" ({words})" if words else ""


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
            f"positions are of a point {point[0]:.4g} m ahead and {point[1]:.4g} m to the left of the axle's middle: "
            "give those of the middle",
            np.column_stack([right[:, :2] + moved @ point, right[:, 2]]),
        )
