"""What reading the wheels can add to a drift at most: whole ticks, and rates that change between two samples.

A wheel's rim is off by x_l, x_r where it is read, or between two readings. Along the path that moves the robot by
s = (x_l + x_r) / 2 and turns it by e = (x_r - x_l) / b,

```
what is added = integral of e^(i theta) (i e dp + ds) + rest
|rest| <= integral of |dp| e^2 / 2 + |ds| |e|
```

with p the robot's way. What is linear is bounded as it is, the rest by its sizes, whatever the signs.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from diffdrive_mj._checks import Array
from diffdrive_mj.estimation.derivatives import Motion, chord
from diffdrive_mj.kinematics import body_twist
from diffdrive_mj.odometry import integrate
from diffdrive_mj.robot import Robot

# Directions in which a sum is bounded: between two of them it is at most 1 / cos(half their distance) of theirs.
_DIRECTIONS = 64
# Far more than what rounds off, a few parts in 1e16 a sample.
_OUTWARD = 1 + 1e-9


def by_ticks(angles: Array, robot: Robot, tick: float, anywhere: bool) -> tuple[float, float]:
    """How far readings that are off by less than a tick [rad] move odometry [m] and turn it [rad] at most.

    Each wheel is off by at most one tick at each sample after the first, in any pattern. By parts the linear term is a
    sum of readings times coefficients; in each direction it is largest where all of them add up.
    """
    rims = tick * np.array([robot.left_radius, robot.right_radius])
    turned = float(rims.sum()) / robot.track_width
    if len(angles) == 1:
        return 0.0, 0.0
    before, after = _by_readings(angles, robot)
    whole = before.copy()
    whole[:-1] += after[1:]
    directions = np.exp(-1j * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS)
    longest = 0.0
    for direction in directions:
        sums = np.cumsum(np.abs((direction * whole).real) @ rims)
        ends = np.append(0.0, sums[:-1]) + np.abs((direction * before).real) @ rims
        longest = max(longest, float(ends.max() if anywhere else ends[-1]))
    way = np.abs(body_twist(np.diff(angles, axis=0), robot)[:, 0]).sum()
    # With a the larger rim, |s| + |e| b / 2 <= a: from one sample to the next |ds| |e| is at most a^2 / b.
    rest = way * turned**2 / 2 + (len(angles) - 1) * rims.max() ** 2 / robot.track_width
    return (longest / math.cos(math.pi / (2 * _DIRECTIONS)) + float(rest)) * _OUTWARD, turned * _OUTWARD


def by_sampling(angles: Array, intervals: Array, acceleration: float, radii: Array, track: float) -> float:
    """How far odometry is moved at most by wheel rates that change between samples [m].

    Each wheel accelerates by at most `acceleration` [rad/s^2], as it likes, between samples that are `intervals` [s]
    apart, and is where it is read at each. So its rim is off by at most r A t (T - t) / 2 in between. The radii (2,)
    are the largest, the track the narrowest.
    """
    rims, pushes = np.abs(np.diff(angles, axis=0)) * radii, radii * acceleration
    # By parts the linear term is the integral of (x_r v_l - x_l v_r) / b.
    linear = (rims @ pushes[::-1]) * intervals**2 / (12 * track)
    turn = pushes.sum() / (2 * track)
    rest = rims.sum(axis=1) * turn**2 * intervals**4 / 120 + pushes.sum() ** 2 * intervals**4 / (48 * track)
    return float((linear + rest).sum()) * _OUTWARD


def _by_readings(angles: Array, robot: Robot) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """Derivatives of each step's end by how far the rims are at its end, and at its beginning (T - 1, 2)."""
    distance, turn = body_twist(np.diff(angles, axis=0), robot).T
    ones, side = np.ones_like(distance), np.array([[-1.0], [1.0]]) / robot.track_width
    by_end = Motion(distance, turn, ones / 2 * [[1.0], [1.0]], ones * side)
    chords = chord(by_end)
    direction = np.exp(1j * (integrate(angles, robot)[:-1, 2] + chords.half_turn))
    along, turning = chords.d_length * direction, 1j * chords.length * direction
    # What is off at the beginning shortens the step and turns it less, but from another heading.
    return (along + turning * chords.d_half_turn).T, (-along + turning * (side - chords.d_half_turn)).T
