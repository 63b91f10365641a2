"""Odometry by any method, with its derivatives by the robot's parameters as differences."""

from __future__ import annotations

import numpy as np

from diffdrive_mj._checks import Array
from diffdrive_mj.drive import Drive
from diffdrive_mj.estimation.derivatives import PARAMETERS, Trajectory, trajectory
from diffdrive_mj.odometry import Method, Step, integrate
from diffdrive_mj.robot import Robot

# Of a length, and of the gain: halfway between what rounding and what curvature leave of a central difference.
_STEP = 1e-5


def path_by(
    method: Method | Step, drive: Drive, robot: Robot, parameters: Array, clock_offset: float = 0.0, count: int = 4
) -> Trajectory:
    """Compute where odometry puts a robot at the times of its true poses, and how that depends on the parameters.

    Args:
        method: "arc", whose derivatives are exact; "euler", "midpoint", or a function as `odometry.integrate` takes it.
        drive: with M true poses, of which only the times are read.
        robot: what a function reads of it beside the parameters.
        parameters: (4,), in the order of `derivatives.PARAMETERS`.
        clock_offset: the time of the true poses minus the encoder's [s].
        count: how many of the parameters, from the first, to differentiate by: 3 or 4.

    Returns:
        Poses seen from the encoder's first sample, and their derivatives.

    Example:
        >>> drive = dd.Drive([0.0, 1.0], [[0.0, 0.0], [8.0, 12.0]], np.zeros((2, 3)))
        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> path = path_by("euler", drive, robot, [0.1, 0.1, 0.4, 0.0])
        >>> path.poses[-1].round(6).tolist(), path.by_parameters[:2, -1, 0].round(6).tolist()
        ([1.0, 0.0, 1.0], [4.0, 6.0])
    """
    if method == "arc":
        return trajectory(drive, parameters, clock_offset, count)
    at = np.clip(drive.clock - clock_offset, drive.t[0], drive.t[-1])
    times = np.union1d(drive.t, at)
    angles, seen = drive.angles_at(times), np.searchsorted(times, at)

    def poses(values: Array) -> Array:
        of = robot.replace(**dict(zip(PARAMETERS, map(float, values), strict=True)))
        return integrate(angles, of, method)[seen]

    x = np.asarray(parameters, dtype=np.float64)
    sizes = _STEP * np.where(np.arange(4) == 3, 1.0, x)
    here = poses(x)
    slopes = [(poses(x + d) - poses(x - d)) / (2 * d.sum()) for d in np.diag(sizes)[:count]]
    # Along the wheels' motion in the interval: as exact as a clock needs it.
    speed = trajectory(drive, x, clock_offset, count).velocity
    turned = np.hypot(speed[:, 0], speed[:, 1]) * np.sign(_forward(drive, at, x))
    velocity = np.stack([turned * np.cos(here[:, 2]), turned * np.sin(here[:, 2]), speed[:, 2]], axis=1)
    return Trajectory(here, np.stack(slopes), velocity)


def _forward(drive: Drive, at: Array, parameters: Array) -> Array:
    """How far the rims roll in the encoder's interval about each time, forwards or backwards (M,)."""
    last = np.clip(np.searchsorted(drive.t, at, side="right") - 1, 0, len(drive.t) - 2)
    rolled = (drive.wheel_angles[last + 1] - drive.wheel_angles[last]) * parameters[:2]
    return np.asarray(rolled.sum(axis=1))
