"""The wheel encoder: an ideal wheel angle becomes the counts that a robot reads, and counts become angles again.

A counter shows floor(angle / tick + phase). It is read at its own times, of which the robot knows the stamps alone:

    stamped    t_0 + k / sample_rate
    read       stamped - latency + u,  u uniform in [-jitter, jitter), one draw for both wheels

The angles that come back are off by less than a tick, however far the wheels turn, and as late as the latency.
"""

from __future__ import annotations

import math
from dataclasses import KW_ONLY, InitVar, dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj._text import shown
from diffdrive_mj.errors import InvalidType, InvalidValue
from diffdrive_mj.kinematics import body_twist
from diffdrive_mj.parts import WheelEncoder
from diffdrive_mj.robot import Robot
from diffdrive_mj.sensors._counters import (
    Counts,
    check_bits,
    held_at_first,
    summed,
    ticks_at,
    unwrap_counts,
    whole_counts,
    wrap_counts,
)
from diffdrive_mj.sensors._sampling import due, interpolated


@dataclass(frozen=True, eq=False)
class Readings:
    """What a robot has read from its encoders.

    Attributes:
        t: (T,) [s], the times that the robot stamps the readings with.
        counts: (..., T, 2) [ticks], left then right; wrapped if the counters wrap.

    Example:
        >>> encoder = dd.Encoder(ticks_per_revolution=360, sample_rate=10.0)
        >>> encoder.read([0.0, 1.0], [(0.0, 0.0), (0.1, 0.2)])
        Readings(11 samples, 0 to 1 s)
    """

    t: Array
    counts: Counts

    def __repr__(self) -> str:
        runs = f"{self.counts.shape[:-2]} runs of " if self.counts.ndim > 2 else ""
        return f"Readings({runs}{len(self.t)} samples, {self.t[0]:g} to {self.t[-1]:g} s)"


# The default of a field that is the robot's own, if there is a robot.
_ROBOTS: Any = None


