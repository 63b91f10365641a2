"""The course of one robot over many drives, each of which serves to update it (001)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj import _checks as checks
from diffdrive_mj import se2
from diffdrive_mj.errors import InvalidType, InvalidValue
from diffdrive_mj.estimation.course import Course, missing_angle


class CourseTracker:
    """The course of one robot, kept up to date by every straight drive.

        tracker = CourseTracker(wander=1e-4)
        tracker.update(course.from_fixes(first, second, travelled, fix_noise=0.01))
        tracker.turn(tracker.missing_angle(second, goal))

    Every course counts as its variance deserves: a Kalman filter on the circle. The wander during a drive shows in
    its chord and in its final heading, half of it in both; the filter knows that. The fixes of two drives are taken
    to be independent.

    Args:
        wander: q, by how much the variance of the heading grows along a drive [rad^2/m].

    Source: 001, Berechnung des Kurses: every straight drive serves to update the course.
    """

    def __init__(self, wander: float = 0.0) -> None:
        self._wander = checks.not_negative("wander", wander)
        self._yaw = 0.0
        self._variance = math.inf

    @property
    def yaw(self) -> float:
        """Where the robot heads [rad], in (-pi, pi]."""
        if math.isinf(self._variance):
            raise InvalidValue("CourseTracker.yaw: not known before the first straight drive")
        return self._yaw

    @property
    def std(self) -> float:
        """The standard deviation of the yaw [rad]; infinite before the first straight drive."""
        return math.sqrt(self._variance)

    def update(self, course: Course) -> float:
        """Take in a straight drive and return the yaw at its end [rad].

        Raises:
            InvalidValue: the drive was not straight, or is many drives.
        """
        if not isinstance(course, Course):
            raise InvalidType(f"course = {course!r}: must be a Course, as of from_fixes")
        if np.ndim(course.yaw):
            raise InvalidValue(f"course has shape {np.shape(course.yaw)}: must be a single drive")
        if not course.straight:
            raise InvalidValue(
                f"course: epsilon = {course.epsilon:g} m exceeds {course.threshold:g} m: the drive must be straight"
            )
        measured = float(course.yaw)
        noise, wandered = float(course.std) ** 2, self._wander * float(course.travelled)
        if math.isinf(self._variance):
            self._yaw, self._variance = measured, noise + wandered / 3
            return self._yaw
        # Start of the drive, its wander W and its fixes' noise are independent; W and its mean share q w / 2.
        spread = self._variance + wandered / 3 + noise
        shared = self._variance + wandered / 2
        gain = shared / spread if spread else 1.0
        innovation = float(se2.wrap_angle(measured - self._yaw))
        self._yaw = float(se2.wrap_angle(self._yaw + gain * innovation))
        self._variance = max(0.0, self._variance + wandered - gain * shared)
        return self._yaw

    def turn(self, angle: float, std: float = 0.0) -> None:
        """Take in a turn on the spot by an angle, of some standard deviation, from the odometer [rad]."""
        angle, std = checks.number("angle", angle), checks.not_negative("std", std)
        self._yaw = float(se2.wrap_angle(self._yaw + angle))
        self._variance += std**2

    def missing_angle(self, position: ArrayLike, goal: ArrayLike) -> float:
        """The turn towards a goal (2,) [m] from a position (2,) [m]; see `course.missing_angle` [rad]."""
        here, there = checks.vector("position", position, 2), checks.vector("goal", goal, 2)
        return float(missing_angle(self.yaw, here, there))
