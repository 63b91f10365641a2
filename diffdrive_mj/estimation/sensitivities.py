"""What small errors of a robot cost its odometry at the end of a few drives, from the robot's numbers alone.

The drives are made of arcs at constant speed, without ramps. A wrong belief takes an arc for another arc
(`kinematics.belief_matrix`), so that the pose at the end is exact, however large the error, and needs no physics.
"""

from __future__ import annotations

import functools
import html
import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from diffdrive_mj import _checks as checks
from diffdrive_mj import se2
from diffdrive_mj._checks import Array
from diffdrive_mj._text import html_table, one_line, table
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.kinematics import body_twist, wheel_rates
from diffdrive_mj.odometry import METHODS, Method, integrate
from diffdrive_mj.robot import Robot
from diffdrive_mj.tolerances import LARGEST, Tolerances

DISTANCE, SIDE, TURNS, RADIUS = 10.0, 4.0, 3.0, 1.8


@dataclass(frozen=True, eq=False)
class ErrorBudget:
    """Holds what each cause costs at the end of each drive, the worst cause first, and prints as a table.

    The worst cause is the one with the largest position error on any of the drives.

    Attributes:
        robot: its name.
        drives: what is driven, by the short name of each of the D drives.
        causes: (C,) what is wrong with the odometry.
        position_error: (C, D) [m].
        heading_error: estimate minus truth (C, D) [rad], not wrapped.

    Example:
        >>> budget = dd.estimation.sensitivities.error_budget(dd.Robot.load("turtlebot3_burger"))
        >>> budget.worst
        (0, 0)
        >>> print(str(budget).splitlines()[-1])
        The worst is radius ratio, 1 %: it puts the end of the straight 3076 mm and 35.6 degrees off.
    """

    robot: str
    drives: Mapping[str, str]
    causes: tuple[str, ...]
    position_error: Array
    heading_error: Array

    @property
    def worst(self) -> tuple[int, int]:
        """The indices of the cause and of the drive with the largest position error."""
        cause, drive = np.unravel_index(np.argmax(self.position_error), self.position_error.shape)
        return int(cause), int(drive)

    def __str__(self) -> str:
        drives = (f"{name}: {what}" for name, what in self.drives.items())
        return "\n".join([self._title(), "", table(self._header(), self._rows()), "", *drives, "", self._finding()])

    def _repr_html_(self) -> str:
        drives = html_table(self.drives.items())
        return "\n".join(
            [html_table(self._rows(), self._header(), self._title()), drives, f"<p>{html.escape(self._finding())}</p>"]
        )

    def _title(self) -> str:
        return f"{self.robot}: how far odometry is off at the end of a drive"

    def _header(self) -> list[str]:
        return ["what is off", *(column for name in self.drives for column in (f"{name} [mm]", "[deg]"))]

    def _rows(self) -> list[list[object]]:
        errors = np.stack([1e3 * self.position_error, np.degrees(self.heading_error)], axis=-1)
        # Rounding errors of what is zero are not shown.
        shown = np.round(errors, 6).reshape(len(self.causes), -1) + 0.0
        return [[cause, *row] for cause, row in zip(self.causes, shown, strict=True)]

    def _finding(self) -> str:
        position, heading = self.position_error[self.worst], self.heading_error[self.worst]
        cause, drive = self.causes[self.worst[0]], list(self.drives)[self.worst[1]]
        return (
            f"The worst is {cause}: it puts the end of the {drive} {1e3 * position:.4g} mm and "
            f"{abs(np.degrees(heading)):.3g} degrees off."
        )