@dataclass(frozen=True)
class Encoder:
    """Both wheels' incremental encoders, how they are read, and what is wrong with them.

    Args:
        robot: whose encoder has the ticks and the gear that are not given here.
        ticks_per_revolution: per turn of the encoder's shaft, all edges counted; need not be whole.
        sample_rate: [Hz].
        gear: turns of the encoder's shaft per turn of the wheel; 1 without a robot.
        latency: a reading shows the angles of this much earlier [s].
        jitter: half-width of the reading times' uniform error [s], below half of the sampling interval, so that the
            times increase; its standard deviation is jitter / sqrt(3).
        counter_bits: None for a counter that never wraps, or 16 or 32: signed, two's complement.
        missed_ticks: probability that an edge is not counted, of the net edges between two readings.
        reversed: whether the left and the right wheel's encoder counts backwards.
        swapped: whether the left wheel's encoder is plugged in as the right one and the right wheel's as the left.

    Raises:
        InvalidValue: a field is out of its range; the message names it.
        InvalidType: a field is of another type, or there are neither ticks nor a robot that has them.

    Example:
        An encoder of 64 edges behind a gear of 43.7, read at 50 Hz:

        >>> encoder = dd.Encoder(ticks_per_revolution=64, gear=43.7, sample_rate=50.0)
        >>> readings = encoder.read(t=[0.0, 1.0], wheel_angles=[(0.0, 0.0), (np.pi, -np.pi)])
        >>> readings.counts[-1].tolist()
        [1398, -1398]
        >>> encoder.to_angles(readings.counts)[-1].round(3).tolist()
        [3.141, -3.141]

        A robot brings its own:

        >>> dd.Encoder(dd.Robot.load("optiodom"), sample_rate=50.0) == encoder
        True
    """

    robot: InitVar[Robot | None] = None
    _: KW_ONLY
    ticks_per_revolution: float = _ROBOTS
    sample_rate: float = 100.0
    gear: float = _ROBOTS
    latency: float = 0.0
    jitter: float = 0.0
    counter_bits: Literal[16, 32] | None = None
    missed_ticks: float = 0.0
    reversed: tuple[bool, bool] = (False, False)
    swapped: bool = False

    def __post_init__(self, robot: Robot | None) -> None:
        self._fill_in(robot)
        for field in ("ticks_per_revolution", "sample_rate", "gear"):
            self._set(field, checks.positive(f"Encoder.{field}", getattr(self, field)))
        for field in ("latency", "jitter", "missed_ticks"):
            self._set(field, checks.not_negative(f"Encoder.{field}", getattr(self, field)))
        if self.jitter >= self.interval / 2:
            raise InvalidValue(
                f"Encoder.jitter = {self.jitter:g} s: must be below half of the sampling interval, "
                f"{self.interval / 2:g} s, or readings overtake each other"
            )
        if self.missed_ticks >= 1:
            raise InvalidValue(f"Encoder.missed_ticks = {self.missed_ticks:g}: must be a probability below 1")
        check_bits("Encoder.counter_bits", self.counter_bits)
        if not isinstance(self.reversed, (tuple, list)) or len(self.reversed) != 2:
            raise InvalidType(f"Encoder.reversed = {shown(self.reversed)}: must be (left, right), each True or False")
        self._set("reversed", tuple(checks.boolean("Encoder.reversed", wheel) for wheel in self.reversed))
        self._set("swapped", checks.boolean("Encoder.swapped", self.swapped))

    def _fill_in(self, robot: Robot | None) -> None:
        """Take what was not given from the robot."""
        own = WheelEncoder() if robot is None else checks.instance("robot", robot, Robot).encoder
        if robot is None and self.ticks_per_revolution is None:
            raise InvalidType("Encoder(...): needs a robot or ticks_per_revolution, such as Encoder(robot)")
        for field in ("ticks_per_revolution", "gear"):
            if getattr(self, field) is None:
                self._set(field, getattr(own, field))

    def _set(self, field: str, value: object) -> None:
        object.__setattr__(self, field, value)

    @property
    def interval(self) -> float:
        """The time between two stamps [s]."""
        return 1 / self.sample_rate

    @property
    def tick_angle(self) -> float:
        """The angle that the wheel turns in one tick, 2 pi / (ticks_per_revolution gear) [rad]."""
        return 2 * math.pi / (self.ticks_per_revolution * self.gear)

    def distance_per_tick(self, robot: Robot) -> Array:
        """Compute how far a wheel rolls in one tick, r tick_angle; the robot moves half of it.

        Args:
            robot: its radii r.

        Returns:
            (2,) [m], left then right.
        """
        checks.instance("robot", robot, Robot)
        return self.tick_angle * np.array([robot.left_radius, robot.right_radius])

    def heading_per_tick(self, robot: Robot) -> Array:
        """Compute how far it turns when one wheel moves by one tick: by -r_l tick_angle / b, or r_r tick_angle / b.

        Args:
            robot: its radii r and track width b.

        Returns:
            (2,) [rad], for a tick of the left wheel, then of the right.
        """
        return body_twist(self.tick_angle * np.eye(2), robot)[:, 1]

    def read(
        self,
        t: ArrayLike,
        wheel_angles: ArrayLike,
        rng: np.random.Generator | None = None,
        *,
        phase: ArrayLike | Literal["random"] = 0.5,
    ) -> Readings:
        """Read the encoders along a drive, whose wheels turn evenly between recorded samples.

        The stamps start with the first recorded time. Those are left out whose reading would lie outside the
        recording, for the latency or for the largest jitter.

        Args:
            t: (T,) [s], increasing: the times of the recorded samples.
            wheel_angles: (..., T, 2) [rad], left then right, ideal.
            rng: the source of random phases, jitter and missed ticks, in this order, anew for each run.
            phase: (..., 2) or a number, what the counters hold at a wheel angle of zero [ticks]: 0 rounds down, 0.5 to
                the nearest; or "random", uniform in [0, 1). Leading dimensions broadcast with those of the angles, so
                that many phases read one drive.

        Returns:
            The stamps and the counts.

        Raises:
            InvalidValue: shapes that do not fit, times that do not increase, randomness without a generator, a
                recording too short for two readings, or a wheel that turns by half of a counter's range or more
                between two of them, which cannot be told from a wrap.
            InvalidType: `rng` is not a numpy Generator, `phase` not a number.
            UnknownName: a `phase` that is a word other than "random".
        """
        angles = checks.array("wheel_angles", wheel_angles, "T", 2)
        recorded = checks.increasing("t", checks.vector("t", t, angles.shape[-2]))
        duration = checks.duration("t", recorded, self.sample_rate)
        numbers = due(duration, self.sample_rate, self.latency + self.jitter, max(0.0, self.jitter - self.latency))
        if len(numbers) < 2:
            raise InvalidValue(
                f"t spans {duration:g} s: too short for two readings every {self.interval:g} s with a latency of "
                f"{self.latency:g} s and a jitter of {self.jitter:g} s"
            )
        stamps = recorded[0] + numbers * self.interval
        generator = self._generator(rng, phase)
        held = _phase(phase, generator, angles.shape[:-2])
        runs = checks.broadcast(wheel_angles=angles[..., 0, 0], phase=held[..., 0])
        instants = stamps - self.latency
        if self.jitter:
            instants = instants + generator.uniform(-self.jitter, self.jitter, (*runs, len(stamps)))
            angles = np.broadcast_to(angles, (*runs, *angles.shape[-2:]))
        turned = interpolated(recorded, angles, instants) * np.where(self.reversed, -1, 1)
        counts = whole_counts(ticks_at(turned, self.tick_angle, held[..., None, :]))
        if self.missed_ticks:
            steps = np.diff(counts, axis=-2)
            counted = np.sign(steps) * generator.binomial(np.abs(steps), 1 - self.missed_ticks)
            counts = summed(counts, counted)
        if self.swapped:
            counts = counts[..., ::-1].copy()
        return Readings(stamps, wrap_counts(counts, self.counter_bits))

    def to_angles(self, counts: ArrayLike, max_rate: float | None = None) -> Array:
        """Compute wheel angles from counts, as a robot does: the wrap is undone, faults stay in.

        Args:
            counts: (..., T, 2) [ticks], left then right, one reading a sampling interval.
            max_rate: the fastest that a wheel can turn [rad/s], so that impossible jumps are found.

        Returns:
            (..., T, 2) [rad], zero at the first reading.

        Raises:
            InvalidType: not numbers.
            InvalidValue: counts that are not whole or do not fit in the bits, or jumps that a wheel cannot make.
        """
        most = None
        if max_rate is not None:
            longest = self.interval + 2 * self.jitter
            # A path of n ticks and a bit crosses n + 1 edges at most.
            ticks_at_most = checks.positive("max_rate", max_rate) * longest / self.tick_angle
            most = 1 + math.floor(min(ticks_at_most, 2.0**53))
        ticks = unwrap_counts(counts, self.counter_bits, most)
        return (ticks - ticks[..., :1, :]).astype(np.float64) * self.tick_angle

    def _generator(self, rng: np.random.Generator | None, phase: object) -> np.random.Generator:
        """The generator, which may only be missing where nothing is random."""
        if rng is None:
            fields = [f"Encoder.{field}" for field in ("jitter", "missed_ticks") if getattr(self, field)]
            if random := ["phase"] * isinstance(phase, str) + fields:
                raise InvalidValue(f"rng = None: must be a numpy Generator, for {' and '.join(random)} is random")
            return np.random.default_rng(0)
        return checks.generator("rng", rng)


def _phase(phase: ArrayLike | str, generator: np.random.Generator, runs: tuple[int, ...]) -> Array:
    """Phases (..., 2) [ticks]."""
    if isinstance(phase, str):
        checks.member("phase", phase, ("random",))
        return generator.random((*runs, 2))
    return held_at_first(phase)
