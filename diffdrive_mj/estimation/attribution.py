"""Whose fault a drift is: one drive replayed with its causes switched on and off, and the final error split among them.

Each replay computes the odometry of the same drive with some causes on and the others off, against the truth with or
without what the contacts did. The parts are Shapley values (`shapley`): they add up to the error.
"""

from __future__ import annotations

import functools
import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj import _checks as checks
from diffdrive_mj import metrics, se2
from diffdrive_mj._checks import Array
from diffdrive_mj._text import html_table, quantity, table
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.estimation import shapley
from diffdrive_mj.estimation.sensitivities import misjudged
from diffdrive_mj.odometry import Method, Step, integrate
from diffdrive_mj.recording import Recording
from diffdrive_mj.robot import Robot
from diffdrive_mj.sensors import Encoder
from diffdrive_mj.sensors._sampling import due, interpolated

_BAR = 20  # length of the longest bar [characters]


@dataclass(frozen=True, eq=False)
class Attribution:
    """Holds what part each cause has in the final error of odometry, the largest first, and prints as a table.

    Attributes:
        name: of the drive.
        causes: (C,) in words.
        parts: (C, 3) [m, m, rad], estimate minus truth along the world's axes; they add up to `error`.
        alone: (C, 3), the error that each cause makes when it is the only one.
        spread: (C, 2) [m, rad], how far what a cause adds is from its part, in the order where that is most: its
            interaction with the others, no summand.
        error: (3,), the final error.
        distance: driven [m].

    Example:
        >>> true = dd.Robot.load("mismatched")
        >>> recording = dd.simulate(true, dd.maneuvers.straight(true, speed=0.5, distance=1.0))
        >>> found = dd.attribute(recording, true, start_error=(0.0, 0.005, 0.0))
        >>> found.causes, found.sizes.round(6).tolist()
        (('start pose', 'contact and slip'), [0.005, 0.0])
    """

    name: str
    causes: tuple[str, ...]
    parts: Array
    alone: Array
    spread: Array
    error: Array
    distance: float

    @property
    def sizes(self) -> Array:
        """How long the position of each part is (C,) [m]."""
        return np.hypot(self.parts[:, 0], self.parts[:, 1])

    def as_dict(self) -> dict[str, Any]:
        """The figures for programs, in metres and radians."""
        keys = ("x_m", "y_m", "heading_rad")
        rows = zip(self.causes, self.parts.tolist(), self.alone.tolist(), self.spread.tolist(), strict=True)
        return {
            "drive": self.name,
            "distance_m": self.distance,
            "error": dict(zip(keys, self.error.tolist(), strict=True)),
            "causes": [
                {
                    "cause": cause,
                    "part": dict(zip(keys, part, strict=True)),
                    "alone": dict(zip(keys, alone, strict=True)),
                    "spread": {"position_m": spread[0], "heading_rad": spread[1]},
                }
                for cause, part, alone, spread in rows
            ],
        }

    def __str__(self) -> str:
        lines = table(self._header(), [*self._rows(), ["all", *self._numbers(self.error), "", ""]]).splitlines()
        longest = max(float(self.sizes.max()), 1e-12)
        bars = ["", "", *("#" * round(_BAR * size / longest) for size in self.sizes.tolist()), ""]
        width = max(map(len, lines))
        drawn = (f"{line:<{width}}  {bar}".rstrip() for line, bar in zip(lines, bars, strict=True))
        return "\n".join([self.title, "", *drawn])

    def _repr_html_(self) -> str:
        return html_table([*self._rows(), ["all", *self._numbers(self.error), "", ""]], self._header(), self.title)

    @property
    def title(self) -> str:
        """What was found, in a line."""
        position, heading = float(np.hypot(*self.error[:2])), abs(round(float(np.degrees(self.error[2])), 6))
        off = f"{quantity(position, 'm')} and {heading:.3g} degrees"
        worst = f"; most of it by {self.causes[0]}" if len(self.causes) > 1 else ""
        return f"{self.name}: {off} off after {self.distance:.4g} m{worst}"

    def _header(self) -> list[str]:
        return ["cause", "x [mm]", "y [mm]", "heading [deg]", "alone [mm]", "+- [mm]"]

    def _numbers(self, error: Array) -> list[float]:
        return [*(np.round(1e3 * error[:2], 6) + 0.0).tolist(), round(float(np.degrees(error[2])), 6) + 0.0]

    def _rows(self) -> list[list[Any]]:
        alone = np.round(1e3 * np.hypot(self.alone[:, 0], self.alone[:, 1]), 6)
        spread = np.round(1e3 * self.spread[:, 0], 6)
        rows = zip(self.causes, self.parts, alone.tolist(), spread.tolist(), strict=True)
        return [[cause, *self._numbers(part), by_itself, apart] for cause, part, by_itself, apart in rows]


SLIP, SAMPLING, TICKS, LATENCY = "contact and slip", "sampling and method", "encoder ticks", "latency and jitter"
SCALE, RATIO, TRACK, GAIN = "wheel radii", "radius ratio", "track width", "turning gain"
START, CLOCK = "start pose", "clock"


