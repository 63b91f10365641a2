"""A case of the conformance suite: readings as a robot has them, the exact poses, and how far one may be off them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj.judging.exact import exact_poses
from diffdrive_mj.judging.readings import counting, held, unwrapped
from diffdrive_mj.judging.tasks import Task, Unit, written
from diffdrive_mj.robot import Robot

# Of a float64, half of the distance to the next one, relative.
_EPSILON = 2.0**-53
# Tolerances are the largest rounding that can add up, times this.
MARGIN = 2.0
COLUMNS = "t,left,right,x,y,theta"


@dataclass(frozen=True, eq=False, kw_only=True)
class Case(Task):
    """Describe a drive whose poses are known exactly: a task with readings in a unit of its own.

    Args:
        name: of the case, and of its file.
        robot: whose numbers the odometry is told.
        t: times of the readings (T,) [s]; they may stand still, run back or be NaN.
        wheel_angles: (T, 2) [rad], left then right, as Python candidates without a header get them; counters are
            unwrapped and begin at zero.
        start: (3,) [m, m, rad], the pose at the first reading that counts.
        truth: None.
        about: what the case is to show, in words.
        readings: (T, 2) as read: radians, or ticks that may wrap; NaN where nothing was read.
        unit: of the readings.
        counter_bits: of counters that wrap; None where none does.
        poses: (T, 3) [m, m, rad], the exact ones.
        tolerance: how far an answer may be off them [m]; a heading counts as the way of a wheel.

    Raises:
        InvalidValue: shapes that do not fit, or no reading that counts.
        InvalidType: not numbers, not a robot.

    Example:
        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> case = exact_case("ahead", "A step ahead.", robot, [0.0, 1.0], [(0.0, 0.0), (10.0, 10.0)], (2.0, 0.0, 0.0))
        >>> for line in case.rows():
        ...     print(line)
        # diffdrive 1 unit=rad left_radius=0.1 right_radius=0.1 track_width=0.4 ... x=2.0 y=0.0 theta=0.0 tolerance=...
        t,left,right,x,y,theta
        0.0,0.0,0.0,2.0,0.0,0.0
        1.0,10.0,10.0,3.0,0.0,0.0
    """

    about: str
    readings: Array
    unit: Unit
    counter_bits: int | None
    poses: Array
    tolerance: float

    def __post_init__(self) -> None:
        checks.string("Case.name", self.name)
        checks.instance("robot", self.robot, Robot)
        for name in ("t", "readings", "wheel_angles", "start", "poses"):
            object.__setattr__(self, name, np.asarray(getattr(self, name), dtype=np.float64))
        checks.array("poses", self.poses, len(self.t), 3)
        checks.vector("start", self.start, 3)
        checks.positive("tolerance", self.tolerance)
        counting(self.t, self.readings)

    @property
    def expected(self) -> Array:
        """The exact poses (T, 3)."""
        return self.poses

    @property
    def allowed(self) -> float:
        """The tolerance [m]."""
        return self.tolerance

    @property
    def raw(self) -> Array:
        """The readings (T, 2)."""
        return self.readings

    @property
    def unit_angle(self) -> float:
        """A radian or a tick [rad]."""
        return 2 * math.pi / self.ticks_per_revolution if self.unit == "ticks" else 1.0

    @property
    def bits(self) -> int | None:
        """Of counters that wrap; None where none does."""
        return self.counter_bits

    def as_read(self, unit: Unit) -> Case:
        """The case itself: its readings have a unit of their own."""
        return self

    def told(self, unit: Unit = "rad") -> dict[str, str | float]:
        """What an odometry is told before the readings: also the bits of counters that wrap, and the tolerance."""
        wraps = {} if self.counter_bits is None else {"counter_bits": self.counter_bits}
        return {**super().told(self.unit), **wraps, "tolerance": self.tolerance}

    def read(self, unit: Unit = "rad") -> list[list[float]]:
        """The readings (T, 2) as they are; ticks as integers."""
        return (self.readings if self.unit == "rad" else self.readings.astype(np.int64)).tolist()

    def rows(self) -> Iterator[str]:
        """The lines of the case's file: the header, the names of the columns, and the readings with their poses."""
        yield self.header(self.unit)
        yield COLUMNS
        for t, wheels, pose in zip(self.t.tolist(), self.read(), self.poses.tolist(), strict=True):
            yield ",".join(map(written, (t, *wheels, *pose)))


