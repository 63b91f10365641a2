"""Wheels that are counted in whole ticks: what the unknown phases of the counters do to odometry.

A counter reads floor(angle / tick + U), and its phase U is the same for all readings of a drive. The error of a reading
is less than a tick however far the wheel has turned, so that the errors of its increments cancel: whoever takes them
for independent noise gets a variance that grows with the rate at which the counter is read.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj._described import checked, described
from diffdrive_mj.estimation.noise import Noise, Readings
from diffdrive_mj.robot import Robot
from diffdrive_mj.sensors.encoder import Encoder

# Pairs of phases, and the fewest: with less of them the deviations are off by more than a tenth.
_PHASES, _FEWEST = 1597, 21
_GOLDEN = (5**0.5 - 1) / 2
# From one reading's part of a tick to the next one's, by wheel: nowhere near a fraction of small numbers.
_JUMPS = (_GOLDEN, 2**0.5 - 1)
# How far into its last tick a wheel that was counted is put: first and last reading then differ as two that are off by
# independent parts of a tick do, f (1 - f) = 1 / 6.
_WITHIN = (1 - 3**-0.5) / 2
# Angles that are whole ticks up to rounding [ticks].
_SLACK = 1e-6


@described()
@dataclass(frozen=True, kw_only=True)
class CounterPhases(Noise):
    """Describe wheels that are counted in ticks, by counters of which nobody knows the phase.

    ```
    read angle = tick (floor(angle / tick + U) - floor(first angle / tick + U)),    U uniform in [0, 1), one a wheel
    ```

    It is no noise of the steps: pairs of phases, evenly spread, make as many drives, whose mean and covariance are
    found. Wheel angles that are whole ticks, as a log has them, get parts of a tick first: a wheel that is read several
    times in a tick has turned evenly between the readings at which its count changes, and a faster one was anywhere in
    its tick, independently at each reading.

    Args:
        tick: the angle of a wheel in a tick [rad].
        phases: how many pairs of phases, 21 at least.

    Raises:
        InvalidValue: a tick that is not positive, too few phases.
        InvalidType: not a number.
        UnknownName: a field that it does not have.

    Example:
        A metre and a half ahead in ticks of a centimetre: each wheel is off by less than a tick, whatever the rate.

        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> sigmas = []
        >>> for samples in (151, 1501):
        ...     angles = np.linspace(0.0, 15.35, samples)[:, None] * (1.0, 1.0)
        ...     sigmas.append(dd.covariance(angles, robot, noise=CounterPhases(tick=0.1)).sigma[-1, 2])
        >>> np.round(sigmas, 4).tolist()  # [rad]
        [0.0177, 0.0177]
    """

    tick: float = field(metadata=checked(checks.positive))
    phases: int = field(default=_PHASES, metadata=checked(partial(checks.whole, least=_FEWEST)))

    @classmethod
    def of(cls, encoder: Encoder | Robot, *, phases: int = _PHASES) -> CounterPhases:
        """Take the ticks of an encoder, or of a robot's own.

        Args:
            encoder: or the robot.
            phases: how many pairs of phases, 21 at least.

        Returns:
            The noise.

        Raises:
            InvalidType: neither an encoder nor a robot.
            InvalidValue: too few phases.

        Example:
            >>> round(CounterPhases.of(dd.Robot.load("turtlebot3_burger")).tick, 6)
            0.001534
        """
        own = Encoder(encoder) if isinstance(encoder, Robot) else checks.instance("encoder", encoder, Encoder)
        return cls(tick=own.tick_angle, phases=phases)

    def readings(self, readings: Readings) -> Iterator[tuple[float, Readings]]:
        """Go through what counters may have read, by their phases.

        Args:
            readings: of the drive.

        Yields:
            A probability and the readings.
        """
        ticks = _evened(readings.wheel_angles / self.tick)
        for phase in _lattice(self.phases):
            counts = np.floor(ticks + phase)
            yield 1 / self.phases, replace(readings, wheel_angles=counts * self.tick)


def _lattice(count: int) -> Array:
    """Points (count, 2) that fill the unit square evenly, each coordinate by itself too: Fibonacci's, or near it."""
    wanted = count * _GOLDEN
    step = min((k for k in range(1, count + 1) if math.gcd(k, count) == 1), key=lambda k: abs(k - wanted))
    number = np.arange(count)
    return (np.stack([number, number * step % count], axis=-1) + 0.5) / count


def _evened(ticks: Array) -> Array:
    """Ticks (..., T, 2) that are whole, with parts of a tick that may have been lost.

    A wheel that is read several times in a tick turns evenly between the readings at which its count changes; one that
    turns by ticks between two readings is anywhere in its tick, independently at each.
    """
    since = ticks - ticks[..., :1, :]
    if np.abs(since - np.round(since)).max() > _SLACK:
        return ticks
    runs = np.round(since).reshape(-1, *ticks.shape[-2:])
    even = np.stack([[_filled(run[:, wheel], _JUMPS[wheel]) for wheel in (0, 1)] for run in runs])
    return np.swapaxes(even, -1, -2).reshape(ticks.shape)


def _filled(counts: Array, jump: float) -> Array:
    """Whole ticks (T,) of a wheel with parts of a tick."""
    changed = np.flatnonzero(np.diff(counts))
    if not changed.size:
        return counts
    samples = np.arange(len(counts))
    last = counts[-1] + math.copysign(_WITHIN, counts[-1] - counts[changed[-1]])
    at = np.concatenate([samples[:1], changed + 0.5, samples[-1:]])
    slowly = np.interp(samples, at, np.concatenate([counts[:1], (counts[changed] + counts[changed + 1]) / 2, [last]]))
    fast = np.zeros(len(counts), dtype=bool)
    fast[1:-1] = np.abs(counts[2:] - counts[:-2]) >= 2
    return np.where(fast, counts + samples * jump % 1, slowly)
