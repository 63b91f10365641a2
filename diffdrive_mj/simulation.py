"""Driving robots in MuJoCo: one or many, open or closed loop, headless.

`simulate` steps all runs together on MuJoCo's batch engine, each with its own model, and records what an ideal
encoder reads beside the true pose. Nothing else leaves the physics. The same inputs give the same bits, alone
or in a batch, on any number of threads.
"""

from __future__ import annotations

import contextlib
import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import mujoco
import numpy as np
from mujoco.batch import Batch
from numpy.typing import ArrayLike

from diffdrive_mj import checks
from diffdrive_mj.checks import Array
from diffdrive_mj.errors import InvalidType, InvalidValue, SimulationDiverged
from diffdrive_mj.maneuvers import Commands
from diffdrive_mj.model import compile_model
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
    """

    t: Array
    wheel_angles: Array
    truth: Array
    robot: Robot | tuple[Robot, ...]
    commands: Commands | tuple[Commands, ...]
    world: World
    physics: Physics

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
        )


def simulate(
    robot: Robot | Sequence[Robot],
    commands: Commands | ClosedLoop | Sequence[Commands],
    *,
    world: World = World(),  # noqa: B008
    physics: Physics = Physics(),  # noqa: B008
    sample_rate: float = 100.0,
    start: ArrayLike = (0.0, 0.0, 0.0),
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
    runs = _Runs(robots, world, physics, start, steps_per_sample, threads)
    driven = (
        _closed_loop(runs, plan, periods, steps_per_period, single)
        if isinstance(plan, ClosedLoop)
        else _open_loop(runs, [d for d in drives if isinstance(d, Commands)], steps_per_period)
    )
    angles, truth = runs.recorded()
    t: Array = np.arange(angles.shape[1], dtype=np.float64) * (steps_per_sample * step)
    if single:
        return Recording(t, angles[0], truth[0], robots[0], driven[0], world, physics)
    return Recording(t, angles, truth, tuple(robots), tuple(driven), world, physics)


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


def _open_loop(runs: _Runs, drives: list[Commands], steps_per_period: int) -> list[Commands]:
    rates = np.stack([drive.wheel_rates for drive in drives])
    periods_per_call = max(1, _STEPS_PER_CALL // (len(drives) * steps_per_period))
    for first in range(0, rates.shape[1], periods_per_call):
        runs.advance(np.repeat(rates[:, first : first + periods_per_call], steps_per_period, axis=1))
    return drives


def _closed_loop(runs: _Runs, driver: ClosedLoop, periods: int, steps_per_period: int, single: bool) -> list[Commands]:
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


class _Runs:
    """The batch of simulations and the samples taken from it so far."""

    def __init__(
        self,
        robots: Sequence[Robot],
        world: World,
        physics: Physics,
        start: ArrayLike,
        steps_per_sample: int,
        threads: int,
    ) -> None:
        self._robots = robots
        self._world = world
        self._timestep = physics.timestep
        models = [compile_model(robot, world, physics) for robot in robots]
        self._batch = Batch(models[0], nsim=len(robots), nthread=threads)
        self._batch.set_models(models)
        self._batch.qpos[:] = np.stack([model.qpos0 for model in models])
        self._joints = [int(models[0].joint(side).qposadr[0]) for side in ("left", "right")]
        self._body = int(models[0].body("robot").id)
        self._steps_per_sample = steps_per_sample
        self._steps = 0
        poses = np.array(np.broadcast_to(_start(start, len(robots)), (len(robots), 3)))
        self._settle(poses, round(physics.settle_time / physics.timestep))
        self._heading = poses[:, 2]
        self._samples = [(np.zeros((len(robots), 1, 2)), poses[:, None])]

    @property
    def count(self) -> int:
        return len(self._robots)

    def angles(self) -> Array:
        """The wheel angles now (N, 2) [rad]."""
        return np.array(self._batch.qpos[:, self._joints])

    def recorded(self) -> tuple[Array, Array]:
        """Wheel angles (N, T, 2) and true poses (N, T, 3) of all the samples."""
        angles, poses = zip(*self._samples, strict=True)
        return np.concatenate(angles, axis=1), np.concatenate(poses, axis=1)

    def advance(self, rates: Array) -> None:
        """Drive on: rates (N, S, 2) [rad/s], one row a time step."""
        edges = self._push_edges(rates.shape[1])
        for first, last in itertools.pairwise(edges):
            self._push()
            self._sample(self._step(last - first, rates[:, first:last]))

    def _push_edges(self, steps: int) -> list[int]:
        """Where the forces change, within the next steps."""
        times = [t for push in self._world.pushes for t in (push.start, push.start + push.duration)]
        places = {round(t / self._timestep) - self._steps for t in times}
        return [0, *sorted(place for place in places if 0 < place < steps), steps]

    def _push(self) -> None:
        if not self._world.pushes:
            return
        total = np.zeros(3)
        for push in self._world.pushes:
            begin, end = (round(t / self._timestep) for t in (push.start, push.start + push.duration))
            if begin <= self._steps < end:
                total += push.acceleration
        masses = np.array([robot.mass for robot in self._robots])
        self._batch.xfrc_applied[:, self._body, :3] = masses[:, None] * total

    def _step(self, steps: int, rates: Array | None) -> Array:
        """Step the engine; the states after each step (N, S, nq)."""
        with _quiet_engine():
            control = None if rates is None else np.tile(rates, 2)  # the servos' proportional and integral parts
            states = self._batch.rollout(steps, control=control, record=("qpos",))["qpos"]
        self._watch(states)
        return states

    def _watch(self, states: Array) -> None:
        """Turn the engine's warnings, and what it should have warned of, into an error."""
        warned = self._batch.warning.reshape(self.count, -1)
        broken = warned.any(axis=1) | ~np.isfinite(states[:, -1]).all(axis=1)
        if not broken.any():
            return
        run = int(np.argmax(broken))
        kinds = np.flatnonzero(warned[run])
        reason = mujoco.mju_warningText(int(kinds[0]), 0) if kinds.size else "the state is not finite"
        t = float(self._batch.time[run]) - self._settled_at
        raise SimulationDiverged(f"robot {run} ({self._robots[run].name}) diverged at t = {t:.4g} s: {reason}")

    def _settle(self, poses: Array, steps: int) -> None:
        """Let the robots come to rest on the floor, then put them at their start poses, wheels at zero."""
        self._settled_at = 0.0
        self._place(poses)
        if steps:
            self._step(steps, None)
        self._place(poses)
        self._batch.qvel[:] = 0
        self._batch.act[:] = 0
        self._settled_at = float(self._batch.time[0])

    def _place(self, poses: Array) -> None:
        """Move the robots in the plane; height, roll and pitch stay."""
        qpos = self._batch.qpos
        qpos[:, :2] = poses[:, :2]
        half = (poses[:, 2] - _heading(qpos[:, 3:7])) / 2
        w, z = np.cos(half), np.sin(half)
        a, b, c, d = qpos[:, 3:7].T.copy()
        qpos[:, 3:7] = np.stack([w * a - z * d, w * b - z * c, w * c + z * b, w * d + z * a], axis=-1)
        qpos[:, self._joints] = 0

    def _sample(self, states: Array) -> None:
        """Keep the states at the sample times; follow the heading through every step of them."""
        headings = np.concatenate([self._heading[:, None], _heading(states[..., 3:7])], axis=1)
        headings = np.unwrap(headings, axis=1)[:, 1:]
        self._heading = headings[:, -1]
        done, every = self._steps, self._steps_per_sample
        self._steps += states.shape[1]
        picked = np.arange(done + every - done % every, self._steps + 1, every) - done - 1
        if picked.size:
            chosen = states[:, picked]
            poses = np.concatenate([chosen[..., :2], headings[:, picked, None]], axis=-1)
            self._samples.append((chosen[..., self._joints], poses))


def _start(start: ArrayLike, count: int) -> Array:
    poses = checks.array("start", start, 3)
    if poses.shape not in ((3,), (1, 3), (count, 3)):
        raise InvalidValue(f"start has shape {poses.shape}: must be (3,) or ({count}, 3)")
    return poses


def _heading(quaternion: Array) -> Array:
    """The direction of the body's x axis on the floor (...) [rad], of quaternions (..., 4) w first."""
    w, x, y, z = np.moveaxis(quaternion, -1, 0)
    return np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


@contextlib.contextmanager
def _quiet_engine() -> Iterator[None]:
    """Keep the engine from writing MUJOCO_LOG.TXT: its warnings are counted, and raised by `_watch`."""
    before, quiet = mujoco.MjLogConfig.get(), mujoco.MjLogConfig.get()
    quiet.logto_console = quiet.logto_file = False
    quiet.set()
    try:
        yield
    finally:
        before.set()
