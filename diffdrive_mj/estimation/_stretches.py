"""Drives cut into stretches: how far each ends from where odometry expects it, and how that scatters."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from diffdrive_mj import se2
from diffdrive_mj._checks import Array
from diffdrive_mj.drive import Drive
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.estimation.derivatives import parameters_of, trajectory
from diffdrive_mj.estimation.moments import CovarianceMethod, PoseMoments, covariance
from diffdrive_mj.estimation.wheel_noise import WheelNoise
from diffdrive_mj.robot import Robot

# Stretches whose common noise, that of the true pose between them, is kept track of; longer drives are cut.
_TOGETHER = 20
# Steps of the wheels in a stretch: the noise of a step turns the robot evenly along it, which few steps show.
_STEPS = 5


@dataclass(eq=False)
class Stretches:
    """Some stretches of a drive, one after the other; S of them have 3 S errors.

    Attributes:
        angles: the wheel angles in each [rad].
        robot: with which odometry is computed.
        ends: where each ended, seen from where it began (S, 3).
        tracked: covariance that the noise of the true poses makes (3 S, 3 S).
        by_parameters: derivatives of the errors by what part radii and track are off (3 S, 3).
        growth: derivatives of the covariance by the variances of both wheels, each (3 S, 3 S) [1/m].
        errors: where the stretches ended less where they are expected to, in the mean (3 S,).
    """

    angles: list[Array]
    robot: Robot
    ends: Array
    tracked: Array
    by_parameters: Array
    growth: tuple[Array, Array] = field(init=False)
    errors: Array = field(init=False)
    _known: tuple[Array, Array] = field(init=False)

    def __post_init__(self) -> None:
        left, right = (self._moments(np.array(one), "first_order") for one in ((1.0, 0.0), (0.0, 1.0)))
        self.growth = _diagonal(left.covariance), _diagonal(right.covariance)
        self._take(left.mean, np.zeros(2), np.zeros_like(self.tracked))

    def __len__(self) -> int:
        return len(self.angles)

    def expect(self, variances: Array) -> None:
        """Take the errors from where the stretches end in the mean with this noise, and its covariance as it is."""
        moments = self._moments(variances)
        self._take(moments.mean, variances, _diagonal(moments.covariance))

    def covariance(self, variances: Array) -> Array:
        """The covariance of the errors (3 S, 3 S), to first order from the noise that was expected last."""
        expected, known = self._known
        left, right = (variances - expected).tolist()
        return np.asarray(self.tracked + known + left * self.growth[0] + right * self.growth[1])

    @staticmethod
    def blocks(whole: Array) -> Array:
        """The blocks (S, 3, 3) of each stretch in a matrix of all (3 S, 3 S)."""
        count = len(whole) // 3
        return whole.reshape(count, 3, count, 3)[np.arange(count), :, np.arange(count)]

    def _take(self, means: Array, variances: Array, known: Array) -> None:
        off = self.ends - means
        off[:, 2] = se2.wrap_angle(off[:, 2])
        self.errors, self._known = off.ravel(), (variances, known)

    def _moments(self, variances: Array, method: CovarianceMethod = "exact") -> PoseMoments:
        """Mean and covariance of where each stretch ends (S, 3) and (S, 3, 3), seen from where it began."""
        left, right = np.sqrt(variances).tolist()
        noise = WheelNoise(left=left, right=right)
        found = [covariance(angles, self.robot, noise=noise, method=method) for angles in self.angles]
        return PoseMoments(np.array([one.mean[-1] for one in found]), np.array([one.covariance[-1] for one in found]))


def cut(name: str, drive: Drive, robot: Robot, length: float, tracked: tuple[float, float]) -> list[Stretches]:
    """Cut a drive into equal stretches of about a length, each from one true pose to another.

    Args:
        name: how messages call the drive.
        drive: with true poses.
        robot: with which odometry is computed.
        length: the mean of the ways of both wheels [m].
        tracked: standard deviations of the true poses, position [m] and heading [rad].

    Raises:
        InvalidValue: wheels that never turn, or stretches with too few steps.
    """
    times = np.union1d(drive.t, drive.clock)
    times = times[(times >= drive.clock[0]) & (times <= drive.clock[-1])]
    angles = drive.angles_at(times)
    steps = np.abs(np.diff(angles, axis=0)) * (robot.left_radius, robot.right_radius)
    way = np.concatenate([[0.0], np.cumsum(steps.mean(axis=1))])
    if way[-1] == 0:
        raise InvalidValue(f"{name}: the wheels never turn between the true poses")
    at = np.searchsorted(times, drive.clock)
    count = max(1, round(way[-1] / length))
    ends = np.unique(np.searchsorted(way[at], np.linspace(0, way[-1] * (1 - 1e-9), count + 1)))
    moved = np.concatenate([[0], np.cumsum(np.any(steps > 0, axis=1))])[at[ends]]
    if np.any(np.diff(moved) < _STEPS):
        raise InvalidValue(
            f"{name}: {int(np.diff(moved).min())} steps of the wheels in a stretch: must be at least {_STEPS}; take a "
            f"longer stretch than {length:g} m, or read the wheels more often"
        )
    path = trajectory(drive, parameters_of(robot), count=3)
    slopes = np.moveaxis(path.by_parameters, 0, -1) * parameters_of(robot)[:3]
    found = []
    for first in range(0, len(ends) - 1, _TOGETHER):
        some = ends[first : first + _TOGETHER + 1]
        begin, end = _seen_from(path.poses[some])
        by_parameters = begin @ slopes[some[:-1]] + end @ slopes[some[1:]]
        found.append(
            Stretches(
                [angles[at[i] : at[j] + 1] for i, j in pairwise(some)],
                robot,
                se2.between(drive.truth[some[:-1]], drive.truth[some[1:]]),
                _tracked(drive.truth[some], tracked),
                by_parameters.reshape(-1, 3),
            )
        )
    return found


def _seen_from(poses: Array) -> tuple[Array, Array]:
    """Derivatives of each pose, seen from the one before it, by that one and by itself, of S + 1 poses (S, 3, 3)."""
    begin, end = np.zeros((2, len(poses) - 1, 3, 3))
    c, s = np.cos(poses[:-1, 2]), np.sin(poses[:-1, 2])
    end[:, :2, :2] = np.moveaxis(np.array([[c, s], [-s, c]]), -1, 0)
    end[:, 2, 2] = 1
    begin[:] = -end
    x, y = se2.between(poses[:-1], poses[1:])[:, :2].T
    begin[:, 0, 2], begin[:, 1, 2] = y, -x
    return begin, end


def _tracked(poses: Array, noise: tuple[float, float]) -> Array:
    """The covariance of poses seen from those before them, each with its own noise (3 S, 3 S)."""
    count = len(poses) - 1
    begin, end = _seen_from(poses)
    slopes = np.zeros((count, 3, count + 1, 3))
    each = np.arange(count)
    slopes[each, :, each] = begin
    slopes[each, :, each + 1] = end
    scaled = slopes.reshape(3 * count, -1) * np.tile([noise[0], noise[0], noise[1]], count + 1)
    return np.asarray(scaled @ scaled.T)


def _diagonal(blocks: Array) -> Array:
    """Blocks (S, 3, 3) on the diagonal of a matrix (3 S, 3 S)."""
    count = len(blocks)
    whole = np.zeros((count, 3, count, 3))
    whole[np.arange(count), :, np.arange(count)] = blocks
    return whole.reshape(3 * count, 3 * count)
