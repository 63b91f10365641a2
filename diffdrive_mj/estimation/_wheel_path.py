"""A drive as straight pieces in the plane of its wheel angles, few where the wheels keep their ratio.

Where a robot ends depends on the path of its wheel angles alone, not on when they are where. Samples that lie on the
line between two others are left out; up to rounding, which `off` bounds.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from diffdrive_mj._checks import Array
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.estimation._robot_box import RobotBox

# How far any robot of the box may turn in a short piece [rad]: the series of `_short_pieces` are short then.
_MOST_TURN = 0.5
_MOST_PIECES = 1_000_000  # more take too long
# How far every robot of the box turns in a long piece at least [rad]: ends alone count there (`_long_pieces`).
_LONG_TURN = np.pi
# How far wheel angles may be from a piece that stands for them, as a part of their way.
_OFF = 1e-12


@dataclass(frozen=True, eq=False)
class WheelPath:
    """Straight pieces of wheel angles, from a drive's start on, where both are zero.

    Attributes:
        short: begin and end of the pieces in which no robot of a box turns far (S, 2, 2) [rad].
        long: of those in which every robot turns far, all to the same side (L, 2, 2) [rad].
        circle: begin and end of the whole path (2, 2) [rad], if it is one piece.
        ends: after how many short pieces a pose is asked for (K,).
        off: how far the drive is from the pieces at most [rad].
    """

    short: Array
    long: Array
    circle: Array | None
    ends: NDArray[np.intp]
    off: float


def wheel_path(angles: Array, box: RobotBox, anywhere: bool) -> WheelPath:
    """The pieces of a drive (T, 2) from zero on, for its end, or for every sample after the first."""
    if len(angles) == 1:
        angles = np.repeat(angles, 2, axis=0)
    off = _OFF * rolled(angles)
    few = angles[_kept(angles, off)]
    circle = few if len(few) == 2 else None
    every = angles if anywhere else few
    pieces = np.stack([every[:-1], every[1:]], axis=1)
    farthest, always = _turns(every, box)
    if farthest.sum() > _MOST_PIECES * _MOST_TURN:
        raise InvalidValue(
            f"the drive turns robots within the tolerances by up to {farthest.sum():.3g} rad: must be at most "
            f"{_MOST_PIECES * _MOST_TURN:.3g} rad"
        )
    long = (always > _LONG_TURN) & (not anywhere)
    count = np.maximum(1, np.ceil(farthest / _MOST_TURN)).astype(np.intp)
    ends = np.cumsum(count[~long])
    which = np.repeat(np.flatnonzero(~long), count[~long])
    part = np.arange(len(which)) - np.repeat(ends - count[~long], count[~long])
    begin, step = pieces[which, 0], np.diff(pieces, axis=1)[which, 0] / count[which][:, None]
    short = np.stack([begin + part[:, None] * step, begin + (part + 1)[:, None] * step], axis=1)
    return WheelPath(short, pieces[long], circle, ends if anywhere else np.array([len(short)]), off)


def turning(angles: Array) -> Array:
    """D, S and 1 at wheel angles (..., 2): by how much kappa, g and the heading at the start turn a robot (..., 3)."""
    left, right = angles[..., 0], angles[..., 1]
    return np.stack([right - left, (left + right) / 2, np.ones_like(left)], axis=-1)


def way(angles: Array) -> Array:
    """S and D / 4 at wheel angles (..., 2): by how much kappa and g bring a robot forward, in track widths (..., 2)."""
    left, right = angles[..., 0], angles[..., 1]
    return np.stack([(left + right) / 2, (right - left) / 4], axis=-1)


def rolled(angles: Array) -> float:
    """How far both wheels turn together, back or forth [rad]."""
    return float(np.abs(np.diff(angles, axis=0)).sum())


def _turns(angles: Array, box: RobotBox) -> tuple[Array, Array]:
    """How far the robots of a box turn from sample to sample (T - 1,): at most, and all to the same side at least."""
    turn = np.diff(turning(angles), axis=0) @ box.physical(box.corners)[1].T
    together = (turn > 0).all(axis=1) | (turn < 0).all(axis=1)
    return np.abs(turn).max(axis=1), np.where(together, np.abs(turn).min(axis=1), 0.0)


def _kept(angles: Array, off: float) -> NDArray[np.intp]:
    """The samples between which all others are on lines; a line is cut at the farthest one (Douglas and Peucker)."""
    kept, ahead = [0], [len(angles) - 1, *_bends(angles, off)[::-1].tolist()]
    while ahead:
        first, last = kept[-1], ahead[-1]
        if last == first + 1:
            kept.append(ahead.pop())
            continue
        from_first = angles[first + 1 : last] - angles[first]
        along = angles[last] - angles[first]
        length = float(np.hypot(*along))
        across = from_first @ (np.array([-along[1], along[0]]) / length) if length > off else np.hypot(*from_first.T)
        far = int(np.abs(across).argmax())
        if abs(across[far]) > off / 2:
            ahead.append(first + 1 + far)
        else:
            kept.append(ahead.pop())
    return np.array(kept)


def _bends(angles: Array, off: float) -> NDArray[np.intp]:
    """Samples that are off the line between their neighbours, at once: in a log of noisy wheels nearly all of them."""
    (x, y), (along, across) = np.diff(angles, axis=0)[:-1].T, (angles[2:] - angles[:-2]).T
    return 1 + np.flatnonzero(np.abs(x * across - y * along) > off * np.hypot(along, across))
