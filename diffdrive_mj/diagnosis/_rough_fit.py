"""A rough fit of a drive: a robot near the believed one, and where on it the true pose is measured."""

from __future__ import annotations

import numpy as np

from diffdrive_mj import se2
from diffdrive_mj._checks import Array
from diffdrive_mj.diagnosis._windows import motions, size
from diffdrive_mj.drive import Drive
from diffdrive_mj.robot import Robot

# Of the track width: the smallest motion that only one of wheels and truth has and that asks for an explanation.
UNEXPLAINED = 0.15
OUTLIER = 6.0  # Of the median gap.
_UNEQUAL = 0.13  # How far either wheel may differ from the mean, relative.
_LARGEST_OFFSET = 0.3  # Of the track width: how far from the axle's midpoint the marker may be.


def rough_fit(drive: Drive, believed: Robot, pairs: Array, truth: Array) -> tuple[Array, Array]:
    """Fit a robot near the believed one, and the marker offset (lever arm), to the truth.

    Args:
        drive: that was measured.
        believed: the nominal robot.
        pairs: the windows (N, 2).
        truth: motions of the marker over them (N, 3) [m].

    Returns:
        The motions of the fitted robot (N, 3) [m], and those of its axle's midpoint according to the truth.
    """
    angles = drive.angles_at(drive.clock)
    turned = angles[pairs[:, 1]] - angles[pairs[:, 0]]
    turn = truth[:, 2] / (believed.track_width / 2)
    swing = np.stack([se2.rotate(axis, turn) - axis for axis in np.eye(2)], axis=-1)
    offset, kept = np.zeros(2), np.ones(len(pairs), dtype=bool)
    for _ in range(3):
        robot = _similar(turned[kept], _at_axle(truth, offset, believed)[kept], believed)
        wheels = motions(drive.odometry(robot), pairs, believed)
        # A drive with next to no turns does not show the offset.
        rows, off = swing[kept].reshape(-1, 2), (truth - wheels)[kept, :2].ravel()
        offset[:] = np.linalg.solve(rows.T @ rows + 0.002 * len(rows) * np.eye(2), rows.T @ off)
        offset *= min(1.0, _LARGEST_OFFSET * believed.track_width / max(float(np.hypot(*offset)), 1e-300))
        gap = size(wheels - _at_axle(truth, offset, believed))
        kept = gap <= max(OUTLIER / 2 * float(np.median(gap)), 2 * UNEXPLAINED * believed.track_width)
    return wheels, _at_axle(truth, offset, believed)


def _at_axle(truth: Array, offset: Array, robot: Robot) -> Array:
    """Motions of the axle's midpoint (N, 3) [m], from those of a marker at an offset ahead and left of it (2,) [m]."""
    swung = se2.rotate(offset, truth[:, 2] / (robot.track_width / 2)) - offset
    return truth - np.pad(swung, ((0, 0), (0, 1)))


def _similar(turned: Array, truth: Array, believed: Robot) -> Robot:
    """The robot near the believed one that moves as the truth does when its wheels turn so far (N, 2) [rad]."""
    rims = turned * [believed.left_radius, believed.right_radius]
    turning = rims * [-0.5, 0.5]
    # What the drive does not show, such as the track on a straight line, stays as believed.
    change = np.linalg.lstsq(turning, truth[:, 2] - turning.sum(axis=1), rcond=0.05)[0]
    mean = np.clip(1 + change.mean(), 0.5, 2.0)
    left, right = mean * np.clip((1 + change) / mean, 1 - _UNEQUAL, 1 + _UNEQUAL)
    half = truth[:, 2] / believed.track_width
    chord = truth[:, 0] * np.cos(half) + truth[:, 1] * np.sin(half)
    driven = rims @ [left, right] / 2 * se2.sinc(half)
    moved = float(driven @ driven)
    scale = float(np.clip(driven @ chord / moved, 0.5, 2.0)) if moved else 1.0
    return believed.replace(
        axle="independent",
        left_radius=believed.left_radius * left * scale,
        right_radius=believed.right_radius * right * scale,
        track_width=believed.track_width * scale,
    )
