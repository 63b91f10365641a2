"""Whole trajectories against the true poses: the residuals of all drives, and their derivatives by the parameters.

The nuisance parameters of each drive, its start pose and its clock offset, are solved for within every step (variable
projection, Golub and Pereyra 1973; Kaufman 1975), so that many drives cost no more than their samples.
"""

from __future__ import annotations

import copy
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

# Poses this many standard deviations off are outliers: reported, and weighed down.
OUTLIER = 6.0
# The believed robot counts as a measurement of this relative standard deviation: what no path shows stays as believed.
_PRIOR = 1.0
# Positions alone have other minima far off, which a tighter prior keeps out.
_PRIOR_OF_FIXES = 0.1
# No truth is better than this [m, rad]; it keeps a perfect recording from claiming perfect knowledge.
_FINEST = 1e-6
# Lengths stay within these multiples of what is believed, the turning gain within these of zero.
_LENGTHS, _GAINS = (0.2, 5.0), (-0.4, 0.4)


@dataclass(frozen=True, eq=False)
class DriveTerms:
    """One drive's share of the problem, for its best nuisance parameters.

    Attributes:
        gap: modelled minus true poses (M, 3) [m, m, rad].
        by_parameters: derivatives of the gap by the first P parameters (M, 3, P).
        by_nuisance: derivatives by the start pose and the clock offset, as far as they are estimated (M, 3, K).
        clock_step: what is left of the clock offset [s].
    """

    gap: Array
    by_parameters: Array
    by_nuisance: Array
    clock_step: float


