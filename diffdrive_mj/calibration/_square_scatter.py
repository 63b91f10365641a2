"""What the scatter of the runs says of a calibration from the square: its covariance, its outliers, its alias."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from diffdrive_mj._checks import Array
from diffdrive_mj.calibration import _square as square
from diffdrive_mj.drive import Drive
from diffdrive_mj.kinematics import body_twist
from diffdrive_mj.robot import Robot

_OUTLIER = 8.0  # Robust standard deviations; of five good runs a way at most 2 % lie that far out.


def outliers(errors: Array, ways: Array) -> NDArray[np.bool_]:
    """Runs whose return position is far from their way's median, by the median of the distances; four runs at least."""
    far = np.zeros(len(ways), dtype=bool)
    for way in (1, -1):
        mine = np.flatnonzero(ways == way)
        if len(mine) >= 4:
            away = errors[mine, :2] - np.median(errors[mine, :2], axis=0)
            distance = np.hypot(away[:, 0], away[:, 1])
            # Of a round normal scatter the median distance is 1.1774 standard deviations.
            far[mine] = distance > _OUTLIER * max(float(np.median(distance)) / 1.1774, 1e-9)
    return far


def alias(drives: Sequence[Drive], believed: Robot) -> float:
    """By how much the radius ratio may be off before whole turns go unseen from one true pose to the next.

    A ratio off by e turns a robot by e d / b more than it believes over a distance d; the circle tells up to half a
    turn, e = pi b / d.
    """
    longest = 0.0
    for drive in drives:
        angles = drive.angles_at(drive.clock)
        longest = max(longest, float(np.abs(body_twist(np.diff(angles, axis=0), believed)[:, 0]).max()))
    return math.pi * believed.track_width / longest


def covariance(drives: Sequence[Drive], ways: Array, left: Array, robot: Robot, weights: Array) -> tuple[Array, float]:
    """Of radius ratio and track, from the scatter of the runs, and the condition number of the scaled problem.

    The outcome p is where the angles a = W c of the centroids c vanish, so that a change dc moves it by
    -(da/dp)^-1 W dc.

    Args:
        drives, ways: of N runs.
        left: return errors (N, 3) that the robot leaves.
        robot: the outcome.
        weights: W, of `readout` (2, 6).

    Returns:
        (2, 2), NaN with fewer than two runs a way, and the condition number.
    """

    def seen(errors: Array) -> Array:
        return weights @ square.centroids(errors, ways).ravel()

    step, outcome = 1e-5, np.array([robot.radius_ratio, robot.track_width])
    columns = []
    for change in step * np.eye(2) * outcome:
        up, down = (
            seen(square.return_errors(drives, square.corrected(robot, *(outcome + d)))) for d in (change, -change)
        )
        columns.append((up - down) / (2 * step))
    slopes = np.stack(columns, axis=-1)
    condition = float(np.linalg.cond(slopes))
    if min(np.count_nonzero(ways == way) for way in (1, -1)) < 2:
        return np.full((2, 2), np.nan), condition
    # A run's share in the angles' covariance: what its deviation from its way's centroid moves them by.
    shares = np.zeros((len(left), 2))
    for i, way in enumerate(ways):
        mine = ways == way
        deviation = np.zeros_like(left)
        deviation[i] = left[i] - left[mine].mean(axis=0)
        shares[i] = seen(deviation) * math.sqrt(mine.sum() / (mine.sum() - 1))
    moves = outcome[:, None] * np.linalg.solve(slopes, shares.T)
    return moves @ moves.T, condition
