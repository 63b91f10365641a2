"""Calibration from any kind of path with true poses: a first guess, then least squares over whole trajectories."""

from __future__ import annotations

from collections.abc import Sequence
from typing import get_args

import numpy as np

from diffdrive_mj import _checks as checks
from diffdrive_mj.calibration._first_guess import continued, linear_fit
from diffdrive_mj.calibration._fit import Fit, refine
from diffdrive_mj.calibration._gain import SEPARATED, separated, with_gain
from diffdrive_mj.calibration._problem import OUTLIER, Problem, Start
from diffdrive_mj.calibration.result import Calibration
from diffdrive_mj.drive import Drive, checked_drives
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.estimation.derivatives import PARAMETERS, parameters_of
from diffdrive_mj.metrics import stacked
from diffdrive_mj.robot import Robot

# A parameter less sure than this, relative, is one that the path cannot show.
_UNSEEN = 0.05
# A drive that fits so many times worse than the median one is reported.
_OUTLYING_DRIVE = 3.0
# With fewer readings the bias of a slow encoder cannot be estimated.
_FEWEST_READINGS = 20


def least_squares(
    drives: Sequence[Drive],
    believed: Robot,
    *,
    start: Start = "estimated",
    turning_gain: bool | None = None,
    clock_offset: bool = False,
    headings: bool = True,
) -> Calibration:
    """Find the radii and the track width whose odometry fits the true poses of all the drives best.

    Args:
        drives: of one robot; each starts anywhere.
        believed: the robot as believed so far; what the drives do not show stays near it.
        start: "estimated" solves for the start pose of each drive too; "truth" takes its first true pose, which suits a
            truth that is far better than the odometry along the whole drive, such as motion capture.
        turning_gain: whether to free the turning gain too; None frees it where the data support it.
        clock_offset: whether to solve for an offset between the clocks of the encoder and the truth, one a drive.
        headings: whether the headings of the truth count; without them only the positions do.

    Returns:
        Parameters left_radius [m], right_radius [m], track_width [m] and, if freed, turning_gain. The covariance comes
        from the derivatives and the residuals, and allows for residuals that are correlated along a drive. details:
        the spread of the residuals, and the mean clock offset if estimated.

    Raises:
        InvalidType: not drives, not a robot, or an option of the wrong type.
        UnknownName: another start.
        InvalidValue: no drives, drives on which nothing moves, or more unknowns than measurements.

    References:
        Antonelli et al. 2005, odometry linear in combinations of the parameters; Censi et al. 2013, heading first.

    Example:
        >>> believed = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> true = dd.Robot(left_radius=0.1, right_radius=0.097, track_width=0.41)
        >>> t = np.arange(10.0)
        >>> wheel_angles = np.stack([5 * t, 5 * t + 4 * np.sin(t)], axis=-1)
        >>> drive = dd.Drive(t, wheel_angles, dd.odometry.integrate(wheel_angles, true))
        >>> dd.calibration.least_squares([drive], believed).values.round(6)
        array([0.1  , 0.097, 0.41 ])
    """
    drives, believed = _moving(checked_drives(drives)), checks.instance("believed", believed, Robot)
    checks.member("start", start, get_args(Start))
    clock_offset, headings = checks.boolean("clock_offset", clock_offset), checks.boolean("headings", headings)
    if turning_gain is not None:
        turning_gain = checks.boolean("turning_gain", turning_gain)
    problem = Problem(drives, believed, start=start, clock_offset=clock_offset, headings=headings)
    guess = linear_fit(drives, believed) if headings else continued(drives, believed, start)
    fit = refine(problem, guess, 4 if turning_gain else 3)
    if turning_gain is None and headings:
        fit = with_gain(problem, fit)
    names = PARAMETERS[: len(fit.free)]
    calibrated = believed.replace(**dict(zip(names, map(float, fit.free), strict=True)))
    return Calibration(
        method="least squares" if headings else "position fixes",
        believed=believed,
        calibrated=calibrated,
        parameters=names,
        values=fit.free,
        covariance=fit.uncertainty.covariance,
        residuals=fit.residuals,
        before=stacked(drive.drift(believed) for drive in drives),
        after=stacked(drive.drift(calibrated) for drive in drives),
        condition=fit.condition,
        warnings=(*_warnings(drives, believed, fit), *_slow_encoder(problem, fit)),
        details=fit.details,
    )


