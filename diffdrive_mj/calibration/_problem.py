"""Refining whole trajectories: residuals of all the drives, and their derivatives by the robot's parameters.

What each drive has of its own, its start pose and its clock's offset, is solved for within every step (variable
projection, Golub and Pereyra 1973; Kaufman 1975), so that many drives cost no more than their samples.
"""

from __future__ import annotations

import copy
import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from scipy import optimize

from diffdrive_mj import se2
from diffdrive_mj._checks import Array
from diffdrive_mj.drive import Drive
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.estimation.derivatives import Trajectory, parameters_of, trajectory
from diffdrive_mj.robot import Robot

Start = Literal["estimated", "truth"]

# The believed robot counts as a measurement of this relative standard deviation: what no path shows stays as believed.
_PRIOR = 1.0
# Positions alone have other minima far off, which a tighter one keeps out.
_PRIOR_OF_FIXES = 0.1
# Poses this many standard deviations off are outliers: reported, and weighed down.
OUTLIER = 6.0
# No truth is better than this [m, rad]; it keeps a perfect recording from claiming perfect knowledge.
_FINEST = 1e-6
# The turning gain is freed when it is this many standard deviations from zero.
SIGNIFICANT = 4.0


@dataclass(frozen=True, eq=False)
class Fit:
    """Where a refinement ended.

    Attributes:
        parameters: (4,), the free ones and those believed.
        covariance: of the free ones (P, P).
        residuals: weighed (N,).
        condition: of the problem in relative units.
        outliers: how many poses of each drive lie far off.
        spreads: root mean square of each drive's residuals.
        white: whether residuals in a row have little to do with each other.
        details: further figures by name.
    """

    parameters: Array
    covariance: Array
    residuals: Array
    condition: float
    outliers: list[int]
    spreads: list[float]
    white: bool
    details: dict[str, float]


def refine(problem: Problem, guess: Array, free: int) -> Fit:
    """Refine the first `free` parameters; weigh positions, headings and outliers by what they leave over."""
    x = guess[:free]
    for _ in range(5):
        x = problem.solve(x)
        if problem.reweigh(x):
            break
    return problem.fit(x)


def _spread(values: Array) -> float:
    """The standard deviation that most values agree on."""
    robust = 1.4826 * float(np.median(np.abs(values)))
    plain = float(np.sqrt(np.mean(values**2)))
    return max(plain if plain < 2 * robust else robust, _FINEST)


