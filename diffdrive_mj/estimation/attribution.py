"""Whose fault a drift is: one drive replayed with its causes switched on and off, and the final error split among them.

The parts are Shapley values (`shapley`): they add up to the error. The slip that the physics reads at the contacts
stands beside the part of it that the replays find, and comes by another way (`sliding`).
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj import _checks as checks
from diffdrive_mj import metrics
from diffdrive_mj._checks import Array
from diffdrive_mj._text import html_table, quantity, table
from diffdrive_mj.drive import Drive
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.estimation import shapley, sliding
from diffdrive_mj.estimation._replays import (
    CLOCK,
    GAIN,
    LATENCY,
    METHOD,
    RATIO,
    REST,
    SAMPLING,
    SCALE,
    SLIP,
    START,
    TICKS,
    TRACK,
    LoggedReplay,
    Replay,
    SimulatedReplay,
)
from diffdrive_mj.odometry import Method, Step, checked_method
from diffdrive_mj.recording import Recording
from diffdrive_mj.robot import Robot
from diffdrive_mj.sensors import Encoder

# With the names of the causes.
__all__ = [
    "CLOCK",
    "GAIN",
    "LATENCY",
    "METHOD",
    "RATIO",
    "REST",
    "SAMPLING",
    "SCALE",
    "SLIP",
    "START",
    "TICKS",
    "TRACK",
    "Attribution",
    "attribute",
]

_BAR = 20  # length of the longest bar [characters]
_ON_THE_SPOT = 0.01  # how far a robot that turns on the spot gets from its start [m]


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
        distance: driven [m], of a measured drive by its wheels.
        slip: (3,), the error that the slip at the contacts makes, read in the physics and not from the odometry; None
            where it was not recorded (`simulate(..., slip=True)`).
        truth: (T, 3), the true poses along the drive, of which the last is where the error is.
        turned: by how much it turned in all, left and right [rad].
        on_the_spot: whether it never left the place where it started, so that headings count and not positions.
        warnings: what to know before relying on it: falls, slip, gaps in a log.

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
    slip: Array | None = None
    truth: Array | None = None
    turned: float = 0.0
    on_the_spot: bool = False
    warnings: tuple[str, ...] = ()

    @property
    def sizes(self) -> Array:
        """How large each part is (C,): its position [m], or its heading [rad] of a robot that turned on the spot."""
        return _sizes(self.parts, self.on_the_spot)

    @property
    def sizes_alone(self) -> Array:
        """How large the error of each cause alone is (C,), as `sizes`."""
        return _sizes(self.alone, self.on_the_spot)

    def as_dict(self) -> dict[str, Any]:
        """The figures for programs, in metres and radians."""
        keys = ("x_m", "y_m", "heading_rad")
        rows = zip(self.causes, self.parts.tolist(), self.alone.tolist(), self.spread.tolist(), strict=True)
        return {
            "drive": self.name,
            "distance_m": self.distance,
            "error": dict(zip(keys, self.error.tolist(), strict=True)),
            "slip": None if self.slip is None else dict(zip(keys, self.slip.tolist(), strict=True)),
            "causes": [
                {
                    "cause": cause,
                    "part": dict(zip(keys, part, strict=True)),
                    "alone": dict(zip(keys, alone, strict=True)),
                    "spread": {"position_m": spread[0], "heading_rad": spread[1]},
                }
                for cause, part, alone, spread in rows
            ],
            "warnings": list(self.warnings),
        }

    def __str__(self) -> str:
        lines = table(self._header(), self._rows()).splitlines()
        longest = max(float(self.sizes.max()), 1e-12)
        bars = ["", "", *("#" * round(_BAR * size / longest) for size in self.sizes.tolist())]
        bars += [""] * (len(lines) - len(bars))
        width = max(map(len, lines))
        drawn = (f"{line:<{width}}  {bar}".rstrip() for line, bar in zip(lines, bars, strict=True))
        return "\n".join([self.title, "", *drawn, *(f"warning: {warning}" for warning in self.warnings)])

    def _repr_html_(self) -> str:
        said = [["warning", warning, *[""] * 4] for warning in self.warnings]
        return html_table([*self._rows(), *said], self._header(), self.title)

    @property
    def title(self) -> str:
        """What was found, in a line."""
        position, heading = float(np.hypot(*self.error[:2])), abs(round(float(np.degrees(self.error[2])), 6))
        off = f"{quantity(position, 'm')} and {heading:.3g} degrees"
        worst = f"; largest part: {self.causes[0]}" if len(self.causes) > 1 else ""
        way = f"{self.distance:.4g} m"
        if self.on_the_spot:
            way = f"{round(np.degrees(self.turned), 6):.4g} degrees on the spot"
        return f"{self.name}: {off} off after {way}{worst}"

    def _header(self) -> list[str]:
        unit = "[deg]" if self.on_the_spot else "[mm]"
        return ["cause", "x [mm]", "y [mm]", "heading [deg]", f"alone {unit}", f"+- {unit}"]

    def _rows(self) -> list[list[Any]]:
        """A row a cause, then the sum, and the slip at the contacts, where it was recorded."""
        below = {"all": self.error, "slip at the contacts": self.slip}
        rows = [(name, error) for name, error in below.items() if error is not None]
        names = [*self.causes, *(name for name, _ in rows)]
        errors = np.vstack([self.parts, *(error for _, error in rows)])
        lengths, angles = 1e3 * errors[:, :2], np.degrees(errors[:, 2:])
        apart, scale, like = self.spread[:, 0], 1e3, lengths
        if self.on_the_spot:
            apart, scale, like = self.spread[:, 1], 180 / math.pi, angles
        beside = _rounded(scale * np.column_stack([self.sizes_alone, apart]), like).tolist()
        numbers = np.hstack([_rounded(lengths, lengths), _rounded(angles, angles)]).tolist()
        return [
            [name, *found, *more]
            for name, found, more in zip(names, numbers, [*beside, *[["", ""]] * len(rows)], strict=True)
        ]


def _sizes(errors: Array, on_the_spot: bool) -> Array:
    return np.abs(errors[:, 2]) if on_the_spot else np.hypot(errors[:, 0], errors[:, 1])


def _rounded(values: Array, like: Array) -> Array:
    """Values without what is below a ten-millionth of the largest, or no more than rounding."""
    largest = float(np.abs(like).max())
    decimals = min(7 - math.ceil(math.log10(largest)), 9) if largest > 0 else 0
    return np.round(values, decimals) + 0.0


def attribute(
    drive: Recording[Robot, Any] | Drive,
    believed: Robot,
    *,
    true: Robot | None = None,
    method: Method | Step = "arc",
    encoder: Encoder | None = None,
    start_error: ArrayLike = (0.0, 0.0, 0.0),
    clock_offset: float = 0.0,
    seed: int = 0,
) -> Attribution:
    """Split the final error of odometry on a drive among its causes.

    Of a simulated drive, a recording, the causes are what the contacts did, how the wheels were read (rate and method,
    ticks, latency), what the odometry takes the robot for (mean radius, radius ratio, track width), where it started,
    and its clock. Switched off, a cause is ideal: the wheels roll, every recorded sample is read exactly, at once and
    taken for an arc, the robot is the true one, its first pose the true one. Causes that are not there are left out.

    Of a measured drive, a log, nobody has the true robot or ideal readings. A reference robot stands for the true one,
    and "contact, slip and the rest" is what odometry with it is off: slip, the floor, the encoder's ticks and rate, the
    noise of the first and the last true pose (a first heading that is off by a degree is 17 mm a metre), and what the
    reference is wrong by. Take a reference that was calibrated on other drives: one that was fitted to this drive has
    taken a share of its slip into its radii and track.

    Args:
        drive: a recording of one run, in which more samples than the encoder's make "sampling" what it says; or a drive
            as it was measured.
        believed: the robot that the odometry computes with.
        true: of a measured drive, the reference, such as `Calibration.calibrated`; a recording has its own.
        method: of the odometry.
        encoder: how the wheels of a recording are read; None for the recorded samples.
        start_error: (3,) [m, m, rad], the pose at which the odometry starts, in the frame of the first true one.
        clock_offset: by how much the readings are younger than their stamps say [s]; of a measured drive, by how much
            they are known to be, and only true poses that lie within the encoder's times either way are looked at.
        seed: of the counters' phases and of the jitter.

    Returns:
        The parts, the largest first.

    Raises:
        InvalidType: not a recording or a drive, a robot, an encoder, numbers.
        InvalidValue: a recording of many runs; a measured drive without a reference, or with an encoder, since it has
            been read; a recording with one; an encoder that is wired wrongly or reads too seldom; values out of range.

    Example:
        >>> true = dd.Robot.load("mismatched")
        >>> recording = dd.simulate(true, dd.maneuvers.square(true, side=1.0, speed=0.5))
        >>> found = attribute(recording, true.replace(track_width=0.402), encoder=dd.Encoder(true, sample_rate=20.0))
        >>> found.causes[0]
        'track width'
        >>> np.allclose(found.parts.sum(axis=0), found.error, rtol=0, atol=1e-12)
        True
    """
    checks.instance("drive", drive, Recording, Drive)
    checks.instance("believed", believed, Robot)
    start, offset = checks.vector("start_error", start_error, 3), checks.number("clock_offset", clock_offset)
    seed = checks.whole("seed", seed, least=0)
    checked_method(method)
    if encoder is not None:
        checks.instance("encoder", encoder, Encoder)
    replay: Replay
    slip = None
    if isinstance(drive, Drive):
        if true is None:
            raise InvalidValue(
                f"true = None: {drive.name} was measured, so that a reference robot must stand for the true one"
            )
        if encoder is not None:
            raise InvalidValue(f"encoder: {drive.name} was measured, with an encoder of its own; leave it out")
        replay = LoggedReplay(drive, checks.instance("true", true, Robot), believed, method, start, offset)
        name, said = drive.name, drive.warnings
    else:
        if true is not None:
            raise InvalidValue("true: a recording has the true robot; leave it out")
        if isinstance(drive.robot, tuple):
            raise InvalidValue("drive has many runs: must be one, such as recording.runs[0]")
        replay = SimulatedReplay(drive, believed, method, encoder, start, offset, np.random.default_rng(seed))
        name, said = drive.robot.name, drive.events
        if drive.slip is not None:
            slip = replay.ideal_end - sliding.path(drive)[-1]
    causes = replay.causes
    switched = list(itertools.product((False, True), repeat=len(causes)))
    ends = [replay.error(frozenset(itertools.compress(causes, on))) for on in switched]
    outcomes = np.reshape(ends, (*(2 for _ in causes), 3))
    steps, parts = shapley.added(outcomes), shapley.parts(outcomes)
    apart = steps - parts[:, None]
    spread = np.stack([np.hypot(apart[..., 0], apart[..., 1]).max(axis=1), np.abs(apart[..., 2]).max(axis=1)], axis=-1)
    driven = replay.driven
    on_the_spot = bool(np.hypot(*(driven - driven[0])[:, :2].T).max() < _ON_THE_SPOT)
    order = np.argsort(-_sizes(parts, on_the_spot), kind="stable")
    return Attribution(
        name,
        tuple(causes[k] for k in order),
        parts[order],
        steps[order, 0],
        spread[order],
        np.asarray(ends[-1]) - ends[0],
        float(metrics.travelled(driven)[-1]),
        slip,
        replay.truth,
        float(np.abs(np.diff(driven[:, 2])).sum()),
        on_the_spot,
        said,
    )