def attribute(
    recording: Recording[Robot, Any],
    believed: Robot,
    *,
    method: Method | Step = "arc",
    encoder: Encoder | None = None,
    start_error: ArrayLike = (0.0, 0.0, 0.0),
    clock_offset: float = 0.0,
    seed: int = 0,
) -> Attribution:
    """Split the final error of odometry on a simulated drive among its causes.

    The causes are what the contacts did, how the wheels were read (rate and method, ticks, latency), what the odometry
    takes the robot for (mean radius, radius ratio, track width), where it started, and its clock. Switched off, a cause
    is ideal: the wheels roll, every recorded sample is read exactly and at once and taken for an arc, the robot is the
    true one, its first pose the true one. Causes that are not there are left out.

    Args:
        recording: of one run; more samples than the encoder's make "sampling" what it says.
        believed: the robot that the odometry computes with.
        method: of the odometry.
        encoder: how the wheels are read; None for the recorded samples.
        start_error: (3,) [m, m, rad], the pose at which the odometry starts, in the frame of the true one.
        clock_offset: by how much the robot's readings are younger than it takes them to be [s].
        seed: of the counters' phases and of the jitter.

    Returns:
        The parts, the largest first.

    Raises:
        InvalidType: not a recording, a robot, an encoder, numbers.
        InvalidValue: a recording of many runs, or values out of range.

    Example:
        >>> true = dd.Robot.load("mismatched")
        >>> recording = dd.simulate(true, dd.maneuvers.square(true, side=1.0, speed=0.5))
        >>> found = attribute(recording, true.replace(track_width=0.402), encoder=dd.Encoder(true, sample_rate=20.0))
        >>> found.causes[0]
        'track width'
        >>> np.allclose(found.parts.sum(axis=0), found.error, rtol=0, atol=1e-12)
        True
    """
    checks.instance("recording", recording, Recording)
    checks.instance("believed", believed, Robot)
    if isinstance(recording.robot, tuple):
        raise InvalidValue("recording has many runs: must be one, such as recording.runs[0]")
    if encoder is not None:
        checks.instance("encoder", encoder, Encoder)
    replay = _Replay(
        recording, believed, method, encoder, checks.vector("start_error", start_error, 3),
        checks.number("clock_offset", clock_offset), np.random.default_rng(checks.whole("seed", seed, least=0)),
    )  # fmt: skip
    causes = replay.causes
    switched = list(itertools.product((False, True), repeat=len(causes)))
    ends = [replay.error(frozenset(itertools.compress(causes, on))) for on in switched]
    outcomes = np.reshape(ends, (*(2 for _ in causes), 3))
    steps, parts = shapley.added(outcomes), shapley.parts(outcomes)
    apart = steps - parts[:, None]
    spread = np.stack([np.hypot(apart[..., 0], apart[..., 1]).max(axis=1), np.abs(apart[..., 2]).max(axis=1)], axis=-1)
    order = np.argsort(-np.hypot(parts[:, 0], parts[:, 1]), kind="stable")
    return Attribution(
        recording.robot.name,
        tuple(causes[k] for k in order),
        parts[order],
        steps[order, 0],
        spread[order],
        np.asarray(ends[-1]) - ends[0],
        float(metrics.travelled(recording.truth)[-1]),
    )


class _Replay:
    """The drive, and what is wrong with how it is seen, each of which can be switched on by its name."""

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
        self._t, self._angles, self._truth = recording.t, recording.wheel_angles, recording.truth
        self._true, self._believed, self._method, self._encoder = recording.robot, believed, method, encoder
        self._start = se2.compose(self._truth[0], start_error)
        self._clock_offset = clock_offset
        self._ideal_end = integrate(self._angles, self._true, "arc", self._truth[0])[-1]
        self._stamps, self._late, self._rounding = self._t, np.zeros(len(self._t)), np.zeros_like(self._angles)
        if encoder is not None:
            numbers = due(float(self._t[-1] - self._t[0]), encoder.sample_rate)
            self._stamps = self._t[0] + numbers * encoder.interval
            phase, jitter = rng.random(2), rng.uniform(-encoder.jitter, encoder.jitter, len(numbers))
            self._late = encoder.latency - jitter
            read = self._at(self._stamps - self._late + clock_offset)
            self._rounding = encoder.tick_angle * np.floor(read / encoder.tick_angle + phase) - read
        self._factors = {
            SCALE: believed.mean_radius / self._true.mean_radius,
            RATIO: believed.radius_ratio / self._true.radius_ratio,
            TRACK: believed.track_width / self._true.track_width,
        }
        there = {
            SLIP: True,
            SAMPLING: encoder is not None or method != "arc",
            TICKS: encoder is not None,
            LATENCY: encoder is not None and (encoder.latency or encoder.jitter),
            # Factors are one up to rounding where nothing is wrong.
            **{name: abs(factor - 1) > 1e-12 for name, factor in self._factors.items()},
            GAIN: believed.turning_gain,
            START: start_error.any(),
            CLOCK: clock_offset,
        }
        self.causes = tuple(cause for cause, is_there in there.items() if is_there)
        self._relative = functools.lru_cache(maxsize=None)(self._relative_end)

    def error(self, on: frozenset[str]) -> Array:
        """The final error (3,) with some causes on."""
        first = self._start if START in on else self._truth[0]
        last = self._truth[-1] if SLIP in on else self._ideal_end
        return se2.compose(first, self._relative(on - {START, SLIP})) - last

    def _relative_end(self, on: frozenset[str]) -> Array:
        """Where odometry ends, in the frame of where it starts."""
        method = self._method if SAMPLING in on else "arc"
        return integrate(self._readings(on), self._robot(on), method)[-1]

    def _readings(self, on: frozenset[str]) -> Array:
        """The wheel angles (S, 2) that odometry reads: what was wrong with each reading is there or not."""
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

    def _robot(self, on: frozenset[str]) -> Robot:
        """The true robot with some parameters as believed."""
        scale, ratio, track = (factor if name in on else 1.0 for name, factor in self._factors.items())
        gain = (self._believed if GAIN in on else self._true).turning_gain
        return misjudged(self._true, scale=scale, ratio=ratio, track=track).replace(turning_gain=gain)
