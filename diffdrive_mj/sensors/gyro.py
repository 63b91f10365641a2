"""The gyro: how fast the robot turns about the gyro's axis, with the errors that data sheets state.

A reading is the mean over the time since the reading before, as a gyro's own integrator or a low-pass filter gives it:

    reading = (1 + s) mean of omega + mean of b + N / sqrt(dt) white noise,    b a random walk of K sqrt(dt) a step

saturated at the range and rounded to the resolution. Bias and noise are exact samples of the continuous processes, so
that their statistics do not depend on the rate. Not modelled: temperature, acceleration, flicker noise, bandwidth, and
the Earth's turn (at most 15 degrees an hour), which on a level floor is part of the bias.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.gyro_log import GyroLog
from diffdrive_mj.sensors._gyro_grades import GRADES
from diffdrive_mj.sensors._sampling import due, interpolated


@dataclass(frozen=True, kw_only=True)
class Gyro:
    """A gyro about the robot's vertical axis; as it stands, it is perfect.

    Args:
        sample_rate: [Hz].
        bias: what it reads at rest when it is switched on [rad/s].
        angle_random_walk: N, by which the angle's standard deviation grows [rad/sqrt(s)]; the white noise's density
            [(rad/s)/sqrt(Hz)] is the same number.
        bias_random_walk: K, by which the bias's standard deviation grows [rad/s/sqrt(s)].
        scale_error: s, by which part it reads too much.
        range: the largest rate that it can read [rad/s]; None for any.
        resolution: the step between two readings [rad/s]; 0 for none.
        roll: of its axis, about the robot's forward axis [rad]; positive tips the axis to the right.
        pitch: of its axis, about the robot's axis to the left [rad]; positive tips it forward.

    Raises:
        InvalidValue: a field is out of its range; the message names it.
        InvalidType: a field is of another type; the message names it.

    References:
        IEEE Std 952 (1997): the noise model and its Allan deviation.
        Farrenkopf (1978): its exact samples.

    Example:
        One that reads 1 % too much and 0.01 rad/s at rest, on a robot that turns at 0.5 rad/s:

        >>> gyro = dd.Gyro(sample_rate=2.0, bias=0.01, scale_error=0.01)
        >>> gyro.read([0.0, 2.0], [(0.0, 0.0, 0.0), (0.0, 0.0, 1.0)]).rates.round(9).tolist()
        [0.515, 0.515, 0.515, 0.515]
    """

    sample_rate: float = 100.0
    bias: float = 0.0
    angle_random_walk: float = 0.0
    bias_random_walk: float = 0.0
    scale_error: float = 0.0
    range: float | None = None
    resolution: float = 0.0
    roll: float = 0.0
    pitch: float = 0.0

    def __post_init__(self) -> None:
        self._set("sample_rate", checks.positive("Gyro.sample_rate", self.sample_rate))
        for field in ("bias", "scale_error", "roll", "pitch"):
            self._set(field, checks.number(f"Gyro.{field}", getattr(self, field)))
        for field in ("angle_random_walk", "bias_random_walk", "resolution"):
            self._set(field, checks.not_negative(f"Gyro.{field}", getattr(self, field)))
        if self.range is not None:
            self._set("range", checks.positive("Gyro.range", self.range))
            if self.resolution > self.range:
                raise InvalidValue(
                    f"Gyro.resolution = {self.resolution:g} rad/s: must not be above its range, {self.range:g} rad/s"
                )
        if self.scale_error <= -1:
            raise InvalidValue(f"Gyro.scale_error = {self.scale_error:g}: must be above -1, a gyro that reads nothing")
        for field in ("roll", "pitch"):
            if abs(getattr(self, field)) >= math.pi / 2:
                raise InvalidValue(
                    f"Gyro.{field} = {getattr(self, field):g} rad: must be below a quarter turn in size, or its axis "
                    f"does not see the robot turn"
                )

    def _set(self, field: str, value: object) -> None:
        object.__setattr__(self, field, value)

    @classmethod
    def load(cls, grade: str, **changes: Any) -> Gyro:
        """Return a gyro of a known grade, its bias and its scale off by what the data sheet allows.

        Args:
            grade: "mpu6050" (hobby), "bmi088" (drones), or "adis16495" (tactical).
            changes: fields to have otherwise.

        Returns:
            The gyro.

        Raises:
            UnknownName: another grade.

        References:
            The data sheets: models/README.md has each number's source.

        Example:
            >>> hobby = dd.Gyro.load("mpu6050", sample_rate=50.0)
            >>> print(f"{np.degrees(hobby.bias):.0f} deg/s, {np.degrees(hobby.angle_random_walk):.3f} deg/sqrt(s)")
            20 deg/s, 0.005 deg/sqrt(s)
        """
        return replace(cls(**checks.one_of("gyro", grade, GRADES)), **changes)

    @property
    def interval(self) -> float:
        """The time between two readings [s]."""
        return 1 / self.sample_rate

    @property
    def is_random(self) -> bool:
        """Whether it adds noise."""
        return bool(self.angle_random_walk or self.bias_random_walk)

    @property
    def axis(self) -> Array:
        """The direction of its axis in the robot's frame (3,): forward, left, up."""
        return np.array([
            math.sin(self.pitch) * math.cos(self.roll),
            -math.sin(self.roll),
            math.cos(self.pitch) * math.cos(self.roll),
        ])  # fmt: skip

    @property
    def gain(self) -> float:
        """What it reads of a level robot's yaw rate: 1 + scale error, times the cosine of its axis's tilt."""
        return (1 + self.scale_error) * float(self.axis[2])

    @property
    def white_noise(self) -> float:
        """The density of all that is white, its rounding included: sqrt(N^2 + resolution^2 dt / 12) [rad/sqrt(s)]."""
        return math.hypot(self.angle_random_walk, self.resolution * math.sqrt(self.interval / 12))

    def allan_deviation(self, averaging_time: ArrayLike) -> Array:
        """Compute the Allan deviation of its readings at rest.

        ```
        sigma(tau) = sqrt(N^2 / tau + K^2 tau / 3)
        ```

        Args:
            averaging_time: tau (...) [s].

        Returns:
            (...) [rad/s], without its rounding.

        Raises:
            InvalidValue: times that are not positive.

        References:
            IEEE Std 952 (1997).

        Example:
            >>> round(float(np.degrees(dd.Gyro.load("adis16495").allan_deviation(1.0))), 5)
            0.0015
        """
        tau = checks.positive_array("averaging_time", averaging_time)
        return np.sqrt(self.angle_random_walk**2 / tau + self.bias_random_walk**2 * tau / 3)

    def drift(self, duration: float, rest: float) -> float:
        """Compute how far off its angle is after some time, less the bias that it read in a rest before.

        ```
        sigma^2 = N^2 (T + T^2 / T_0) + K^2 T^2 (T + T_0) / 3
        ```

        Args:
            duration: T [s].
            rest: T_0 [s].

        Returns:
            The standard deviation [rad], its rounding included; a scale error comes on top, by what the robot turned.

        Raises:
            InvalidValue: times that are not positive.

        Example:
            A minute after a rest of two seconds:

            >>> for grade in ("mpu6050", "bmi088", "adis16495"):
            ...     print(f"{grade}: {np.degrees(dd.Gyro.load(grade).drift(60.0, rest=2.0)):.3f} deg")
            mpu6050: 0.226 deg
            bmi088: 0.604 deg
            adis16495: 0.065 deg
        """
        time, before = checks.positive("duration", duration), checks.positive("rest", rest)
        white = self.white_noise**2 * (time + time**2 / before)
        return math.sqrt(white + self.bias_random_walk**2 * time**2 * (time + before) / 3)

    def read(
        self,
        t: ArrayLike,
        truth: ArrayLike,
        rng: np.random.Generator | None = None,
        *,
        attitude: ArrayLike | None = None,
    ) -> GyroLog:
        """Read the gyro along a drive, which turns evenly from each recorded pose to the next.

        Args:
            t: (T,) [s], increasing: the times of the recorded poses.
            truth: (..., T, 3) [m, m, rad], headings continuous.
            rng: the source of the noise, anew for each run: white noise, then the bias's steps and its means.
            attitude: (..., T, 4), the robot's attitude in the world as unit quaternions, w first, where it rolls and
                pitches too (`Recording.attitude`); None for a level robot.

        Returns:
            The readings; the first comes one interval after the first pose.

        Raises:
            InvalidValue: shapes that do not fit, times that do not increase, noise without a generator, a recording
                too short for two readings.
            InvalidType: `rng` is no numpy Generator.
        """
        turned = self._turned(truth, attitude)
        recorded = checks.increasing("t", checks.vector("t", t, turned.shape[-1]))
        duration = checks.duration("t", recorded, self.sample_rate)
        edges = recorded[0] + due(duration, self.sample_rate) * self.interval
        if len(edges) < 3:
            raise InvalidValue(f"t spans {duration:g} s: too short for two readings every {self.interval:g} s")
        rates = np.diff(interpolated(recorded, turned[..., None], edges)[..., 0]) * self.sample_rate
        read = (1 + self.scale_error) * rates + self.bias
        if self.is_random:
            read += self._noise(read.shape, checks.generator("rng", rng))
        if self.resolution:
            read = self.resolution * np.round(read / self.resolution)
        limit = math.inf if self.range is None else self.range
        return GyroLog(edges[1:], np.clip(read, -limit, limit), np.abs(read) >= limit)

    def _noise(self, shape: tuple[int, ...], rng: np.random.Generator) -> Array:
        """White noise and the mean of the bias's walk over each interval (..., S) [rad/s]."""
        dt = self.interval
        white, end, within = rng.standard_normal((3, *shape))
        steps = self.bias_random_walk * math.sqrt(dt) * end
        # The mean of a random walk whose end is known: half of the step, and a bridge of variance K^2 dt / 12.
        mean = np.cumsum(steps, axis=-1) - steps / 2 + self.bias_random_walk * math.sqrt(dt / 12) * within
        return self.angle_random_walk / math.sqrt(dt) * white + mean

    def _turned(self, truth: ArrayLike, attitude: ArrayLike | None) -> Array:
        """How far the robot has turned about the gyro's axis since the first pose (..., T) [rad]."""
        poses = checks.array("truth", truth, "T", 3)
        if attitude is None:
            return self.axis[2] * (poses[..., 2] - poses[..., :1, 2])
        most = np.abs(np.diff(poses[..., 2], axis=-1)).max(initial=0.0)
        if most >= math.pi:
            raise InvalidValue(
                f"truth: turns by {most:.3g} rad between two poses: must be below half a turn, or attitudes do not say "
                f"which way; record at a higher sample_rate"
            )
        quaternions = checks.array("attitude", attitude, "T", 4)
        if quaternions.shape[:-1] != poses.shape[:-1]:
            raise InvalidValue(
                f"attitude has shape {quaternions.shape}: must be that of truth {poses.shape}, but for 4"
            )
        turns = _body_turns(quaternions) @ self.axis
        return np.concatenate([np.zeros_like(turns[..., :1]), np.cumsum(turns, axis=-1)], axis=-1)


def _body_turns(attitude: Array) -> Array:
    """Rotation vectors (..., T - 1, 3) [rad] from each attitude to the next, in the body's frame: log(q_k^-1 q_k+1)."""
    w, v = attitude[..., 0], attitude[..., 1:]
    cosine = w[..., :-1] * w[..., 1:] + (v[..., :-1, :] * v[..., 1:, :]).sum(axis=-1)
    sine = (
        w[..., :-1, None] * v[..., 1:, :] - w[..., 1:, None] * v[..., :-1, :] - np.cross(v[..., :-1, :], v[..., 1:, :])
    )
    # The shorter way round: a quaternion and its negative are one attitude.
    sine = np.where(cosine[..., None] < 0, -sine, sine)
    size = np.linalg.norm(sine, axis=-1)
    half = np.arctan2(size, np.abs(cosine))
    return sine * (2 * half / np.where(size > 0, size, 1.0))[..., None]
