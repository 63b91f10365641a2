"""How far the tyres slide over the floor, read where they touch it.

A point of the tyre moves with the body and turns with the wheel. Over a step that moves the body by dp and turns it by
w, in its own axes, and the wheel by dphi about its axle e, the point at the arm a from the hub h moves by

    slip = R' dp + w x (h + a) + dphi e x a

with R the attitude before the step, where the contacts take out the slip of the new velocity. All of it is the engine's
own, its positions and the geometry of the compiled model: no radius, track width or pose of an odometry enters. Where
friction damping leaves part of the slip to later steps, and recorded poses lead the engine's by it (`_motion.lead`), dp
is turned by as much.

A robot with skid steer has two wheels a side. The mean of their slips is that of the side: it is how the middle between
them moves over the floor beyond what the wheels roll.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from diffdrive_mj._checks import Array
from diffdrive_mj.physics._motion import heading, lead
from diffdrive_mj.physics._mujoco import mujoco
from diffdrive_mj.physics._probes import Steps, vertical
from diffdrive_mj.solver import Physics


class SlipProbe:
    """How far the lowest points of the tyres have slid, forward and to the left in the robot's axes.

    Args:
        models: of the robots, N.
        physics: how they are solved.
        rest: (N, nq), the engine's positions before the first step.

    Attributes:
        reading: (N, 2, 2) [m], of the left and the right side so far.
        travel: (N, S, 2) [m], how far the tyres slid in each of the steps read last, whichever way: of each side the
            tyre that slid farther.
    """

    travel: Array

    def __init__(self, models: Sequence[mujoco.MjModel], physics: Physics, rest: Array) -> None:
        first = models[0]
        names = [first.joint(number).name for number in range(first.njnt)]
        # Front wheels, with skid steer the rear ones, each left before right.
        names = [name for name in ("left", "right", "left_rear", "right_rear") if name in names]
        self._angles = [int(first.joint(name).qposadr[0]) for name in names]
        tyres = [first.geom(f"{name}_tyre").id for name in names]
        wheels = [first.body(f"{name}_wheel").id for name in names]
        self._radii, self._crowns = np.array([model.geom_size[tyres, :2] for model in models]).T[..., None]
        # A cylinder touches along its width, for which the middle stands.
        crowned = np.array([model.geom_type[tyres] == mujoco.mjtGeom.mjGEOM_ELLIPSOID for model in models])
        self._crowns = np.where(crowned.T[..., None], self._crowns, 0.0)
        self._hubs = np.array([model.body_pos[wheels] for model in models]).transpose(1, 2, 0)[..., None]
        self._turned_on = 0.5 - lead(physics)
        self._before, self.reading = rest[:, None], np.zeros((len(models), 2, 2))

    def skip(self, steps: Steps) -> None:
        """Let steps go by in which nothing slips."""
        self._before = steps.states[:, -1:].copy()

    def read(self, steps: Steps) -> Array:
        """The slip after each of the steps (N, S, 2, 2) [m]: of the left and the right side; forward, to the left."""
        states = np.moveaxis(np.concatenate([self._before, steps.states], axis=1), -1, 0).copy()
        self.skip(steps)
        turn = _turn(states[3:7])
        up = np.moveaxis(vertical(np.moveaxis(states[3:7, :, :-1], 0, -1)), -1, 0).copy()
        forward, left = _along_the_floor(up)
        moved = _moved(states, self._turned_on * (up * turn).sum(axis=0))
        slid = np.empty((*moved.shape[1:], len(self._angles), 2))
        for wheel, column in enumerate(self._angles):
            arm = _lowest(up, self._radii[wheel], self._crowns[wheel])
            spun = np.diff(states[column], axis=-1)
            by_turning = _cross(turn, self._hubs[wheel] + arm)
            by_turning[0] += spun * arm[2]
            by_turning[2] -= spun * arm[0]
            slid[..., wheel, 0] = moved[0] + (forward * by_turning).sum(axis=0)
            slid[..., wheel, 1] = moved[1] + (left * by_turning).sum(axis=0)
        by_axle = slid.reshape(*slid.shape[:2], -1, 2, 2)
        self.travel = np.linalg.norm(by_axle, axis=-1).max(axis=2)
        slip = np.cumsum(np.concatenate([self.reading[:, None], by_axle.mean(axis=2)], axis=1), axis=1)[:, 1:]
        self.reading = slip[:, -1].copy()
        return slip


class SlideProbe:
    """How far tyres have slid in all, whichever way, while they had lost their grip; and their slip, if it is recorded.

    Args:
        slip: that nobody else reads.
        recorded: whether the slip of every step is wanted, and not only of those in which a wheel has no grip.

    Attributes:
        slide: (N, 2) [m], of the left and the right wheel.
    """

    def __init__(self, slip: SlipProbe, recorded: bool) -> None:
        self._slip, self._recorded = slip, recorded
        self.slide = np.zeros(slip.reading.shape[:2])

    @property
    def reading(self) -> dict[str, Array]:
        """The slip so far (N, 2, 2) [m] by the name of a recording's field, if it is recorded."""
        return {"slip": self._slip.reading} if self._recorded else {}

    def read(self, steps: Steps, slipping: NDArray[np.bool_]) -> dict[str, Array]:
        """Add up the slip in those of the steps (N, S, 2) in which a wheel has no grip; each comes once, in order.

        Returns:
            The slip after each of the steps (N, S, 2, 2) [m], as `reading` has it.
        """
        if not (self._recorded or slipping.any()):
            self._slip.skip(steps)
            return {}
        slip = self._slip.read(steps)
        self.slide += (self._slip.travel * slipping).sum(axis=1)
        return {"slip": slip} if self._recorded else {}


def _turn(attitudes: Array) -> Array:
    """The rotation vectors (3, N, S) in the body's axes, from each of some attitudes (4, N, S + 1) to the next."""
    (w, *before), (a, *after) = attitudes[..., :-1], attitudes[..., 1:]
    part = w * np.array(after) - a * np.array(before) - _cross(np.array(before), np.array(after))
    half = np.arcsin(np.minimum(np.sqrt((part * part).sum(axis=0)), 1.0))
    return part * (2 / np.sinc(half / np.pi))


def _along_the_floor(up: Array) -> tuple[Array, Array]:
    """The directions forward and to the left along the floor (3, N, S), in the body's axes."""
    x, y, z = up
    level = np.sqrt(y * y + z * z)
    return np.array([level, -x * y / level, -x * z / level]), np.array([np.zeros_like(x), z / level, -y / level])


def _moved(states: Array, turned_on: Array) -> Array:
    """How far the engine moved the body, forward and to the left (2, N, S), seen when it had turned on by an angle."""
    direction = heading(np.moveaxis(states[3:7, :, :-1], 0, -1)) + turned_on
    cos, sin = np.cos(direction), np.sin(direction)
    dx, dy = np.diff(states[:2], axis=-1)
    return np.array([cos * dx + sin * dy, cos * dy - sin * dx])


def _lowest(up: Array, radius: Array, crown: Array) -> Array:
    """Where an ellipsoid, its semi-axes the radius, the crown across and the radius, is lowest, from its centre."""
    squares = np.array([radius**2, crown**2, radius**2])
    return -squares * up / np.sqrt((squares * up * up).sum(axis=0))


def _cross(a: Array, b: Array) -> Array:
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
