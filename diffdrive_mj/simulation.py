"""Driving robots in MuJoCo: one or many, open or closed loop, headless.

`simulate` steps all runs together on MuJoCo's batch engine, each with its own model, and records what an ideal
encoder reads beside the true pose. Nothing else leaves the physics. The same inputs give the same bits, alone
or in a batch, on any number of threads.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj import checks
from diffdrive_mj.checks import Array
from diffdrive_mj.engine import Runs
from diffdrive_mj.errors import InvalidType, InvalidValue
from diffdrive_mj.maneuvers import Commands
from diffdrive_mj.optical_flow import FlowSensor
from diffdrive_mj.robot import Robot
from diffdrive_mj.world import Physics, World

# Steps of all runs together in one call of the engine: it bounds memory, not speed.
_STEPS_PER_CALL = 200_000

T = TypeVar("T")


@dataclass(frozen=True)
class ClosedLoop:
    """A driver that decides anew once a control period.

    Args:
        function: called with the time [s] and the wheel angles of all the runs (N, 2) [rad], (2,) for a
            single robot; returns the wheel rates to hold for the period, in the same shape [rad/s].
        period: [s].
        duration: of the drive [s].
    """

    function: Callable[[float, Array], ArrayLike]
    period: float
    duration: float

    def __post_init__(self) -> None:
        checks.positive("ClosedLoop.period", self.period)
        checks.positive("ClosedLoop.duration", self.duration)


@dataclass(frozen=True, eq=False)
class Recording:
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
    """

    t: Array
    wheel_angles: Array
    truth: Array
    robot: Robot | tuple[Robot, ...]
    commands: Commands | tuple[Commands, ...]
    world: World
    physics: Physics
    flow: Array | None = None

    def __repr__(self) -> str:
        runs = f"{len(self.robot)} runs of " if isinstance(self.robot, tuple) else ""
        return f"Recording({runs}{len(self.t)} samples, {self.t[-1]:g} s)"

    def at_rate(self, sample_rate: float) -> Recording:
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


def simulate(
    robot: Robot | Sequence[Robot],
    commands: Commands | ClosedLoop | Sequence[Commands],
    *,
    world: World = World(),  # noqa: B008
    physics: Physics = Physics(),  # noqa: B008
    sample_rate: float = 100.0,
    start: ArrayLike = (0.0, 0.0, 0.0),
    flow_sensor: FlowSensor | None = None,
    threads: int = 0,
) -> Recording:
    """Drive robots and record wheel angles and true poses.

    Args:
        robot: the true robot, or a sequence of them.
        commands: open loop, one for all robots or one each, of one period and duration (`Commands.extended`),
            or a `ClosedLoop`.
        world: floor and disturbances.
        physics: how it is solved.
        sample_rate: of the recording [Hz]; the interval must be a whole number of time steps, and the last sample is
            the last that fits into the drive.
        start: (..., 3) [m, m, rad], the pose at time zero, one for all or one each.
        flow_sensor: an optical flow sensor on every robot, to be recorded too.
        threads: 0 for all cores; the result does not depend on it.

    Returns:
        A recording; with a leading axis if robots or commands came as a sequence.

    Raises:
        InvalidValue, InvalidType: inputs that do not fit.
        SimulationDiverged: an engine warning, with the robot, the time and the warning.
    """
    single = isinstance(robot, Robot) and isinstance(commands, (Commands, ClosedLoop))
    robots, drives = _one_each(robot, commands)
    plan = drives[0]
    step = physics.timestep
    steps_per_period = checks.multiple("command period", plan.period, "Physics.timestep", step)
    steps_per_sample = checks.multiple(
        "sampling interval", 1 / checks.positive("sample_rate", sample_rate), "Physics.timestep", step
    )
    periods = checks.multiple("duration", plan.duration, "command period", plan.period)
    runs = Runs(robots, world, physics, _start(start, len(robots)), steps_per_sample, threads, flow_sensor)
    driven = (
        _closed_loop(runs, plan, periods, steps_per_period, single)
        if isinstance(plan, ClosedLoop)
        else _open_loop(runs, [d for d in drives if isinstance(d, Commands)], steps_per_period)
    )
    angles, truth, flow = runs.recorded()
    t: Array = np.arange(angles.shape[1], dtype=np.float64) * (steps_per_sample * step)
    seen = None if flow_sensor is None else flow
    if single:
        seen = None if seen is None else seen[0]
        return Recording(t, angles[0], truth[0], robots[0], driven[0], world, physics, seen)
    return Recording(t, angles, truth, tuple(robots), tuple(driven), world, physics, seen)


