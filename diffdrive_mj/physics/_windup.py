"""Servos at the limit of their motors: the integral does not wind up, and what the wheels fall short by is kept.

Every 10 ms a commanded angle that asks for more torque than the motor has is set to where it asks for just that much:
the integral keeps what the motor can use of it, and a wheel that has fallen behind does not catch up later.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from diffdrive_mj._checks import Array
from diffdrive_mj.physics._mujoco import mujoco
from diffdrive_mj.physics.effects.motors import driven_wheel

_PERIOD = 0.01


class Windup:
    """The motors of some robots, of which at least one has a limit.

    Args:
        models: of the robots, N.

    Attributes:
        shortfall: (N, 2), by how much a wheel was slower than commanded at most while its motor gave all it had, as a
            share of the largest command so far.
        shortfall_time: (N, 2) [s], when that was.
    """

    def __init__(self, models: Sequence[mujoco.MjModel]) -> None:
        wheels = [[driven_wheel(model, side) for side in ("left", "right")] for model in models]
        names = ("feedforward", "damping", "integral", "limit")
        values = np.array([[[getattr(wheel, name) for name in names] for wheel in pair] for pair in wheels])
        self._feedforward, self._damping, self._integral, self._limit = np.moveaxis(values, -1, 0)
        self._timestep = float(models[0].opt.timestep)
        self._every = max(1, round(_PERIOD / self._timestep))
        self._largest = np.zeros((len(models), 2))
        self.shortfall, self.shortfall_time = np.zeros((len(models), 2)), np.zeros((len(models), 2))

    @classmethod
    def of(cls, models: Sequence[mujoco.MjModel]) -> Windup | None:
        """None for motors without limits."""
        return cls(models) if any(model.jnt_actfrclimited.any() for model in models) else None

    def steps_to_look(self, steps: int) -> int:
        """After how many more steps `trimmed` is due."""
        return self._every - steps % self._every

    def trimmed(self, steps: int, command: Array, angles: Array, rates: Array, commanded_angles: Array) -> Array:
        """The commanded angles (N, 2) [rad] that the servos go on from.

        Args:
            steps: taken so far; between two looks nothing is trimmed.
            command: (N, 2) [rad/s].
            angles: of the wheels (N, 2) [rad].
            rates: of the wheels (N, 2) [rad/s].
            commanded_angles: so far (N, 2) [rad].
        """
        if steps % self._every:
            return commanded_angles
        proportional = self._feedforward * command - self._damping * rates
        asked = proportional + self._integral * (commanded_angles - angles)
        full = np.abs(asked) > self._limit * (1 + 1e-9)  # to the limit itself is no fault
        self._keep(steps * self._timestep, command, np.where(full, np.sign(command) * (command - rates), 0.0))
        usable = np.sign(asked) * self._limit - proportional
        ahead = np.divide(usable, self._integral, out=np.zeros_like(usable), where=self._integral > 0)
        return np.where(full & (self._integral > 0), angles + ahead, commanded_angles)

    def _keep(self, time: float, command: Array, slower: Array) -> None:
        self._largest = np.maximum(np.abs(command), self._largest)
        share = np.divide(slower, self._largest, out=np.zeros_like(slower), where=self._largest > 0)
        self.shortfall_time = np.where(share > self.shortfall, time, self.shortfall_time)
        self.shortfall = np.maximum(share, self.shortfall)