class Problem:
    """The residuals of drives, weighted, as a function of the first parameters of a robot.

    Args:
        drives: of one robot.
        believed: the robot as believed so far: the prior.
        start: of each drive: "estimated", or the first pose of the "truth".
        clock_offset: whether each drive has a clock offset to be solved for.
        headings: whether the headings of the truth count.

    Attributes:
        drives: as given.
        prior_std: standard deviations of the believed parameters (4,).
        has_clock_offset: whether each drive has a clock offset.
        per_drive: how many nuisance parameters each drive has, K.
        components: 3, or 2 without headings.
        scale: standard deviations of the truth (3,) [m, m, rad].
        weights: of each drive's poses (M,).
        clock_offsets: of the drives [s].
    """

    def __init__(
        self, drives: Sequence[Drive], believed: Robot, *, start: Start, clock_offset: bool, headings: bool
    ) -> None:
        self.drives = drives
        self._believed = parameters_of(believed)
        self._start, self.has_clock_offset = start, clock_offset
        self.per_drive = (3 if start == "estimated" else 0) + clock_offset
        self.components = 3 if headings else 2
        self.clock_offsets = np.zeros(len(drives))
        self.scale = np.array([1e-3, 1e-3, 1e-3])
        self.weights = [np.ones(len(drive.truth)) for drive in drives]
        # Relative for lengths, absolute for the gain.
        self.prior_std = (_PRIOR if headings else _PRIOR_OF_FIXES) * np.where(np.arange(4) == 3, 1.0, self._believed)
        self._last: tuple[bytes, list[DriveTerms]] | None = None
        measurements = self.components * sum(len(drive.truth) for drive in drives)
        unknowns = 3 + self.per_drive * len(drives)
        if measurements < unknowns:
            raise InvalidValue(
                f"drives: {measurements} measurements for {unknowns} unknowns; more drives or poses are needed"
            )

    def thinned(self) -> Problem:
        """The same problem with every second reading of the encoders left out, at the same scales and weights."""
        other = copy.copy(self)
        other._last = None
        other.drives = [
            replace(drive, t=drive.t[kept], wheel_angles=drive.wheel_angles[kept], truth_t=drive.clock)
            for drive in self.drives
            for kept in [np.union1d(np.arange(0, len(drive.t), 2), [len(drive.t) - 1])]
        ]
        return other

    def completed(self, x: Array) -> Array:
        """All the parameters (4,) of which x are the first: the others are as believed."""
        return np.concatenate([x, self._believed[len(x) :]])

    def solve(self, x: Array) -> Array:
        """The best parameters from a first guess x (P,), within bounds."""
        is_gain, lengths = np.arange(len(x)) == 3, self._believed[: len(x)]
        lowest, highest = (
            np.where(is_gain, gain, length * lengths) for gain, length in zip(_GAINS, _LENGTHS, strict=True)
        )
        found = optimize.least_squares(
            self.residuals, x, self.jacobian, bounds=(lowest, highest), x_scale=self.prior_std[: len(x)] * 1e-3,
            xtol=1e-10, ftol=1e-10, gtol=1e-12,
        )  # fmt: skip
        return np.asarray(found.x, dtype=np.float64)

    def residuals(self, x: Array) -> Array:
        """Modelled minus measured, weighted, for the best nuisance parameters; then those of the prior."""
        weighted = [self._weighted(i, terms.gap).ravel() for i, terms in enumerate(self.terms(x))]
        return np.concatenate([*weighted, (x - self._believed[: len(x)]) / self.prior_std[: len(x)]])

    def jacobian(self, x: Array) -> Array:
        """Derivatives of the residuals by the parameters, the nuisance columns projected out (Kaufman 1975)."""
        blocks = [self._projected(i, terms) for i, terms in enumerate(self.terms(x))]
        return np.concatenate([*blocks, np.diag(1 / self.prior_std[: len(x)])])

    def reweigh(self, x: Array) -> bool:
        """Set scales and weights from the residuals; return whether they have settled."""
        parts = self.terms(x)
        rows = np.concatenate([terms.gap for terms in parts])
        scale = np.array([_spread(rows[:, :2])] * 2 + [_spread(rows[:, 2:])])
        self.clock_offsets = self.clock_offsets + [terms.clock_step for terms in parts]
        settled = bool(np.allclose(scale[: self.components], self.scale[: self.components], rtol=1e-2))
        self.scale = scale
        for i, terms in enumerate(parts):
            off = np.abs(terms.gap / scale)[:, : self.components].max(axis=1)
            # Huber's weights, beyond half an outlier.
            self.weights[i] = np.minimum(1.0, OUTLIER / 2 / np.maximum(off, 1e-12))
        self._last = None
        return settled

    def terms(self, x: Array) -> list[DriveTerms]:
        """Each drive's share; that of the last parameters is kept."""
        key = x.tobytes()
        if self._last is None or self._last[0] != key:
            parameters = self.completed(x)
            self._last = (key, [self._terms(i, parameters, len(x)) for i in range(len(self.drives))])
        return self._last[1]

    def _terms(self, i: int, parameters: Array, count: int) -> DriveTerms:
        drive = self.drives[i]
        path = trajectory(drive, parameters, self.clock_offsets[i], count)
        pose = self._first_pose(drive, path)
        for _ in range(4 if self._start == "estimated" else 1):
            gap = se2.compose(pose, path.poses) - drive.truth
            gap[:, 2] = se2.wrap_angle(gap[:, 2])
            by_nuisance = self._by_nuisance(path, pose)
            if self._start == "truth":
                break
            step = self._best_step(i, gap, by_nuisance)
            pose = pose + step[:3]
            if np.abs(step[:3]).max() < 1e-13:
                break
        clock_step = 0.0
        if self.has_clock_offset:
            clock_step = float(self._best_step(i, gap, by_nuisance)[-1])
            gap = gap + by_nuisance[..., -1] * clock_step
        slopes = np.moveaxis(_turned(path.by_parameters, pose[2]), 0, -1)
        if self._start == "truth":
            # The first pose is pinned: the path moves and turns about it.
            lever = se2.compose(pose, path.poses)[:, :2] - drive.truth[0, :2]
            first_heading = path.by_parameters[:, 0, 2]
            slopes = slopes - slopes[:1]
            slopes[:, 0] += lever[:, 1:] * first_heading
            slopes[:, 1] -= lever[:, :1] * first_heading
        return DriveTerms(gap, slopes, by_nuisance, clock_step)

    def _first_pose(self, drive: Drive, path: Trajectory) -> Array:
        """The pose of the encoder's first sample: such that the first true pose is met, or the path as a whole."""
        if self._start == "truth" or self.components == 3:
            return se2.compose(drive.truth[0], se2.inverse(path.poses[0]))
        at, true = path.poses[:, :2] - path.poses[0, :2], drive.truth[:, :2] - drive.truth[0, :2]
        turn = np.arctan2((at[:, 0] * true[:, 1] - at[:, 1] * true[:, 0]).sum(), (at * true).sum())
        return np.array([*(drive.truth[0, :2] - se2.rotate(path.poses[0, :2], turn)), turn])

    def _by_nuisance(self, path: Trajectory, pose: Array) -> Array:
        """Derivatives of poses by a drive's start pose and its clock offset (M, 3, K)."""
        columns = []
        if self._start == "estimated":
            moved = se2.rotate(path.poses[:, :2], pose[2])
            one, zero = np.ones(len(moved)), np.zeros(len(moved))
            columns = [
                np.stack([one, zero, zero], axis=1),
                np.stack([zero, one, zero], axis=1),
                np.stack([-moved[:, 1], moved[:, 0], one], axis=1),
            ]
        if self.has_clock_offset:
            columns.append(_turned(path.velocity, pose[2]))
        return np.stack(columns, axis=-1) if columns else np.zeros((len(path.poses), 3, 0))

    def _weighted(self, i: int, rows: Array) -> Array:
        """Rows (M, 3, ...) of a drive in units of their scale, by the root of their weights; headings if they count."""
        factor = np.sqrt(self.weights[i])[:, None] / self.scale
        return (rows * factor.reshape(*factor.shape, *[1] * (rows.ndim - 2)))[:, : self.components]

    def _best_step(self, i: int, gap: Array, by_nuisance: Array) -> Array:
        """The step of a drive's nuisance parameters (K,) that takes out most of the gap."""
        columns = self._weighted(i, by_nuisance).reshape(-1, by_nuisance.shape[-1])
        left = self._weighted(i, gap).ravel()
        return np.asarray(-np.linalg.solve(columns.T @ columns, columns.T @ left), dtype=np.float64)

    def _projected(self, i: int, terms: DriveTerms) -> Array:
        columns = self._weighted(i, terms.by_parameters).reshape(-1, terms.by_parameters.shape[-1])
        if not self.per_drive:
            return columns
        basis = self._weighted(i, terms.by_nuisance).reshape(-1, self.per_drive)
        return columns - basis @ np.linalg.solve(basis.T @ basis, basis.T @ columns)


def _spread(values: Array) -> float:
    """The standard deviation that most values agree on."""
    robust = 1.4826 * float(np.median(np.abs(values)))
    plain = float(np.sqrt(np.mean(values**2)))
    return max(plain if plain < 2 * robust else robust, _FINEST)


def _turned(derivative: Array, angle: float) -> Array:
    """Derivatives of poses (..., 3), turned into the frame of the truth."""
    return np.concatenate([se2.rotate(derivative[..., :2], angle), derivative[..., 2:]], axis=-1)
