"""Odometries that are wrong as real ones were: what they make of counters, times and readings that are no numbers.

Each is right but for one part; where the fault is known from a thread, the class says which.
"""

from __future__ import annotations

import math

from diffdrive_mj.judging.right import Pose, Right


class _WrapForwardsOnly(Right):
    """Undoes the wrap of a counter that runs over its end forwards, and not backwards (AutonomyLab/libcreate #71)."""

    def step(self, difference: float) -> float:
        if self.bits is None:
            return difference
        return difference + 2**self.bits if difference < -(2 ** (self.bits - 1)) else difference


class _WrapNotUndone(Right):
    """Takes the difference of two counts as it is (joshnewans/diffdrive_arduino #5 asks what happens then)."""

    def step(self, difference: float) -> float:
        return difference


class _WrapAtTheWrongWidth(Right):
    """Undoes wraps at 32 bits, whatever the counter has."""

    def step(self, difference: float) -> float:
        return difference if self.bits is None else (difference + 2**31) % 2**32 - 2**31


class _EightBits(Right):
    """Keeps counts in a uint8_t, far too narrow for them (chrisl8/ArloBot #40)."""

    def update(self, wheels: tuple[float, float], t: float) -> Pose:
        if self.header["unit"] == "ticks":
            wheels = (wheels[0] % 256, wheels[1] % 256)
        return super().update(wheels, t)

    def step(self, difference: float) -> float:
        return difference


class _WholeTurns(Right):
    """Divides integers, so that only whole turns of a wheel count (ArduPilot/ardupilot #9702)."""

    def update(self, wheels: tuple[float, float], t: float) -> Pose:
        if self.counts(*wheels, t):
            turn = 2 * math.pi / self.unit
            wheels = (turn * math.trunc(wheels[0] / turn), turn * math.trunc(wheels[1] / turn))
        return super().update(wheels, t)


class _WholeTicksPerTurn(Right):
    """Keeps the ticks of a turn as an integer: 2796 for 2796.8."""

    def __init__(self, header: dict[str, float]) -> None:
        super().__init__({**header, "ticks_per_revolution": int(header["ticks_per_revolution"])})


class _FirstReadingIsMotion(Right):
    """Takes the first reading for motion since zero.

    ROBOTIS-GIT/turtlebot3 #1063, ROBOTIS-GIT/turtlebot3_manipulation #83.
    """

    def update(self, wheels: tuple[float, float], t: float) -> Pose:
        if self.last is None:
            self.last = (-math.inf, 0.0, 0.0)
        return super().update(wheels, t)


class _StampOfZero(Right):
    """Times the first step from a stamp of zero, at the speed of the wheels (ROBOTIS-GIT/turtlebot3 #393)."""

    first = True

    def motion(self, left: float, right: float, seconds: float) -> tuple[float, float]:
        assert self.last is not None
        factor = (self.last[0] + seconds) / seconds if self.first else 1.0
        self.first = False
        return super().motion(factor * left, factor * right, seconds)


class _NanSwallowed(Right):
    """Takes in a NaN, and is NaN from then on.

    fetchrobotics/robot_controllers #19; of steered wheels ros-controls/ros2_controllers #2083.
    """

    def counts(self, left: float, right: float, t: float) -> bool:
        return self.last is None or not t <= self.last[0]


class _NanForgets(Right):
    """Starts over after a NaN reading: the motion across it is lost."""

    def counts(self, left: float, right: float, t: float) -> bool:
        if not all(map(math.isfinite, (left, right, t))):
            self.last = None
        return super().counts(left, right, t)


class _ZeroPeriodDropsMotion(Right):
    """Takes a reading for the last one though it leaves its motion out, as one that comes too soon.

    What ros-controls/ros2_controllers #1854 keeps its stamp from.
    """

    def update(self, wheels: tuple[float, float], t: float) -> Pose:
        if self.last is not None and abs(t - self.last[0]) < 1e-4:
            self.last = (t, *wheels)
        return super().update(wheels, t)


class _LateReadingsTakenIn(Right):
    """Takes in old readings that come late, and readings that share a time."""

    def counts(self, left: float, right: float, t: float) -> bool:
        return all(map(math.isfinite, (left, right, t)))


class _ReadingLate(Right):
    """Answers with the pose before the reading that it has taken in."""

    def update(self, wheels: tuple[float, float], t: float) -> Pose:
        before = self.answer()
        super().update(wheels, t)
        return before


class _NominalPeriod(Right):
    """Takes a fixed period for the time between readings (i2rt-robotics/i2rt #64)."""

    def motion(self, left: float, right: float, seconds: float) -> tuple[float, float]:
        period = 0.05
        return super().motion(left / seconds * period, right / seconds * period, seconds)
