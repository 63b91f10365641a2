"""Refining a robot's parameters, and what is known of the outcome."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from diffdrive_mj._checks import Array
from diffdrive_mj.calibration._problem import Problem
from diffdrive_mj.calibration._ticks import hide, spread, ticks_of
from diffdrive_mj.calibration._uncertainty import Uncertainty, uncertainty
from diffdrive_mj.errors import InvalidValue


@dataclass(frozen=True, eq=False)
class Fit:
    """Where a refinement ended.

    Attributes:
        problem: with the scales and weights of the fit.
        parameters: all of them (4,), the P free ones first.
        uncertainty: of the free ones.
        by_ticks: what of their covariance the ticks of the encoder leave (P, P).
        residuals: weighted (N,).
        condition: of the problem in relative units.
        outliers: how many poses of each drive lie far off.
        spreads: root mean square of each drive's residuals.
        details: further figures by name.
    """

    problem: Problem
    parameters: Array
    uncertainty: Uncertainty
    by_ticks: Array
    residuals: Array
    condition: float
    outliers: list[int]
    spreads: list[float]
    details: dict[str, float]

    @property
    def free(self) -> Array:
        """The free parameters (P,)."""
        return self.parameters[: len(self.uncertainty.covariance)]

    @property
    def std(self) -> Array:
        """Standard deviations of the free parameters (P,)."""
        return np.sqrt(np.diag(self.uncertainty.covariance))


def refine(problem: Problem, guess: Array, count: int) -> Fit:
    """Refine the first parameters, positions, headings and outliers weighted by what they leave over.

    Args:
        problem: whose scales and weights are set.
        guess: (4,), from which to start.
        count: how many parameters are free.

    Raises:
        InvalidValue: numbers of sizes so different that the problem has no solution in floating point.
    """
    x, ticks = guess[:count], ticks_of(problem.drives)
    try:
        hide(problem, x, ticks)
        x = problem.as_shown(x)
        for _ in range(5):
            x = problem.solve(x)
            if problem.reweigh(x):
                break
        hide(problem, x, ticks)
        return _fit(problem, x, ticks)
    except np.linalg.LinAlgError:
        raise InvalidValue("drives: no robot fits numbers of such different sizes; check columns and units") from None


def _fit(problem: Problem, x: Array, ticks: Array) -> Fit:
    width, count = problem.components, len(x)
    jacobian = problem.jacobian(x)[:-count].reshape(-1, width, count)
    residuals = problem.residuals(x)[:-count].reshape(-1, width)
    lengths = [len(drive.truth) for drive in problem.drives]
    counted = np.split(np.concatenate(problem.counted), np.cumsum(lengths)[:-1])
    measured = [rows[kept] for rows, kept in zip(np.split(residuals, np.cumsum(lengths)[:-1]), counted, strict=True)]
    left_over = np.concatenate(measured)
    freedom = max(len(left_over) - count - problem.per_drive * len(lengths), 1)
    variance = max(1.0, float(left_over @ left_over) / freedom)
    singular = np.linalg.svd(jacobian.reshape(-1, count) * problem.prior_std[:count], compute_uv=False)
    by_ticks = spread(problem, x, ticks)
    details = {"position_residual_m": float(problem.scale[0])}
    if width == 3:
        details["heading_residual_rad"] = float(problem.scale[2])
    if problem.has_clock_offset:
        details["clock_offset_s"] = float(np.mean(problem.clock_offsets))
    return Fit(
        problem=problem,
        parameters=problem.completed(x),
        uncertainty=uncertainty(jacobian, residuals, lengths, problem.prior_std[:count], variance, by_ticks),
        by_ticks=by_ticks,
        residuals=left_over,
        condition=float(singular[0] / singular[-1]) if singular[-1] > 0 else float("inf"),
        outliers=[int(np.count_nonzero(weights < 0.5)) for weights in problem.weights],
        spreads=[float(np.sqrt(np.mean(rows**2))) if len(rows) else 0.0 for rows in measured],
        details=details,
    )
