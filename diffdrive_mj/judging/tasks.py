"""What an odometry is given to solve: readings of the wheels, the robot's numbers, and where the robot starts."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj.drive import Drive
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.judging.readings import Mask, counting, held
from diffdrive_mj.odometry import integrate
from diffdrive_mj.robot import Robot
from diffdrive_mj.sensors._sampling import poses_between

# Times that are equal up to rounding [s].
_SLACK = 1e-9
# What arithmetic may be off by, per metre that a wheel rolls [m], and at least [m].
ARITHMETIC, LEAST = 1e-9, 1e-12
Unit = Literal["rad", "ticks"]


@dataclass(frozen=True, eq=False)
class Task:
    """Describe one drive as an odometry sees it.

    Args:
        name: of the drive.
        robot: whose radii, track width and encoder the odometry is told.
        t: times of the readings (T,) [s].
        wheel_angles: (T, 2) [rad], left then right, absolute.
        start: (3,) [m, m, rad], the pose at the first reading.
        truth: (T, 3) [m, m, rad], where the robot really was; None if nobody knows.

    Raises:
        InvalidValue: shapes that do not fit, or values that are not finite.
        InvalidType: not numbers, not a robot.

    Example:
        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> task = Task("ahead", robot, [0.0, 1.0], [(0, 0), (10, 10)], start=(2.0, 0.0, 0.0))
        >>> task.expected[-1].tolist()
        [3.0, 0.0, 0.0]
    """

    name: str
    robot: Robot
    t: Array
    wheel_angles: Array
    start: Array = (0.0, 0.0, 0.0)  # type: ignore[assignment]
    truth: Array | None = None

    def __post_init__(self) -> None:
        checks.string("Task.name", self.name)
        checks.instance("robot", self.robot, Robot)
        t = checks.array("t", self.t, "T")
        own = {"t": t, "wheel_angles": checks.array("wheel_angles", self.wheel_angles, len(t), 2)}
        own["start"] = checks.vector("start", self.start, 3)
        if self.truth is not None:
            own["truth"] = checks.array("truth", self.truth, len(t), 3)
        for name, value in own.items():
            object.__setattr__(self, name, value)

    @classmethod
    def of(cls, drive: Drive, robot: Robot) -> Task:
        """Take the readings of a drive that lie within the times of its true poses, which are interpolated there.

        Args:
            drive: simulated or real.
            robot: as the odometry shall believe it to be.

        Raises:
            InvalidValue: fewer than two such readings.
        """
        checks.instance("drive", drive, Drive)
        kept = (drive.t >= drive.clock[0] - _SLACK) & (drive.t <= drive.clock[-1] + _SLACK)
        if np.count_nonzero(kept) < 2:
            raise InvalidValue(f"{drive.name}: fewer than two readings within the times of the true poses")
        t = drive.t[kept]
        truth = poses_between(drive.clock, drive.truth, np.clip(t, drive.clock[0], drive.clock[-1]))
        return cls(drive.name, robot, t, drive.wheel_angles[kept], truth[0], truth)

    @property
    def raw(self) -> Array:
        """What is read (T, 2), in units of `unit_angle`; counters of `bits` wrap."""
        return self.wheel_angles

    @property
    def unit_angle(self) -> float:
        """The unit of what is read [rad]."""
        return 1.0

    @property
    def bits(self) -> int | None:
        """Of counters that wrap; None where none does."""
        return None

    @property
    def radii(self) -> tuple[float, float]:
        """The robot's, left and right [m]."""
        return self.robot.left_radius, self.robot.right_radius

    @functools.cached_property
    def counting(self) -> Mask:
        """Which readings count (T,): the law of `judging.readings`."""
        return counting(self.t, self.wheel_angles)

    def odometry(self, robot: Robot) -> Array:
        """The poses (T, 3) by the package's arc odometry with a robot's numbers; held where no reading counts."""
        return held(integrate(self.wheel_angles[self.counting], robot, start=self.start), self.counting)

    @property
    def expected(self) -> Array:
        """The poses (T, 3) of exact arc odometry."""
        return self.odometry(self.robot)

    @property
    def allowed(self) -> float:
        """How far arithmetic may be off the expected poses [m]."""
        return max(ARITHMETIC * self.rolled, LEAST * (1 + float(np.abs(self.start).max())))

    @property
    def rolled(self) -> float:
        """How far the wheels roll, in the mean of both [m]."""
        rims = np.abs(np.diff(self.wheel_angles[self.counting], axis=0))
        return float((rims * self.radii).sum() / 2)

    @property
    def ticks_per_revolution(self) -> float:
        """Ticks for a turn of a wheel, its gear included."""
        return self.robot.encoder.ticks_per_wheel_turn

    def told(self, unit: Unit) -> dict[str, str | float]:
        """What an odometry is told before the readings: their unit, the robot's numbers, and where it starts."""
        checks.member("unit", unit, get_args(Unit))
        x, y, theta = self.start.tolist()
        return {
            "unit": unit,
            "left_radius": self.robot.left_radius, "right_radius": self.robot.right_radius,
            "track_width": self.robot.track_width, "ticks_per_revolution": self.ticks_per_revolution,
            "x": x, "y": y, "theta": theta,
        }  # fmt: skip

    def read(self, unit: Unit) -> list[list[float]]:
        """The readings (T, 2) as a program gets them: radians, or whole ticks as integers."""
        wheels: NDArray[Any] = self.wheel_angles if unit == "rad" else self.counts
        return wheels.tolist()

    def header(self, unit: Unit) -> str:
        """The line that tells a program the robot's numbers, and where it starts."""
        return "# diffdrive 1 " + " ".join(f"{name}={value}" for name, value in self.told(unit).items())

    def lines(self, unit: Unit) -> Iterator[str]:
        """The header, then `t,left,right` for each reading."""
        yield self.header(unit)
        for t, (left, right) in zip(self.t.tolist(), self.read(unit), strict=True):
            yield f"{written(t)},{written(left)},{written(right)}"

    @property
    def counts(self) -> NDArray[np.int64]:
        """The wheel angles in ticks (T, 2)."""
        counts = self.wheel_angles * (self.ticks_per_revolution / (2 * math.pi))
        return np.round(counts).astype(np.int64)

    def in_ticks(self) -> Task:
        """The same drive with wheel angles that are whole ticks, as a program that counts reads them."""
        angles = self.counts.astype(np.float64) * (2 * math.pi / self.ticks_per_revolution)
        return Task(self.name, self.robot, self.t, angles, self.start, self.truth)

    def as_read(self, unit: Unit) -> Task:
        """The task as one is judged who reads it in a unit."""
        return self.in_ticks() if unit == "ticks" else self


def written(number: float) -> str:
    """A number with all its digits, as every language's own parser reads it.

    Example:
        >>> [written(number) for number in (0.1, 7, float("nan"))]
        ['0.1', '7', 'NaN']
    """
    return "NaN" if math.isnan(number) else repr(number)
