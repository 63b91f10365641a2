"""Judging an estimated path against the true one.

`drift` compares the poses as they are, from a common start: what a robot feels. `ate` (absolute trajectory
error) may align first; `rpe` (relative pose error) compares stretches of equal length or duration, paired
by the truth. Headings are compared on the circle.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj import _checks as checks
from diffdrive_mj import se2
from diffdrive_mj._checks import Array, array
from diffdrive_mj._text import span
from diffdrive_mj.errors import InvalidType, InvalidValue

ALIGNMENTS = ("origin", "none", "se2")


@dataclass(frozen=True, eq=False)
class Drift:
    """What an estimate is off by, along the drive. Leading dimensions are those of the runs.

    Attributes:
        distance: driven, from the truth (...) [m].
        travelled: driven up to each sample (..., T) [m].
        position_error: (..., T) [m].
        heading_error: estimate minus truth on the circle (..., T) [rad], in (-pi, pi].
        warnings: what to know before relying on it, such as a wheel that slipped; printed below the figures.
    """

    distance: Array
    travelled: Array
    position_error: Array
    heading_error: Array
    warnings: tuple[str, ...] = ()

    @property
    def max_position(self) -> Array:
        """The largest position error along the drive (...) [m]."""
        return np.asarray(self.position_error.max(axis=-1))[()]

    @property
    def final_position(self) -> Array:
        """The position error at the end (...) [m]."""
        return self.position_error[..., -1]

    @property
    def final_position_rms(self) -> float:
        """Root mean square of the final position errors of all the runs [m]."""
        return float(np.sqrt(np.mean(self.final_position**2)))

    @property
    def max_heading(self) -> Array:
        """The largest size of the heading error along the drive (...) [rad]."""
        return np.asarray(np.abs(self.heading_error).max(axis=-1))[()]

    @property
    def final_heading(self) -> Array:
        """The heading error at the end, signed (...) [rad]."""
        return self.heading_error[..., -1]

    @property
    def max_position_per_metre(self) -> Array:
        """The largest position error over the whole distance (...) [m/m]."""
        return self._per_metre(self.max_position)

    @property
    def final_position_per_metre(self) -> Array:
        """[m/m]."""
        return self._per_metre(self.final_position)

    @property
    def max_heading_per_metre(self) -> Array:
        """[rad/m]."""
        return self._per_metre(self.max_heading)

    @property
    def final_heading_per_metre(self) -> Array:
        """[rad/m], signed."""
        return self._per_metre(self.final_heading)

    def _per_metre(self, error: Array) -> Array:
        # Standing still: no error is no drift, any other error is infinite.
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(error == 0, 0.0, error / self.distance)[()]

    def summary(self) -> str:
        """The position errors of all the runs in one line."""
        return (
            f"final position {1e3 * self.final_position_rms:.4g} mm RMS, {1e3 * np.max(self.final_position):.4g} mm "
            f"at most; on the way {1e3 * np.max(self.max_position):.4g} mm at most"
        )

    def __str__(self) -> str:
        rows = [
            f"distance driven        {span(self.distance, 'm')}",
            f"largest position error {span(self.max_position, 'mm', 1e3)}   "
            f"{span(self.max_position_per_metre, 'um/m', 1e6)}",
            f"final position error   {span(self.final_position, 'mm', 1e3)}   "
            f"{span(self.final_position_per_metre, 'um/m', 1e6)}",
            f"largest heading error  {span(np.degrees(self.max_heading), 'deg')}",
            f"final heading error    {span(np.degrees(self.final_heading), 'deg')}",
            *(f"warning: {warning}" for warning in self.warnings),
        ]
        return "\n".join(rows)


@dataclass(frozen=True, eq=False)
class ErrorStatistics:
    """Position and heading errors and their statistics over the last dimension.

    Attributes:
        position_error: (..., N) [m]; NaN where a run has no pair.
        heading_error: (..., N) [rad], sizes.
    """

    position_error: Array
    heading_error: Array

    @property
    def rmse(self) -> Array:
        """Root mean square of the position error (...) [m]."""
        return np.sqrt(_over_pairs(np.nanmean, self.position_error**2))

    @property
    def mean(self) -> Array:
        """[m]."""
        return _over_pairs(np.nanmean, self.position_error)

    @property
    def median(self) -> Array:
        """[m]."""
        return _over_pairs(np.nanmedian, self.position_error)

    @property
    def max(self) -> Array:
        """[m]."""
        return _over_pairs(np.nanmax, self.position_error)

    @property
    def heading_rmse(self) -> Array:
        """Root mean square of the heading error (...) [rad]."""
        return np.sqrt(_over_pairs(np.nanmean, self.heading_error**2))

    @property
    def heading_max(self) -> Array:
        """[rad]."""
        return _over_pairs(np.nanmax, self.heading_error)

    def __str__(self) -> str:
        return (
            f"position error  rmse {span(self.rmse, 'mm', 1e3)}   max {span(self.max, 'mm', 1e3)}\n"
            f"heading error   rmse {span(np.degrees(self.heading_rmse), 'deg')}   "
            f"max {span(np.degrees(self.heading_max), 'deg')}"
        )


def _over_pairs(statistic: Callable[..., Array], errors: Array) -> Array:
    """A statistic over each run's pairs; NaN, and no warning, for a run that has none."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        return np.asarray(statistic(errors, axis=-1))[()]


