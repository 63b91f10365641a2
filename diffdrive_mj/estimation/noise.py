"""What a model of noise is: it says of each step of a drive how far and by how much it turned, and how surely.

A step's distance and turn are Gaussian and independent of all other steps. What is the same along the whole drive, such
as a gyro's bias or the phase of a counter, is no noise of a step: a model names it apart.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj.drive import Drive
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.kinematics import body_twist
from diffdrive_mj.recording import Recording
from diffdrive_mj.robot import Robot


@dataclass(frozen=True, eq=False)
class Readings:
    """Hold what was read on a drive, or on many.

    Attributes:
        wheel_angles: (..., T, 2) [rad], left then right.
        t: (T,) [s]; None where nobody says.
        turns: (..., T - 1) [rad], what a gyro read, not a number where it did not see all of a step; None without one.

    Example:
        >>> Readings.of([(0.0, 0.0), (1.0, 1.0)]).wheel_angles.shape
        (2, 2)
    """

    wheel_angles: Array
    t: Array | None = None
    turns: Array | None = None

    @classmethod
    def of(cls, wheel_angles: ArrayLike | Drive | Recording, times: ArrayLike | None = None) -> Readings:
        """Take readings from what holds them.

        Args:
            wheel_angles: (..., T, 2) [rad], two samples at least, or a drive or a recording, which bring their times.
            times: of an array's samples (T,) [s].

        Returns:
            The readings.

        Raises:
            InvalidType: not numbers.
            InvalidValue: shapes that do not fit, values that are not finite, times that do not increase or that a drive
                has already.
        """
        if not isinstance(wheel_angles, (Drive, Recording)):
            angles = checks.array("wheel_angles", wheel_angles, "T", 2)
            if angles.shape[-2] < 2:
                raise InvalidValue(f"wheel_angles has shape {angles.shape}: must have two samples at least")
            return cls(angles, None if times is None else _clock(times, angles.shape[-2]))
        if times is not None:
            raise InvalidValue("times: must be left out, since a drive has its own")
        gyro = wheel_angles.gyro if isinstance(wheel_angles, Drive) else None
        angles = checks.array("wheel_angles", wheel_angles.wheel_angles, "T", 2)
        if gyro is None:
            return cls(angles, wheel_angles.t)
        turned, seen = gyro.turns(wheel_angles.t)
        return cls(angles, wheel_angles.t, np.where(seen, turned, np.nan))

    @property
    def increments(self) -> Array:
        """How far the wheels turn in each step (..., T - 1, 2) [rad]."""
        return np.diff(self.wheel_angles, axis=-2)

    def durations(self, whose: str) -> Array:
        """Return how long each step takes.

        Args:
            whose: the model that asks, for the message.

        Returns:
            (T - 1,) [s].

        Raises:
            InvalidValue: nobody says when the samples were.
        """
        if self.t is None:
            raise InvalidValue(f"{whose} grows with time: times = ... must say when the samples were, or give a Drive")
        return np.diff(self.t)


def _clock(times: ArrayLike, samples: int) -> Array:
    return checks.increasing("times", checks.vector("times", times, samples))


@dataclass(frozen=True, eq=False)
class Steps:
    """Hold how far each step goes and turns, and how surely.

    Attributes:
        distance: its mean (..., S) [m].
        turn: its mean (..., S) [rad].
        var_distance: variance of the distance (..., S) [m^2].
        covariance: of distance and turn (..., S) [m rad].
        var_turn: variance of the turn (..., S) [rad^2].

    Example:
        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> Steps.of(Readings.of([(0.0, 0.0), (1.0, 3.0)]), robot).turn
        array([0.5])
    """

    distance: Array
    turn: Array
    var_distance: Array
    covariance: Array
    var_turn: Array

    @classmethod
    def of(cls, readings: Readings, robot: Robot) -> Steps:
        """Take the wheels at their word.

        Args:
            readings: of the wheels.
            robot: with the radii, the track width and the turning gain.

        Returns:
            Steps without noise.
        """
        distance, turn = np.moveaxis(body_twist(readings.increments, robot), -1, 0)
        none = np.zeros_like(distance)
        return cls(distance, turn, none, none, none)

    def noisier(self, var_distance: Array | float, covariance: Array | float, var_turn: Array | float) -> Steps:
        """Add noise that is independent of what is there.

        Args:
            var_distance: (..., S) [m^2].
            covariance: (..., S) [m rad].
            var_turn: (..., S) [rad^2].

        Returns:
            The same steps, less sure.
        """
        return replace(
            self,
            var_distance=self.var_distance + var_distance,
            covariance=self.covariance + covariance,
            var_turn=self.var_turn + var_turn,
        )


class Noise:
    """A model of noise: a subclass says what it does to the steps, and what of it stays the same along a drive.

    Example:
        A robot that is pushed to and fro by its floor, a little in every step:

        >>> class Shaking(Noise):
        ...     def applied(self, steps, readings, robot, common):
        ...         return steps.noisier(var_distance=0.0, covariance=0.0, var_turn=1e-4)
        >>> angles = np.linspace(0.0, 10.0, 101)[:, None] * (1.0, 1.0)
        >>> dd.covariance(angles, dd.Robot.load("matched"), noise=Shaking()).sigma[-1, 2].round(9).item()
        0.1
    """

    def applied(self, steps: Steps, readings: Readings, robot: Robot, common: Array) -> Steps:
        """Return the steps with this noise.

        Args:
            steps: as the wheels and the models before this one have them.
            readings: of the drive.
            robot: as believed.
            common: what is the same along the whole drive (C,), less its mean.

        Returns:
            The steps; these by default.
        """
        return steps

    @property
    def common(self) -> Array:
        """The covariance (C, C) of what is unknown and the same along the whole drive."""
        return np.zeros((0, 0))

    def readings(self, readings: Readings) -> Iterator[tuple[float, Readings]]:
        """Go through what may have been read in place of given readings, where that is not Gaussian.

        Args:
            readings: of the drive.

        Yields:
            A probability and the readings; all probabilities add up to one.
        """
        yield 1.0, readings
