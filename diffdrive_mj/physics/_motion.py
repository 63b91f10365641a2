"""The true pose from the engine's steps.

MuJoCo's Euler step moves a body by its new velocity,

    p' = p + v' dt,    theta' = theta + omega' dt

and the contacts have made that velocity free of sideways slip for the heading before the step, up to the part of the
slip that friction damping leaves: a body that turns by dtheta a step lags by 1 / friction_damping steps. A step's
displacement thus points along the heading theta + dtheta (1 - 1 / friction_damping), where the mean heading theta +
dtheta / 2 would be right to second order. Turning it there,

    p' = p + R((1 / friction_damping - 1/2) dtheta) v' dt

puts the midpoint rule in the place of Euler's. Nothing but the engine's own positions and headings enters: a wheel that
slides takes the pose with it, whatever its angle says. While a robot slides or flies nothing holds its displacement to
its heading, and this is off by up to dtheta / 2; `Physics(truth="engine")` leaves it out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from diffdrive_mj._checks import Array
from diffdrive_mj.solver import Physics


def heading(quaternion: Array) -> Array:
    """The direction of the body's x axis on the floor (...) [rad], of quaternions (..., 4) w first."""
    w, x, y, z = np.moveaxis(quaternion, -1, 0).copy()  # through contiguous memory
    return np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


def lead(physics: Physics) -> float:
    """By what part of a step's turn the recorded pose turns the engine's displacement."""
    if physics.truth == "engine":
        return 0.0
    assert physics.friction_damping is not None
    return 1 / physics.friction_damping - 0.5


@dataclass(frozen=True)
class Motion:
    """Where some robots are, in the engine's coordinates and in truth, both from the place of the start.

    Attributes:
        engine: (N, 2) [m], the engine's position.
        direction: (N,) [rad], the engine's heading on the circle.
        turns: (N,) whole turns to add to it.
        position: (N, 2) [m], the true one.
    """

    engine: Array
    direction: Array
    turns: Array
    position: Array

    @classmethod
    def begin(cls, states: Array, start_heading: Array) -> Motion:
        """At the start, from the engine's positions (N, nq)."""
        direction = heading(states[:, 3:7])
        turns = np.round((start_heading - direction) / (2 * np.pi))
        return cls(states[:, :2].copy(), direction, turns, np.zeros((len(states), 2)))

    @property
    def poses(self) -> Array:
        """(N, 3) [m, m, rad]."""
        return np.concatenate([self.position, (self.direction + 2 * np.pi * self.turns)[:, None]], axis=-1)

    def follow(self, states: Array, physics: Physics) -> Array:
        """The true poses (N, S, 3) after each of some steps, from the engine's positions (N, S, nq).

        How many steps come at once does not change a bit of them.
        """
        count, steps = states.shape[:2]
        direction = np.empty((count, steps + 1))
        direction[:, 0], direction[:, 1:] = self.direction, heading(states[..., 3:7])
        change = direction[:, 1:] - direction[:, :-1]
        wraps = np.round(change / (2 * np.pi))
        turns = self.turns[:, None] - np.cumsum(wraps, axis=1)
        # The sums begin with where they left off: they run in the order of the steps, whatever their number.
        sums = np.empty((2, count, steps + 1))
        for axis, coordinate in enumerate(sums):
            coordinate[:, 0] = self.position[:, axis]
            coordinate[:, 1] = states[:, 0, axis] - self.engine[:, axis]
            coordinate[:, 2:] = states[:, 1:, axis] - states[:, :-1, axis]
        if part := lead(physics):
            ahead = part * (change - 2 * np.pi * wraps)
            cos, sin = np.cos(ahead), np.sin(ahead)
            x, y = sums[0, :, 1:].copy(), sums[1, :, 1:]
            sums[0, :, 1:] = cos * x - sin * y
            sums[1, :, 1:] = sin * x + cos * y
        poses = np.empty((count, steps, 3))
        np.cumsum(sums[0], axis=1, out=sums[0])
        np.cumsum(sums[1], axis=1, out=sums[1])
        poses[..., 0], poses[..., 1] = sums[:, :, 1:]
        poses[..., 2] = direction[:, 1:] + 2 * np.pi * turns
        return poses

    def after(self, states: Array, poses: Array) -> Motion:
        """After steps that ended in engine states (N, nq) and at true poses (N, 3)."""
        direction = heading(states[:, 3:7])
        turns = np.round((poses[:, 2] - direction) / (2 * np.pi))
        return Motion(states[:, :2].copy(), direction, turns, poses[:, :2].copy())

    def of(self, runs: NDArray[np.intp]) -> Motion:
        """Some of the robots."""
        return Motion(self.engine[runs], self.direction[runs], self.turns[runs], self.position[runs])

    def replaced(self, runs: NDArray[np.intp], new: Motion) -> Motion:
        """The same with some of the robots elsewhere."""
        fields = ("engine", "direction", "turns", "position")
        values = {field: getattr(self, field).copy() for field in fields}
        for field, value in values.items():
            value[runs] = getattr(new, field)
        return Motion(**values)
