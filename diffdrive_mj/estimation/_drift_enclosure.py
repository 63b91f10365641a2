"""A proven bound on the drift over a box of robots: a Taylor polynomial, its remainder, and all rounding.

The true robot ends at

```
b F,    F = integral of e^(i theta) (kappa dS + g dD / 4),    theta = theta_0 + kappa D + g S
```

(`_robot_box` has the letters). With d how far (kappa, g, theta_0) are from the middle of a box, and e = d . (D, S, 1) how
far that turns the robot at a place of its path, |e^(i e) - 1 - i e + e^2 / 2| <= |e|^3 / 6 leaves

```
F = F_0 + J d + d Q d + rest,    |rest| <= integral of |kappa dS + g dD / 4| |e|^3 / 6 + |d_kappa dS + d_g dD / 4| e^2 / 2
```

Without the last two the drift is |F_0 + J d - P / b| b, with P where odometry ends: the size of what is linear over what is
linear and positive (1 / b), so that none of a polytope exceeds its corners. The last two are bounded by their sizes.

Rounding: a sum of n terms in any order is off by at most n u of the sum of their sizes, u = 2^-53; angles by a few u of
theirs; sines, and polynomials of angles below a radian, by a few u. Each is counted several times over.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from diffdrive_mj._checks import Array
from diffdrive_mj.estimation._boxes import Enclosures
from diffdrive_mj.estimation._robot_box import RobotBox, corners
from diffdrive_mj.odometry import integrate
from diffdrive_mj.robot import Robot

Complex = NDArray[np.complex128]
_UNIT = 2.0**-53
# How far any robot of the box may turn in a piece of the path [rad]: the series of `_means` are short then.
_MOST_TURN = 0.5
# What the last steps, from bounds of parts to that of the whole, may round off.
_OUTWARD = 1 + 2.0**-40


class DriftOverBoxes:
    """How far the robots of a box are from where odometry takes them to be, on one drive.

    Args:
        wheel_angles: (T, 2) [rad].
        believed: the robot of the odometry.
        box: of true robots.
        anywhere: the largest drift at any sample, not that at the end.
    """

    def __init__(self, wheel_angles: Array, believed: Robot, box: RobotBox, anywhere: bool) -> None:
        self._box = box
        angles = wheel_angles - wheel_angles[0]
        path, samples = _pieces(angles, box)
        self._samples = samples[1:] - 1 if anywhere else None
        total, difference = path.mean(axis=1), path[:, 1] - path[:, 0]
        # A row each for kappa, g and the heading: what it turns the robot by, at the middle of a piece and from there on.
        turns = np.stack([difference, total, np.ones_like(total)])
        self._middle, self._half = (turns[:, 1:] + turns[:, :-1]) / 2, np.diff(turns, axis=1) / 2
        self._way = np.diff(np.stack([total, difference / 4]), axis=1)  # a row each for kappa and g
        pairs = ((self._middle, self._middle), (self._middle, self._half), (self._half, self._half))
        self._columns = [np.einsum("in,jn,kn->nijk", self._way, *pair).reshape(len(path) - 1, -1) for pair in pairs]
        ends = [np.einsum("jn,kn,ln->njkl", *[np.abs(part)] * 3) for part in (turns[:, 1:], turns[:, :-1])]
        sizes = np.einsum("in,njkl->nijkl", np.abs(self._way), (ends[0] + ends[1]) / 2)
        self._sizes = sizes.sum(axis=0)[None] if self._samples is None else np.cumsum(sizes, axis=0)[self._samples]
        self._reach = np.abs(turns).max(axis=1)
        self._weight = self._sizes[-1].sum(axis=0)[:, 2, 2] / max(self._sizes[-1].sum(axis=0)[2, 2, 2], 1e-300)
        whole = corners(np.stack([box.low, box.high])[None])[0]
        self._terms = _terms(float(np.abs(box.physical(whole)[1] @ self._half).max()))
        rim = np.abs(np.diff(angles, axis=0)).sum()
        lengths = box.lengths(whole)
        self._longest = float(lengths[:, :2].max() * rim)
        self._rounding = _rounding(len(path), float((lengths[:, :2] / lengths[:, 2:]).max() * rim))
        poses = integrate(angles, believed)
        at = slice(1, None) if anywhere else slice(-1, None)
        self._estimate: Complex = poses[at, 0] + 1j * poses[at, 1]
        own = max(believed.left_radius, believed.right_radius) * rim
        self._estimate_off = believed.track_width * _rounding(len(path), own / believed.track_width)
        self._no_more = (self._longest + own) * _OUTWARD

    def enclose(self, boxes: Array) -> Enclosures:
        """Bounds on the drift over boxes (N, 2, 4)."""
        edges = corners(boxes)
        track, at = self._box.physical(edges)
        center = self._box.physical(boxes.mean(axis=1))[1]
        d = at - center[:, None]
        width = np.abs(d).max(axis=1)
        value, slope, bend = self._series(center)
        linear = track[..., None] * (value[:, None] + np.einsum("nkj,nvj->nvk", slope, d)) - self._estimate
        off = np.abs(linear)
        curved = np.einsum("nkij,ni,nj->nk", np.abs(bend), width, width)
        turned = width @ self._reach
        rest = self._remainder(center, width) + (self._rounding * (2 + turned) ** 2)[:, None]
        bound = off.max(axis=1) + track.max(axis=1)[:, None] * (curved + rest) + self._estimate_off
        worst = off[np.arange(len(boxes)), :, bound.argmax(axis=1)].argmax(axis=1)
        upper = np.minimum(bound.max(axis=1) * _OUTWARD, self._no_more)
        return Enclosures(upper, edges[np.arange(len(boxes)), worst], self._bend(boxes))

    def value(self, points: Array) -> Array:
        """The drift of robots (N, 4), not rounded outwards."""
        track, at = self._box.physical(points)
        turned, half = at @ self._middle, at @ self._half
        chord = (at[:, :2] @ self._way) * _means(half, self._terms)[0] * np.exp(1j * turned)
        where = chord.sum(axis=1)[:, None] if self._samples is None else np.cumsum(chord, axis=1)[:, self._samples]
        found: Array = np.abs(track[:, None] * where - self._estimate).max(axis=1)
        return found

    def _series(self, center: Array) -> tuple[Complex, Complex, Complex]:
        """F_0 (N, K), J (N, K, 3) and Q (N, K, 3, 3) about robots (N, 3), at K ends."""
        turned = center @ self._middle
        direction = np.stack([np.cos(turned), np.sin(turned)])
        means = _means(center @ self._half, self._terms)
        still, first, second = (
            self._sums(direction * mean, columns) for mean, columns in zip(means, self._columns, strict=True)
        )
        turning = 1j * still[..., 2] - first[..., 2, :]  # by a way and by what turns it (N, K, 2, 3)
        mixed = first + np.swapaxes(first, -1, -2)
        twice = np.einsum("ni,nkijl->nkjl", center[:, :2], still + 1j * mixed + second) / -2
        slope = np.einsum("ni,nkij->nkj", center[:, :2], turning)
        slope[..., :2] += still[..., 2, 2]
        twice[..., :2, :] += turning / 2
        twice[..., :2] += np.swapaxes(turning, -1, -2) / 2
        return np.einsum("ni,nki->nk", center[:, :2], still[..., 2, 2]), slope, twice

    def _sums(self, direction: Array, columns: Array) -> Complex:
        """Sums along the path of columns (S, 18) times e^(i theta), given as cosines and sines (2, N, S)."""
        if self._samples is None:
            sums = (direction @ columns)[:, :, None]
        else:
            sums = np.cumsum(direction[..., None] * columns, axis=2)[:, :, self._samples]
        found: Complex = (sums[0] + 1j * sums[1]).reshape(*sums.shape[1:3], 2, 3, 3)
        return found

    def _remainder(self, center: Array, width: Array) -> Array:
        """What the third power and above of a deviation can add to F (N, K)."""
        squares = np.einsum("kijlm,nl,nm->nkij", self._sizes, width, width)
        cubes = np.einsum("ni,nj,nkij->nk", np.abs(center[:, :2]), width, squares)
        found: Array = cubes / 6 + np.einsum("ni,nki->nk", width[:, :2], squares[..., 2]) / 2
        return found

    def _bend(self, boxes: Array) -> Array:
        """How much the robots of boxes turn along the path by each of their coordinates (N, 4)."""
        center = boxes.mean(axis=1)
        sides = center[:, None] + np.eye(4) * (boxes[:, 1] - center)[:, None]
        turned: Array = np.abs(self._box.physical(sides)[1] - self._box.physical(center)[1][:, None]) @ self._weight
        return turned


def _pieces(angles: Array, box: RobotBox) -> tuple[Array, NDArray[np.intp]]:
    """A path of pieces in which no robot of the box turns far, and where in it the samples are."""
    if len(angles) == 1:
        angles = np.repeat(angles, 2, axis=0)
    step = np.diff(angles, axis=0)
    at = box.physical(corners(np.stack([box.low, box.high])[None])[0])[1]
    turn = np.abs(at[:, :2] @ np.stack([step[:, 1] - step[:, 0], step.mean(axis=1)])).max(axis=0)
    count = np.maximum(1, np.ceil(turn / _MOST_TURN)).astype(np.intp)
    samples = np.concatenate([[0], np.cumsum(count)])
    index = np.repeat(np.arange(len(step)), count) + (np.arange(samples[-1]) - np.repeat(samples[:-1], count)) / np.repeat(
        count, count
    )
    fine = [np.interp(np.append(index, len(step)), np.arange(len(angles)), wheel) for wheel in angles.T]
    return np.stack(fine, axis=-1), samples


def _terms(half: float) -> int:
    """How many terms of the series of `_means` leave out less than rounding does, up to a half turn [rad]."""
    count = 1
    while half ** (2 * count) / math.factorial(2 * count + 1) > _UNIT / 8:
        count += 1
    return count


def _means(half: Array, terms: int) -> tuple[Array, Array, Array]:
    """The means over t from -1 to 1 of e^(i half t) times 1, t / i and t^2.

    Each is a series in half^2 whose signs alternate and whose terms fall: what is left out is less than the next one.
    """
    square = half**2
    zeroth, first, second = (np.zeros_like(half) for _ in range(3))
    for n in reversed(range(terms)):
        sign = (-1) ** n
        zeroth = zeroth * square + sign / math.factorial(2 * n + 1)
        first = first * square + sign * (2 * n + 2) / math.factorial(2 * n + 3)
        second = second * square + sign / (math.factorial(2 * n) * (2 * n + 3))
    return zeroth, first * half, second


def _rounding(samples: int, rim: float) -> float:
    """What rounding can add to F on a path of some samples, whose wheels' ways add up to `rim` track widths."""
    return _UNIT * (2 * samples + 64 + 64 * rim) * rim
