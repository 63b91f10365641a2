"""Calibration from any kind of path with true poses: a first guess, then least squares over whole trajectories."""

from __future__ import annotations

from collections.abc import Sequence
from typing import get_args

import numpy as np

from diffdrive_mj import _checks as checks
from diffdrive_mj.calibration._cautions import cautions
from diffdrive_mj.calibration._first_guess import continued, linear_fit
from diffdrive_mj.calibration._fit import refine
from diffdrive_mj.calibration._gain import with_gain
from diffdrive_mj.calibration._problem import Problem
from diffdrive_mj.calibration._start import Start
from diffdrive_mj.calibration.result import Calibration
from diffdrive_mj.diagnosis.refusals import implausible, mixed_up, refuse, repeated, worse
from diffdrive_mj.drive import Drive, checked_drives
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.estimation.derivatives import PARAMETERS
from diffdrive_mj.metrics import stacked
from diffdrive_mj.odometry import Method, Step, checked_method
from diffdrive_mj.robot import Robot


def least_squares(
    drives: Sequence[Drive],
    believed: Robot,
    *,
    start: Start = "estimated",
    turning_gain: bool | None = None,
    clock_offset: bool = False,
    headings: bool = True,
    method: Method | Step = "arc",
    anyway: bool = False,
) -> Calibration:
    """Find the radii and the track width whose odometry fits the true poses of all the drives best.

    Args:
        drives: of one robot; each starts anywhere.
        believed: the robot as believed so far; what the drives do not show stays near it.
        start: what of each drive's first pose is estimated: all of it ("estimated"), its heading alone ("position"), or
            nothing ("truth"). What is not estimated is that of the first true pose. For drives that were not used,
            "estimated" was best on circles and "position" on squares and lines of a real robot; "position" also leaves
            the least at the end of the drives used. "truth" puts a true heading that is off, such as that of a log
            that begins in motion, into the parameters.
        turning_gain: whether to free the turning gain too; None frees it where the drives show it, which takes turns of
            different radii: squares alone do not, nor circles of one radius.
        clock_offset: whether to solve for the truth's time minus the encoder's, one offset a drive.
        headings: whether the headings of the truth count; without them only the positions do.
        method: of the odometry whose parameters are sought: "arc", "euler", "midpoint", or a function of your own as
            `odometry.integrate` takes it.
        anyway: accept what would be refused, with a warning.

    Returns:
        Parameters left_radius [m], right_radius [m], track_width [m] and, if freed, turning_gain. The covariance comes
        from the scatter of whole drives, from five on, or from three if residuals are correlated along them; else from
        that of single poses, or of stretches of the drives. details: the spread of the residuals, and the mean clock
        offset if estimated.

    Raises:
        InvalidType: not drives, not a robot, or an option of the wrong type.
        UnknownName: another start.
        InvalidValue: no drives, drives on which nothing moves, or more unknowns than measurements.
        CalibrationRefused: columns or units that look mixed up, a drive given twice, a parameter 1.3 times the believed
            one or more, or odometry that is worse than before; the message says what cures it.

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
    against = [*repeated(drives), *mixed_up(drives, believed, headings=headings)]
    refused = refuse(against, anyway=checks.boolean("anyway", anyway))
    method = checked_method(method)
    problem = Problem(drives, believed, start=start, clock_offset=clock_offset, headings=headings, method=method)
    guess = linear_fit(drives, believed) if headings else continued(drives, believed, start)
    fit = refine(problem, guess, 4 if turning_gain else 3)
    if turning_gain is None and headings:
        fit = with_gain(fit)
    names = PARAMETERS[: len(fit.free)]
    calibrated = believed.replace(**dict(zip(names, map(float, fit.free), strict=True)))
    before, after = (stacked(drive.drift(robot, method) for drive in drives) for robot in (believed, calibrated))
    # Without headings the truth may have none, and odometry nothing to start from.
    against = [*implausible(believed, calibrated)]
    against += worse(before, after, fit.details["position_residual_m"]) if headings else ()
    return Calibration(
        method="least squares" if headings else "position fixes",
        believed=believed,
        calibrated=calibrated,
        parameters=names,
        values=fit.free,
        covariance=fit.uncertainty.covariance,
        residuals=fit.residuals,
        before=before,
        after=after,
        condition=fit.condition,
        warnings=(*refused, *refuse(against, anyway=anyway), *cautions(fit, believed)),
        details=fit.details,
    )


def from_fixes(
    drives: Sequence[Drive],
    believed: Robot,
    *,
    start: Start = "estimated",
    clock_offset: bool = False,
    anyway: bool = False,
) -> Calibration:
    """Find the radii and the track width from position fixes alone, for a robot without any sensor of its heading.

    The headings of the drives are not read; the courses and distances between the fixes decide.

    Args:
        drives: of one robot; each starts anywhere.
        believed: the robot as believed so far; what the drives do not show stays near it.
        start: as in `least_squares`; "truth" reads the heading of the first pose.
        clock_offset: whether to solve for the truth's time minus the encoder's, one offset a drive.
        anyway: accept what would be refused, with a warning.

    Returns:
        Parameters left_radius [m], right_radius [m] and track_width [m], otherwise as `least_squares` returns.

    Raises:
        InvalidType: not drives, not a robot, or an option of the wrong type.
        UnknownName: another start.
        InvalidValue: no drives, drives on which nothing moves, or more unknowns than measurements.
        CalibrationRefused: a drive given twice, or a parameter 1.3 times the believed one or more.

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
    return least_squares(
        drives, believed, start=start, turning_gain=False, clock_offset=clock_offset, headings=False, anyway=anyway
    )


def _moving(drives: list[Drive]) -> list[Drive]:
    """Drives on which something moves."""
    if all(np.ptp(drive.wheel_angles, axis=0).max() < 1e-6 for drive in drives):
        raise InvalidValue("drives: the wheels never turn, so that nothing can be calibrated")
    if all(np.ptp(drive.truth[:, :2], axis=0).max() < 1e-6 and np.ptp(drive.truth[:, 2]) < 1e-6 for drive in drives):
        raise InvalidValue("drives: the true pose never moves, so that nothing can be calibrated")
    return drives
