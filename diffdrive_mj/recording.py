"""What the physics saw of a drive: ideal wheel angles beside the true pose."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj.commands import Commands
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.robot import Robot
from diffdrive_mj.solver import Physics
from diffdrive_mj.world import World

# The share of its friction above which a wheel is said to slip.
LARGEST_USE = 0.95

RobotT = TypeVar("RobotT", bound=Robot | tuple[Robot, ...])
CommandsT = TypeVar("CommandsT", bound=Commands | tuple[Commands, ...])


@dataclass(frozen=True, eq=False)
class Grip:
    """How the robots held on to the floor.

    Attributes:
        friction_use: (..., 2), largest share of the friction that the left and the right wheel used.
        friction_time: (..., 2) [s], when that was.
        lift_time: (...) [s], when a wheel or the caster first left the floor; nan if none did.
        fall_time: (...) [s], when the robot fell; nan if it did not.
    """

    friction_use: Array
    friction_time: Array
    lift_time: Array
    fall_time: Array

    def of(self, run: int) -> Grip:
        """That of one run."""
        return Grip(self.friction_use[run], self.friction_time[run], self.lift_time[run], self.fall_time[run])


@dataclass(frozen=True, eq=False)
class Recording(Generic[RobotT, CommandsT]):
    """What was measured on a drive; with a leading axis N for many runs.

    Attributes:
        t: (T,) [s].
        wheel_angles: (..., T, 2) [rad], left then right, as an ideal encoder reads them.
        truth: (..., T, 3) [m, m, rad], the true pose of the axle's midpoint; theta continuous.
        robot: the true robot, or a tuple of N.
        commands: that were driven, or a tuple of N.
        world, physics: as simulated.
        flow: (..., T, 2) [m], how far the flow sensor's place has moved over the floor since the start, forward and to
            the left in its own axes; None without a sensor.
        grip: how the robots held on to the floor.
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

    def __repr__(self) -> str:
        runs = f"{len(self.robot)} runs of " if isinstance(self.robot, tuple) else ""
        return f"Recording({runs}{len(self.t)} samples, {self.t[-1]:g} s)"

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
        """What happened that wheel odometry cannot see, a line each: falls, wheels off the floor, slip."""
        if self.grip is None:
            return ()
        robots = self.robot if isinstance(self.robot, tuple) else (self.robot,)
        use, when = (value.reshape(-1, 2) for value in (self.grip.friction_use, self.grip.friction_time))
        lift, fall = (np.reshape(value, -1) for value in (self.grip.lift_time, self.grip.fall_time))
        found: list[str] = []
        for run, robot in enumerate(robots):
            name = f"robot {run} ({robot.name})" if len(robots) > 1 else f"robot {robot.name}"
            if not np.isnan(fall[run]):
                found.append(f"{name} fell at {fall[run]:.4g} s")
            if not np.isnan(lift[run]):
                found.append(f"{name}: a wheel or the caster was off the floor at {lift[run]:.4g} s")
            for side, wheel in enumerate(("left", "right")):
                if use[run, side] > LARGEST_USE:
                    found.append(
                        f"{name}: the {wheel} wheel used {100 * use[run, side]:.0f} % of its friction at "
                        f"{when[run, side]:.4g} s"
                    )
        return tuple(found)

    @property
    def _held(self) -> Grip:
        if self.grip is None:
            raise InvalidValue("Recording.grip is None: only recordings of `simulate` know how the wheels held on")
        return self.grip

    def at_rate(self, sample_rate: float) -> Recording[RobotT, CommandsT]:
        """The same drive seen at a lower rate [Hz], which must divide the recorded one."""
        if len(self.t) < 2:
            return self
        interval = 1 / checks.positive("sample_rate", sample_rate)
        stride = checks.multiple("sampling interval", interval, "the recorded one", float(self.t[1] - self.t[0]))
        return replace(
            self,
            t=self.t[::stride],
            wheel_angles=self.wheel_angles[..., ::stride, :],
            truth=self.truth[..., ::stride, :],
            flow=None if self.flow is None else self.flow[..., ::stride, :],
        )
