"""The least-squares problem of passive wheels: which of their values drives show, and the values that fit best."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from diffdrive_mj._checks import Array
from diffdrive_mj.errors import CalibrationRefused
from diffdrive_mj.sensors.passive_wheels import PassiveWheels

# What a wheel's values are, in this order.
KINDS = ("lever_arm", "radius", "angle")
# Shown is what the drives say within this: of the farthest wheel's distance, of a radius, in radians.
_SHOWN = 0.02
_MOST_ROUNDS, _SETTLED = 30, 1e-6


@dataclass(frozen=True, eq=False)
class Drives:
    """The angles (K, n) of all the wheels on all the drives, the motions (K, 3), and the noise of both.

    Values of the wheels (n, 3) are their lever arms [m], radii [m] and angles [rad].
    """

    angles: Array
    motions: Array
    covariances: Array
    angle_std: Array

    def residuals(self, values: Array) -> Array:
        """What each wheel rolled beyond the law (K, n) [m]."""
        return self.angles * values[:, 1] - self.motions @ _law(values).T

    def derivatives(self, values: Array) -> Array:
        """By the wheel's own values (K, n, 3)."""
        x, y, turn = (np.broadcast_to(column, self.angles.shape) for column in self.motions.T[..., None])
        cos, sin, _ = _law(values).T
        return np.stack([-turn, self.angles, sin * x - cos * y], axis=-1)

    def noise(self, values: Array) -> Array:
        """The covariance of a drive's residuals (K, n, n) [m^2]: a motion's error is in all of them."""
        law = _law(values)
        counted = np.diag((values[:, 1] * self.angle_std) ** 2)
        return law @ self.covariances @ law.T + counted

    def whitened(self, values: Array, of: Array) -> Array:
        """Residuals (K, n), or their derivatives (K, n, P), in their own standard deviations."""
        columns = of.reshape(*of.shape[:2], -1)
        return np.linalg.solve(np.linalg.cholesky(self.noise(values)), columns).reshape(of.shape)


def _law(values: Array) -> Array:
    lever, _, angle = values.T
    return np.stack([np.cos(angle), np.sin(angle), lever], axis=-1)


def scales_of(wheels: PassiveWheels) -> Array:
    """Within what each value must be known to count as shown (n, 3)."""
    spread = max(*(np.hypot(wheel.x, wheel.y) for wheel in wheels.wheels), float(wheels.radii.min()))
    return _SHOWN * np.stack([np.full_like(wheels.radii, spread), wheels.radii, np.ones_like(wheels.radii)], axis=-1)


def shown(drives: Drives, values: Array, scales: Array) -> NDArray[np.bool_]:
    """Which values (n, 3) the drives show: wheel by wheel the surest, then the surest beside that, and so on."""
    std = np.sqrt(np.diagonal(drives.noise(values), axis1=1, axis2=2))
    slopes = np.moveaxis(drives.derivatives(values) / std[..., None] * scales, 1, 0)
    free = np.zeros(values.shape, dtype=np.bool_)
    for wheel, slope in enumerate(slopes):
        seen = np.zeros((len(slope), 0))
        left = slope
        for _ in KINDS:
            # What the chosen ones explain of the others is none of their own.
            left = slope - seen @ np.linalg.lstsq(seen, slope, rcond=None)[0] if seen.size else slope
            sizes = np.where(free[wheel], 0.0, np.linalg.norm(left, axis=0))
            best = int(sizes.argmax())
            if sizes[best] <= 1:
                break
            free[wheel, best] = True
            seen = slope[:, free[wheel]]
    if not free.any():
        raise CalibrationRefused(
            "the drives show nothing of the passive wheels: drive a spin of whole turns and a straight", accept=""
        )
    return free


def solve(drives: Drives, values: Array, free: NDArray[np.bool_]) -> tuple[Array, Array]:
    """The values (n, 3) that fit best, and the covariance (P, P) of the free ones."""
    values = values.copy()
    wheels, kinds = np.nonzero(free)
    for _ in range(_MOST_ROUNDS):
        own = drives.derivatives(values)
        slopes = np.zeros((*drives.angles.shape, len(wheels)))
        slopes[:, wheels, np.arange(len(wheels))] = own[:, wheels, kinds]
        slopes = drives.whitened(values, slopes).reshape(-1, len(wheels))
        step, *_ = np.linalg.lstsq(slopes, -drives.whitened(values, drives.residuals(values)).ravel(), rcond=None)
        values[free] += step
        size = np.linalg.norm(slopes, axis=0)
        # In the deviations that the drives leave.
        if np.abs(step * size).max() < _SETTLED:
            break
    else:
        raise CalibrationRefused(
            "no mounting of the passive wheels explains the readings: does one count backwards, is their order "
            "another, or a drive not as stated?",
            accept="",
        )
    return values, np.linalg.inv((slopes / size).T @ (slopes / size)) / np.outer(size, size)
