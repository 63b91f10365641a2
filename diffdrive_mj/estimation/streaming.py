"""Odometry one sample at a time, with the mean and the covariance of the pose, as it runs on a robot."""

from __future__ import annotations

import cmath
from dataclasses import fields

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj import _checks as checks
from diffdrive_mj import _covariances
from diffdrive_mj._checks import Array
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.estimation._noisy_step import rule, step_moments
from diffdrive_mj.estimation._of_wheels import variances
from diffdrive_mj.estimation._placed import Spread, behind
from diffdrive_mj.estimation._recursion import START, after
from diffdrive_mj.estimation.moments import PoseMoments
from diffdrive_mj.estimation.noise import Readings, Steps
from diffdrive_mj.estimation.wheel_noise import WheelNoise
from diffdrive_mj.robot import Robot


class MomentOdometer:
    """Odometry on arcs that knows how sure it is, one sample at a time; `dd.covariance` gives the same numbers.

    Args:
        robot: the believed robot; one with a turning gain takes a hundred times as long.
        noise: of its wheels.
        start: (3,) [m, m, rad], the pose at the first sample.
        start_covariance: (3, 3) of the start; None for one that is known.

    Raises:
        InvalidType: not a robot, not wheel noise, not numbers.
        InvalidValue: shapes that do not fit, a covariance that is not symmetric or has a negative eigenvalue.

    Example:
        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> odometer = MomentOdometer(robot, dd.WheelNoise(left=0.002, right=0.002))
        >>> for angle in np.linspace(0.0, 500.0, 1001):  # as it comes from the encoders: 50 m
        ...     pose = odometer.update((angle, angle))
        >>> pose.round(4).tolist()
        [49.9688, 0.0, 0.0]
        >>> np.sqrt(np.diag(odometer.covariance)).round(4).tolist()
        [0.0374, 1.4422, 0.05]
    """

    def __init__(
        self,
        robot: Robot,
        noise: WheelNoise,
        start: ArrayLike = (0.0, 0.0, 0.0),
        start_covariance: ArrayLike | None = None,
    ) -> None:
        self._robot = checks.instance("robot", robot, Robot)
        self._noise = checks.instance("noise", noise, WheelNoise)
        self._radii, self._track = (robot.left_radius, robot.right_radius), robot.track_width
        # Of a radian of each wheel.
        self._variances = (noise.left**2 * robot.left_radius, noise.right**2 * robot.right_radius)
        given = np.zeros((3, 3)) if start_covariance is None else start_covariance
        scatter = _covariances.covariance("start_covariance", given, 3)
        if scatter.ndim != 2:
            raise InvalidValue(f"start_covariance has shape {scatter.shape}: must be (3, 3)")
        self._start = Spread.of(checks.vector("start", start, 3), scatter)
        self._place = complex(self._start.place)
        self._heading = float(self._start.heading)
        self._turned = cmath.exp(1j * self._heading - float(self._start.variance) / 2)
        self._seen = START
        self._last: tuple[float, float] | None = None

    @property
    def pose(self) -> Array:
        """The mean of the pose after the last sample (3,) [m, m, rad]."""
        place = self._place + self._turned * self._seen.place
        return np.array((place.real, place.imag, self._heading + self._seen.heading))

    @property
    def covariance(self) -> Array:
        """Its covariance after the last sample (3, 3), of x, y and theta."""
        mean, covariance = np.empty(3), np.empty((3, 3))
        behind(self._start, self._seen.seen).write(mean, covariance)
        return covariance

    @property
    def moments(self) -> PoseMoments:
        """Both, as of a drive of a single sample: (1, 3) and (1, 3, 3)."""
        return PoseMoments(self.pose[None], self.covariance[None])

    def update(self, wheel_angles: ArrayLike) -> Array:
        """Take in one sample and return the mean of the pose; the first sample returns the start's.

        Args:
            wheel_angles: (2,) [rad], left then right.

        Returns:
            (3,) [m, m, rad].

        Raises:
            InvalidType: not numbers.
            InvalidValue: another shape, values that are not finite, or a turn so large that the sample before it must
                have been long ago.
        """
        angles = left, right = checks.vector("wheel_angles", wheel_angles, 2).tolist()
        if self._last is not None:
            self._advance(left - self._last[0], right - self._last[1])
        self._last = angles
        return self.pose

    def _advance(self, left: float, right: float) -> None:
        """Take a step, in plain numbers: numpy's are slower by far."""
        if self._robot.turning_gain:
            distance, turn, var_distance, covariance, var_turn = self._with_gain(left, right)
        else:
            left_way, right_way = self._radii[0] * left, self._radii[1] * right
            distance, turn = (left_way + right_way) / 2, (right_way - left_way) / self._track
            var_distance, covariance, var_turn = variances(
                self._variances[0] * abs(left), self._variances[1] * abs(right), self._track
            )
        fine = rule(abs(turn), var_turn)
        step = step_moments(distance, turn, var_distance, covariance, var_turn, fine, cmath.exp)
        self._seen = after(self._seen, step, turn, var_turn)

    def _with_gain(self, left: float, right: float) -> list[float]:
        """Distance and turn of a step, and their noise, where the turn is not linear in the wheels' ways."""
        readings = Readings(np.array([(0.0, 0.0), (left, right)]))
        steps = self._noise.applied(Steps.of(readings, self._robot), readings, self._robot, np.zeros(0))
        return [getattr(steps, part.name).item() for part in fields(steps)]
