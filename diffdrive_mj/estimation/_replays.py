"""Drives replayed with causes of error switched on and off.

Each replay computes the odometry of the same drive with some causes on, against the truth with or without what no
cause explains. Switched off, a cause is ideal: the robot is the true one, its readings are exact and on time.
"""

from __future__ import annotations

import functools
from abc import ABC, abstractmethod
from dataclasses import replace
from typing import Any

import numpy as np

from diffdrive_mj import se2
from diffdrive_mj._checks import Array
from diffdrive_mj.drive import Drive
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.estimation.sensitivities import misjudged
from diffdrive_mj.odometry import Method, Step, integrate
from diffdrive_mj.recording import Recording
from diffdrive_mj.robot import Robot
from diffdrive_mj.sensors import Encoder
from diffdrive_mj.sensors._sampling import due, interpolated

SLIP, SAMPLING, TICKS, LATENCY = "contact and slip", "sampling and method", "encoder ticks", "latency and jitter"
SCALE, RATIO, TRACK, GAIN = "wheel radii", "radius ratio", "track width", "turning gain"
START, CLOCK = "start pose", "clock"
METHOD, REST = "method", "contact, slip and the rest"
_SLACK = 1e-9  # [s]


class Replay(ABC):
    """A drive of one robot, and what is wrong with how it is seen, each of which can be switched on by its name.

    Args:
        true: the robot with which only what no cause explains is left.
        believed: the robot that the odometry computes with.
        method: of the odometry.
        start_error: (3,) [m, m, rad], the pose at which the odometry starts, in the frame of the first true one.
        rest: the name of what is left.
        causes: the others that are there.

    Attributes:
        truth: (M, 3) [m, m, rad], the true poses.
        driven: (T, 3) [m, m, rad], the path, its poses close enough to tell how far it led.
    """

    def __init__(
        self,
        true: Robot,
        believed: Robot,
        method: Method | Step,
        start_error: Array,
        truth: Array,
        rest: str,
        causes: dict[str, Any],
    ) -> None:
        self._true, self._believed, self._method = true, believed, method
        self.truth = self.driven = truth
        self._first, self._start, self._rest = truth[0], se2.compose(truth[0], start_error), rest
        self._factors = {
            SCALE: believed.mean_radius / true.mean_radius,
            RATIO: believed.radius_ratio / true.radius_ratio,
            TRACK: believed.track_width / true.track_width,
        }
        there = {
            rest: True,
            **causes,
            # Factors are one up to rounding where nothing is wrong.
            **{name: abs(factor - 1) > 1e-12 for name, factor in self._factors.items()},
            GAIN: believed.turning_gain != true.turning_gain,
            START: start_error.any(),
        }
        self.causes = tuple(cause for cause, is_there in there.items() if is_there)
        self._relative = functools.lru_cache(maxsize=None)(self._relative_end)
        self.ideal_end = se2.compose(self._first, self._relative(frozenset()))
        self._last = truth[-1]

    def error(self, on: frozenset[str]) -> Array:
        """The final error (3,) with some causes on."""
        first = self._start if START in on else self._first
        last = self._last if self._rest in on else self.ideal_end
        return se2.compose(first, self._relative(on - {START, self._rest})) - last

    def _relative_end(self, on: frozenset[str]) -> Array:
        """Where odometry ends, in the frame of where it starts."""
        method = self._method if {SAMPLING, METHOD} & on else "arc"
        return integrate(self._readings(on), self._robot(on), method)[-1]

    @abstractmethod
    def _readings(self, on: frozenset[str]) -> Array:
        """The wheel angles (S, 2) that odometry reads: what was wrong with each reading is there or not."""

    def _robot(self, on: frozenset[str]) -> Robot:
        """The true robot with some parameters as believed."""
        scale, ratio, track = (factor if name in on else 1.0 for name, factor in self._factors.items())
        gain = (self._believed if GAIN in on else self._true).turning_gain
        return misjudged(self._true, scale=scale, ratio=ratio, track=track).replace(turning_gain=gain)


