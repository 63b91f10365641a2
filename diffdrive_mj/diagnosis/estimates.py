"""What looks wrong with an estimate beside the truth: clocks that are apart, units, and headings that do not fit.

An estimate that is merely bad is not reported; one whose log was read or written wrongly is.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from diffdrive_mj import se2
from diffdrive_mj._checks import Array
from diffdrive_mj.diagnosis._windows import WINDOW, windows
from diffdrive_mj.metrics._pairs import complex_positions

_MOST = 2000  # Windows that are looked at, of however many there are.
_FURTHEST, _STEP = 5.0, 0.05  # How far apart clocks are tried, and how finely [s].
_BETTER = 3.0  # By what factor another offset must leave less of the motions unexplained.
_UNEXPLAINED = 0.02  # What clocks that are apart leave of the motions, at least.
_SCALE = 1.5  # No estimate is worse, in how far it drives or turns.
_SIDEWAYS = 0.5  # Of its way: no robot on two wheels slides that much.
_STRAIGHT = 0.5  # Windows that turn by less have a direction [rad].
_DRIVEN, _TURNED = 0.1, 1.0  # How much of a drive must be seen [m, rad].
_ARM = 0.2  # How far a turn of a radian counts beside a metre [m].


def odd_poses(t: Array, truth: Array, estimate: Array, names: tuple[str, str], offset: float = 0.0) -> tuple[str, ...]:
    """Look for faults of two logs of one drive that are no errors of the estimate.

    Looked for are: clocks that are up to 5 s apart; distances or turns that differ by more than half; turns the other
    way; headings across the way that is driven. Poses more than 1.5 s apart show nothing.

    Args:
        t: times (N,) [s] of both.
        truth: (N, 3) [m, m, rad].
        estimate: (N, 3) [m, m, rad], in a frame of its own.
        names: of both, for the messages.
        offset: that was added to the estimate's times [s].

    Returns:
        A sentence for each fault; empty if both look clean.

    Example:
        >>> t = np.arange(0, 10, 0.1)
        >>> poses = np.stack([t, np.zeros(100), np.zeros(100)], axis=-1)
        >>> odd_poses(t, poses, poses, ("mocap", "odom"))
        ()
        >>> odd_poses(t, poses, poses * 1000, ("mocap", "odom"))
        ('odom drives 1000 times as far as mocap: is the unit of x and y right (position_unit)?',)
    """
    pairs = windows(t)
    pairs = pairs[:: max(1, -(-len(pairs) // _MOST))]
    if not len(pairs):
        return ()
    moved = _moved(truth, pairs), _moved(estimate, pairs)
    if late := _lateness(t, moved[0], estimate, pairs):
        how = f"{abs(late):.2g} s {'late' if late > 0 else 'early'}"
        return (f"the clock of {names[1]} looks {how}: offset = {offset - late:.3g} would make the motions agree",)
    # Windows overlap: what is seen in several counts once.
    once = (t[-1] - t[0]) / WINDOW / len(pairs)
    return (*_sizes(*moved, once, names), *_sideways(names, moved, once))


def _moved(poses: Array, pairs: Array) -> Array:
    """Forward, left [m] and turn [rad] over each window (N, 3), in the frame of its start."""
    moved = se2.between(poses[pairs[:, 0]], poses[pairs[:, 1]])
    turned = np.concatenate([[0.0], np.cumsum(se2.wrap_angle(np.diff(poses[:, 2])))])
    moved[:, 2] = turned[pairs[:, 1]] - turned[pairs[:, 0]]
    return moved


def _driven(moved: Array) -> Array:
    """How far each motion (N, 3) goes (N,) [m]."""
    return np.hypot(moved[:, 0], moved[:, 1])


def _drives(moved: Array) -> NDArray[np.bool_]:
    """Which motions (N, 3) drive more than they turn (N,)."""
    return _driven(moved) > _ARM * np.abs(moved[:, 2])


def _lateness(t: Array, moved: Array, estimate: Array, pairs: Array) -> float:
    """How much later the estimate moves as the truth has moved [s]; 0 where no other time is clearly better."""
    furthest = min(_FURTHEST, (t[-1] - t[0]) / 4)
    within = (t[pairs[:, 0]] >= t[0] + furthest) & (t[pairs[:, 1]] <= t[-1] - furthest)
    if np.count_nonzero(within) < 2:
        return 0.0
    pairs, moved = pairs[within], moved[within]
    true = np.column_stack([_driven(moved), _ARM * moved[:, 2]])
    position, heading = complex_positions(estimate), np.unwrap(estimate[:, 2])
    steps = round(furthest / _STEP)
    lags = _STEP * np.arange(-steps, steps + 1)
    left = np.empty(len(lags))
    for k, lag in enumerate(lags):
        begin, end = (t[pairs] + lag).T
        driven = np.abs(np.interp(end, t, position) - np.interp(begin, t, position))
        turned = np.interp(end, t, heading) - np.interp(begin, t, heading)
        left[k] = _unexplained(true, np.column_stack([driven, _ARM * turned]))
    # The nearest that is better than its neighbours, and much better than the clocks as they are.
    good = left < left[steps] / _BETTER**2
    good[1:-1] &= (left[1:-1] <= left[:-2]) & (left[1:-1] <= left[2:])
    good[[0, steps, -1]] = False
    if left[steps] < _UNEXPLAINED**2 * (true**2).sum() or not good.any():
        return 0.0
    k = min(np.flatnonzero(good).tolist(), key=lambda k: abs(k - steps))
    before, here, after = left[k - 1 : k + 2]
    bend = before - 2 * here + after
    return float(lags[k] + (_STEP * (before - after) / (2 * bend) if bend > 0 else 0.0))


def _unexplained(true: Array, believed: Array) -> float:
    """What is left of the truth's motions (N, 2), squared, where the estimate's may be of another scale [m^2]."""
    common, size = (true * believed).sum(axis=0), (believed**2).sum(axis=0)
    explained = np.divide(common**2, size, out=np.zeros(2), where=size > 0)
    return float(((true**2).sum(axis=0) - explained).sum())


def _sizes(true: Array, believed: Array, once: float, names: tuple[str, str]) -> Iterator[str]:
    """Distances and turns of the one against the other."""
    # A marker beside the axle swings where the robot turns, which is no driving.
    drives = _drives(true)
    for verb, unit, least, sizes in (
        ("drives", "of x and y right (position_unit)", _DRIVEN, [_driven(m)[drives] for m in (true, believed)]),
        ("turns", "of theta right (angle_unit)", _TURNED, [np.abs(m[:, 2]) for m in (true, believed)]),
    ):
        a, b = (float(size.sum()) for size in sizes)
        ratio = b / a if a else np.inf
        if max(a, b) * once > least and not 1 / _SCALE <= ratio <= _SCALE:
            yield f"{names[1]} {verb} {ratio:.4g} times as far as {names[0]}: is the unit {unit}?"
    turns = np.abs(true[:, 2]).sum()
    if turns * once > _TURNED and true[:, 2] @ believed[:, 2] < -(true[:, 2] @ true[:, 2]) / 2:
        yield f"{names[1]} turns the other way than {names[0]}: is theta counter-clockwise, and are x and y exchanged?"


def _sideways(names: tuple[str, str], logs: tuple[Array, Array], once: float) -> Iterator[str]:
    """Logs whose headings are not where the robot drives."""
    for name, log in zip(names, logs, strict=True):
        moved = np.column_stack([log[:, :2], se2.wrap_angle(log[:, 2])])
        driven = _driven(moved)
        far = _drives(moved) & (driven > driven.max() / 4) & (np.abs(moved[:, 2]) < _STRAIGHT)
        way = driven[far].sum()
        if way * once <= _DRIVEN:
            continue
        across = np.abs(se2.log(moved[far])[:, 1]).sum()
        if across > _SIDEWAYS * way:
            yield (
                f"{name} moves sideways for {across / way:.0%} of its way: are x and y exchanged, is theta in another "
                "unit, clockwise or of another axis, or the marker far from the axle?"
            )
