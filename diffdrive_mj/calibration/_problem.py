"""Whole trajectories against the true poses: the residuals of all drives, and their derivatives by the parameters.

The nuisance parameters of each drive, its start pose and its clock offset, are solved for within every step (variable
projection, Golub and Pereyra 1973; Kaufman 1975), so that many drives cost no more than their samples.
"""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import optimize

from diffdrive_mj import se2
from diffdrive_mj._checks import Array
from diffdrive_mj.calibration._start import FREE, Start, by_first_pose, first_pose, from_first_pose
from diffdrive_mj.drive import Drive
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.estimation.derivatives import PARAMETERS, parameters_of
from diffdrive_mj.estimation.differences import path_by
from diffdrive_mj.odometry import Method, Step, integrate
from diffdrive_mj.robot import Robot

# Poses this many standard deviations off are outliers: reported, and weighed down.
OUTLIER = 6.0
# The believed robot counts as a measurement of this relative standard deviation: what no path shows stays as believed,
# and positions alone do not lead to other minima far off.
_PRIOR = 0.1
# No truth is better than this [m, rad]; it keeps a perfect recording from claiming perfect knowledge.
_FINEST = 1e-6
# Of how many measurements more than the unknowns fit by themselves the scatter of a kind shows.
_FEWEST_FREE = 2.0
# Steps of a fit, of which a good one takes five.
_STEPS = 100
# Lengths stay within these multiples of what is believed, the turning gain within these of zero.
_LENGTHS, _GAINS = (0.2, 5.0), (-0.4, 0.4)


@dataclass(frozen=True, eq=False)
class DriveTerms:
    """One drive's share of the problem, for its best nuisance parameters.

    Attributes:
        first_pose: the modelled one (3,) [m, m, rad].
        gap: modelled minus true poses (M, 3) [m, m, rad].
        by_parameters: derivatives of the gap by the first P parameters (M, 3, P).
        by_nuisance: derivatives by what is estimated of the first pose, and by the clock offset (M, 3, K).
        clock_step: what is left of the clock offset [s].
    """

    first_pose: Array
    gap: Array
    by_parameters: Array
    by_nuisance: Array
    clock_step: float


