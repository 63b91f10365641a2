"""Wheel odometry: from wheel angles to poses.

A step's wheel increments give the distance ds and the turn dtheta (`kinematics.body_twist`). The three methods
differ in the length and the direction of the straight line that stands for the step:

    euler      ds                      along the heading at the start of the step
    midpoint   ds                      along the heading half-way (004: the chord taken for the arc)
    arc        ds sinc(dtheta / 2)     along the heading half-way: the exact chord (000; 002 and 003 with
                                       the start heading, which 003's arc formulas leave out)
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from diffdrive_mj.checks import Array, array, member, positive, vector
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.kinematics import body_twist
from diffdrive_mj.robot import Robot
from diffdrive_mj.se2 import sinc

METHODS = ("euler", "midpoint", "arc")
TEN_DEGREES = np.radians(10.0)


def integrate(wheel_angles: ArrayLike, robot: Robot, method: str = "arc", start: ArrayLike = (0.0, 0.0, 0.0)) -> Array:
    """The poses that a robot believes in, from its wheel angles.

    Args:
        wheel_angles: (..., T, 2) [rad], left then right: absolute rotations, as an encoder counts them.
        robot: the believed robot; its radii and track width are read.
        method: "euler", "midpoint" or "arc".
        start: (..., 3) [m, m, rad], the pose at the first sample.

    Returns:
        (..., T, 3) [m, m, rad]; headings are continuous.

    Raises:
        UnknownName: the method. InvalidValue: shapes that do not fit, or values that are not finite.

    Source: 004 (midpoint); 000, equations 1.3 to 1.14, 002 and 003 (arc).
    """
    angles, first = array("wheel_angles", wheel_angles, "T", 2), array("start", start, 3)
    member("odometry method", method, METHODS)
    try:
        shape = np.broadcast_shapes(angles.shape[:-2], first.shape[:-1])
    except ValueError:
        raise InvalidValue(f"start has shape {first.shape}: must broadcast with wheel_angles {angles.shape}") from None
    # One row a pose coordinate: the sums then run through contiguous memory.
    steps = np.empty((3, *shape, angles.shape[-2]))
    steps[..., 0] = np.moveaxis(np.broadcast_to(first, (*shape, 3)), -1, 0)
    if angles.shape[-2] > 1:
        _steps(np.diff(angles, axis=-2), robot, method, steps)
    return np.moveaxis(np.cumsum(steps, axis=-1), 0, -1)


def _steps(increments: Array, robot: Robot, method: str, steps: Array) -> None:
    """Fill in the pose's steps after the first column, which holds the start pose."""
    twist = body_twist(increments, robot)
    length, turn = twist[..., 0], twist[..., 1]
    steps[2, ..., 1:] = turn
    theta = np.cumsum(steps[2], axis=-1)[..., :-1]
    if method == "euler":
        direction = theta
    else:
        half = turn / 2
        direction = theta + half
        if method == "arc":
            length = length * sinc(half)
    np.multiply(length, np.cos(direction), out=steps[0, ..., 1:])
    np.multiply(length, np.sin(direction), out=steps[1, ..., 1:])


class Odometer:
    """Odometry one sample at a time, as it runs on a robot; `integrate` gives the same numbers.

        odometer = Odometer(robot)
        for angles in stream:
            pose = odometer.update(angles)

    Args:
        robot, method, start: as for `integrate`, for one robot.
    """

    def __init__(self, robot: Robot, method: str = "arc", start: Sequence[float] | Array = (0.0, 0.0, 0.0)) -> None:
        self._robot = robot
        self._method = member("odometry method", method, METHODS)
        self._pose = vector("start", start, 3).copy()
        self._last: Array | None = None

    @property
    def pose(self) -> Array:
        """The pose after the last sample (3,) [m, m, rad]."""
        return self._pose.copy()

    def update(self, wheel_angles: Sequence[float] | Array) -> Array:
        """Take in one sample and return the pose; the first sample returns the start.

        Args:
            wheel_angles: (2,) [rad], left then right.
        """
        angles = vector("wheel_angles", wheel_angles, 2)
        if self._last is not None:
            pair = np.stack([self._last, angles])
            self._pose = integrate(pair, self._robot, self._method, self._pose)[-1]
        self._last = angles
        return self.pose


def subdivide(wheel_angles: ArrayLike, robot: Robot, max_turn: float = TEN_DEGREES) -> tuple[Array, NDArray[np.intp]]:
    """Samples put between the given ones, so that the heading turns by at most `max_turn` a segment.

    Each segment is divided evenly, at constant wheel rates. It makes "euler" and "midpoint" better;
    "arc" is exact for constant rates and does not need it.

    Args:
        wheel_angles: (..., T, 2) [rad]; all runs are divided alike, as the sharpest of them needs.
        robot: the believed robot.
        max_turn: [rad]; G. W. Lucas advises at most 10 degrees (quoted in 003).

    Returns:
        The finer angles (..., S, 2) and the places (T,) of the given samples in them.
    """
    angles = array("wheel_angles", wheel_angles, "T", 2)
    limit = positive("max_turn", max_turn)
    if angles.shape[-2] == 1:
        return angles.copy(), np.zeros(1, dtype=np.intp)
    turns = np.abs(body_twist(np.diff(angles, axis=-2), robot)[..., 1])
    widest = turns.reshape(-1, turns.shape[-1]).max(axis=0)
    # The small slack keeps a turn that is the limit up to rounding in one piece.
    pieces = np.maximum(1, np.ceil(widest / limit * (1 - 1e-12))).astype(np.intp)
    places = np.concatenate([[0], np.cumsum(pieces)])
    segment = np.repeat(np.arange(len(pieces)), pieces)
    fraction = (np.arange(places[-1]) - places[segment]) / pieces[segment]
    start, end = angles[..., segment, :], angles[..., segment + 1, :]
    fine = start + (end - start) * fraction[:, None]
    return np.concatenate([fine, angles[..., -1:, :]], axis=-2), places
