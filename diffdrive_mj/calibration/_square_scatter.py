"""What the scatter of the runs says of a calibration from the square: its covariance, its outliers, its ambiguity."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from diffdrive_mj._checks import Array
from diffdrive_mj.calibration._square import corrected
from diffdrive_mj.calibration._square_drives import centroids, return_errors
from diffdrive_mj.drive import Drive
from diffdrive_mj.kinematics import body_twist
from diffdrive_mj.robot import Robot

_OUTLIER = 8.0  # Robust standard deviations; of five good runs a direction at most 2 % lie that far out.


def outliers(errors: Array, directions: Array) -> NDArray[np.bool_]:
    """Which runs return far from the median of their direction, by the median distance; of four runs at least (N,)."""
    far = np.zeros(len(directions), dtype=bool)
    for direction in (1, -1):
        mine = np.flatnonzero(directions == direction)
        if len(mine) >= 4:
            away = errors[mine, :2] - np.median(errors[mine, :2], axis=0)
            distance = np.hypot(away[:, 0], away[:, 1])
            # Of a round normal scatter the median distance is 1.1774 standard deviations.
            far[mine] = distance > _OUTLIER * max(float(np.median(distance)) / 1.1774, 1e-9)
    return far


def heading_ambiguity(drives: Sequence[Drive], believed: Robot) -> float:
    """By how much the radius ratio may be off before whole turns go unseen from one true pose to the next.

    A ratio off by e turns a robot by e d / b more than it believes over a distance d; headings on the circle show up to
    half a turn, e = pi b / d.
    """
    longest = 0.0
    for drive in drives:
        angles = drive.angles_at(drive.clock)
        longest = max(longest, float(np.abs(body_twist(np.diff(angles, axis=0), believed)[:, 0]).max()))
    return math.pi * believed.track_width / longest


def covariance(
    drives: Sequence[Drive], directions: Array, left: Array, robot: Robot, weights: Array
) -> tuple[Array, float]:
    """The covariance of radius ratio and track, from the scatter of the runs.

    The outcome p is where the angles a = W c of the centroids c vanish, so that a change dc moves it by
    -(da/dp)^-1 W dc.

    Args:
        drives: N runs.
        directions: of the runs (N,).
        left: return errors that the robot leaves (N, 3) [m, m, rad].
        robot: the outcome.
        weights: W, of `_square.readout` (2, 6).

    Returns:
        (2, 2), NaN with fewer than two runs a direction, and the condition number of the scaled problem.
    """

    def seen(errors: Array) -> Array:
        return weights @ centroids(errors, directions).ravel()

    step, outcome = 1e-5, np.array([robot.radius_ratio, robot.track_width])
    columns = []
    for change in step * np.eye(2) * outcome:
        up, down = (seen(return_errors(drives, corrected(robot, *(outcome + d)))) for d in (change, -change))
        columns.append((up - down) / (2 * step))
    slopes = np.stack(columns, axis=-1)
    condition = float(np.linalg.cond(slopes))
    if min(np.count_nonzero(directions == direction) for direction in (1, -1)) < 2:
        return np.full((2, 2), np.nan), condition
    # A run's share in the angles' covariance: what its deviation from the centroid of its direction moves them by.
    shares = np.zeros((len(left), 2))
    for i, direction in enumerate(directions):
        mine = directions == direction
        deviation = np.zeros_like(left)
        deviation[i] = left[i] - left[mine].mean(axis=0)
        shares[i] = seen(deviation) * math.sqrt(mine.sum() / (mine.sum() - 1))
    moves = outcome[:, None] * np.linalg.solve(slopes, shares.T)
    return moves @ moves.T, condition