def from_fixes(
    drives: Sequence[Drive], believed: Robot, *, start: Start = "estimated", clock_offset: bool = False
) -> Calibration:
    """Find the radii and the track width from position fixes alone, for a robot without any sensor of its heading.

    The headings of the drives are not read; the courses and distances between the fixes decide.

    Args:
        drives: of one robot; each starts anywhere.
        believed: the robot as believed so far; what the drives do not show stays near it.
        start: "estimated" or "truth", as in `least_squares`; "truth" reads the heading of the first pose.
        clock_offset: whether to solve for an offset between the clocks of the encoder and the truth, one a drive.

    Returns:
        Parameters left_radius [m], right_radius [m] and track_width [m], otherwise as `least_squares` returns.

    Raises:
        InvalidType: not drives, not a robot, or an option of the wrong type.
        UnknownName: another start.
        InvalidValue: no drives, drives on which nothing moves, or more unknowns than measurements.

    References:
        [Petersen 2013], whose robot knows its positions and nothing else.

    Example:
        >>> believed = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> true = dd.Robot(left_radius=0.1, right_radius=0.097, track_width=0.41)
        >>> t = np.arange(10.0)
        >>> wheel_angles = np.stack([5 * t, 5 * t + 4 * np.sin(t)], axis=-1)
        >>> truth = dd.odometry.integrate(wheel_angles, true) * (1, 1, 0)  # no headings
        >>> dd.calibration.from_fixes([dd.Drive(t, wheel_angles, truth)], believed).values.round(4)
        array([0.1  , 0.097, 0.41 ])
    """
    return least_squares(drives, believed, start=start, turning_gain=False, clock_offset=clock_offset, headings=False)


def _moving(drives: list[Drive]) -> list[Drive]:
    """Drives on which something moves."""
    if all(np.ptp(drive.wheel_angles, axis=0).max() < 1e-6 for drive in drives):
        raise InvalidValue("drives: the wheels never turn, so that nothing can be calibrated")
    if all(np.ptp(drive.truth[:, :2], axis=0).max() < 1e-6 and np.ptp(drive.truth[:, 2]) < 1e-6 for drive in drives):
        raise InvalidValue("drives: the true pose never moves, so that nothing can be calibrated")
    return drives


def _slow_encoder(problem: Problem, fit: Fit) -> list[str]:
    """A warning where the encoder is read so slowly that the curvature changes between its samples."""
    if min(len(drive.t) for drive in problem.drives) < _FEWEST_READINGS:
        return []
    bias = np.abs(problem.sampling_bias(fit.free))
    relative = (bias[:3] / fit.free[:3]).max()
    if relative < 1e-6 or (bias < 2 * fit.std).all():
        return []
    rate = min(1 / float(np.median(np.diff(drive.t))) for drive in problem.drives)
    return [
        f"the encoder is read slowly for this path ({rate:.3g} Hz): expect {1e6 * relative:.2g} ppm of bias, since the "
        "curvature changes between two readings, beyond the stated uncertainty"
    ]


def _warnings(drives: Sequence[Drive], believed: Robot, fit: Fit) -> list[str]:
    found = []
    sizes = np.where(np.arange(4) == 3, 1.0, parameters_of(believed))[: len(fit.free)]
    unseen = [name for name, unsure in zip(PARAMETERS, fit.std / sizes, strict=False) if unsure > _UNSEEN]
    if unseen:
        found.append(
            f"the drives do not show {', '.join(unseen)} (condition {fit.condition:.2g}): "
            f"{'it stays' if len(unseen) == 1 else 'they stay'} near the believed value; drive turns and straight lines"
        )
    typical = float(np.median(fit.spreads))
    for drive, count, spread in zip(drives, fit.outliers, fit.spreads, strict=True):
        if len(drives) > 2 and spread > _OUTLYING_DRIVE * typical:
            found.append(f"{drive.name}: fits {spread / typical:.1f} times worse than the other drives")
        if count:
            share = count / len(drive.truth)
            found.append(f"{drive.name}: {count} true poses ({100 * share:.1f} %) lie more than {OUTLIER:g} sigma off")
        if drive.dropped:
            found.append(f"{drive.name}: {drive.dropped} true poses outside the encoder's times were left out")
    if fit.uncertainty.rough:
        found.append(
            "the residuals are correlated along the drives, which so few drives show only roughly: the stated "
            "uncertainty may be too small; drive at least three times"
        )
    return found
