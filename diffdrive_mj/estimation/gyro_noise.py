"""Heading by a gyro: its angle random walk, and a bias that is not known."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj._described import checked, described
from diffdrive_mj.estimation.noise import Noise, Readings, Steps
from diffdrive_mj.robot import Robot


@described()
@dataclass(frozen=True, kw_only=True)
class GyroNoise(Noise):
    """Describe a gyro that every turn is taken from, while the distance is the wheels'.

    ```
    turn W = (what the gyro read) - bias dt        variance of W = N^2 dt        cov(D, W) = 0
    ```

    The bias is unknown by `bias_sigma`, and the same along the whole drive. Where a drive has no gyro, or its gyro did
    not see a step, the wheels' turn stands in: what a drive would be worth with such a gyro. After `WheelNoise`, which
    has the distance's noise, it replaces the noise of the wheels' turn.

    Args:
        random_walk: N, the angle random walk [rad / sqrt(s)].
        bias_sigma: how well its bias is known [rad/s].
        bias: taken out of what it read [rad/s].

    Raises:
        InvalidValue: a number that is not finite, a random walk or a sigma that is negative.
        InvalidType: not a number.
        UnknownName: a field that it does not have.

    Example:
        After a minute at rest, with a bias known to 0.001 rad/s:

        >>> still = dd.covariance(
        ...     np.zeros((61, 2)), dd.Robot.load("matched"), times=np.arange(61.0),
        ...     noise=GyroNoise(random_walk=0.001, bias_sigma=0.001),
        ... )
        >>> round(still.sigma[-1, 2].item() ** 2, 9) == round(0.001**2 * 60 + 0.06**2, 9)
        True
    """

    random_walk: float = field(metadata=checked(checks.not_negative))
    bias_sigma: float = field(default=0.0, metadata=checked(checks.not_negative))
    bias: float = field(default=0.0, metadata=checked(checks.number))

    def applied(self, steps: Steps, readings: Readings, robot: Robot, common: Array) -> Steps:
        """Return the steps with the gyro's turns.

        Args:
            steps: with the wheels' distances.
            readings: of the drive, with times.
            robot: not read.
            common: the bias, less what is taken out (1,) [rad/s].

        Returns:
            The steps.

        Raises:
            InvalidValue: readings without times.
        """
        dt = readings.durations("GyroNoise")
        read = steps.turn if readings.turns is None else readings.turns - self.bias * dt
        seen = ~np.isnan(read)
        return replace(
            steps,
            turn=np.where(seen, read - common[0] * dt, steps.turn),
            covariance=np.where(seen, 0.0, steps.covariance),
            var_turn=np.where(seen, self.random_walk**2 * dt, steps.var_turn),
        )

    @property
    def common(self) -> Array:
        """The variance of the bias (1, 1) [rad^2/s^2]."""
        return np.array([[self.bias_sigma**2]])
