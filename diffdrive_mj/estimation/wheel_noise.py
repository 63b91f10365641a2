"""Noise that grows with each wheel's own way."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj._described import checked, described
from diffdrive_mj.estimation._noisy_gain import noisy_turns
from diffdrive_mj.estimation._of_wheels import variances
from diffdrive_mj.estimation.noise import Noise, Readings, Steps
from diffdrive_mj.robot import Robot


@described()
@dataclass(frozen=True, kw_only=True)
class WheelNoise(Noise):
    """Describe noise that grows as a random walk with each wheel's own way, in turns on the spot too.

    ```
    variance of a wheel's way s = k^2 |s|
    V_D = (v_l + v_r) / 4        cov(D, W) = (v_r - v_l) / (2 b)        V_W = (v_l + v_r) / b^2
    ```

    with v_l and v_r the variances of both ways in a step, D its distance, W its turn and b the track width.

    Variances of steps add up to that of the whole way, however finely a drive is sampled. With a turning gain, which
    makes the turn nonlinear in the ways, the moments are those of the turns that noisy ways make.

    Args:
        left: k of the left wheel [m / sqrt(m)].
        right: k of the right wheel [m / sqrt(m)].

    Raises:
        InvalidValue: a number that is negative or not finite.
        InvalidType: not a number.
        UnknownName: a field that noise does not have.

    References:
        Chong and Kleeman (1997), Accurate odometry and error modelling for a mobile robot.

    Example:
        >>> WheelNoise(left=0.002, right=0.002).left
        0.002
    """

    left: float = field(metadata=checked(checks.not_negative))
    right: float = field(metadata=checked(checks.not_negative))

    @classmethod
    def of_variances(cls, *, left: float, right: float) -> WheelNoise:
        """Return the noise whose constants are the variances per metre, as Martinelli and Siegwart give them.

        The variances of the ways are k_l |s_l| and k_r |s_r|, so that these k are the squares of this class's own.

        Args:
            left: k_l [m].
            right: k_r [m].

        Returns:
            The noise.

        Raises:
            InvalidValue: a number that is negative or not finite.
            InvalidType: not a number.

        References:
            Martinelli and Siegwart (2003), Estimating the odometry error of a mobile robot during navigation.

        Example:
            >>> WheelNoise.of_variances(left=4e-6, right=9e-6)
            WheelNoise(left=0.002, right=0.003)
        """
        given = {"left": left, "right": right}
        return cls(**{name: math.sqrt(checks.not_negative(name, value)) for name, value in given.items()})

    def applied(self, steps: Steps, readings: Readings, robot: Robot, common: Array) -> Steps:
        """Return the steps with the noise of the wheels' ways.

        Args:
            steps: without it.
            readings: of the wheels.
            robot: with the radii, the track width and the turning gain.
            common: not read.

        Returns:
            The steps.
        """
        radii = np.array([robot.left_radius, robot.right_radius])
        increments = readings.increments
        left, right = np.moveaxis(np.array([self.left, self.right]) ** 2 * np.abs(increments * radii), -1, 0)
        noise = variances(left, right, robot.track_width)
        if not robot.turning_gain:
            return steps.noisier(*noise)
        var_distance, covariance, var_turn = (part.ravel() for part in noise)
        flat = noisy_turns(increments.reshape(-1, 2), var_distance, covariance, var_turn, robot)
        shift, *noisy = flat.reshape(4, *left.shape)
        return replace(steps, turn=steps.turn + shift).noisier(*noisy)
