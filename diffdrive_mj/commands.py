"""What the wheels are told: rates in advance, or a driver that decides on the way."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj.errors import InvalidValue


@dataclass(frozen=True, eq=False)
class Commands:
    """Wheel rates at a fixed period; each row is held for one period.

    Args:
        period: [s].
        wheel_rates: (T, 2) [rad/s], left then right.
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
        """[s]."""
        return len(self.wheel_rates) * self.period

    def extended(self, duration: float) -> Commands:
        """The same commands followed by standing still until a duration [s] has passed."""
        missing = math.ceil(checks.positive("duration", duration) / self.period - 1e-9) - len(self.wheel_rates)
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
    """

    function: Callable[[float, Array], ArrayLike]
    period: float
    duration: float

    def __post_init__(self) -> None:
        checks.positive("ClosedLoop.period", self.period)
        checks.positive("ClosedLoop.duration", self.duration)