def error_budget(
    robot: Robot,
    *,
    tolerance: float | None = None,
    rate: float = 10.0,
    latency: float = 0.01,
    speed: float = 0.5,
    yaw_rate: float = 1.0,
) -> ErrorBudget:
    """Compute what small errors cost at the end of a straight line, a square, a spin and an arc.

    Each cause stands alone:

    - Odometry believes both wheel radii, the radius ratio (the mean radius kept) or the track width to be larger.
    - The larger wheel counts one encoder tick too many at the start.
    - The wheels are read at a rate, from the start on, and a method of odometry takes the motion between two readings
      for a line or an arc. (An arc is exact where the wheels turn evenly, a line where the robot does not turn.)
    - Latency makes the pose old: the robot passes the end at full speed, and odometry says where it was.

    Args:
        robot: the true one; its radii, track width, turning gain, encoder and tolerances are read.
        tolerance: by what part each parameter is believed to be larger; the robot's own tolerances if not given.
        rate: of the odometry [Hz].
        latency: [s].
        speed: along lines and arcs [m/s].
        yaw_rate: of turns on the spot [rad/s].

    Returns:
        The errors, the worst cause first.

    Raises:
        InvalidType: not a robot, not numbers.
        InvalidValue: a value out of its range, or more samples than fit in memory.

    Example:
        On a straight line 1 % of both radii is 1 % of the distance:

        >>> budget = dd.estimation.sensitivities.error_budget(dd.Robot.load("matched"))
        >>> budget.position_error[budget.causes.index("wheel radii, 1 %"), 0].round(9).item()
        0.1
    """
    checks.instance("robot", robot, Robot)
    known = within(robot, tolerance)
    rate, age = checks.positive("rate", rate), checks.not_negative("latency", latency)
    drives = _drives(checks.positive("speed", speed), checks.positive("yaw_rate", yaw_rate))
    wrong = {
        f"wheel radii, {100 * known.radius:g} %": {"scale": 1 + known.radius},
        f"radius ratio, {100 * known.radius_ratio:g} %": {"ratio": 1 + known.radius_ratio},
        f"track width, {100 * known.track_width:g} %": {"track": 1 + known.track_width},
    }
    estimates = {
        **{name: functools.partial(_believed, robot, misjudged(robot, **factor)) for name, factor in wrong.items()},
        "one encoder tick": functools.partial(_with_a_tick, robot),
        **{f"{rate:g} Hz, {method}": functools.partial(_sampled, robot, rate, method) for method in METHODS},
        f"latency, {1e3 * age:g} ms": functools.partial(_late, age),
    }
    errors = np.array([[estimate(path) - _end(path) for _, path in drives.values()] for estimate in estimates.values()])
    position, heading = np.hypot(errors[..., 0], errors[..., 1]), errors[..., 2]
    worst_first = np.lexsort((-np.abs(heading).max(axis=1), -position.max(axis=1)))  # the last key counts first
    return ErrorBudget(
        one_line(robot.name),
        {name: what for name, (what, _) in drives.items()},
        tuple(list(estimates)[k] for k in worst_first),
        position[worst_first],
        heading[worst_first],
    )


def _drives(speed: float, yaw_rate: float) -> dict[str, tuple[str, Array]]:
    """Each drive in words, and its segments (S, 3): distance [m], turn [rad], duration [s]."""
    straight, side = (DISTANCE, 0.0, DISTANCE / speed), (SIDE, 0.0, SIDE / speed)
    quarter, spin = ((0.0, turn, turn / yaw_rate) for turn in (math.pi / 2, 2 * math.pi * TURNS))
    arc = (DISTANCE, DISTANCE / RADIUS, DISTANCE / speed)
    along, on_the_spot = f"at {speed:g} m/s", f"on the spot at {yaw_rate:g} rad/s"
    return {
        "straight": (f"{DISTANCE:g} m ahead {along}", np.array([straight])),
        "square": (f"sides of {SIDE:g} m {along}, quarter turns {on_the_spot}", np.array([side, quarter] * 4)),
        "spin": (f"{TURNS:g} turns {on_the_spot}", np.array([spin])),
        "arc": (f"{DISTANCE:g} m along a circle of {RADIUS:g} m radius {along}", np.array([arc])),
    }


