"""What the physics saw of a drive: ideal wheel angles beside the true pose."""

from __future__ import annotations

import typing
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any, Generic, cast

import numpy as np
from numpy.typing import NDArray

from diffdrive_mj import _checks as checks
from diffdrive_mj import metrics
from diffdrive_mj._checks import Array
from diffdrive_mj._text import html_table, span
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.grip import Grip
from diffdrive_mj.odometry import Method, Step, integrate
from diffdrive_mj.robot import Robot
from diffdrive_mj.solver import Physics
from diffdrive_mj.world import World

if TYPE_CHECKING:
    from typing_extensions import TypeVar

    # One robot or a tuple of them, and their commands: `simulate` says which.
    RobotT = TypeVar("RobotT", default=Any)
    CommandsT = TypeVar("CommandsT", default=Any)
else:
    RobotT, CommandsT = typing.TypeVar("RobotT"), typing.TypeVar("CommandsT")


@dataclass(frozen=True, eq=False)
class Recording(Generic[RobotT, CommandsT]):
    """What the physics recorded of a drive; with a leading axis N for many runs.

    Attributes:
        t: (T,) [s].
        wheel_angles: (..., T, 2) [rad], left then right, as an ideal encoder reads them.
        truth: (..., T, 3) [m, m, rad], the true pose of the axle's midpoint; theta continuous.
        robot: the true robot, or a tuple of N.
        commands: what was driven, or a tuple of N.
        world: as simulated.
        physics: as simulated.
        flow: (..., T, 2) [m], how far the flow sensor's site has moved over the floor since the start, forward and to
            the left in its own axes; None without a sensor.
        grip: how the robots held on to the floor.
        height: (..., T) [m], of the axle's midpoint above the floor's plane; None in recordings not made by `simulate`.
        attitude: (..., T, 4), the body's rotation from its own axes to the world's as quaternions, w first, the roll of
            a rigid axle at rest included; None in recordings not made by `simulate`.
        passive_angles: (..., T, n) [rad], how far each passive wheel has turned since the start; None without them.
        slip: (..., T, 2, 2) [m], how far the tyre of the left and of the right wheel has slid over the floor since the
            start, forward and to the left in the robot's axes, read where they touch it; None if not asked for. With
            skid steer it is the mean of a side's front and rear tyre. Off the floor, on cables and on rough ground the
            lowest point of the tyre stands for the contact: what climbing does is then in it. Soft tyres stand for
            rigid ones: that they roll on a smaller radius (`Tyres.stiffness`) is in it, half of what they give way by
            for every radian.
        caster_angle: (..., T) [rad], where the fork of a swivel caster points (`Caster.angle`); None for a ball.

    Example:
        >>> robot = dd.Robot.load("mismatched")
        >>> recording = dd.simulate(robot, dd.maneuvers.straight(robot, speed=0.5, distance=0.1), sample_rate=10.0)
        >>> recording
        Recording(15 samples, 1.4 s)
        >>> recording.truth[-1, 0].round(3).item()
        0.1
        >>> believed = robot.replace(right_radius=robot.left_radius)  # takes the wheels for equal
        >>> np.degrees(recording.drift(believed).final_heading).round(1).item()
        1.4
    """

    t: Array
    wheel_angles: Array
    truth: Array
    robot: RobotT
    commands: CommandsT
    world: World
    physics: Physics
    flow: Array | None = None
    grip: Grip | None = None
    height: Array | None = None
    attitude: Array | None = None
    passive_angles: Array | None = None
    slip: Array | None = None
    caster_angle: Array | None = None

    def __repr__(self) -> str:
        runs = f"{len(self.robot)} runs of " if isinstance(self.robot, tuple) else ""
        return f"Recording({runs}{len(self.t)} samples, {self.t[-1]:g} s)"

    def _repr_html_(self) -> str:
        robots = cast(tuple[Robot, ...], self.robot if isinstance(self.robot, tuple) else (self.robot,))
        rows = [
            ("robot", ", ".join(dict.fromkeys(robot.name for robot in robots))),
            ("runs", len(robots)),
            ("samples", len(self.t)),
            ("duration", f"{self.t[-1]:g} s"),
            ("distance driven", span(metrics.travelled(self.truth)[..., -1], "m")),
            *(("warning", event) for event in self.events),
        ]
        return html_table(rows)

    @property
    def friction_use(self) -> Array:
        """Largest share of the friction that each wheel used (..., 2), left then right; at 1 a wheel slips."""
        return self._held.friction_use

    @property
    def lift(self) -> NDArray[np.bool_]:
        """Whether a wheel or the caster left the floor (...)."""
        return ~np.isnan(self._held.lift_time)

    @property
    def upright(self) -> NDArray[np.bool_]:
        """Whether the robot stayed up (...)."""
        return np.isnan(self._held.fall_time)

    @property
    def events(self) -> tuple[str, ...]:
        """What happened that wheel odometry cannot see, a line each: falls, slip, motors at their limits."""
        return (*self.surprises, *(() if self.grip is None else self.grip.skids(*self._named)))

    @property
    def surprises(self) -> tuple[str, ...]:
        """The events without what a robot with skid steer cannot help doing."""
        return () if self.grip is None else self.grip.events(*self._named)

    @property
    def _named(self) -> tuple[list[str], list[bool]]:
        """What messages call the robots, and which have skid steer."""
        robots = cast(tuple[Robot, ...], self.robot if isinstance(self.robot, tuple) else (self.robot,))
        names = [f"robot {run} ({robot.name})" for run, robot in enumerate(robots)]
        if not isinstance(self.robot, tuple):
            names = [f"robot {robots[0].name}"]
        return names, [robot.skids for robot in robots]

    @property
    def runs(self) -> tuple[Recording, ...]:
        """Each run as a recording of its own."""
        if not isinstance(self.robot, tuple):
            return (self,)
        return tuple(self.run(k) for k in range(len(self.robot)))

    def run(self, number: int) -> Recording:
        """Return one of many runs as a recording of its own.

        Args:
            number: of the run, from 0 on.

        Returns:
            Its samples, robot, commands and grip.

        Raises:
            InvalidValue: a recording of a single robot, or another number.

        Example:
            >>> robot = dd.Robot.load("matched")
            >>> spins = [dd.maneuvers.spin(robot, turns=turns) for turns in (0.05, -0.05)]
            >>> dd.simulate(robot, spins).run(1).truth[-1, 2] < 0
            np.True_
        """
        count = len(self.robot) if isinstance(self.robot, tuple) else 0
        if not 0 <= checks.whole("number", number, least=0) < count:
            raise InvalidValue(f"number = {number}: must be below the number of runs, {count}")
        values = {field.name: getattr(self, field.name) for field in fields(self) if field.name != "t"}
        of_each = {name: value for name, value in values.items() if isinstance(value, (np.ndarray, tuple))}
        grip = None if self.grip is None else self.grip.of(number)
        return replace(self, grip=grip, **{name: value[number] for name, value in of_each.items()})

    def odometry(self, robot: Robot, method: Method | Step = "arc") -> Array:
        """Compute what a robot believes, from the ideal wheel angles and the first true pose.

        Args:
            robot: the believed robot.
            method: "euler", "midpoint", "arc", or a function as `odometry.integrate` takes it.

        Returns:
            (..., T, 3) [m, m, rad].

        Raises:
            InvalidType: not a robot.
            UnknownName: the method.
        """
        return integrate(self.wheel_angles, robot, method, self.truth[..., 0, :])

    def drift(self, robot: Robot, method: Method | Step = "arc") -> metrics.Drift:
        """Compute how far off a robot's odometry is, along the drive.

        Args:
            robot: the believed robot.
            method: "euler", "midpoint", "arc", or a function as `odometry.integrate` takes it.

        Returns:
            The errors of `odometry` against the truth.

        Raises:
            InvalidType: not a robot.
            UnknownName: the method.
        """
        return replace(metrics.drift(self.truth, self.odometry(robot, method)), warnings=self.events)

    def at_rate(self, sample_rate: float) -> Recording[RobotT, CommandsT]:
        """Keep the samples of a lower rate.

        Args:
            sample_rate: [Hz]; it must divide the recorded one.

        Returns:
            The same drive with fewer samples.

        Raises:
            InvalidValue: a rate that does not divide the recorded one.
        """
        if len(self.t) < 2:
            return self
        interval = 1 / checks.positive("sample_rate", sample_rate)
        stride = checks.multiple("sampling interval", interval, "the recorded one", float(self.t[1] - self.t[0]))
        return self._at(slice(None, None, stride))

    def during(self, start: float, end: float) -> Recording:
        """Keep the part of the drive from one time to another, both included.

        Args:
            start: [s].
            end: [s].

        Returns:
            The same drive with fewer samples.

        Raises:
            InvalidValue: no sample lies there.
        """
        start, end = checks.number("start", start), checks.number("end", end)
        # Recorded times are off by rounding.
        kept = np.flatnonzero((self.t >= start - 1e-9) & (self.t <= end + 1e-9))
        if not len(kept):
            raise InvalidValue(
                f"start = {start:g} s, end = {end:g} s: no sample there; recorded are {self.t[0]:g} to {self.t[-1]:g} s"
            )
        return self._at(slice(kept[0], kept[-1] + 1))

    def _at(self, samples: slice) -> Recording:
        # Runs come before the samples, what is sampled after them.
        where = (*[slice(None)] * (self.truth.ndim - 2), samples)
        values = {field.name: getattr(self, field.name) for field in fields(self) if field.name != "t"}
        sampled: dict[str, Any] = {
            name: value[where] for name, value in values.items() if isinstance(value, np.ndarray)
        }
        return replace(self, t=self.t[samples], **sampled)

    @property
    def _held(self) -> Grip:
        if self.grip is None:
            raise InvalidValue("Recording.grip is None: only recordings of `simulate` know how the wheels held on")
        return self.grip