class Problem:
    """The residuals of drives, weighted, as a function of the first parameters of a robot.

    Args:
        drives: of one robot.
        believed: the robot as believed so far: the prior.
        start: of each drive: what of its first pose is estimated.
        clock_offset: whether each drive has a clock offset to be solved for.
        headings: whether the headings of the truth count.
        method: of odometry.

    Attributes:
        drives: as given.
        prior_std: standard deviations of the believed parameters (4,).
        has_clock_offset: whether each drive has a clock offset.
        per_drive: how many nuisance parameters each drive has, K.
        components: 3, or 2 without headings.
        counted: which components of each drive's poses are measurements (M, components): the pinned ones are not.
        scale: standard deviations of the truth (3,) [m, m, rad].
        weights: of each drive's poses (M,).
        clock_offsets: the truth's time minus the encoder's, of each drive [s].
        shown: which directions of the P parameters, relative, are fitted (P, P), a projector; None for all.
    """

    def __init__(
        self, drives: Sequence[Drive], believed: Robot, *, start: Start, clock_offset: bool, headings: bool,
        method: Method | Step = "arc",
    ) -> None:  # fmt: skip
        self.drives = drives
        self._robot, self._believed = believed, parameters_of(believed)
        self.start, self.has_clock_offset, self.method = start, clock_offset, method
        self.per_drive = len(FREE[start]) + clock_offset
        self.components = 3 if headings else 2
        self.counted = [np.ones((len(drive.truth), self.components), dtype=bool) for drive in drives]
        for counted in self.counted:
            counted[0, [k for k in range(self.components) if k not in FREE[start]]] = False
        self.clock_offsets = np.zeros(len(drives))
        self.scale = np.array([1e-3, 1e-3, 1e-3])
        self.weights = [np.ones(len(drive.truth)) for drive in drives]
        # Relative for lengths, absolute for the gain.
        self.prior_std = _PRIOR * np.where(np.arange(4) == 3, 1.0, self._believed)
        self.shown: Array | None = None
        self._last: tuple[bytes, list[DriveTerms]] | None = None
        measurements = sum(int(counted.sum()) for counted in self.counted)
        unknowns = 3 + self.per_drive * len(drives)
        if measurements < unknowns:
            raise InvalidValue(
                f"drives: {measurements} measurements for {unknowns} unknowns; more drives or poses are needed"
            )

    def on(self, drives: Sequence[Drive]) -> Problem:
        """The same problem, of other drives with as many true poses."""
        other = copy.copy(self)
        other.drives, other._last = drives, None
        return other

    def as_shown(self, x: Array) -> Array:
        """Parameters (P,), as believed in the directions that are not fitted."""
        if self.shown is None:
            return x
        believed, unit = self._believed[: len(x)], self.prior_std[: len(x)]
        return np.asarray(believed + unit * (self.shown @ ((x - believed) / unit)))

    def sampling_bias(self, x: Array) -> Array:
        """How far off the parameters (P,) may be since the curvature changes between two readings of the encoder.

        The error of taking steps for arcs is of second order: without every second reading it is four times as large,
        so that a third of the change is what is left in the fit.
        """
        thinned = self.on(
            [
                replace(drive, t=drive.t[kept], wheel_angles=drive.wheel_angles[kept], truth_t=drive.clock)
                for drive in self.drives
                for kept in [np.union1d(np.arange(0, len(drive.t), 2), [len(drive.t) - 1])]
            ]
        )
        jacobian = thinned.jacobian(x)
        change = np.linalg.solve(jacobian.T @ jacobian, jacobian.T @ (self.residuals(x) - thinned.residuals(x)))
        return np.asarray(change / 3, dtype=np.float64)

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
            xtol=1e-10, ftol=1e-10, gtol=1e-12, max_nfev=_STEPS,
        )  # fmt: skip
        return np.asarray(found.x, dtype=np.float64)

    def residuals(self, x: Array) -> Array:
        """Modelled minus measured, weighted, for the best nuisance parameters; then those of the prior."""
        weighted = [self.weighted(i, terms.gap).ravel() for i, terms in enumerate(self.terms(x))]
        return np.concatenate([*weighted, (x - self._believed[: len(x)]) / self.prior_std[: len(x)]])

    def jacobian(self, x: Array) -> Array:
        """Derivatives of the residuals by the parameters, the nuisance columns projected out (Kaufman 1975)."""
        blocks, unit = [self._projected(i, terms) for i, terms in enumerate(self.terms(x))], self.prior_std[: len(x)]
        columns = np.concatenate(blocks)
        if self.shown is not None:
            columns = columns * unit @ self.shown / unit
        return np.concatenate([columns, np.diag(1 / unit)])

    def reweigh(self, x: Array) -> bool:
        """Set scales and weights from the residuals; return whether they have settled."""
        parts = self.terms(x)
        scale = self._scale(x)
        self.clock_offsets = self.clock_offsets + [terms.clock_step for terms in parts]
        settled = bool(np.allclose(scale, self.scale, rtol=1e-2))
        self.scale = scale
        off = [np.abs(terms.gap / scale)[:, : self.components].max(axis=1) for terms in parts]
        # Huber's weights, beyond half an outlier.
        self.weights = [np.minimum(1.0, OUTLIER / 2 / np.maximum(each, 1e-12)) for each in off]
        self._last = None
        return settled

    def _scale(self, x: Array) -> Array:
        """Standard deviations of the truth (3,), from the residuals and how many of them the unknowns use up."""
        gaps, counted = np.concatenate([terms.gap for terms in self.terms(x)]), np.concatenate(self.counted)
        used = self._used(x)
        kinds = [slice(0, 2), slice(2, 3)][: self.components - 1]
        measured = [gaps[:, kind][counted[:, kind]] for kind in kinds]
        freedom = [len(values) - used[kind].sum() for values, kind in zip(measured, kinds, strict=True)]
        scale = self.scale.copy()
        if min(freedom) < _FEWEST_FREE:
            # One kind may fit exactly, which is not precision: the two keep their ratio.
            together = np.concatenate([values / scale[kind][0] for values, kind in zip(measured, kinds, strict=True)])
            return np.maximum(scale * np.sqrt(together @ together / max(sum(freedom), 1.0)), _FINEST)
        for kind, values, free in zip(kinds, measured, freedom, strict=True):
            scale[kind] = max(_spread(values) * np.sqrt(len(values) / free), _FINEST)
        return scale

    def _used(self, x: Array) -> Array:
        """How many of the measurements of each component (components,) the unknowns fit by themselves."""
        parts = self.terms(x)
        blocks = [self._projected(i, terms) for i, terms in enumerate(parts)]
        information = sum(block.T @ block for block in blocks) + np.diag(1 / self.prior_std[: len(x)] ** 2)
        used = np.zeros(self.components)
        for i, (block, terms) in enumerate(zip(blocks, parts, strict=True)):
            basis = self.weighted(i, terms.by_nuisance).reshape(len(block), self.per_drive)
            share = (block * np.linalg.solve(information, block.T).T).sum(axis=1)
            share += _leverage(basis)
            used += share.reshape(-1, self.components).sum(axis=0)
        return used

    def terms(self, x: Array) -> list[DriveTerms]:
        """Each drive's share; that of the last parameters is kept."""
        key = x.tobytes()
        if self._last is None or self._last[0] != key:
            parameters = self.completed(x)
            self._last = (key, [self._terms(i, parameters, len(x)) for i in range(len(self.drives))])
        return self._last[1]

    def paths(self, i: int, x: Array, wheel_angles: Array) -> Array:
        """Where parameters (P,) put drive i if its wheels had turned otherwise (..., T, 2), from the same first pose.

        Returns:
            (..., M, 3) [m, m, rad].
        """
        drive = self.drives[i]
        at = np.clip(drive.clock - self.clock_offsets[i], drive.t[0], drive.t[-1])
        times = np.union1d(drive.t, at)
        angles = np.apply_along_axis(lambda wheel: np.interp(times, drive.t, wheel), -2, wheel_angles)
        robot = self._robot.replace(**dict(zip(PARAMETERS, map(float, self.completed(x)), strict=True)))
        poses = integrate(angles, robot, self.method)[..., np.searchsorted(times, at), :]
        return se2.compose(self.terms(x)[i].first_pose, se2.between(poses[..., :1, :], poses))

    def weighted(self, i: int, rows: Array) -> Array:
        """Rows (M, 3, ...) of a drive in units of their scale, by the root of their weights; headings if they count."""
        factor = np.sqrt(self.weights[i])[:, None] / self.scale
        return (rows * factor.reshape(*factor.shape, *[1] * (rows.ndim - 2)))[:, : self.components]

    def _terms(self, i: int, parameters: Array, count: int) -> DriveTerms:
        drive, free = self.drives[i], FREE[self.start]
        path = path_by(self.method, drive, self._robot, parameters, self.clock_offsets[i], count)
        path = from_first_pose(path)
        pose = first_pose(drive.truth, path, laid_over=2 in free and self.components == 2)
        for _ in range(4 if free else 1):
            gap = se2.compose(pose, path.poses) - drive.truth
            gap[:, 2] = se2.wrap_angle(gap[:, 2])
            by_nuisance = by_first_pose(path, pose)[..., free]
            if self.has_clock_offset:
                by_nuisance = np.concatenate([by_nuisance, -_turned(path.velocity, pose[2])[..., None]], axis=-1)
            step = self._best_step(i, gap, by_nuisance)
            pose[free] += step[: len(free)]
            if np.abs(step[: len(free)]).max(initial=0.0) < 1e-13:
                break
        clock_step = 0.0
        if self.has_clock_offset:
            clock_step = float(step[-1])
            gap = gap + by_nuisance[..., -1] * clock_step
        return DriveTerms(pose, gap, np.moveaxis(_turned(path.by_parameters, pose[2]), 0, -1), by_nuisance, clock_step)

    def _best_step(self, i: int, gap: Array, by_nuisance: Array) -> Array:
        """The step of a drive's nuisance parameters (K,) that takes out most of the gap."""
        columns = self.weighted(i, by_nuisance).reshape(len(gap) * self.components, by_nuisance.shape[-1])
        return -_fitted(columns, self.weighted(i, gap).ravel())

    def _projected(self, i: int, terms: DriveTerms) -> Array:
        columns = self.weighted(i, terms.by_parameters).reshape(-1, terms.by_parameters.shape[-1])
        if not self.per_drive:
            return columns
        basis = self.weighted(i, terms.by_nuisance).reshape(-1, self.per_drive)
        return columns - basis @ _fitted(basis, columns)


def _spread(values: Array) -> float:
    """The standard deviation that most values agree on."""
    robust = 1.4826 * float(np.median(np.abs(values)))
    plain = float(np.sqrt(np.mean(values**2)))
    return plain if plain < 2 * robust else robust


def _leverage(columns: Array) -> Array:
    """How far each row is fitted by the columns themselves (N,)."""
    if not columns.shape[1]:
        return np.zeros(len(columns))
    return np.asarray(
        (columns @ np.linalg.pinv(columns.T @ columns, rcond=1e-13, hermitian=True) * columns).sum(axis=1)
    )


def _fitted(columns: Array, rows: Array) -> Array:
    """What multiples of the columns fit rows best; none of those that they do not show, such as a heading at rest."""
    if not columns.shape[1]:
        return np.zeros((0, *rows.shape[1:]))
    return np.asarray(np.linalg.lstsq(columns.T @ columns, columns.T @ rows, rcond=1e-13)[0], dtype=np.float64)


def _turned(derivative: Array, angle: float) -> Array:
    """Derivatives of poses (..., 3), turned into the frame of the truth."""
    return np.concatenate([se2.rotate(derivative[..., :2], angle), derivative[..., 2:]], axis=-1)
