"""The course of one robot over many drives, each of which updates it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj import _checks as checks
from diffdrive_mj import se2
from diffdrive_mj._text import shown
from diffdrive_mj.errors import InvalidType, InvalidValue
from diffdrive_mj.estimation.course import Course, missing_angle


class CourseTracker:
    """Keeps the course of one robot up to date from its straight drives.

    Every course counts in proportion to the inverse of its variance: a Kalman filter on the circle. The random walk of
    the heading during a drive moves both its chord and its final heading, the chord by half as much; the filter allows
    for that. The fixes of two drives are taken to be independent.

    Args:
        random_walk: q, by how much the variance of the heading grows along a drive [rad^2/m].

    Raises:
        InvalidValue: a negative random walk.

    References:
        [Petersen 2013], Berechnung des Kurses: every straight drive updates the course.

    Example:
        >>> tracker = dd.course_tracker.CourseTracker(random_walk=1e-4)
        >>> yaw = tracker.update(dd.course.from_fixes((0, 0), (1, 0), 1.0, fix_noise=0.01))
        >>> round(float(np.degrees(tracker.std)), 2)
        0.88
        >>> tracker.turn(tracker.missing_angle(position=(1, 0), goal=(1, 3)))
        >>> round(float(np.degrees(tracker.yaw)), 6)
        90.0
    """

    def __init__(self, random_walk: float = 0.0) -> None:
        self._random_walk = checks.not_negative("random_walk", random_walk)
        self._yaw = 0.0
        self._variance = math.inf

    @property
    def yaw(self) -> float:
        """The robot's heading [rad], in (-pi, pi]."""
        if math.isinf(self._variance):
            raise InvalidValue("CourseTracker.yaw: not known before the first straight drive")
        return self._yaw

    @property
    def std(self) -> float:
        """The standard deviation of the yaw [rad]; infinite before the first straight drive."""
        return math.sqrt(self._variance)

    def update(self, course: Course) -> float:
        """Take a straight drive into account.

        Args:
            course: of a single drive, from `course.from_fixes`.

        Returns:
            The yaw at the end of the drive [rad], in (-pi, pi].

        Raises:
            InvalidType: not a course.
            InvalidValue: the drive was not straight, or it is several drives.

        Example:
            >>> north = dd.course.from_fixes((0, 0), (0, 1), 1.0, fix_noise=0.01)
            >>> round(dd.course_tracker.CourseTracker().update(north), 4)
            1.5708
        """
        if not isinstance(course, Course):
            raise InvalidType(f"course = {shown(course)}: must be a Course, such as course.from_fixes returns")
        if np.ndim(course.yaw):
            raise InvalidValue(f"course has shape {np.shape(course.yaw)}: must be a single drive")
        if not course.straight:
            raise InvalidValue(
                f"course: epsilon = {course.epsilon:g} m exceeds {course.threshold:g} m: the drive must be straight"
            )
        measured = float(course.yaw)
        noise, walked = float(course.std) ** 2, self._random_walk * float(course.travelled)
        if math.isinf(self._variance):
            self._yaw, self._variance = measured, noise + walked / 3
            return self._yaw
        # The heading at the start, the walk W and the fixes' noise are independent; W and its mean share q w / 2.
        spread = self._variance + walked / 3 + noise
        shared = self._variance + walked / 2
        gain = shared / spread if spread else 1.0
        innovation = float(se2.wrap_angle(measured - self._yaw))
        self._yaw = float(se2.wrap_angle(self._yaw + gain * innovation))
        self._variance = max(0.0, self._variance + walked - gain * shared)
        return self._yaw

    def turn(self, angle: float, std: float = 0.0) -> None:
        """Take a turn on the spot into account, as the odometer measured it.

        Args:
            angle: counter-clockwise [rad].
            std: its standard deviation [rad].

        Example:
            >>> dd.course_tracker.CourseTracker().turn(np.pi / 2, std=0.01)
        """
        angle, std = checks.number("angle", angle), checks.not_negative("std", std)
        self._yaw = float(se2.wrap_angle(self._yaw + angle))
        self._variance += std**2

    def missing_angle(self, position: ArrayLike, goal: ArrayLike) -> float:
        """Compute the turn on the spot towards a goal, by the shorter way; see `course.missing_angle`.

        Args:
            position: of the robot (2,) [m].
            goal: (2,) [m].

        Returns:
            The turn [rad], counter-clockwise, in (-pi, pi].

        Raises:
            InvalidValue: no straight drive so far, or the robot stands on its goal.

        Example:
            >>> tracker = dd.course_tracker.CourseTracker()
            >>> yaw = tracker.update(dd.course.from_fixes((0, 0), (0, 1), 1.0, fix_noise=0.01))
            >>> round(tracker.missing_angle((0, 1), (0, 5)), 4)
            0.0
        """
        here, there = checks.vector("position", position, 2), checks.vector("goal", goal, 2)
        return float(missing_angle(self.yaw, here, there))