class Problem:
    """Residuals and derivatives by the parameters, the drives' own unknowns solved for."""

    def __init__(
        self, drives: Sequence[Drive], believed: Robot, start: Start, clock_offset: bool, headings: bool
    ) -> None:
        self._drives, self._believed = drives, parameters_of(believed)
        self._start = start
        self._own = (3 if start == "estimated" else 0) + clock_offset
        self._clock = clock_offset
        self._width = 3 if headings else 2
        # Of the truth's clock: as taken along the path so far, and what is left of it to first order.
        self._offsets, self._late = np.zeros(len(drives)), np.zeros(len(drives))
        self._scale = np.array([1e-3, 1e-3, 1e-3])
        self._weights = [np.ones(len(drive.truth)) for drive in drives]
        # Relative for lengths, absolute for the gain.
        self.doubt = (_PRIOR if headings else _PRIOR_OF_FIXES) * np.where(np.arange(4) == 3, 1.0, self._believed)
        self._last: tuple[bytes, tuple[list[Array], list[Array], list[Array]]] | None = None
        measurements, unknowns = self._width * sum(len(d.truth) for d in drives), 3 + self._own * len(drives)
        if measurements < unknowns:
            raise InvalidValue(
                f"drives: {measurements} measurements for {unknowns} unknowns; more drives or poses are needed"
            )

    def wants_gain(self, parameters: Array) -> bool:
        """Whether a step of the turning gain too, from a fit without it, would be worth a fit of its own."""
        jacobian = self.jacobian(parameters)
        inverse = np.linalg.inv(jacobian.T @ jacobian)
        step = inverse @ (jacobian.T @ self.residuals(parameters))
        return bool(abs(step[3]) > SIGNIFICANT / 2 * np.sqrt(inverse[3, 3]))

    def thinned(self) -> Problem:
        """The same problem with every second reading of the encoders left out, at the same scales and weights."""
        other = copy.copy(self)
        other._last = None
        other._drives = [
            replace(drive, t=drive.t[kept], wheel_angles=drive.wheel_angles[kept], truth_t=drive.clock)
            for drive in self._drives
            for kept in [np.union1d(np.arange(0, len(drive.t), 2), [len(drive.t) - 1])]
        ]
        return other

    def solve(self, x: Array) -> Array:
        """The best parameters from a first guess; lengths stay within a fifth and five times what is believed."""
        center = np.where(np.arange(len(x)) == 3, 0.0, self._believed[: len(x)])
        lowest = np.where(np.arange(len(x)) == 3, -0.4, center / 5)
        highest = np.where(np.arange(len(x)) == 3, 0.4, center * 5)
        found = optimize.least_squares(
            self.residuals, x, self.jacobian, bounds=(lowest, highest), x_scale=self.doubt[: len(x)] * 1e-3,
            xtol=1e-10, ftol=1e-10, gtol=1e-12,
        )  # fmt: skip
        return np.asarray(found.x, dtype=np.float64)

    def residuals(self, x: Array) -> Array:
        """Modelled minus measured, weighed, for the best unknowns of each drive; then the prior's."""
        gaps, _, _ = self._evaluate(x)
        weighed = [(self._weigh(i, gap)).ravel() for i, gap in enumerate(gaps)]
        return np.concatenate([*weighed, (x - self._believed[: len(x)]) / self.doubt[: len(x)]])

    def jacobian(self, x: Array) -> Array:
        """Derivatives of the residuals: the parameters' columns with the drives' own projected out (Kaufman 1975)."""
        _, slopes, own = self._evaluate(x)
        blocks = [self._projected(i, slopes[i][..., : len(x)], own[i]) for i in range(len(self._drives))]
        return np.concatenate([*blocks, np.diag(1 / self.doubt[: len(x)])])

    def reweigh(self, x: Array) -> bool:
        """Scales and weights from the residuals; whether they have settled."""
        gaps, _, _ = self._evaluate(x)
        rows = np.concatenate(gaps)
        scale = np.array([_spread(rows[:, :2])] * 2 + [_spread(rows[:, 2:])])
        self._offsets, self._late = self._offsets + self._late, np.zeros_like(self._late)
        settled = bool(np.allclose(scale[: self._width], self._scale[: self._width], rtol=1e-2))
        self._scale = scale
        for i, gap in enumerate(gaps):
            off = np.abs(gap / scale)[:, : self._width].max(axis=1)
            # Huber's weights, beyond half an outlier.
            self._weights[i] = np.minimum(1.0, OUTLIER / 2 / np.maximum(off, 1e-12))
        self._last = None
        return settled

    def _evaluate(self, x: Array) -> tuple[list[Array], list[Array], list[Array]]:
        """Each drive's gaps (M, 3), their derivatives by the parameters (M, 3, 4) and by its own unknowns (M, 3, k)."""
        key = x.tobytes()
        if self._last is None or self._last[0] != key:
            parameters = self._believed.copy()
            parameters[: len(x)] = x
            parts = [self._drive(i, parameters, len(x)) for i in range(len(self._drives))]
            gaps, slopes, own = (list(part) for part in zip(*parts, strict=True))
            self._last = (key, (gaps, slopes, own))
        return self._last[1]

    def _drive(self, i: int, parameters: Array, count: int) -> tuple[Array, Array, Array]:
        drive = self._drives[i]
        path = trajectory(drive, parameters, self._offsets[i], count)
        pose = self._first_pose(drive, path)
        for _ in range(4 if self._start == "estimated" else 1):
            gap = se2.compose(pose, path.poses) - drive.truth
            gap[:, 2] = se2.wrap_angle(gap[:, 2])
            own = self._own_slopes(path, pose)
            if self._start == "truth":
                break
            step = self._solve(i, gap, own)
            pose = pose + step[:3]
            if np.abs(step[:3]).max() < 1e-13:
                break
        if self._clock:
            self._late[i] = self._solve(i, gap, own)[-1]
            gap = gap + own[..., -1] * self._late[i]
        slopes = np.stack([_turned(part, pose[2]) for part in path.by_parameters], axis=-1)
        if self._start == "truth":  # the start is pinned: derivatives of the way from it
            slopes = slopes - slopes[:1]
            lever = se2.compose(pose, path.poses)[:, :2] - drive.truth[0, :2]
            heading = _turned(path.by_parameters[:, 0], 0.0)[:, 2]
            slopes[:, 0] -= -lever[:, 1:] * heading
            slopes[:, 1] -= lever[:, :1] * heading
        return gap, slopes, own

    def _first_pose(self, drive: Drive, path: Trajectory) -> Array:
        """The pose of the encoder's first sample: such that the first true pose is met, or the path as a whole."""
        first = se2.compose(drive.truth[0], se2.inverse(path.poses[0]))
        if self._start == "truth" or self._width == 3:
            return first
        at, true = path.poses[:, :2] - path.poses[0, :2], drive.truth[:, :2] - drive.truth[0, :2]
        turn = np.arctan2((at[:, 0] * true[:, 1] - at[:, 1] * true[:, 0]).sum(), (at * true).sum())
        return np.array([*(drive.truth[0, :2] - se2.rotate(path.poses[0, :2], turn)), turn])

    def _own_slopes(self, path: Trajectory, pose: Array) -> Array:
        """Derivatives of poses by a drive's start pose and its clock's offset (M, 3, k)."""
        columns = []
        if self._start == "estimated":
            moved = se2.rotate(path.poses[:, :2], pose[2])
            one, zero = np.ones(len(moved)), np.zeros(len(moved))
            columns = [
                np.stack([one, zero, zero], axis=1),
                np.stack([zero, one, zero], axis=1),
                np.stack([-moved[:, 1], moved[:, 0], one], axis=1),
            ]
        if self._clock:
            columns.append(_turned(path.velocity, pose[2]))
        return np.stack(columns, axis=-1) if columns else np.zeros((len(path.poses), 3, 0))

    def _weigh(self, i: int, rows: Array) -> Array:
        """Rows (M, 3, ...) in units of their scale, by the root of their weights; no headings if they do not count."""
        factor = np.sqrt(self._weights[i])[:, None] / self._scale
        return (rows * factor.reshape(*factor.shape, *[1] * (rows.ndim - 2)))[:, : self._width]

    def _solve(self, i: int, gap: Array, own: Array) -> Array:
        """The step of a drive's own unknowns that takes out most of the gap."""
        columns, left = self._weigh(i, own).reshape(-1, own.shape[-1]), self._weigh(i, gap).ravel()
        return np.asarray(-np.linalg.solve(columns.T @ columns, columns.T @ left), dtype=np.float64)

    def _projected(self, i: int, slopes: Array, own: Array) -> Array:
        columns = self._weigh(i, slopes).reshape(-1, slopes.shape[-1])
        if not own.shape[-1]:
            return columns
        basis = self._weigh(i, own).reshape(-1, own.shape[-1])
        return columns - basis @ np.linalg.solve(basis.T @ basis, basis.T @ columns)

    def fit(self, x: Array) -> Fit:
        """Parameters, their covariance, and what the drives show of them."""
        gaps, _, _ = self._evaluate(x)
        jacobian, left = self.jacobian(x), self.residuals(x)
        measured = left[: -len(x)]
        freedom = max(len(measured) - len(x) - self._own * len(self._drives), 1)
        variance = max(1.0, float(measured @ measured) / freedom)
        inverse = np.linalg.inv(jacobian.T @ jacobian)
        edges = np.cumsum([0, *(len(gap) * self._width for gap in gaps)])
        pieces = [measured[a:b].reshape(-1, self._width) for a, b in itertools.pairwise(edges)]
        white = _correlation(pieces) < 0.5
        # The prior is no measurement: its share does not shrink with the residuals.
        prior = np.diag(1 / self.doubt[: len(x)] ** 2)
        covariance = inverse @ (variance * (jacobian.T @ jacobian - prior) + prior) @ inverse
        if not white:
            scores = (jacobian[: -len(x)] * measured[:, None]) @ inverse
            covariance = covariance * max(1.0, _inflation(scores, edges, self._width, variance * np.diag(inverse)))
        singular = np.linalg.svd(jacobian[: -len(x)] * self.doubt[: len(x)], compute_uv=False)
        condition = float(singular[0] / singular[-1]) if singular[-1] > 0 else float("inf")
        details = {"position_residual_m": float(self._scale[0])}
        if self._width == 3:
            details["heading_residual_rad"] = float(self._scale[2])
        if self._clock:
            details["clock_offset_s"] = float(np.mean(self._offsets))
        parameters = self._believed.copy()
        parameters[: len(x)] = x
        outliers = [int(np.count_nonzero(weights < 0.5)) for weights in self._weights]
        spreads = [float(np.sqrt(np.mean(piece**2))) for piece in pieces]
        return Fit(parameters, covariance, measured, condition, outliers, spreads, white, details)


def _correlation(pieces: Sequence[Array]) -> float:
    """How alike the residuals (M, k) of two poses in a row are, from -1 to 1."""
    long = [piece for piece in pieces if len(piece) > 10]
    if not long:
        return 0.0
    together = np.concatenate([piece[:-1] * piece[1:] for piece in long])
    return float(together.mean() / np.mean(np.concatenate(long) ** 2))


def _inflation(scores: Array, edges: Array, width: int, variances: Array) -> float:
    """How much larger the variances are when residuals wander: sums of the scores over tenths of each drive decide."""
    sums = []
    for a, b in itertools.pairwise(edges):
        sums += [piece.sum(axis=0) for piece in np.array_split(scores[a:b], min(10, (b - a) // width))]
    return float(np.mean(np.sum(np.square(sums), axis=0) / variances))


def _turned(derivative: Array, angle: float) -> Array:
    """Derivatives of poses (M, 3), turned into the frame of the truth."""
    return np.concatenate([se2.rotate(derivative[:, :2], angle), derivative[:, 2:]], axis=1)
