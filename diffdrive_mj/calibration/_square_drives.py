"""Drives along a square: that they are such squares, in which direction they go, and how far off they return."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from diffdrive_mj import se2
from diffdrive_mj._checks import Array
from diffdrive_mj.drive import Drive
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.kinematics import body_twist
from diffdrive_mj.robot import Robot

# The largest mismatch side |1 - radius ratio| / track: how far a side may turn before it is no longer straight [rad].
LARGEST_MISMATCH = 0.3
_LENGTH_TOLERANCE = 0.1


def return_errors(drives: Sequence[Drive], robot: Robot) -> Array:
    """How far truth ends from a robot's odometry, in the frame of the true start pose (N, 3) [m, m, rad].

    The heading is counted from one true pose to the next, so that it may exceed half a turn if they are dense.
    """
    rows = []
    for drive in drives:
        odometry, truth = drive.odometry(robot), drive.truth
        gap = se2.rotate(truth[-1, :2] - odometry[-1, :2], -truth[0, 2])
        rows.append([*gap, se2.wrap_angle(np.diff(truth[:, 2] - odometry[:, 2])).sum()])
    return np.array(rows)


def centroids(errors: Array, directions: Array) -> Array:
    """Mean return error of each direction (2, 3) [m, m, rad]: counter-clockwise, clockwise."""
    return np.stack([errors[directions == direction].mean(axis=0) for direction in (1, -1)])


def driving_directions(drives: Sequence[Drive], believed: Robot, side: float) -> Array:
    """In which direction each square was driven (N,): 1 counter-clockwise, -1 clockwise.

    Args:
        drives: one square each.
        believed: the robot whose odometry shows the shape.
        side: of the square [m].

    Raises:
        InvalidValue: a drive that is not such a square, or none in one direction; the message names it.
    """
    directions = np.array([_driving_direction(drive, believed, side) for drive in drives])
    missing = [name for name, way in (("counter-clockwise", 1.0), ("clockwise", -1.0)) if way not in directions]
    if missing:
        raise InvalidValue(f"drives: none {' and none '.join(missing)}: the square must be driven in both directions")
    return directions


def _driving_direction(drive: Drive, believed: Robot, side: float) -> float:
    if not np.ptp(drive.wheel_angles, axis=0).any():
        raise InvalidValue(f"{drive.name}: the wheels never turn: must be a square")
    kept = (drive.t >= drive.clock[0] - 1e-9) & (drive.t <= drive.clock[-1] + 1e-9)
    distance, turn = body_twist(np.diff(drive.wheel_angles[kept], axis=0), believed).T
    driven, heading = (np.concatenate([[0.0], np.cumsum(steps)]) for steps in (np.abs(distance), turn))
    length, turned = float(driven[-1]), float(heading[-1])
    if abs(abs(turned) - 2 * math.pi) > math.pi / 4:
        raise InvalidValue(f"{drive.name}: odometry turns by {turned:.3g} rad: must be a square, about 2 pi or -2 pi")
    if abs(length / (4 * side) - 1) > _LENGTH_TOLERANCE:
        raise InvalidValue(f"{drive.name}: odometry drives {length:.4g} m: must be four sides of {side:g} m")
    direction = math.copysign(1.0, turned)
    # The middle half of a side turns by half of what is allowed at most, LARGEST_MISMATCH / 2.
    on_sides = np.interp(length / 4 * np.add.outer(np.arange(4), [0.25, 0.75]), driven, heading)
    along, corners = on_sides[:, 1] - on_sides[:, 0], np.diff([*on_sides.mean(axis=1), turned])
    for k in range(4):
        if abs(along[k]) > math.pi / 8 or abs(direction * corners[k] - math.pi / 2) > math.pi / 4:
            raise InvalidValue(
                f"{drive.name}: odometry turns by {along[k]:.3g} rad along its side {k + 1} and by {corners[k]:.3g} "
                f"rad about the corner after it: must be a square, each side followed by its corner"
            )
    return direction
