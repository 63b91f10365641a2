"""What is read off the engine's steps while a drive runs: grip, standing, and sensors of the motion.

A probe sees every step once, in order. A new sensor of the motion is a new `MotionProbe`; all of them read the true
poses, which are the corrected ones, so that no two of them see another motion.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from diffdrive_mj import se2
from diffdrive_mj._checks import Array
from diffdrive_mj.grip import LARGEST_USE, Grip
from diffdrive_mj.physics._mujoco import mujoco
from diffdrive_mj.physics.effects._terrain import GROUNDED

# Contacts whose forces are recorded; the sensors of `models/diffdrive.xml` bear these names.
CHASSIS = "chassis_contact"
# For how long a contact on terrain may carry nothing without being off the floor [s].
_FLICKER = 0.01
_LARGEST_TILT = math.radians(30)
# More than a tilt is off by rounding [rad].
_ROUNDING = 1e-6
# How far above its rest a robot has left the world [m].
_HIGHEST = 5.0


@dataclass(frozen=True)
class Steps:
    """Some steps of all the runs together.

    Attributes:
        time: (S,) [s], at the end of each step.
        states: (N, S, nq), the engine's positions after each step.
        forces: (N, S, nsensordata), its sensors, as of the step's beginning.
        friction: (N, S, 2), coefficients under the left and the right wheel.
        poses: (N, S + 1, 3) [m, m, rad], the true poses before, between and after the steps.
    """

    time: Array
    states: Array
    forces: Array
    friction: Array
    poses: Array


class Probe(Protocol):
    """What looks at every step."""

    def read(self, steps: Steps) -> None:
        """Take in some steps; each comes once, in order."""


class MotionProbe(Protocol):
    """A sensor of the motion: what it has read since the start, sampled into a recording.

    Attributes:
        reading: (N, ...), after the steps read so far.
    """

    reading: Array

    def read(self, steps: Steps) -> Array:
        """Its reading after each of some steps (N, S, ...); each comes once, in order."""


class _Window:
    """Sums over the last steps, whatever pieces they come in; before the first step all was as in it."""

    def __init__(self, steps: int) -> None:
        self._steps = steps
        self._before: Array | None = None

    def sums(self, values: Array) -> Array:
        """The sums (..., S) that end at each of some steps."""
        if self._steps == 1:
            return values
        if self._steps == 2:  # nothing is copied
            total = np.empty_like(values)
            np.add(values[..., 0] if self._before is None else self._before[..., 0], values[..., 0], out=total[..., 0])
            np.add(values[..., :-1], values[..., 1:], out=total[..., 1:])
            self._before = values[..., -1:].copy()
            return total
        before = values[..., :1].repeat(self._steps - 1, axis=-1) if self._before is None else self._before
        known = np.concatenate([before, values], axis=-1)
        count = values.shape[-1]
        self._before = known[..., count:].copy()
        total = known[..., :count] + known[..., 1 : count + 1]
        for first in range(2, self._steps):
            total += known[..., first : first + count]
        return total


class GripProbe:
    """How much of their friction the wheels use, and whether a contact leaves the floor.

    The share is |T| / (mu N) with the tangential force T and the load N, both as means over two steps, and as sums over
    all that a wheel touches. Where things lie on the floor, a wheel that rolls from one facet or edge to the next loses
    touch for a step or two: there, what carries nothing for less than 10 ms is not off the floor.

    Attributes:
        slipping: (N, S, 2), which wheels used all of their friction, or carried nothing, in the steps read last.
    """

    slipping: NDArray[np.bool_]

    def __init__(self, model: mujoco.MjModel, count: int) -> None:
        sensors = [model.sensor(k) for k in range(model.nsensor)]
        forces = {one.name: slice(int(one.adr[0]), int(one.adr[0] + one.dim[0])) for one in sensors}
        names = [name for name in forces if name.endswith("_contact") and name != CHASSIS]
        # The front wheels, with skid steer the rear wheels, each left before right; then the caster.
        wheels = [name for name in names if name.startswith(("left", "right"))]
        self._wheels = len(wheels)
        self._columns = [forces[name] for name in (*wheels, *sorted({*names} - {*wheels}))]
        self._chassis = forces[GROUNDED].start if GROUNDED in forces else None
        steps = math.ceil(_FLICKER / model.opt.timestep) if GROUNDED in forces else 1
        self._pulls, self._holds, self._loads = _Window(2), _Window(2), _Window(steps)
        self._use = np.zeros((count, 2))
        self._use_time = np.zeros((count, 2))
        self._lift_time = np.full(count, np.nan)
        self._grounded_time = np.full(count, np.nan)

    def read(self, steps: Steps) -> None:
        """Keep the largest share and when it was, and the first time that a contact carried nothing."""
        # One row a contact: all that follows then runs through contiguous memory.
        touched = [steps.forces[..., columns] for columns in self._columns]
        load = np.array([_total(force, 0) for force in touched])
        pull = self._pulls.sums(np.array([_total(force, 1, 2) for force in touched[: self._wheels]]))
        hold = np.empty_like(pull)
        for wheel in range(self._wheels):
            np.multiply(load[wheel], steps.friction[..., wheel % 2], out=hold[wheel])
        hold = self._holds.sums(hold)
        grounded = hold.min() > 0  # all the time, as nearly always
        use = pull / hold if grounded else np.divide(pull, hold, out=np.zeros_like(pull), where=hold > 0)
        if self._wheels > 2:  # front and rear, each left before right
            use = use.reshape(-1, 2, *use.shape[1:]).max(axis=0)
        largest = use.max(axis=-1)
        if grounded and not (largest > LARGEST_USE).any():
            self.slipping = np.zeros((*steps.forces.shape[:2], 2), dtype=bool)
        else:
            free = (hold <= 0).reshape(-1, 2, *use.shape[1:]).any(axis=0)
            self.slipping = np.ascontiguousarray(np.moveaxis((use > LARGEST_USE) | free, 0, -1))
        for side, run in zip(*np.nonzero(largest > self._use.T), strict=True):
            self._use[run, side] = largest[side, run]
            self._use_time[run, side] = steps.time[use[side, run].argmax()]
        loads = self._loads.sums(load)
        if loads.min() <= 0:
            self._lift_time = _first(self._lift_time, np.any(loads <= 0, axis=0), steps.time)
        if self._chassis is not None:
            self._grounded_time = _first(self._grounded_time, steps.forces[..., self._chassis] > 0, steps.time)

    def grip(self, fall_time: Array, stuck_time: Array, edge_time: Array) -> Grip:
        """What was read, with when each robot fell, got stuck and left the rough floor (nan: it did not)."""
        times = (self._lift_time, fall_time, stuck_time, edge_time, self._grounded_time)
        return Grip(self._use, self._use_time, *times)


class FallProbe:
    """Whether the robots stay up: none tilts by more than 30 degrees, lies on its chassis or flies away."""

    def __init__(self, model: mujoco.MjModel, rest: Array) -> None:
        self._chassis = int(model.sensor(CHASSIS).adr[0])
        self._up, self._height = vertical(rest[:, 3:7]), rest[:, 2]
        self._leaning = math.acos(float(np.clip(self._up[:, 2].min(), -1.0, 1.0)))
        self.time = np.full(len(rest), np.nan)
        self.how = [""] * len(rest)

    def read(self, steps: Steps) -> None:
        """Keep the first time at which each robot has fallen, and what it looked like."""
        if self._upright(steps):
            return
        quaternions = np.moveaxis(steps.states[..., 3:7], -1, 0).copy()
        tilt = sum(part * up[:, None] for part, up in zip(_vertical(*quaternions), self._up.T, strict=True))
        signs = {
            "tilts by more than 30 degrees": tilt < math.cos(_LARGEST_TILT),
            "lies on its chassis": steps.forces[..., self._chassis] > 0,
            "has left the floor for good": steps.states[..., 2] > self._height[:, None] + _HIGHEST,
        }
        for how, seen in signs.items():
            for run in np.flatnonzero(seen.any(axis=1)).tolist():
                time = float(steps.time[seen[run].argmax()])
                if not self.time[run] <= time:
                    self.time[run], self.how[run] = time, how

    def _upright(self, steps: Steps) -> bool:
        """Whether no robot can have fallen: a tilt is at most that from level and that of the rest together.

        The vertical's last coordinate is the cosine of the tilt, 1 - 2 (x^2 + y^2).
        """
        x, y = steps.states[..., 4], steps.states[..., 5]
        tilted = math.acos(1 - 2 * min(float((x * x + y * y).max()), 1.0)) + self._leaning
        low = bool((steps.states[..., 2].max(axis=1) <= self._height + _HIGHEST).all())
        return tilted < _LARGEST_TILT - _ROUNDING and low and not steps.forces[..., self._chassis].max() > 0


class TwistProbe:
    """A sensor of the motion whose reading is a sum: of what it sees of each step, along which the twist is constant.

    Args:
        seen: what it sees (..., K) of steps (..., 3): ahead [m], to the left [m], turn [rad].
        count: of robots.
    """

    def __init__(self, seen: Callable[[Array], Array], count: int) -> None:
        self._seen = seen
        self.reading = np.zeros_like(seen(np.zeros((count, 3))))

    def read(self, steps: Steps) -> Array:
        """The sum after each of the steps (N, S, K)."""
        seen = self._seen(se2.log(se2.between(steps.poses[:, :-1], steps.poses[:, 1:])))
        sums = np.cumsum(np.concatenate([self.reading[:, None], seen], axis=1), axis=1)[:, 1:]
        self.reading = sums[:, -1].copy()
        return sums


def _total(forces: Array, *axes: int) -> Array:
    """The sizes of some contacts' forces (..., 3 n) along one axis or in a plane, added up (...)."""
    parts = [forces[..., axis::3] for axis in axes]
    if forces.shape[-1] == 3:
        parts = [part[..., 0] for part in parts]
        return parts[0] if len(parts) == 1 else np.hypot(*parts)
    total: Array = (parts[0] if len(parts) == 1 else np.hypot(*parts)).sum(axis=-1)
    return total


def _first(known: Array, seen: NDArray[np.bool_], time: Array) -> Array:
    """When each run first saw something (N,), of what was known before and of some steps (N, S)."""
    found = np.where(seen.any(axis=1), time[seen.argmax(axis=1)], np.nan)
    return np.where(np.isnan(known), found, known)


def vertical(quaternions: Array) -> Array:
    """The world's vertical in the body's axes (..., 3), which does not depend on the heading."""
    return np.stack(_vertical(*np.moveaxis(quaternions, -1, 0)), axis=-1)


def _vertical(w: Array, x: Array, y: Array, z: Array) -> tuple[Array, Array, Array]:
    """The same by its components (...)."""
    return 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)
