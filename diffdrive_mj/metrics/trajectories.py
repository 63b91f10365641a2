"""The errors of whole trajectories: absolute (ATE), after an alignment, and relative (RPE), over stretches."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, TypeVar, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from diffdrive_mj import _checks as checks
from diffdrive_mj import se2
from diffdrive_mj._checks import Array
from diffdrive_mj._text import span
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.metrics._pairs import complex_positions, paired
from diffdrive_mj.metrics.drifts import travelled

Alignment = Literal["origin", "none", "se2"]
ALIGNMENTS: tuple[Alignment, ...] = get_args(Alignment)
C = TypeVar("C", Array, NDArray[np.complex128])


@dataclass(frozen=True, eq=False)
class ErrorStatistics:
    """Position and heading errors and their statistics over the last dimension.

    Attributes:
        position_error: (..., N) [m]; NaN where a run has no pair.
        heading_error: (..., N) [rad], sizes.

    Example:
        >>> print(dd.metrics.ErrorStatistics(np.array([0.003, 0.004]), np.radians([1.0, 1.0])))
        position error  rmse 3.536 mm   max 4 mm
        heading error   rmse 1 deg   max 1 deg
    """

    position_error: Array
    heading_error: Array

    @property
    def rmse(self) -> Array:
        """Root mean square of the position error (...) [m]."""
        return np.sqrt(_over_pairs(np.nanmean, self.position_error**2))

    @property
    def mean(self) -> Array:
        """Mean of the position error (...) [m]."""
        return _over_pairs(np.nanmean, self.position_error)

    @property
    def median(self) -> Array:
        """Median of the position error (...) [m]."""
        return _over_pairs(np.nanmedian, self.position_error)

    @property
    def max(self) -> Array:
        """Maximum of the position error (...) [m]."""
        return _over_pairs(np.nanmax, self.position_error)

    @property
    def heading_rmse(self) -> Array:
        """Root mean square of the heading error (...) [rad]."""
        return np.sqrt(_over_pairs(np.nanmean, self.heading_error**2))

    @property
    def heading_max(self) -> Array:
        """Maximum of the heading error (...) [rad]."""
        return _over_pairs(np.nanmax, self.heading_error)

    def __repr__(self) -> str:
        return f"ErrorStatistics({self.position_error.shape[-1]} pairs, rmse {span(self.rmse, 'mm', 1e3)})"

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


def ate(truth: ArrayLike, estimate: ArrayLike, align: Alignment = "origin") -> ErrorStatistics:
    """Compute the absolute trajectory error.

    Args:
        truth: (..., T, 3) [m, m, rad].
        estimate: (..., T, 3) [m, m, rad], at the same samples.
        align: "origin" moves the estimate so that the first poses agree, "none" leaves it, "se2" moves it
            to the least squares fit of the positions (no scaling; it hides constant errors of heading).

    Returns:
        The errors of all poses.

    Raises:
        UnknownName: the alignment.
        InvalidType: not numbers.
        InvalidValue: shapes that do not fit, or values that are not finite.

    References:
        Sturm, Engelhard, Endres, Burgard, Cremers 2012, A benchmark for the evaluation of RGB-D SLAM systems.
        Horn 1987, Closed-form solution of absolute orientation using unit quaternions: the fit, in the plane. Its angle
        atan2(sum cross, sum dot) is defined for a straight line too, where the decomposition of Umeyama 1991 is not.

    Example:
        An estimate that starts 1 m to the side and is otherwise perfect:

        >>> truth = np.array([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (2.0, 0.0, 0.0)])
        >>> estimate = truth + (0.0, 1.0, 0.0)
        >>> [dd.metrics.ate(truth, estimate, align).rmse.item() for align in ("none", "origin", "se2")]
        [1.0, 0.0, 0.0]
    """
    truth, estimate = paired(truth, estimate)
    checks.member("alignment", align, ALIGNMENTS)
    true, believed = complex_positions(truth), complex_positions(estimate)
    ahead = estimate[..., 2] - truth[..., 2]
    if align != "none":
        true -= true[..., :1] if align == "origin" else true.mean(axis=-1, keepdims=True)
        believed -= believed[..., :1] if align == "origin" else believed.mean(axis=-1, keepdims=True)
        # The product's real part is the sum of the dot products, its imaginary part that of the cross products.
        turn = -ahead[..., :1] if align == "origin" else np.angle(np.vecdot(believed, true)[..., None])
        believed *= np.exp(1j * turn)
        ahead += turn
    believed -= true
    return ErrorStatistics(np.abs(believed), np.abs(se2.wrap_angle(ahead)))


def rpe(
    truth: ArrayLike,
    estimate: ArrayLike,
    *,
    distance: float | None = None,
    duration: float | None = None,
    t: ArrayLike | None = None,
) -> ErrorStatistics:
    """Compute the relative pose error over stretches of one distance, or of one duration.

    A stretch starts at every sample and ends at the first later one that is at least the step ahead in the truth.
    Its error is between(stretch of the truth, stretch of the estimate).

    Args:
        truth: (..., T, 3) [m, m, rad].
        estimate: (..., T, 3) [m, m, rad], at the same samples.
        distance: length of a stretch along the truth [m], or
        duration: its duration [s], with
        t: the samples' times (T,) [s], increasing; from any zero, such as Unix times.

    Returns:
        The errors of all stretches.

    Raises:
        InvalidType: not numbers.
        InvalidValue: neither or both steps, times with a distance, a step longer than the whole drive, shapes that do
            not fit, values that are not finite, or times that do not increase.

    References:
        Sturm, Engelhard, Endres, Burgard, Cremers 2012, A benchmark for the evaluation of RGB-D SLAM systems.
        Kuemmerle et al. 2009, On measuring the accuracy of SLAM algorithms.

    Example:
        An estimate whose lengths are 1 % too long is off by 10 mm on every metre:

        >>> truth = np.stack([np.linspace(0.0, 5.0, 51), np.zeros(51), np.zeros(51)], axis=-1)
        >>> dd.metrics.rpe(truth, truth * (1.01, 1.0, 1.0), distance=1.0).mean.round(6).item()
        0.01
    """
    truth, estimate = paired(truth, estimate)
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
        if t is not None:
            raise InvalidValue("rpe: t = ... goes with duration = ...; a distance is measured along the truth")
        step = checks.positive("distance", distance)
        clock = travelled(truth)
    end = _first_at_least(clock, step)
    found = end < truth.shape[-2]
    if not found.any():
        raise InvalidValue(
            f"rpe: step {step:g} is longer than the whole drive, {float(np.ptp(clock, axis=-1).max()):g}"
        )
    end = np.broadcast_to(np.minimum(end, truth.shape[-2] - 1), truth.shape[:-1])

    def stretch(values: C) -> C:
        return np.take_along_axis(values, end, axis=-1) - values

    # Turned like the truth, the estimate's stretch is off by as much as the frames of both poses say.
    ahead = estimate[..., 2] - truth[..., 2]
    gap = np.exp(-1j * ahead) * stretch(complex_positions(estimate)) - stretch(complex_positions(truth))
    return ErrorStatistics(
        np.where(found, np.abs(gap), np.nan),
        np.where(found, np.abs(se2.wrap_angle(stretch(ahead))), np.nan),
    )


def _first_at_least(clock: Array, step: float) -> NDArray[np.intp]:
    """For every sample the index of the first later one that is `step` ahead; the length where there is none."""
    # The slack keeps rounding, of the step and of times far from zero, from stretching a step by one sample.
    slack = 1e-9 * step + 2 * np.spacing(np.abs(clock).max())
    later = np.arange(1, clock.shape[-1] + 1)
    found = [np.searchsorted(run, run + (step - slack)) for run in clock.reshape(-1, clock.shape[-1])]
    return np.maximum(np.stack(found).reshape(clock.shape), later)