def travelled(truth: ArrayLike) -> Array:
    """The distance driven up to each sample, each step counted as the arc through its two poses.

    Args:
        truth: (..., T, 3) [m, m, rad].

    Returns:
        (..., T) [m], zero at the first sample.
    """
    poses = array("truth", truth, "T", 3)
    result = np.zeros(poses.shape[:-1])
    if poses.shape[-2] > 1:
        arcs = se2.log(se2.between(poses[..., :-1, :], poses[..., 1:, :]))
        np.cumsum(np.hypot(arcs[..., 0], arcs[..., 1]), axis=-1, out=result[..., 1:])
    return result


def drift(truth: ArrayLike, estimate: ArrayLike) -> Drift:
    """Compare an estimate with the truth, sample by sample, without aligning anything.

    Args:
        truth: (..., T, 3) [m, m, rad].
        estimate: (..., T, 3), at the same samples; leading dimensions broadcast.

    Raises:
        InvalidValue: shapes that do not fit, or values that are not finite.
    """
    truth, estimate = _pair(truth, estimate)
    along = travelled(truth)
    gap = estimate[..., :2] - truth[..., :2]
    return Drift(
        distance=along[..., -1],
        travelled=along,
        position_error=np.hypot(gap[..., 0], gap[..., 1]),
        heading_error=se2.wrap_angle(estimate[..., 2] - truth[..., 2]),
    )


def stacked(drifts: Iterable[Drift]) -> Drift:
    """The drifts of several drives as the drift of several runs: a new first dimension.

    A drive that is shorter than the longest keeps its last errors until the end.

    Args:
        drifts: at least one, of the same leading dimensions.

    Raises:
        InvalidType: something else than drifts.
        InvalidValue: none, or leading dimensions that differ.
    """
    given = list(drifts)
    for drift in given:
        if not isinstance(drift, Drift):
            raise InvalidType(f"drifts holds {drift!r}: must be Drift")
    if len({drift.distance.shape for drift in given}) != 1:
        shapes = ", ".join(str(drift.distance.shape) for drift in given) or "none"
        raise InvalidValue(f"drifts: leading dimensions {shapes}: must be at least one, all alike")
    length = max(drift.travelled.shape[-1] for drift in given)
    samples = np.arange(length)

    def joined(parts: list[Array]) -> Array:
        return np.stack([part[..., np.minimum(samples, part.shape[-1] - 1)] for part in parts])

    return Drift(
        distance=np.stack([drift.distance for drift in given]),
        travelled=joined([drift.travelled for drift in given]),
        position_error=joined([drift.position_error for drift in given]),
        heading_error=joined([drift.heading_error for drift in given]),
        warnings=tuple(warning for drift in given for warning in drift.warnings),
    )


def ate(truth: ArrayLike, estimate: ArrayLike, align: str = "origin") -> ErrorStatistics:
    """The absolute trajectory error.

    Args:
        truth, estimate: (..., T, 3) [m, m, rad], at the same samples.
        align: "origin" moves the estimate so that the first poses agree, "none" leaves it, "se2" moves it
            to the least squares fit of the positions (no scaling; it hides constant errors of heading).

    Source: Sturm et al. 2012; the fit is Horn's in the plane, whose angle atan2(sum cross, sum dot) is
        defined for a straight line too, where the decomposition of Umeyama 1991 is not.
    """
    truth, estimate = _pair(truth, estimate)
    checks.member("alignment", align, ALIGNMENTS)
    if align == "origin":
        offset = se2.compose(truth[..., :1, :], se2.inverse(estimate[..., :1, :]))
        estimate = se2.compose(offset, estimate)
    elif align == "se2":
        estimate = se2.compose(_best_fit(truth, estimate)[..., None, :], estimate)
    errors = drift(truth, estimate)
    return ErrorStatistics(errors.position_error, np.abs(errors.heading_error))