def exact_case(
    name: str, about: str, robot: Robot, t: ArrayLike, readings: ArrayLike, start: ArrayLike, *, unit: Unit = "rad",
    counter_bits: int | None = None, poses: ArrayLike | None = None, tolerance: float | None = None,
) -> Case:  # fmt: skip
    """Compute what a case expects: the poses in 50-digit arithmetic, and the tolerance by what rounding can do.

    Args:
        name: of the case.
        about: what it is to show.
        robot: whose numbers the odometry is told.
        t: times of the readings (T,) [s].
        readings: (T, 2) in the unit.
        start: (3,) [m, m, rad].
        unit: "rad" or "ticks".
        counter_bits: of counters that wrap.
        poses: the exact ones, if they are known already.
        tolerance: if it is known already [m].

    Raises:
        InvalidValue: shapes that do not fit, or no reading that counts.

    Example:
        A counter of 16 bits that wraps as a wheel goes on, a quarter of a turn:

        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> ticks = [(32767, 32767), (-31745, -31745)]
        >>> case = exact_case("wrap", "A wrap.", robot, [0, 1], ticks, (0, 0, 0), unit="ticks", counter_bits=16)
        >>> case.poses[1].tolist()
        [0.15707963267948968, 0.0, 0.0]
    """
    start, counts = checks.vector("start", start, 3), counting(t, readings)
    read, ticks = np.asarray(readings, dtype=np.float64), unit == "ticks"
    if poses is None:
        poses = held(exact_poses(read[counts], robot, start.tolist(), in_ticks=ticks, bits=counter_bits), counts)
    tick = 2 * math.pi / robot.encoder.ticks_per_wheel_turn if ticks else 1.0
    angles = unwrapped(read, counts, counter_bits) * tick if ticks else read
    if tolerance is None:
        tolerance = _tolerance(angles[counts], float(np.abs(tick * read[counts]).max()), np.asarray(poses), robot)
    return Case(
        name=name, about=about, robot=robot, t=np.asarray(t), wheel_angles=angles, start=start, readings=read,
        unit=unit, counter_bits=counter_bits, poses=np.asarray(poses), tolerance=tolerance,
    )  # fmt: skip


def _tolerance(angles: Array, largest: float, poses: Array, robot: Robot) -> float:
    """What a right arc in double precision cannot exceed, with a margin, to two digits [m].

    Each of the steps rounds the coordinates and the heading once, and its own distance and turn a few times; whoever
    turns readings into metres before taking differences rounds the whole way at the rim; and formulas with 1 / turn
    lose, around a threshold that is chosen well, half of the turn of a step or the rounding of one over it.
    """
    left, right = (np.diff(angles, axis=0) * (robot.left_radius, robot.right_radius)).T
    step, turn = np.abs(left + right) / 2, np.abs(right - left) / robot.track_width
    driven, steps = float(np.maximum(np.abs(left), np.abs(right)).sum()), len(turn)
    rim = largest * max(robot.left_radius, robot.right_radius)
    heading = max(float(np.abs(poses[:, 2]).max()), 2 * math.pi)
    coordinate = float(np.abs(poses[:, :2]).max())
    off_heading = _EPSILON * (steps * heading + 4 * rim / robot.track_width + 8 * float(turn.sum()))
    with np.errstate(divide="ignore"):
        off_arcs = float((step * np.minimum(turn / 2, 2 * _EPSILON / turn)).sum())
    off = _EPSILON * (steps * coordinate + 4 * rim + 8 * driven) + off_heading * (driven + robot.track_width / 2)
    return _rounded_up(MARGIN * (off + off_arcs))


def _rounded_up(value: float) -> float:
    """A number to two digits, not below it."""
    power = 10.0 ** (math.floor(math.log10(value)) - 1)
    return float(f"{math.ceil(value / power) * power:.1e}")
