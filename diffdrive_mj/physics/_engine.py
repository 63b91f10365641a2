"""Many robots in MuJoCo's batch engine, stepped together, watched and sampled.

What is the same for all the runs, a push, changes between two calls of the engine. What each run meets by itself, the
floor under its wheels, is run ahead of: a run whose floor changes goes back to that step and on from there with the new
friction, while the others keep what they have. How a drive is cut into calls does not change a bit of it.
"""

from __future__ import annotations

import copy
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from diffdrive_mj._checks import Array
from diffdrive_mj.errors import SimulationDiverged
from diffdrive_mj.physics._disturbances import Floor, Pushes
from diffdrive_mj.physics._motion import Motion, heading
from diffdrive_mj.physics._mujoco import Batch, SimulationError, mujoco
from diffdrive_mj.physics._standing import refuse_start
from diffdrive_mj.physics._windup import Windup
from diffdrive_mj.physics.effects.casters import one_kind
from diffdrive_mj.physics.limits import refuse_to_slide
from diffdrive_mj.physics.model import compile_model, pairs_of
from diffdrive_mj.physics.servo import wound_up
from diffdrive_mj.robot import Robot
from diffdrive_mj.solver import Physics
from diffdrive_mj.world import World

# Steps of all the runs together in one call: it bounds memory, and less would make calls dear.
STEPS_PER_CALL = 40_000
_STATE = int(mujoco.mjtState.mjSTATE_INTEGRATION)
# How far a run goes ahead where the floor may change [steps].
_NEAREST, _FARTHEST = 4, 1024
# The engine's warnings in words, by their kind (mjtWarning).
_WARNINGS = (
    "an inertia matrix is near singular",
    "there is no memory for all the contacts",
    "there is no memory for all the constraints",
    "a position is not finite or too large",
    "a velocity is not finite or too large",
    "an acceleration is not finite or too large",
    "a command is not finite",
)


