"""What to know of a fit before relying on it, a sentence each."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from diffdrive_mj.calibration._fit import Fit
from diffdrive_mj.calibration._gain import SEPARATED, separated
from diffdrive_mj.calibration._problem import OUTLIER, Problem
from diffdrive_mj.drive import Drive
from diffdrive_mj.estimation.derivatives import PARAMETERS, parameters_of
from diffdrive_mj.robot import Robot

# A parameter less sure than this, relative, is one that the path cannot show.
_UNSEEN = 0.05
# A drive that fits so many times worse than the median one is reported.
_OUTLYING_DRIVE = 3.0
# With fewer readings the bias of a slow encoder cannot be estimated.
_FEWEST_READINGS = 20
# How long a start is [s], and what share of the fastest speed counts as driving.
_START, _MOVING = 0.1, 0.1


def cautions(fit: Fit, believed: Robot) -> Iterator[str]:
    """All of them."""
    yield from _unseen(fit, believed)
    yield from _odd_drives(fit)
    if fit.uncertainty.rough:
        yield (
            "the residuals are correlated along the drives, which one or two drives show only roughly: the stated "
            "deviations are twice what their parts show; drive more often"
        )
    if fit.problem.start == "truth":
        yield from _begun_in_motion(fit.problem, believed)
    if fit.problem.method == "arc":  # others lose more, to first order in the interval
        yield from _slow_encoder(fit)


def speed_at_first(drive: Drive, robot: Robot) -> float:
    """How fast the robot drives at the first true pose [m/s]; 0 where that is little, compared with the drive."""
    radii = [robot.left_radius, robot.right_radius]
    speeds = np.abs(np.diff(drive.wheel_angles, axis=0) * radii).mean(axis=1) / np.diff(drive.t)
    first = drive.clock[0]
    turned = np.abs(np.diff(drive.angles_at([first, min(first + _START, drive.t[-1])]), axis=0) * radii)
    speed = float(turned.mean()) / _START
    return speed if speed > _MOVING * float(np.percentile(speeds, 95)) else 0.0


def _unseen(fit: Fit, believed: Robot) -> Iterator[str]:
    sizes = np.where(np.arange(4) == 3, 1.0, parameters_of(believed))[: len(fit.free)]
    unseen = [name for name, unsure in zip(PARAMETERS, fit.std / sizes, strict=False) if unsure > _UNSEEN]
    if unseen:
        yield (
            f"the drives do not show {', '.join(unseen)} (condition {fit.condition:.2g}): "
            f"{'it stays' if len(unseen) == 1 else 'they stay'} near the believed value; drive turns and straight lines"
        )
    if len(fit.free) == 4 and separated(fit.problem, fit.parameters) < SEPARATED:
        yield (
            "the drives hardly separate the turning gain from the track width: both may be far off on other paths; "
            "drive turns of different radii, or calibrate without the gain"
        )


def _odd_drives(fit: Fit) -> Iterator[str]:
    drives = fit.problem.drives
    typical = float(np.median(fit.spreads))
    for drive, count, spread in zip(drives, fit.outliers, fit.spreads, strict=True):
        if len(drives) > 2 and spread > _OUTLYING_DRIVE * typical:
            yield f"{drive.name}: fits {spread / typical:.1f} times worse than the other drives"
        if count:
            share = 100 * count / len(drive.truth)
            yield f"{drive.name}: {count} true poses ({share:.1f} %) lie more than {OUTLIER:g} sigma off"
        if drive.dropped:
            yield f"{drive.name}: {drive.dropped} true poses outside the encoder's times were left out"


def _begun_in_motion(problem: Problem, believed: Robot) -> Iterator[str]:
    for drive in problem.drives:
        if speed := speed_at_first(drive, believed):
            yield (
                f"{drive.name}: the log begins while the robot drives at {speed:.2g} m/s, where a true heading is less "
                "sure: leave it to the fit (start = position)"
            )


def _slow_encoder(fit: Fit) -> Iterator[str]:
    """A warning where the encoder is read so slowly that the curvature changes between its samples."""
    drives = fit.problem.drives
    if min(len(drive.t) for drive in drives) < _FEWEST_READINGS:
        return
    bias = np.abs(fit.problem.sampling_bias(fit.free))
    relative = (bias[:3] / fit.free[:3]).max()
    if relative < 1e-6 or (bias < 2 * fit.std).all():
        return
    rate = min(1 / float(np.median(np.diff(drive.t))) for drive in drives)
    yield (
        f"the encoder is read slowly for this path ({rate:.3g} Hz): expect {1e6 * relative:.2g} ppm of bias, since the "
        "curvature changes between two readings, beyond the stated uncertainty"
    )