class SimulatedReplay(Replay):
    """A recording, whose readings are made with and without what is wrong with them."""

    def __init__(
        self,
        recording: Recording[Robot, Any],
        believed: Robot,
        method: Method | Step,
        encoder: Encoder | None,
        start_error: Array,
        clock_offset: float,
        rng: np.random.Generator,
    ) -> None:
        self._t, self._angles, self._clock_offset = recording.t, recording.wheel_angles, clock_offset
        self._stamps, self._late, self._rounding = self._t, np.zeros(len(self._t)), np.zeros_like(self._angles)
        if encoder is not None:
            if any(encoder.reversed) or encoder.swapped:
                raise InvalidValue("encoder: is reversed or swapped, which is no part of an error; wire it right")
            duration = float(self._t[-1] - self._t[0])
            numbers = due(duration, encoder.sample_rate)
            if len(numbers) < 2:
                raise InvalidValue(
                    f"the drive takes {duration:g} s: too short for two readings every {encoder.interval:g} s"
                )
            self._stamps = self._t[0] + numbers * encoder.interval
            phase, jitter = rng.random(2), rng.uniform(-encoder.jitter, encoder.jitter, len(numbers))
            self._late = encoder.latency - jitter
            read = self._at(self._stamps - self._late + clock_offset)
            # Ticks that are missed and counters that wrap, too; a constant moves nothing.
            counts = replace(encoder, latency=0.0, jitter=0.0).read(self._stamps, read, rng, phase=phase).counts
            self._rounding = encoder.to_angles(counts) - (read - read[0])
        causes = {
            SAMPLING: encoder is not None or method != "arc",
            TICKS: encoder is not None,
            LATENCY: encoder is not None and (encoder.latency or encoder.jitter),
            CLOCK: clock_offset,
        }
        super().__init__(recording.robot, believed, method, start_error, recording.truth, SLIP, causes)

    def _readings(self, on: frozenset[str]) -> Array:
        instants = self._stamps if SAMPLING in on else self._t
        shift = np.zeros(len(instants))
        if LATENCY in on:
            shift -= np.interp(instants, self._stamps, self._late)
        if CLOCK in on:
            shift += self._clock_offset
        angles = self._at(instants + shift)
        if TICKS in on:
            angles += np.stack([np.interp(instants, self._stamps, wheel) for wheel in self._rounding.T], axis=-1)
        return angles

    def _at(self, instants: Array) -> Array:
        """The true wheel angles (S, 2); before and after the recording the wheels stand still."""
        return interpolated(self._t, self._angles, np.clip(instants, self._t[0], self._t[-1]))


class LoggedReplay(Replay):
    """A drive as it was measured: its readings are what they are, but for the clock that stamped them."""

    def __init__(
        self,
        drive: Drive,
        true: Robot,
        believed: Robot,
        method: Method | Step,
        start_error: Array,
        clock_offset: float,
    ) -> None:
        begin, end = drive.t[0] + max(clock_offset, 0.0) - _SLACK, drive.t[-1] + min(clock_offset, 0.0) + _SLACK
        kept = np.flatnonzero((drive.clock >= begin) & (drive.clock <= end))
        if len(kept) < 2:
            raise InvalidValue(
                f"clock_offset = {clock_offset:g} s: {drive.name} has {len(kept)} true poses within the encoder's "
                "times with and without it; must be at least two"
            )
        self._drive, self._clock_offset = drive, clock_offset
        self._from, self._to = drive.clock[kept[0]], drive.clock[kept[-1]]
        truth = se2.unwrapped(drive.truth[kept])
        super().__init__(
            true, believed, method, start_error, truth, REST, {METHOD: method != "arc", CLOCK: clock_offset}
        )
        # Poses may be too sparse to say how often the robot turned round between them.
        turn = self.ideal_end[2] + se2.wrap_angle(self._last[2] - self.ideal_end[2])
        self._last = np.array([*self._last[:2], turn])
        self.driven = integrate(self._readings(frozenset()), true)

    def _readings(self, on: frozenset[str]) -> Array:
        shift = 0.0 if CLOCK in on else -self._clock_offset
        first, last = self._from + shift, self._to + shift
        within = self._drive.t[(self._drive.t > first) & (self._drive.t < last)]
        return self._drive.angles_at(np.concatenate([[first], within, [last]]))
