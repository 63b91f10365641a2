"""The museum of bugs: odometries that are wrong as real ones were, each a class that is right but for one part.

Where the fault is known from a thread, the class says which; some are of robots with other wheels, and their fault is
carried over. The suite fails each of them, and the verdict names the fault.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from diffdrive_mj.judging import _bugs_of_readings as readings
from diffdrive_mj.judging.right import Pose, Right


class _TurnsTheWrongWay(Right):
    """Turns clockwise where the wheels turn it counter-clockwise (ros-controls/ros2_controllers #280)."""

    def motion(self, left: float, right: float, seconds: float) -> tuple[float, float]:
        return (left + right) / 2, (left - right) / self.track


class _YInverted(Right):
    """Has y to the right: a sign put right for one robot is wrong for another (AutonomyLab/libcreate #12, #21)."""

    def shift(self, length: float, direction: float) -> None:
        self.x += length * math.cos(direction)
        self.y -= length * math.sin(direction)


class _TurnIsARate(Right):
    """Turns by the yaw rate, 100 times too much at 100 Hz (ros-controls/ros2_controllers #789, #1118)."""

    def motion(self, left: float, right: float, seconds: float) -> tuple[float, float]:
        return (left + right) / 2, (right - left) / self.track / seconds


class _StepIsASpeed(Right):
    """Moves by speeds that no one has multiplied by the time.

    ros-controls/ros2_controllers #286, RoverRobotics-archive/roverrobotics_ros2 #21.
    """

    def motion(self, left: float, right: float, seconds: float) -> tuple[float, float]:
        return (left + right) / 2 / seconds, (right - left) / self.track / seconds


class _SmallAngles(Right):
    """Uses a formula for small angles at all angles, of a steered wheel in ros-controls/ros2_controllers #1777."""

    def motion(self, left: float, right: float, seconds: float) -> tuple[float, float]:
        return (left + right) / 2, math.atan2(right - left, self.track)


class _WheelsSwapped(Right):
    """Takes left for right (sonyccd/roboclaw_ros #18; of steered wheels ros-controls/ros2_controllers #878)."""

    def update(self, wheels: tuple[float, float], t: float) -> Pose:
        return super().update((wheels[1], wheels[0]), t)


class _OneWheelForBoth(Right):
    """Reads the second wheel for both (ros-controls/ros2_control_demos #350)."""

    def update(self, wheels: tuple[float, float], t: float) -> Pose:
        return super().update((wheels[1], wheels[1]), t)


class _OneWheelForTheRobot(Right):
    """Takes the speed of one wheel for the robot's.

    ros-controls/ros2_controllers #933, of steered wheels, with ros-controls/ros2_controllers #1150, its cure.
    """

    def motion(self, left: float, right: float, seconds: float) -> tuple[float, float]:
        return right, (right - left) / self.track


class _WholeDegrees(Right):
    """Turns by whole degrees a reading, the rest is lost (AutonomyLab/create_robot #28, polled every 15 ms)."""

    def motion(self, left: float, right: float, seconds: float) -> tuple[float, float]:
        degrees = math.degrees((right - left) / self.track)
        return (left + right) / 2, math.radians(math.trunc(degrees))


class _StartForgotten(Right):
    """Begins at the origin, whatever it is told."""

    def __init__(self, header: Mapping[str, Any]) -> None:
        super().__init__({**header, "x": 0.0, "y": 0.0, "theta": 0.0})


class _Euler(Right):
    """Moves along the heading before the step (zauberzeug/rosys #201)."""

    def move(self, distance: float, turn: float) -> None:
        self.shift(distance, self.theta)
        self.theta += turn


class _Midpoint(Right):
    """Moves by the arc's length instead of the chord's."""

    def move(self, distance: float, turn: float) -> None:
        self.shift(distance, self.theta + turn / 2)
        self.theta += turn


class _ArcWithThreshold(Right):
    """Drives straight on where a step turns by less than 1e-3 rad."""

    def move(self, distance: float, turn: float) -> None:
        if abs(turn) < 1e-3:
            self.shift(distance, self.theta)
            self.theta += turn
        else:
            super().move(distance, turn)


class _ArcWithoutThreshold(Right):
    """Divides by any turn but zero: the circle's radius times a difference that is all rounding."""

    def move(self, distance: float, turn: float) -> None:
        if turn == 0.0:
            super().move(distance, turn)
            return
        radius, after = distance / turn, self.theta + turn
        self.x += radius * (math.sin(after) - math.sin(self.theta))
        self.y -= radius * (math.cos(after) - math.cos(self.theta))
        self.theta = after


class _HeadingNotCarried(Right):
    """Moves every step along the first heading, plus half of its own turn (rpng/MINS #98)."""

    def move(self, distance: float, turn: float) -> None:
        self.shift(distance, self.header["theta"] + turn / 2)
        self.theta += turn


class _MeanOfHeadings(Right):
    """Averages headings on both sides of 180 degrees to zero (JacksonAreaRobotics/JAR-Template #17)."""

    def move(self, distance: float, turn: float) -> None:
        before, after = (math.remainder(theta, 2 * math.pi) for theta in (self.theta, self.theta + turn))
        chord = distance * (math.sin(turn / 2) / (turn / 2) if turn else 1.0)
        self.shift(chord, (before + after) / 2)
        self.theta = after


class _SinglePrecision(Right):
    """Adds up in single precision (simplefoc/Arduino-FOC #83, of a motor that stopped)."""

    def move(self, distance: float, turn: float) -> None:
        super().move(distance, turn)
        self.x, self.y, self.theta = (float(np.float32(value)) for value in (self.x, self.y, self.theta))


class _DiameterForRadius(Right):
    """Takes the wheels' diameters for their radii."""

    def motion(self, left: float, right: float, seconds: float) -> tuple[float, float]:
        return super().motion(2 * left, 2 * right, seconds)


class _SumForMean(Right):
    """Drives as far as both wheels together (simondlevy/BreezySLAM #25)."""

    def motion(self, left: float, right: float, seconds: float) -> tuple[float, float]:
        return left + right, (right - left) / self.track


class _DividesByPi(Right):
    """Divides the ways of the wheels by pi (hadabot/hadabot_main #9)."""

    def motion(self, left: float, right: float, seconds: float) -> tuple[float, float]:
        return super().motion(left / math.pi, right / math.pi, seconds)


class _TrackMissing(Right):
    """Leaves the track out, as a book did (Introduction-to-Autonomous-Robots/Introduction-to-Autonomous-Robots #21)."""

    def motion(self, left: float, right: float, seconds: float) -> tuple[float, float]:
        return (left + right) / 2, right - left


class _OneRadiusForBoth(Right):
    """Takes both wheels for the left one."""

    def __init__(self, header: Mapping[str, Any]) -> None:
        super().__init__({**header, "right_radius": header["left_radius"]})


_OWN = (
    _TurnsTheWrongWay, _YInverted, _TurnIsARate, _StepIsASpeed, _SmallAngles, _WheelsSwapped, _OneWheelForBoth,
    _OneWheelForTheRobot, _WholeDegrees, _StartForgotten, _Euler, _Midpoint, _ArcWithThreshold, _ArcWithoutThreshold,
    _HeadingNotCarried, _MeanOfHeadings, _SinglePrecision, _DiameterForRadius, _SumForMean, _DividesByPi, _TrackMissing,
    _OneRadiusForBoth,
)  # fmt: skip
_OF_READINGS = (
    kind for kind in vars(readings).values() if isinstance(kind, type) and kind.__module__ == readings.__name__
)
# By their names; each is a candidate for `judge`.
MUSEUM: dict[str, type[Right]] = {kind.__name__.lstrip("_"): kind for kind in (*_OWN, *_OF_READINGS)}