class Engine:
    """The batch of simulations and how far they have come.

    Args:
        robots: true robots, N.
        world: floor and disturbances.
        physics: how it is solved.
        start: (N, 3) [m, m, rad].
        threads: 0 for all cores.

    Attributes:
        models: of the robots, all of one layout.
        model: of the first robot.
        rest: (N, nq), the positions at time zero.
        steps: taken so far.
        motion: where the robots were when last `follow` was called.
        windup: motors that have limits; None if none has.
    """

    def __init__(self, robots: Sequence[Robot], world: World, physics: Physics, start: Array, threads: int) -> None:
        one_kind(robots)
        self._robots, self._physics = robots, physics
        self._pushes = Pushes(world.pushes, physics.timestep)
        self._floor = Floor(world, robots, start) if world.patches else None
        self.models = [compile_model(robot, physics, world) for robot in robots]
        if self._floor is not None:
            self.models = [copy.copy(model) for model in self.models]  # the compiled ones are shared
        self.model, self.windup = self.models[0], Windup.of(self.models)
        left, right = (int(self.model.joint(side).qposadr[0]) for side in ("left", "right"))
        self._joints = slice(left, right + 1)  # neighbours
        self._fork = int(self.model.joint("caster_fork").qposadr[0]) if robots[0].caster.kind == "swivel" else None
        self._fork_angles = np.array([robot.caster.angle for robot in robots])
        self._dofs = [int(self.model.joint(side).dofadr[0]) for side in ("left", "right")]
        self._pairs = [pairs_of(self.model, f"{side}_tyre") for side in ("left", "right")]
        self._body = int(self.model.body("robot").id)
        self._masses = np.array([float(model.body_subtreemass[self._body]) for model in self.models])
        self._friction = np.full((len(robots), 2), world.friction)
        self._ahead = _FARTHEST // 16
        self._batch = Batch(self.model, nsim=len(robots), nthread=threads)
        self._batch.set_models(self.models)
        # Views of the state; asking the batch for them anew costs as much as a step.
        self._qpos, self._ctrl = self._batch.qpos, self._batch.ctrl
        self._qpos[:] = np.stack([model.qpos0 for model in self.models])
        # What lies on the floor lies somewhere; on a floor that is the same everywhere all start at the origin.
        self._place = start[:, :2] if world.cables or world.rough else np.zeros((len(robots), 2))
        self._qpos[:, :2] = self._place
        self._settle(start[:, 2], round(physics.settle_time / physics.timestep))
        if world.slope is not None and world.slope.angle:
            leads = [
                wound_up(robot, physics, world, at) for robot, at in zip(robots, start[:, 2].tolist(), strict=True)
            ]
            self._batch.act[:] = np.stack(leads)
        self.rest = np.array(self._qpos)
        refuse_start(world, robots, self.models, self.rest)
        self.steps = 0
        self.motion = self._over = Motion.begin(self.rest, start[:, 2])
        if self._floor is not None:
            everyone = np.arange(len(robots))
            self._grip(everyone, self._floor.friction(self.motion.poses[:, None], everyone)[:, 0])
        refuse_to_slide(robots, world, start[:, 2], self._friction)

    def angles(self) -> Array:
        """The wheel angles now (N, 2) [rad]."""
        return self._qpos[:, self._joints].copy()

    def joint_angles(self, states: Array) -> Array:
        """The wheel angles (..., 2) [rad] in positions (..., nq)."""
        return states[..., self._joints]

    def caster_angles(self, states: Array) -> Array | None:
        """Where the casters' forks point (N, S) [rad] in positions (N, S, nq); None for balls."""
        return None if self._fork is None else self._fork_angles[:, None] + states[..., self._fork]

    def hold(self, rates: Array, steps: int) -> tuple[Array, Array, Array]:
        """Take some steps at constant rates (N, 2) [rad/s]; what `advance` returns."""
        if self._pushes or self._floor is not None or self.windup is not None:
            return self.advance(np.repeat(rates[:, None], steps, axis=1))
        self._ctrl[:, :2] = self._ctrl[:, 2:] = rates
        return self._roll(steps, None)

    def advance(self, rates: Array) -> tuple[Array, Array, Array]:
        """Take some steps.

        Args:
            rates: (N, S, 2) [rad/s], one row a step.

        Returns:
            Positions after each step (N, S, nq), sensors at its beginning (N, S, nsensordata), and the friction under
            the left and the right wheel (N, S, 2).
        """
        control = np.tile(rates, 2)  # the servos' proportional and integral parts
        pieces, done = [], 0
        while done < control.shape[1]:
            steps = control.shape[1] - done
            if self._pushes:
                acceleration = self._pushes.acceleration(self.steps)
                self._batch.xfrc_applied[:, self._body, :3] = self._masses[:, None] * acceleration
                steps = min(steps, self._pushes.steps_to_change(self.steps) or steps)
            if self.windup is not None:
                steps = min(steps, self.windup.steps_to_look(self.steps))
            piece = control[:, done : done + steps]
            pieces.append(self._roll(steps, piece) if self._floor is None else self._cross(self._floor, piece))
            done += steps
            if self.windup is not None:
                self._batch.act[:] = self.windup.trimmed(
                    self.steps, piece[:, -1, :2], self.angles(), self._batch.qvel[:, self._dofs], self._batch.act
                )
        if len(pieces) == 1:
            return pieces[0]
        states, sensors, friction = (np.concatenate(parts, axis=1) for parts in zip(*pieces, strict=True))
        return states, sensors, friction

    def follow(self, states: Array) -> Array:
        """The true poses (N, S + 1, 3) before, between and after the steps that `advance` has returned last."""
        begin = self.motion.poses[:, None]
        poses = self.motion.follow(states, self._physics)
        self.motion = self.motion.after(states[:, -1], poses[:, -1])
        return np.concatenate([begin, poses], axis=1)

    def refuse_divergence(self, states: Array) -> None:
        """Turn the engine's warnings, and what it should have warned of, into an error."""
        warned = self._batch.warning[:, :, 1] > 0  # how often, by kind
        broken = warned.any(axis=1) | ~np.isfinite(states).all(axis=(1, 2))
        if not broken.any():
            return
        run = int(np.argmax(broken))
        kinds = np.flatnonzero(warned[run])
        reason = _WARNINGS[int(kinds[0])] if kinds.size else "the state is not finite"
        t = float(self._batch.time[run]) - self._settled_at
        diverged = SimulationDiverged(
            f"robot {run} ({self._robots[run].name}) diverged at t = {t:.4g} s: {reason}; a smaller Physics.timestep "
            "or a softer servo may hold it"
        )
        diverged.runs = tuple(np.flatnonzero(broken).tolist())
        raise diverged

    def _roll(self, steps: int, control: Array | None) -> tuple[Array, Array, Array]:
        try:
            out = self._batch.rollout(steps, control=control, record=("qpos", "sensordata"))
        except SimulationError as error:
            raise SimulationDiverged(str(error)) from None
        self.steps += steps
        friction = np.broadcast_to(self._friction.copy()[:, None], (len(self._friction), steps, 2))
        return out["qpos"], out["sensordata"], friction

    def _cross(self, floor: Floor, control: Array) -> tuple[Array, Array, Array]:
        """Steps over a floor whose friction changes with the place, each run up to its own next change."""
        count, steps = control.shape[:2]
        states = np.empty((count, steps, self.model.nq))
        sensors = np.empty((count, steps, self.model.nsensordata))
        friction = np.empty((count, steps, 2))
        done = np.zeros(count, dtype=np.intp)
        while (done < steps).any():
            runs = np.flatnonzero(done < steps)
            ahead = int(min(self._ahead, (steps - done[runs]).max()))
            rows = done[runs, None] + np.arange(ahead)
            asked = control[runs[:, None], np.minimum(rows, steps - 1)]
            out = self._batch.rollout(ahead, control=asked, record=("qpos", "sensordata", _STATE), ids=runs)
            before = self._over.of(runs)
            poses = before.follow(out["qpos"], self._physics)
            met = floor.friction(poses, runs)
            changed = (met != self._friction[runs, None]).any(axis=-1)
            taken = np.where(changed.any(axis=1), changed.argmax(axis=1) + 1, ahead)
            taken = np.minimum(taken, steps - done[runs])
            kept = np.arange(ahead) < taken[:, None]
            where = np.broadcast_to(runs[:, None], kept.shape)[kept], rows[kept]
            states[where], sensors[where] = out["qpos"][kept], out["sensordata"][kept]
            friction[where] = np.broadcast_to(self._friction[runs, None], (*kept.shape, 2))[kept]
            each, last = np.arange(len(runs)), taken - 1
            self._batch.state[runs] = out[_STATE][each, last]
            self._over = self._over.replaced(runs, before.after(out["qpos"][each, last], poses[each, last]))
            done[runs] += taken
            new = changed[each, last]
            self._grip(runs[new], met[each, last][new])
            self._ahead = int(np.clip(2 * ahead if (taken == ahead).all() else 1.5 * taken.mean(), _NEAREST, _FARTHEST))
        self.steps += steps
        return states, sensors, friction

    def _grip(self, runs: NDArray[np.intp], friction: Array) -> None:
        """Give the wheels of some runs the friction (n, 2) of the floor under them."""
        if not runs.size:
            return
        self._friction[runs] = friction
        for run, (left, right) in zip(runs.tolist(), friction.tolist(), strict=True):
            for pairs, coefficient in zip(self._pairs, (left, right), strict=True):
                self.models[run].pair_friction[pairs, :2] = coefficient
        self._batch.set_models(self.models)

    def _settle(self, headings: Array, steps: int) -> None:
        """Let the robots come to rest on the floor, then turn them to their headings, wheels at zero."""
        self._turn(headings)
        if steps:
            self._batch.rollout(steps)
            self._qpos[:, :2] = self._place
            self._qpos[:, self._joints] = 0
            self._turn(headings)
            self._batch.qvel[:] = 0
            self._batch.act[:] = 0
        self._settled_at = float(self._batch.time[0])

    def _turn(self, headings: Array) -> None:
        """Turn the robots in the plane; height, roll and pitch stay."""
        quaternions = self._qpos[:, 3:7]
        half = (headings - heading(quaternions)) / 2
        w, z = np.cos(half), np.sin(half)
        a, b, c, d = quaternions.T.copy()
        quaternions[:] = np.stack([w * a - z * d, w * b - z * c, w * c + z * b, w * d + z * a], axis=-1)
