"""Arc odometry in 50-digit arithmetic: what every odometry of double precision is held against."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import mpmath
import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj._checks import Array
from diffdrive_mj.robot import Robot

DIGITS = 50


def exact_poses(
    wheels: ArrayLike, robot: Robot, start: Sequence[float], *, in_ticks: bool = False, bits: int | None = None
) -> Array:
    """Compute the poses along readings that all count, each right to the last digit of a float64.

    ```
    turn = (r_r phi_r - r_l phi_l) / b        distance = (r_l phi_l + r_r phi_r) / 2
    x += distance sinc(turn / 2) cos(theta + turn / 2)        theta += turn
    ```

    Args:
        wheels: (K, 2) as read, left then right: radians, or ticks that may wrap.
        robot: whose radii, track width and encoder are taken for exact, as the float64 that they are.
        start: (3,) [m, m, rad], the pose at the first reading.
        in_ticks: whether the wheels are in ticks.
        bits: of the counters; None if they do not wrap.

    Returns:
        (K, 3) [m, m, rad], rounded once.

    Example:
        A quarter of a circle of radius 1 m:

        >>> robot = dd.Robot(left_radius=0.5, right_radius=0.5, track_width=1.0)
        >>> exact_poses([(0.0, 0.0), (np.pi / 2, 3 * np.pi / 2)], robot, (0.0, 0.0, 0.0))[-1].round(12).tolist()
        [1.0, 1.0, 1.570796326795]
    """
    rows = np.asarray(wheels).tolist()
    with mpmath.workdps(DIGITS):
        tick = 2 * mpmath.pi / mpmath.mpf(robot.encoder.ticks_per_wheel_turn) if in_ticks else mpmath.mpf(1)
        radii = [tick * mpmath.mpf(radius) for radius in (robot.left_radius, robot.right_radius)]
        x, y, theta = map(mpmath.mpf, start)
        poses = [(float(x), float(y), float(theta))]
        for before, after in itertools.pairwise(rows):
            left, right = (
                r * _step(mpmath.mpf(new) - mpmath.mpf(old), bits)
                for r, new, old in zip(radii, after, before, strict=True)
            )
            half = (right - left) / mpmath.mpf(robot.track_width) / 2
            chord = (left + right) / 2 * (mpmath.sin(half) / half if half else 1)
            cosine, sine = mpmath.cos_sin(theta + half)
            x, y, theta = x + chord * cosine, y + chord * sine, theta + 2 * half
            poses.append((float(x), float(y), float(theta)))
    return np.array(poses)


def _step(ticks: mpmath.mpf, bits: int | None) -> mpmath.mpf:
    """The shortest step of a counter of some bits: in [-2^(bits - 1), 2^(bits - 1))."""
    if bits is None:
        return ticks
    half = 2 ** (bits - 1)
    return (ticks + half) % (2 * half) - half
