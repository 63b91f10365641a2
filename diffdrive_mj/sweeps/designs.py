"""Designs: where in the unit cube each trial of a study lies, one coordinate for each number that varies.

Point i of a design is the same in whatever parts the points are asked for, and, but for "saltelli", however many there
are.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Literal

import numpy as np

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj._text import shown
from diffdrive_mj.errors import InvalidType, InvalidValue

Design = Literal["random", "sobol", "saltelli"]
# (seed, names of what varies, first, last, trials of the whole design) -> (last - first, D)
Points = Callable[[int, Sequence[str], int, int, int], Array]

# Keep quantiles finite: half a step of the generator's, and of the sequence's, numbers.
_LEAST, _BITS = 2.0**-54, 30
_LONGEST = 2**_BITS


def random_points(seed: int, names: Sequence[str], first: int, last: int, trials: int) -> Array:
    """Draw points independently, from one stream for each name: what else varies does not change its numbers.

    Args:
        seed: of the streams.
        names: of what varies (D).
        first: point.
        last: point, which is not returned.
        trials: of the whole design, which make no difference.

    Returns:
        (last - first, D), each above zero and below one.

    Example:
        >>> both = random_points(0, ["robot.left_radius", "robot.track_width"], 0, 4, 4)
        >>> bool((random_points(0, ["robot.track_width"], 2, 4, 4)[:, 0] == both[2:, 1]).all())
        True
    """
    _refuse(seed, names, first, last, trials)
    streams = [np.random.PCG64(np.random.SeedSequence([seed, 0, int.from_bytes(name.encode())])) for name in names]
    # A double takes one step of this generator, so that the i-th is there without those before it.
    drawn = [np.random.Generator(stream.advance(first)).random(last - first) for stream in streams]
    return np.maximum(np.stack(drawn, axis=-1) if drawn else np.zeros((last - first, 0)), _LEAST)


def sobol_points(seed: int, names: Sequence[str], first: int, last: int, trials: int) -> Array:
    """Take points of a scrambled Sobol' sequence, which fill the cube more evenly than chance does.

    Means over n points are off by about 1/n for smooth figures, where chance leaves 1/sqrt(n). Numbers of points that
    are powers of two are the most even.

    Args:
        seed: of the scrambling.
        names: of what varies (D).
        first: point.
        last: point, which is not returned.
        trials: of the whole design, which make no difference.

    Returns:
        (last - first, D), each above zero and below one.

    Raises:
        InvalidValue: more points than the sequence has, 2^30.

    References:
        Sobol' (1967); Owen (1998): the scrambling.

    Example:
        One point in each quarter of the range:

        >>> np.sort(sobol_points(0, ["world.friction"], 0, 4, 4)[:, 0] * 4).astype(int).tolist()
        [0, 1, 2, 3]
    """
    _refuse(seed, names, first, last, trials)
    if last > _LONGEST:
        raise InvalidValue(f"Study.trials: a Sobol' sequence has {_LONGEST} points; design='random' has any number")
    if not names:
        return np.zeros((last - first, 0))
    from scipy.stats import qmc

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # numbers of points that are no powers of two
        sequence = qmc.Sobol(len(names), scramble=True, bits=_BITS, rng=seed)
        if first:  # SciPy cannot pass over none
            sequence.fast_forward(first)
        points: Array = sequence.random(last - first)
    return points + 0.5**_BITS / 2


def saltelli_points(seed: int, names: Sequence[str], first: int, last: int, trials: int) -> Array:
    """Take points that tell how much of a figure's variance each number explains, alone and with the others.

    The trials are D + 2 blocks of n = trials / (D + 2) rows: A and B, the two halves of a Sobol' sequence in 2 D
    dimensions, and for each number in turn A with that number out of B. Trial i is row i % n of block i // n.

    Args:
        seed: of the sequence.
        names: of what varies (D).
        first: point.
        last: point, which is not returned.
        trials: of the whole design; those of a larger one are others.

    Returns:
        (last - first, D), each above zero and below one.

    References:
        Saltelli and others (2010): the scheme, and the estimators that take it.

    Example:
        >>> a, b, ab1, ab2 = saltelli_points(0, ["robot.mean_radius", "robot.track_width"], 0, 4, trials=4)
        >>> ab1.tolist() == [b[0], a[1]], ab2.tolist() == [a[0], b[1]]
        (True, True)
    """
    _refuse(seed, names, first, last, trials)
    dimensions = len(names)
    if trials % (dimensions + 2):
        raise InvalidValue(f"trials = {trials}: must be a multiple of D + 2 = {dimensions + 2}")
    block, row = np.divmod(np.arange(first, last), trials // (dimensions + 2))
    start = int(row.min())
    halves = sobol_points(seed, [*names, *names], start, int(row.max()) + 1, trials).reshape(-1, 2, dimensions)
    a, b = halves[row - start].swapaxes(0, 1)
    return np.where((block[:, None] == 1) | (block[:, None] == 2 + np.arange(dimensions)), b, a)


DESIGNS: dict[str, Points] = {"random": random_points, "sobol": sobol_points, "saltelli": saltelli_points}


def placed(design: Design, seed: int, grids: Mapping[str, int], first: int, last: int, trials: int) -> Array:
    """Place trials: every combination of the grids is driven by the same points of the design, one after the other.

    Args:
        design: a name in `DESIGNS`.
        seed: of its randomness.
        grids: how many values the grid of each of the D names has, 0 for one that has no grid.
        first: trial.
        last: trial, which is not returned.
        trials: of the whole study.

    Returns:
        (last - first, D), the share of each number.

    Example:
        Two speeds, each with the same two radii:

        >>> shares = placed("random", 0, {"maneuver.speed": 2, "robot.left_radius": 0}, 0, 4, 4)
        >>> shares[:, 0].tolist(), bool(shares[0, 1] == shares[1, 1] != shares[2, 1])
        ([0.25, 0.75, 0.25, 0.75], True)
    """
    if not isinstance(grids, Mapping):
        raise InvalidType(f"grids = {shown(grids)}: must be a mapping from names to numbers of values")
    points = checks.one_of("design", design, DESIGNS)
    _refuse(seed, grids, first, last, trials)
    for name, size in grids.items():
        checks.whole(f"grids[{shown(name)}]", size, least=0)
    if not grids:
        return np.zeros((last - first, 0))
    sizes = [max(size, 1) for size in grids.values()]
    combinations = math.prod(sizes)
    turn, combination = np.divmod(np.arange(first, last), combinations)
    free = [name for name, size in grids.items() if not size]
    start, end = int(turn[0]), int(turn[-1]) + 1
    drawn = iter(points(seed, free, start, end, -(-trials // combinations))[turn - start].T)
    places = np.unravel_index(combination, sizes)
    columns = [
        (place + 0.5) / size if size else next(drawn) for place, size in zip(places, grids.values(), strict=True)
    ]
    return np.stack(columns, axis=-1)


def _refuse(seed: int, names: Iterable[str], first: int, last: int, trials: int) -> None:
    """Refuse points that a design does not have."""
    checks.whole("seed", seed, least=0)
    checks.strings("names", names)
    first, last = checks.whole("first", first, least=0), checks.whole("last", last, least=0)
    if not first < last <= checks.whole("trials", trials):
        raise InvalidValue(f"trials {first} to {last}: must be some of the {trials} that there are")