def _end(motion: Array) -> Array:
    """Where segments (S, 2 or more) of distance and turn end: the composition of exact arcs (3,)."""
    arcs = np.zeros((len(motion), 3))
    arcs[:, 0], arcs[:, 2] = motion[:, 0], motion[:, 1]
    return functools.reduce(se2.compose, se2.exp(arcs), np.zeros(3))


def within(robot: Robot, tolerance: float | None = None) -> Tolerances:
    """Return by what parts a robot's odometry may take its numbers to be too large.

    Args:
        robot: whose own tolerances count.
        tolerance: for each of its numbers, in their place.

    Returns:
        The tolerances.

    Raises:
        InvalidValue: a tolerance that is not positive, or above a half.
        InvalidType: not a robot, not a number.

    Example:
        >>> within(dd.Robot.load("matched"), 0.002).track_width
        0.002
    """
    checks.instance("robot", robot, Robot)
    if tolerance is None:
        return robot.tolerances
    part = checks.positive("tolerance", tolerance)
    if part > LARGEST:
        raise InvalidValue(f"tolerance = {part:g}: must be at most {LARGEST:g}")
    return Tolerances(radius=part, radius_ratio=part, track_width=part)


def misjudged(robot: Robot, *, scale: float = 1.0, ratio: float = 1.0, track: float = 1.0) -> Robot:
    """Make the robot that an odometry believes in when it is wrong by some factors.

    Args:
        robot: the true one; its radii, track width and turning gain are read.
        scale: of the mean radius.
        ratio: of the radius ratio, the mean radius kept.
        track: of the track width.

    Returns:
        The believed robot.

    Raises:
        InvalidValue: factors that are not positive, or too large.
        InvalidType: not a robot, not numbers.

    Example:
        >>> believed = misjudged(dd.Robot.load("matched"), ratio=1.01)
        >>> round(believed.radius_ratio, 9), round(believed.mean_radius, 9)
        (1.01, 0.1)
    """
    checks.instance("robot", robot, Robot)
    factors = {"scale": scale, "ratio": ratio, "track": track}
    scale, ratio, track = (checks.positive(name, value) for name, value in factors.items())
    mean, believed_ratio = scale * robot.mean_radius, ratio * robot.radius_ratio
    left = 2 * mean / (1 + believed_ratio)
    return Robot(
        left_radius=left,
        right_radius=believed_ratio * left,
        track_width=track * robot.track_width,
        turning_gain=robot.turning_gain,
    )


def _believed(robot: Robot, belief: Robot, path: Array) -> Array:
    return _end(body_twist(wheel_rates(path[:, :2], robot), belief))


def _with_a_tick(robot: Robot, path: Array) -> Array:
    tick = 2 * math.pi / robot.encoder.ticks_per_wheel_turn
    larger_wheel = (0.0, tick) if robot.radius_ratio >= 1 else (tick, 0.0)
    return se2.compose(_end(body_twist([larger_wheel], robot)), _end(path))


def _sampled(robot: Robot, rate: float, method: Method, path: Array) -> Array:
    clock = np.concatenate([[0.0], np.cumsum(path[:, 2])])
    angles = np.vstack([(0.0, 0.0), np.cumsum(wheel_rates(path[:, :2], robot), axis=0)])
    count = max(1, checks.samples("the duration of a drive", float(clock[-1]), 1 / rate))
    times = np.append(np.arange(count) / rate, clock[-1])
    return integrate(np.stack([np.interp(times, clock, wheel) for wheel in angles.T], axis=-1), robot, method)[-1]


def _late(age: float, path: Array) -> Array:
    """The pose some time before the end."""
    duration = path[:, 2]
    begin = np.cumsum(duration) - duration
    driven = np.clip(duration.sum() - age - begin, 0.0, duration)
    return _end((driven / duration)[:, None] * path)
