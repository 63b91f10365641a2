"""Many robots in MuJoCo's batch engine, stepped together, disturbed, watched and sampled.

What changes along the way, a push or the floor under a wheel, changes between two calls of the engine; each call goes
as far as nothing can change. How a drive is cut into calls does not change a bit of it.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence

import mujoco
import numpy as np
from mujoco.batch import Batch

from diffdrive_mj import se2
from diffdrive_mj._checks import Array
from diffdrive_mj.errors import SimulationDiverged
from diffdrive_mj.physics.model import compile_model
from diffdrive_mj.robot import Robot
from diffdrive_mj.sensors.optical_flow import FlowSensor
from diffdrive_mj.solver import Physics
from diffdrive_mj.world import World

# No wheel gets faster than this within one call [m/s^2]: it bounds how far it may go before the floor is looked at.
_LARGEST_ACCELERATION = 50.0


class Runs:
    """The batch of simulations, and the samples taken from it so far.

    Args:
        robots: true robots, N.
        world: floor and disturbances.
        physics: how it is solved.
        start: (N, 3) [m, m, rad].
        steps_per_sample: time steps between two samples.
        threads: 0 for all cores.
        flow_sensor: an optical flow sensor on every robot, or None.
    """

    def __init__(
        self,
        robots: Sequence[Robot],
        world: World,
        physics: Physics,
        start: Array,
        steps_per_sample: int,
        threads: int,
        flow_sensor: FlowSensor | None = None,
    ) -> None:
        self._robots, self._world, self._physics = robots, world, physics
        self._flow_sensor = flow_sensor
        self._flow = np.zeros((len(robots), 2))
        self._steps_per_sample = steps_per_sample
        self._steps = 0
        self._heading = start[:, 2]
        self._friction = np.full((len(robots), 2), world.friction)
        models = self._models()
        self._joints = [int(models[0].joint(side).qposadr[0]) for side in ("left", "right")]
        self._body = int(models[0].body("robot").id)
        self._batch = Batch(models[0], nsim=len(robots), nthread=threads)
        self._batch.set_models(models)
        self._batch.qpos[:] = np.stack([model.qpos0 for model in models])
        self._settle(start, round(physics.settle_time / physics.timestep))
        self._samples = [(np.zeros((len(robots), 1, 2)), start[:, None], self._flow[:, None])]

    @property
    def count(self) -> int:
        """How many robots drive."""
        return len(self._robots)

    def angles(self) -> Array:
        """The wheel angles now (N, 2) [rad]."""
        return np.array(self._batch.qpos[:, self._joints])

    def recorded(self) -> tuple[Array, Array, Array]:
        """Wheel angles (N, T, 2), true poses (N, T, 3) and flow (N, T, 2) of all the samples."""
        angles, poses, flow = (np.concatenate(parts, axis=1) for parts in zip(*self._samples, strict=True))
        return angles, poses, flow

    def advance(self, rates: Array) -> None:
        """Drive on: rates (N, S, 2) [rad/s], one row a time step."""
        while rates.shape[1]:
            self._push()
            self._grip()
            steps = min(rates.shape[1], self._steps_to_next_push(), self._steps_to_next_patch())
            self._sample(*self._step(steps, rates[:, :steps]))
            rates = rates[:, steps:]

    def _models(self) -> list[mujoco.MjModel]:
        return [
            compile_model(robot, self._physics, (left, right))
            for robot, (left, right) in zip(self._robots, self._friction.tolist(), strict=True)
        ]

    def _push_steps(self) -> list[tuple[int, int]]:
        dt = self._physics.timestep
        return [(round(push.start / dt), round((push.start + push.duration) / dt)) for push in self._world.pushes]

    def _push(self) -> None:
        """Apply the forces of now."""
        if not self._world.pushes:
            return
        total = np.zeros(3)
        for push, (begin, end) in zip(self._world.pushes, self._push_steps(), strict=True):
            if begin <= self._steps < end:
                total += push.acceleration
        masses = np.array([robot.mass for robot in self._robots])
        self._batch.xfrc_applied[:, self._body, :3] = masses[:, None] * total

    def _steps_to_next_push(self) -> int:
        """Steps until a force changes."""
        edges = [edge - self._steps for edges in self._push_steps() for edge in edges]
        return min((edge for edge in edges if edge > 0), default=np.iinfo(int).max)

    def _contacts(self) -> Array:
        """Where the wheels stand on the floor (N, 2, 2) [m], left then right."""
        half = np.array([robot.track_width / 2 for robot in self._robots])
        across = np.stack([np.zeros((self.count, 2)), np.stack([half, -half], axis=-1)], axis=-1)
        return self._batch.qpos[:, None, :2] + se2.rotate(across, self._heading[:, None])

    def _grip(self) -> None:
        """Give each wheel the friction of the floor under it."""
        if not self._world.patches:
            return
        friction = self._world.friction_at(self._contacts())
        if not np.array_equal(friction, self._friction):
            self._friction = friction
            self._batch.set_models(self._models())

    def _steps_to_next_patch(self) -> int:
        """Steps in which no wheel can reach the border of a patch, at least one."""
        if not self._world.patches:
            return int(np.iinfo(int).max)
        contacts = self._contacts()
        gap = np.min([patch.distance(contacts) for patch in self._world.patches], axis=(0, 2))
        velocity = self._batch.qvel
        half = np.array([robot.track_width / 2 for robot in self._robots])
        speed = np.hypot(velocity[:, 0], velocity[:, 1]) + np.abs(velocity[:, 5]) * half
        a = _LARGEST_ACCELERATION
        free = (np.sqrt(speed**2 + 2 * a * gap) - speed) / a
        return max(1, int(free.min() / self._physics.timestep))

    def _step(self, steps: int, rates: Array | None) -> tuple[Array, Array | None]:
        """Step the engine; positions (N, S, nq) after each step, and velocities (N, S, nv) for a flow sensor."""
        fields = ("qpos",) if self._flow_sensor is None else ("qpos", "qvel")
        with _quiet_engine():
            control = None if rates is None else np.tile(rates, 2)  # the servos' proportional and integral parts
            states = self._batch.rollout(steps, control=control, record=fields)
        self._watch(states["qpos"])
        return states["qpos"], states.get("qvel")

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

    def _sample(self, states: Array, velocities: Array | None) -> None:
        """Keep what was measured at the sample times; follow the heading and the flow through every step."""
        headings = np.concatenate([self._heading[:, None], _heading(states[..., 3:7])], axis=1)
        headings = np.unwrap(headings, axis=1)
        flow = np.broadcast_to(self._flow[:, None], (*states.shape[:2], 2))
        if self._flow_sensor is not None and velocities is not None:
            step = self._physics.timestep * _flow_velocity(self._flow_sensor, states, velocities, headings)
            flow = flow + np.cumsum(step, axis=1)
        self._flow, self._heading = flow[:, -1], headings[:, -1]
        done, every = self._steps, self._steps_per_sample
        self._steps += states.shape[1]
        picked = np.arange(done + every - done % every, self._steps + 1, every) - done - 1
        if picked.size:
            chosen = states[:, picked]
            poses = np.concatenate([chosen[..., :2], headings[:, picked + 1, None]], axis=-1)
            self._samples.append((chosen[..., self._joints], poses, flow[:, picked]))


def _flow_velocity(sensor: FlowSensor, states: Array, velocities: Array, headings: Array) -> Array:
    """The velocity of a sensor's place over the floor, in its own axes (N, S, 2) [m/s].

    A step moves the robot by its new velocity, which is seen in the mean of the headings before and after it: in one of
    the two, half a step's turn would look like a slide.
    """
    w, x, y, z = np.moveaxis(states[..., 3:7], -1, 0)
    axes = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        ]
    )
    place = np.broadcast_to(np.array([sensor.x, sensor.y, 0.0]), (*states.shape[:2], 3)).copy()
    place[..., 2] = -states[..., 2]  # on the floor
    turning = np.einsum("ijkl,klj->kli", axes, np.cross(velocities[..., 3:6], place))
    mean = (headings[:, :-1] + headings[:, 1:]) / 2
    along = se2.rotate(velocities[..., :2], -mean) + se2.rotate(turning, -headings[:, 1:])
    return se2.rotate(along, -sensor.angle)


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
