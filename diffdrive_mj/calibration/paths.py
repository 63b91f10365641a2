"""Calibration by least squares, from any kind of path with true poses: a linear fit, then whole trajectories."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj.calibration._first_guess import linear_fit
from diffdrive_mj.calibration._problem import OUTLIER, SIGNIFICANT, Fit, Problem, Start, refine
from diffdrive_mj.calibration.result import Calibration
from diffdrive_mj.drive import Drive
from diffdrive_mj.errors import InvalidType, InvalidValue
from diffdrive_mj.estimation.derivatives import PARAMETERS, parameters_of
from diffdrive_mj.metrics import stacked
from diffdrive_mj.robot import Robot

# A parameter less sure than this, relative, is one that the path cannot show.
_UNSEEN = 0.05
# A drive that fits so many times worse than the median one is reported.
_OUTLYING_DRIVE = 3.0


def least_squares(
    drives: Sequence[Drive],
    believed: Robot,
    *,
    start: Start = "estimated",
    turning_gain: bool | None = None,
    clock_offset: bool = False,
    headings: bool = True,
) -> Calibration:
    """The radii and the track that make the odometry fit the true poses of all the drives best.

    Args:
        drives: of one robot; each starts where it likes.
        believed: the robot as believed so far.
        start: of each drive: "estimated" with the parameters, or the first pose of the "truth", for a truth that is
            far better than the odometry along the whole drive, as of motion capture.
        turning_gain: whether to free the turning gain too; None frees it where the data support it.
        clock_offset: whether the truth's clock may be off, by a time for each drive.
        headings: whether the truth's headings count; without them positions alone do (`from_fixes`).

    Returns:
        A calibration whose covariance comes from the derivatives and the residuals; where these wander it allows for
        it by their sums over stretches of the drives.

    Raises:
        InvalidValue: no drives, drives on which nothing moves, or more unknowns than measurements.

    Source: Antonelli, Chiaverini, Fusco 2005 (linear in the parameters); Censi et al. 2013 (heading first).
    """
    drives = _checked(drives)
    checks.member("start", start, ("estimated", "truth"))
    problem = Problem(drives, believed, start, clock_offset, headings)
    guess = linear_fit(drives, believed) if headings else _continued(drives, believed, start)
    fit = refine(problem, guess, 4 if turning_gain else 3)
    if turning_gain is None and headings and problem.wants_gain(fit.parameters):
        richer = refine(problem, fit.parameters, 4)
        if abs(richer.parameters[3]) > SIGNIFICANT * np.sqrt(richer.covariance[3, 3]) and richer.parameters[3] < 0.2:
            fit = richer
    names = PARAMETERS[: len(fit.covariance)]
    values = fit.parameters[: len(names)]
    calibrated = believed.replace(**dict(zip(names, map(float, values), strict=True)))
    return Calibration(
        method="least squares" if headings else "position fixes",
        believed=believed,
        calibrated=calibrated,
        parameters=names,
        values=values,
        covariance=fit.covariance,
        residuals=fit.residuals,
        before=stacked(drive.drift(believed) for drive in drives),
        after=stacked(drive.drift(calibrated) for drive in drives),
        condition=fit.condition,
        warnings=(*_warnings(drives, believed, start, fit), *_slow_encoder(drives, problem, fit)),
        details=fit.details,
    )


def from_fixes(drives: Sequence[Drive], believed: Robot) -> Calibration:
    """What a robot can find out from position fixes alone, without any sensor of its heading: 001's robot.

    The headings of the drives are not read; courses and distances between the fixes decide.
    """
    return least_squares(drives, believed, turning_gain=False, headings=False)


def _checked(drives: Sequence[Drive]) -> list[Drive]:
    drives = checked_drives(drives)
    if all(np.ptp(drive.wheel_angles, axis=0).max() < 1e-6 for drive in drives):
        raise InvalidValue("drives: the wheels never turn, so that nothing can be calibrated")
    if all(np.ptp(drive.truth[:, :2], axis=0).max() < 1e-6 and np.ptp(drive.truth[:, 2]) < 1e-6 for drive in drives):
        raise InvalidValue("drives: the true pose never moves, so that nothing can be calibrated")
    return drives


def _continued(drives: Sequence[Drive], believed: Robot, start: Start) -> Array:
    """A first guess from positions alone: longer and longer beginnings of the drives, so that none is far off."""
    guess = parameters_of(believed)
    for share in (0.1, 0.2, 0.4, 0.7):
        beginnings = [
            replace(drive, truth=drive.truth[:count], truth_t=drive.clock[:count])
            for drive in drives
            for count in [max(2, round(share * len(drive.truth)))]
        ]
        if 2 * sum(len(drive.truth) for drive in beginnings) > 3 + 3 * len(drives):
            guess[:3] = Problem(beginnings, believed, start, clock_offset=False, headings=False).solve(guess[:3])
    return guess


def _slow_encoder(drives: Sequence[Drive], problem: Problem, fit: Fit) -> list[str]:
    """A warning where the encoder is read so slowly that the curvature changes between its samples.

    The error of taking steps for arcs is of second order: without every second reading it is four times as large, so
    that a third of the change is what is left in the fit.
    """
    if min(len(drive.t) for drive in drives) < 20:
        return []
    x = fit.parameters[: len(fit.covariance)]
    thinned = problem.thinned()
    jacobian = thinned.jacobian(x)
    shift = -np.linalg.solve(jacobian.T @ jacobian, jacobian.T @ thinned.residuals(x))
    bias = np.abs(shift[:3] / x[:3]).max() / 3
    if bias < 1e-6 or (np.abs(shift) / 3 < 2 * np.sqrt(np.diag(fit.covariance))).all():
        return []
    rate = min(1 / float(np.median(np.diff(drive.t))) for drive in drives)
    return [
        f"the encoder is read slowly for this path ({rate:.3g} Hz): expect {1e6 * bias:.2g} ppm of bias from the "
        "curvature's changes between two readings, beyond the stated uncertainty"
    ]


def _warnings(drives: Sequence[Drive], believed: Robot, start: Start, fit: Fit) -> list[str]:
    found = []
    sizes = np.where(np.arange(4) == 3, 1.0, parameters_of(believed))[: len(fit.covariance)]
    relative = np.sqrt(np.diag(fit.covariance)) / sizes
    unseen = [name for name, doubt in zip(PARAMETERS, relative, strict=False) if doubt > _UNSEEN]
    if unseen:
        found.append(
            f"the drives do not show {', '.join(unseen)} (condition {fit.condition:.2g}): "
            f"{'it stays' if len(unseen) == 1 else 'they stay'} near what was believed; drive turns and straight lines"
        )
    typical = float(np.median(fit.spreads))
    for drive, count, spread in zip(drives, fit.outliers, fit.spreads, strict=True):
        if len(drives) > 2 and spread > _OUTLYING_DRIVE * typical:
            found.append(f"{drive.name}: fits {spread / typical:.1f} times worse than the other drives do")
        if count:
            share = count / len(drive.truth)
            found.append(f"{drive.name}: {count} true poses ({100 * share:.1f} %) lie more than {OUTLIER:g} sigma off")
        if drive.dropped:
            found.append(f"{drive.name}: {drive.dropped} true poses outside the encoder's times were left out")
    if not fit.white:
        advice = "; the odometry is worse than the truth, start='truth' may serve better" * (start == "estimated")
        found.append(f"the residuals wander: the stated uncertainty allows for it only roughly{advice}")
    return found
