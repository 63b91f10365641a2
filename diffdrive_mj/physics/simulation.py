"""Driving robots in MuJoCo: one or many, open or closed loop, headless.

`simulate` steps all runs together on MuJoCo's batch engine, each with its own model, and records what an ideal
encoder reads beside the true pose. Nothing else leaves the physics. The same inputs give the same bits, alone
or in a batch, on any number of threads.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable, Sequence
from typing import Any, Literal, TypeVar, overload

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj.commands import ClosedLoop, Commands
from diffdrive_mj.errors import InvalidValue, PhysicsWarning
from diffdrive_mj.physics._log import QUIET_ENGINE
from diffdrive_mj.physics._runs import Runs
from diffdrive_mj.physics.model import suited
from diffdrive_mj.recording import Recording
from diffdrive_mj.robot import Robot
from diffdrive_mj.sensors.optical_flow import FlowSensor
from diffdrive_mj.sensors.passive_wheels import PassiveWheels
from diffdrive_mj.solver import Physics
from diffdrive_mj.world import World

# Where a pose is so far away that double precision no longer resolves a micrometre [m], and a heading a nanoradian
# [rad].
_FARTHEST, _MOST_TURNED = 1e9, 1e6
# What wheels of skid steer slide at [m/s].
_SLIP = 0.5

T = TypeVar("T")
OnFall = Literal["raise", "record"]


@overload
def simulate(
    robot: Robot,
    commands: Commands | ClosedLoop,
    *,
    world: World = ...,
    physics: Physics | None = ...,
    sample_rate: float = ...,
    start: ArrayLike = ...,
    flow_sensor: FlowSensor | None = ...,
    passive_wheels: PassiveWheels | None = ...,
    slip: bool = ...,
    on_fall: OnFall = ...,
    threads: int = ...,
) -> Recording[Robot, Commands]: ...
@overload
def simulate(
    robot: Sequence[Robot],
    commands: Commands | ClosedLoop | Sequence[Commands],
    *,
    world: World = ...,
    physics: Physics | None = ...,
    sample_rate: float = ...,
    start: ArrayLike = ...,
    flow_sensor: FlowSensor | None = ...,
    passive_wheels: PassiveWheels | None = ...,
    slip: bool = ...,
    on_fall: OnFall = ...,
    threads: int = ...,
) -> Recording[tuple[Robot, ...], tuple[Commands, ...]]: ...
@overload
def simulate(
    robot: Robot,
    commands: Sequence[Commands],
    *,
    world: World = ...,
    physics: Physics | None = ...,
    sample_rate: float = ...,
    start: ArrayLike = ...,
    flow_sensor: FlowSensor | None = ...,
    passive_wheels: PassiveWheels | None = ...,
    slip: bool = ...,
    on_fall: OnFall = ...,
    threads: int = ...,
) -> Recording[tuple[Robot, ...], tuple[Commands, ...]]: ...
def simulate(
    robot: Robot | Sequence[Robot],
    commands: Commands | ClosedLoop | Sequence[Commands],
    *,
    world: World = World(),  # noqa: B008
    physics: Physics | None = None,
    sample_rate: float = 100.0,
    start: ArrayLike = (0.0, 0.0, 0.0),
    flow_sensor: FlowSensor | None = None,
    passive_wheels: PassiveWheels | None = None,
    slip: bool = False,
    on_fall: OnFall = "raise",
    threads: int = 0,
) -> Recording[Any, Any]:
    """Drive robots and record wheel angles and true poses.

    Args:
        robot: the true robot, or a sequence of them.
        commands: open loop, one for all robots or one each, of one period and duration (`Commands.extended`),
            or a `ClosedLoop`.
        world: floor and disturbances.
        physics: how it is solved; None is `Physics()`, and `Physics.skidding()` for robots with skid steer.
        sample_rate: of the recording [Hz]; the interval must be a whole number of time steps, and the last sample is
            the last that fits into the drive.
        start: (..., 3) [m, m, rad], the pose at time zero, one for all or one each.
        flow_sensor: an optical flow sensor on every robot, to be recorded too.
        passive_wheels: wheels without a motor on every robot, to be recorded too.
        slip: whether to record how far the tyres slide over the floor, which costs 2 to 3 % of the time.
        on_fall: "raise" ends the drive of a robot that tips over in an error, "record" keeps its recording.
        threads: 0 for all cores; the result does not depend on it.

    Returns:
        A recording; with a leading axis if robots or commands came as a sequence. `Recording.events` says what happened
        that wheel odometry cannot see, and a `PhysicsWarning` says that something did.

    Raises:
        InvalidValue, InvalidType, UnknownName: inputs that do not fit, or a robot that cannot stand.
        RobotFell: a robot tipped over, with its time.
        SimulationDiverged: an engine warning, with the robot, the time and the warning.

    Example:
        >>> from diffdrive_mj import maneuvers
        >>> robot = Robot(left_radius=0.1, right_radius=0.091, track_width=0.4)
        >>> recording = simulate(robot, maneuvers.straight(robot, speed=0.5, distance=0.5))
        >>> print(f"{recording.truth[-1, 0]:.3f} m")
        0.500 m
    """
    single = isinstance(robot, Robot) and isinstance(commands, (Commands, ClosedLoop))
    robots, drives = _one_each(robot, commands)
    checks.instance("world", world, World)
    physics = suited(robots[0], physics)
    if len({one.skids for one in robots}) > 1:
        raise InvalidValue("robot: some have skid steer and some have none; simulate them apart")
    sensors = {}  # by the names of the recording's fields
    if flow_sensor is not None:
        sensors["flow"] = checks.instance("flow_sensor", flow_sensor, FlowSensor).displacement
    if passive_wheels is not None:
        sensors["passive_angles"] = checks.instance("passive_wheels", passive_wheels, PassiveWheels).angles
    checks.boolean("slip", slip)
    checks.member("on_fall", on_fall, ("raise", "record"))
    # More threads than robots would have nothing to do.
    threads = min(checks.whole("threads", threads, least=0), len(robots))
    plan = drives[0]
    step = physics.timestep
    steps_per_period = checks.multiple("command period", plan.period, "Physics.timestep", step)
    steps_per_sample = checks.multiple(
        "sampling interval", 1 / checks.positive("sample_rate", sample_rate), "Physics.timestep", step
    )
    periods = checks.multiple("duration", plan.duration, "command period", plan.period)
    starts = _start(start, len(robots))
    with QUIET_ENGINE:
        runs = Runs(
            robots, world, physics, starts, steps_per_sample, threads, sensors,
            slip=slip, raise_on_fall=on_fall == "raise",
        )  # fmt: skip
        driven = (
            _closed_loop(runs, plan, periods, steps_per_period, single)
            if isinstance(plan, ClosedLoop)
            else _open_loop(runs, [d for d in drives if isinstance(d, Commands)], steps_per_period)
        )
        t, samples, grip = runs.recorded(driven)
    recording: Recording[Any, Any]
    if single:
        one: dict[str, Any] = {name: values[0] for name, values in samples.items()}
        recording = Recording(
            t, robot=robots[0], commands=driven[0], world=world, physics=physics, grip=grip.of(0), **one
        )
    else:
        all_runs: dict[str, Any] = dict(samples)
        recording = Recording(
            t, robot=tuple(robots), commands=tuple(driven), world=world, physics=physics, grip=grip, **all_runs
        )
    _warn(recording)
    return recording


def _warn(recording: Recording[Any, Any]) -> None:
    """Say once what wheel odometry cannot see."""
    physics, events = recording.physics, recording.surprises
    robots = recording.robot if isinstance(recording.robot, tuple) else (recording.robot,)
    if robots[0].skids and physics.slip_limit < _SLIP:
        events = (
            f"Physics.slip_limit = {physics.slip_limit:.2g} m/s: throws up the wheels of a robot with skid steer, "
            "which slide faster; Physics.skidding() does not",
            *events,
        )
    if physics.coarse:
        events = (physics.coarse, *events)
    if events:
        more = f", and {len(events) - 1} more in Recording.events" if len(events) > 1 else ""
        warnings.warn(f"{events[0]}{more}", PhysicsWarning, stacklevel=3)


def _all(name: str, value: object, *kinds: type[T]) -> list[T]:
    """One of some kinds, or a sequence of them, as a list."""
    if isinstance(value, (*kinds, str)) or not isinstance(value, Iterable) or getattr(value, "shape", None) == ():
        return [checks.instance(name, value, *kinds)]
    items = [checks.instance(f"{name}[{k}]", item, *kinds) for k, item in enumerate(value)]
    if not items:
        raise InvalidValue(f"{name}: must hold at least one")
    return items


def _one_each(
    robot: Robot | Sequence[Robot], commands: Commands | ClosedLoop | Sequence[Commands]
) -> tuple[list[Robot], list[Commands | ClosedLoop]]:
    """As many robots as commands, checked."""
    robots = _all("robot", robot, Robot)
    drives: list[Commands | ClosedLoop] = _all("commands", commands, Commands, ClosedLoop)
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
    runs.drive(np.stack([drive.wheel_rates for drive in drives]), steps_per_period)
    return drives


def _closed_loop(runs: Runs, driver: ClosedLoop, periods: int, steps_per_period: int, single: bool) -> list[Commands]:
    shape = (2,) if single else (runs.count, 2)
    rates = np.empty((runs.count, periods, 2))
    for period in range(periods):
        t = period * driver.period
        decided = driver.function(t, runs.angles().reshape(shape))
        if not (isinstance(decided, np.ndarray) and decided.shape == shape and decided.dtype == np.float64):
            decided = checks.array(f"rates of the driver at {t:g} s", decided, *shape)
            if decided.shape != shape:
                raise InvalidValue(f"rates of the driver at {t:g} s have shape {decided.shape}: must be {shape}")
        if not math.isfinite(decided.sum()):
            checks.array(f"rates of the driver at {t:g} s", decided, *shape)
        rates[:, period] = decided
        runs.hold(rates[:, period], steps_per_period)
    return [Commands(driver.period, row) for row in rates]


def _start(start: ArrayLike, count: int) -> Array:
    poses = checks.array("start", start, 3)
    if poses.shape not in ((3,), (1, 3), (count, 3)):
        raise InvalidValue(f"start has shape {poses.shape}: must be (3,) or ({count}, 3)")
    for name, values, most in (("m", poses[..., :2], _FARTHEST), ("rad", poses[..., 2], _MOST_TURNED)):
        if np.abs(values).max() > most:
            raise InvalidValue(f"start = {np.abs(values).max():.3g} {name}: must be within {most:g} {name} of zero")
    return np.array(np.broadcast_to(poses, (count, 3)))