def _best_fit(truth: Array, estimate: Array) -> Array:
    """The pose (..., 3) that moves the estimate's positions closest to the truth's."""
    center_t, center_e = truth[..., :2].mean(axis=-2), estimate[..., :2].mean(axis=-2)
    t, e = truth[..., :2] - center_t[..., None, :], estimate[..., :2] - center_e[..., None, :]
    dot = (e * t).sum(axis=(-2, -1))
    cross = (e[..., 0] * t[..., 1] - e[..., 1] * t[..., 0]).sum(axis=-1)
    angle = np.arctan2(cross, dot)
    return np.concatenate([center_t - se2.rotate(center_e, angle), angle[..., None]], axis=-1)


def rpe(
    truth: ArrayLike,
    estimate: ArrayLike,
    *,
    distance: float | None = None,
    duration: float | None = None,
    t: ArrayLike | None = None,
) -> ErrorStatistics:
    """The relative pose error over stretches of one distance, or of one duration.

    A stretch starts at every sample and ends at the first one that is at least the step ahead in the truth.
    Its error is between(stretch of the truth, stretch of the estimate).

    Args:
        truth, estimate: (..., T, 3) [m, m, rad], at the same samples.
        distance: length of a stretch along the truth [m], or
        duration: its duration [s], with
        t: the samples' times (T,) [s], increasing.

    Raises:
        InvalidValue: neither or both steps, or a step longer than the whole drive.

    Source: Sturm et al. 2012; Kuemmerle et al. 2009.
    """
    truth, estimate = _pair(truth, estimate)
    if (distance is None) == (duration is None):
        raise InvalidValue("rpe: must be given either distance = ... [m] or duration = ... [s] with t = ...")
    if duration is not None:
        step = checks.positive("duration", duration)
        if t is None:
            raise InvalidValue("rpe: duration needs the samples' times, t = ...")
        clock = checks.vector("t", t, truth.shape[-2])
        if (np.diff(clock) <= 0).any():
            raise InvalidValue("t: must increase")
    else:
        step = checks.positive("distance", distance)
        clock = travelled(truth)
    clock = np.broadcast_to(clock, truth.shape[:-1])
    end = _first_at_least(clock, step)
    found = end < clock.shape[-1]
    if not found.any():
        raise InvalidValue(
            f"rpe: step {step:g} is longer than the whole drive, {float(np.ptp(clock, axis=-1).max()):g}"
        )
    end = np.minimum(end, clock.shape[-1] - 1)[..., None]
    stretches = (se2.between(poses, np.take_along_axis(poses, end, axis=-2)) for poses in (truth, estimate))
    error = se2.between(*stretches)
    return ErrorStatistics(
        np.where(found, np.hypot(error[..., 0], error[..., 1]), np.nan),
        np.where(found, np.abs(se2.wrap_angle(error[..., 2])), np.nan),
    )


def _first_at_least(clock: Array, step: float) -> np.ndarray:
    """For every sample the place of the first that is `step` ahead; the length where there is none."""
    flat = clock.reshape(-1, clock.shape[-1])
    # The small slack keeps rounding from stretching a step by one sample.
    found = [np.searchsorted(run, run + step * (1 - 1e-9)) for run in flat]
    return np.stack(found).reshape(clock.shape)


def _pair(truth: ArrayLike, estimate: ArrayLike) -> tuple[Array, Array]:
    """Truth and estimate, checked and broadcast to one shape."""
    truth, estimate = array("truth", truth, "T", 3), array("estimate", estimate, "T", 3)
    if truth.shape[-2] != estimate.shape[-2]:
        raise InvalidValue(
            f"estimate has {estimate.shape[-2]} samples and truth {truth.shape[-2]}: must be the same samples"
        )
    try:
        a, b = np.broadcast_arrays(truth, estimate)
    except ValueError:
        raise InvalidValue(
            f"estimate has shape {estimate.shape}: must broadcast with truth, shape {truth.shape}"
        ) from None
    return a, b
