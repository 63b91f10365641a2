"""One drive of many robots: the engine's steps are read by the probes, sampled, and let go."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from diffdrive_mj._checks import Array
from diffdrive_mj.commands import Commands
from diffdrive_mj.errors import RobotFell
from diffdrive_mj.grip import Grip
from diffdrive_mj.physics._engine import STEPS_PER_CALL, Engine
from diffdrive_mj.physics._mishaps import edge_times, stuck_times
from diffdrive_mj.physics._probes import FallProbe, GripProbe, MotionProbe, Steps, TwistProbe
from diffdrive_mj.physics._slip import SlideProbe, SlipProbe
from diffdrive_mj.robot import Robot
from diffdrive_mj.solver import Physics
from diffdrive_mj.world import World


class Runs:
    """Robots that drive, and the samples taken of them so far.

    Args:
        robots: true robots, N.
        world: floor and disturbances.
        physics: how it is solved.
        start: (N, 3) [m, m, rad].
        steps_per_sample: time steps between two samples.
        threads: 0 for all cores.
        sensors: of the motion, on every robot: what each reads of steps, by the name of a recording's field.
        slip: whether it is read how far the tyres slide.
        raise_on_fall: whether a robot that falls ends the drive in an error.
    """

    def __init__(
        self,
        robots: Sequence[Robot],
        world: World,
        physics: Physics,
        start: Array,
        steps_per_sample: int,
        threads: int,
        sensors: Mapping[str, Callable[[Array], Array]],
        *,
        slip: bool,
        raise_on_fall: bool,
    ) -> None:
        self._robots, self._world, self._timestep, self._start = robots, world, physics.timestep, start
        self._steps_per_sample, self._raise_on_fall = steps_per_sample, raise_on_fall
        self._engine = Engine(robots, world, physics, start, threads)
        self._grip = GripProbe(self._engine.model, self.count)
        self._slide = SlideProbe(SlipProbe(self._engine.models, physics, self._engine.rest), slip)
        self._fall = FallProbe(self._engine.model, self._engine.rest)
        self._sensors: dict[str, MotionProbe] = {name: TwistProbe(seen, self.count) for name, seen in sensors.items()}
        self._unread: list[tuple[Array, Array, Array]] = []
        self._read = 0
        rest = self._engine.rest
        first = {
            "wheel_angles": np.zeros((self.count, 2)),
            "truth": start,
            "height": rest[:, 2],
            "attitude": rest[:, 3:7],
            **{name: angles[:, 0] for name, angles in self._casters(rest[:, None]).items()},
            **{name: sensor.reading for name, sensor in self._sensors.items()},
            **self._slide.reading,
        }
        self._samples = {name: [values[:, None].copy()] for name, values in first.items()}

    @property
    def count(self) -> int:
        """How many robots drive."""
        return len(self._robots)

    def angles(self) -> Array:
        """The wheel angles now (N, 2) [rad]."""
        angles = self._engine.angles()
        if not math.isfinite(angles.sum()):
            self._digest()
        return angles

    def drive(self, rates: Array, steps_per_period: int) -> None:
        """Drive on: rates (N, P, 2) [rad/s], one row a command period."""
        most = max(1, STEPS_PER_CALL // (self.count * steps_per_period))
        for first in range(0, rates.shape[1], most):
            piece = np.repeat(rates[:, first : first + most], steps_per_period, axis=1)
            self._keep(self._engine.advance(piece))
            self._digest()

    def hold(self, rates: Array, steps: int) -> None:
        """Drive on at constant rates (N, 2) [rad/s], as a closed loop does period by period."""
        self._keep(self._engine.hold(rates, steps))

    def recorded(self, driven: Sequence[Commands]) -> tuple[Array, dict[str, Array], Grip]:
        """The times (T,) [s], all the samples (N, T, ...) by the names of a recording's fields, and the grip."""
        self._digest()
        samples = {name: np.concatenate(pieces, axis=1) for name, pieces in self._samples.items()}
        truth, windup = samples["truth"], self._engine.windup
        t: Array = np.arange(truth.shape[1], dtype=np.float64) * (self._steps_per_sample * self._timestep)
        stuck = stuck_times(t, truth, self._robots, driven)
        grip = self._grip.grip(self._fall.time, stuck, edge_times(t, truth, self._world))
        if windup is not None:
            grip = replace(grip, shortfall=windup.shortfall, shortfall_time=windup.shortfall_time)
        return t, samples, replace(grip, slide=self._slide.slide)

    def _keep(self, piece: tuple[Array, Array, Array]) -> None:
        """Put steps aside: reading many at once is cheaper."""
        self._unread.append(piece)
        if (self._engine.steps - self._read) * self.count >= STEPS_PER_CALL:
            self._digest()

    def _digest(self) -> None:
        """Let the probes read the steps put aside, and keep what was measured at the sample times."""
        if not self._unread:
            return
        if len(self._unread) == 1:  # as on an open loop; nothing is copied
            states, sensors, friction = self._unread[0]
        else:
            states, sensors, friction = (np.concatenate(parts, axis=1) for parts in zip(*self._unread, strict=True))
        self._unread.clear()
        self._engine.refuse_divergence(states)
        time = self._timestep * np.arange(self._read + 1, self._read + states.shape[1] + 1)
        steps = Steps(time, states, sensors, friction, self._engine.follow(states))
        self._grip.read(steps)
        slip = self._slide.read(steps, self._grip.slipping)
        self._fall.read(steps)
        if self._raise_on_fall:
            self._refuse_fall()
        self._sample(steps, {name: sensor.read(steps) for name, sensor in self._sensors.items()} | slip)
        self._read += states.shape[1]

    def _refuse_fall(self) -> None:
        fallen = np.flatnonzero(~np.isnan(self._fall.time))
        if fallen.size:
            run = int(fallen[np.argmin(self._fall.time[fallen])])
            others = f", and {fallen.size - 1} more" if fallen.size > 1 else ""
            raise RobotFell(
                f"robot {run} ({self._robots[run].name}) {self._fall.how[run]} at t = {self._fall.time[run]:.4g} s"
                f"{others}: drive it more gently or lower its centre of mass"
            )

    def _sample(self, steps: Steps, readings: dict[str, Array]) -> None:
        every, count = self._steps_per_sample, steps.states.shape[1]
        first = every - 1 - self._read % every
        if first >= count:
            return
        picked = slice(first, None, every)
        poses, states = steps.poses[:, first + 1 :: every].copy(), steps.states[:, picked]
        poses[..., :2] += self._start[:, None, :2]
        # Copies, since views would keep all the steps.
        values = {
            "wheel_angles": self._engine.joint_angles(states).copy(),
            "truth": poses,
            "height": states[..., 2].copy(),
            "attitude": states[..., 3:7].copy(),
            **self._casters(states),
            **{name: reading[:, picked].copy() for name, reading in readings.items()},
        }
        for name, value in values.items():
            self._samples[name].append(value)

    def _casters(self, states: Array) -> dict[str, Array]:
        angles = self._engine.caster_angles(states)
        return {} if angles is None else {"caster_angle": angles}