def _one_each(
    robot: Robot | Sequence[Robot], commands: Commands | ClosedLoop | Sequence[Commands]
) -> tuple[list[Robot], list[Commands | ClosedLoop]]:
    """As many robots as commands, checked."""
    robots = [robot] if isinstance(robot, Robot) else list(robot)
    drives: list[Commands | ClosedLoop] = [commands] if isinstance(commands, (Commands, ClosedLoop)) else list(commands)
    for name, items, kinds in (("robot", robots, (Robot,)), ("commands", drives, (Commands, ClosedLoop))):
        if not items:
            raise InvalidValue(f"{name}: must hold at least one")
        for item in items:
            if not isinstance(item, kinds):
                raise InvalidType(f"{name} holds {item!r}: must be {' or '.join(k.__name__ for k in kinds)}")
    if isinstance(drives[0], Commands):
        first = drives[0]
        for other in drives:
            if not isinstance(other, Commands) or (other.period, len(other.wheel_rates)) != (
                first.period,
                len(first.wheel_rates),
            ):
                raise InvalidValue(
                    f"commands: {first} and {other}: must have one period and one duration; see Commands.extended"
                )
    elif len(drives) > 1:
        raise InvalidValue("commands: must hold one ClosedLoop, which drives all the robots")
    count = max(len(robots), len(drives))
    if isinstance(drives[0], ClosedLoop):
        return robots, drives
    return _stretch("robot", robots, count), _stretch("commands", drives, count)


def _stretch(name: str, items: list[T], count: int) -> list[T]:
    if len(items) not in (1, count):
        raise InvalidValue(f"{name} has {len(items)} entries: must be 1 or {count}")
    return items * (count // len(items))


def _open_loop(runs: Runs, drives: list[Commands], steps_per_period: int) -> list[Commands]:
    rates = np.stack([drive.wheel_rates for drive in drives])
    periods_per_call = max(1, _STEPS_PER_CALL // (len(drives) * steps_per_period))
    for first in range(0, rates.shape[1], periods_per_call):
        runs.advance(np.repeat(rates[:, first : first + periods_per_call], steps_per_period, axis=1))
    return drives


def _closed_loop(runs: Runs, driver: ClosedLoop, periods: int, steps_per_period: int, single: bool) -> list[Commands]:
    shape = (2,) if single else (runs.count, 2)
    rates = np.empty((runs.count, periods, 2))
    for period in range(periods):
        t = period * driver.period
        decided = checks.array(
            f"rates of the driver at {t:g} s", driver.function(t, runs.angles().reshape(shape)), *shape
        )
        if decided.shape != shape:
            raise InvalidValue(f"rates of the driver at {t:g} s have shape {decided.shape}: must be {shape}")
        rates[:, period] = decided
        runs.advance(np.repeat(rates[:, period : period + 1], steps_per_period, axis=1))
    return [Commands(driver.period, row) for row in rates]


def _start(start: ArrayLike, count: int) -> Array:
    poses = checks.array("start", start, 3)
    if poses.shape not in ((3,), (1, 3), (count, 3)):
        raise InvalidValue(f"start has shape {poses.shape}: must be (3,) or ({count}, 3)")
    return np.array(np.broadcast_to(poses, (count, 3)))
