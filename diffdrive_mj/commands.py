"""What the wheels are told: rates in advance, or a driver that decides on the way."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj._text import shown
from diffdrive_mj.errors import InvalidType, InvalidValue


@dataclass(frozen=True, eq=False)
class Commands:
    """Wheel rates at a fixed period; each row is held for one period.

    Args:
        period: [s].
        wheel_rates: (T, 2) [rad/s], left then right.

    Raises:
        InvalidType: not numbers.
        InvalidValue: a period that is not positive, rates of another shape, or not finite.

    Example:
        >>> dd.Commands(period=0.02, wheel_rates=[(5.0, 5.5)] * 100)
        Commands(100 periods of 0.02 s, 2 s)
    """

    period: float
    wheel_rates: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "period", checks.positive("Commands.period", self.period))
        rates = checks.array("Commands.wheel_rates", self.wheel_rates, "T", 2)
        if rates.ndim != 2:
            raise InvalidValue(f"Commands.wheel_rates has shape {rates.shape}: must be (T, 2); give many as a list")
        rates = rates.copy()
        rates.flags.writeable = False
        object.__setattr__(self, "wheel_rates", rates)

    def __repr__(self) -> str:
        return f"Commands({len(self.wheel_rates)} periods of {self.period:g} s, {self.duration:g} s)"

    @property
    def duration(self) -> float:
        """From the first command's start to the last one's end [s]."""
        return len(self.wheel_rates) * self.period

    @property
    def wheel_angles(self) -> Array:
        """How far the wheels are told to turn, at the start and at the end of each period (T + 1, 2) [rad]."""
        return np.concatenate([np.zeros((1, 2)), np.cumsum(self.wheel_rates * self.period, axis=0)])

    def extended(self, duration: float) -> Commands:
        """Append standing still until a duration has passed, so that shorter commands run beside longer ones.

        Args:
            duration: [s], at least that of the commands.

        Returns:
            The same commands, then rates of zero.

        Raises:
            InvalidType: not a number.
            InvalidValue: a duration shorter than that of the commands.
        """
        count = checks.samples("duration", checks.positive("duration", duration), self.period)
        missing = count - len(self.wheel_rates)
        if missing < 0:
            raise InvalidValue(f"duration = {duration:g} s: must be at least that of the commands, {self.duration:g} s")
        return Commands(self.period, np.concatenate([self.wheel_rates, np.zeros((missing, 2))]))


@dataclass(frozen=True)
class ClosedLoop:
    """A driver that decides anew once a control period.

    Args:
        function: called with the time [s] and the wheel angles of all the runs (N, 2) [rad], (2,) for a
            single robot; returns the wheel rates to hold for the period, in the same shape [rad/s].
        period: [s].
        duration: of the drive [s].

    Raises:
        InvalidType: a function that cannot be called, or not numbers.
        InvalidValue: a period or duration that is not positive.

    Example:
        >>> driver = dd.ClosedLoop(lambda t, angles: (4.0 * min(t, 1.0), 5.0 * min(t, 1.0)), period=0.05, duration=1.5)
        >>> dd.simulate(dd.Robot.load("matched"), driver, sample_rate=10.0)
        Recording(16 samples, 1.5 s)
    """

    function: Callable[[float, Array], ArrayLike]
    period: float
    duration: float

    def __post_init__(self) -> None:
        if not callable(self.function):
            raise InvalidType(
                f"ClosedLoop.function = {shown(self.function)}: must be a function of time and wheel angles"
            )
        object.__setattr__(self, "period", checks.positive("ClosedLoop.period", self.period))
        object.__setattr__(self, "duration", checks.positive("ClosedLoop.duration", self.duration))
        checks.samples("ClosedLoop.duration", self.duration, self.period)
