"""Arc odometry as a function of the robot's parameters, with its derivatives.

The parameters are p = (r_l, r_r, b, c): radii, track width and turning gain. With the chord L = ds sinc(dtheta / 2) of
each step and its direction m = theta + dtheta / 2 a path is three sums along the drive,

```
theta = sum dtheta        x = sum L cos(m)        y = sum L sin(m)
```

and so is every derivative of it. `odometry` computes the same poses without derivatives, for any robot and method.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import ArrayLike

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj.drive import Drive
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.robot import Robot
from diffdrive_mj.se2 import sinc

PARAMETERS = ("left_radius", "right_radius", "track_width", "turning_gain")

# sinc'(h) / h as a series in h^2. The closed form (cos h - sinc h) / h loses its digits where h is small.
_SINC_SLOPE = np.array([(-1) ** n * 2 * n / math.factorial(2 * n + 1) for n in range(1, 7)])
_SMALL = 0.1


def parameters_of(robot: Robot) -> Array:
    """Return a robot's parameters as an array.

    Args:
        robot: whose radii, track width and turning gain are read.

    Returns:
        (4,) [m, m, m, 1], in the order of `PARAMETERS`.

    Example:
        >>> dd.estimation.derivatives.parameters_of(dd.Robot(left_radius=0.1, right_radius=0.091, track_width=0.4))
        array([0.1  , 0.091, 0.4  , 0.   ])
    """
    checks.instance("robot", robot, Robot)
    return np.array([getattr(robot, name) for name in PARAMETERS])


@dataclass(frozen=True, eq=False)
class Motion:
    """Holds how far a robot drives and turns in S steps, and the derivatives by its first P parameters.

    Attributes:
        distance: ds (S,) [m].
        turn: dtheta (S,) [rad], counter-clockwise.
        d_distance: derivatives of the distances (P, S).
        d_turn: derivatives of the turns (P, S).

    Example:
        >>> dd.estimation.derivatives.motion([[1.0, 1.0]], [0.1, 0.1, 0.4, 0.0]).distance
        array([0.1])
    """

    distance: Array
    turn: Array
    d_distance: Array
    d_turn: Array


def motion(increments: ArrayLike, parameters: ArrayLike, count: int = 4) -> Motion:
    """Compute how far a robot drives and turns, as `kinematics.body_twist` does, with derivatives.

    ```
    ds = (r_l phi_l + r_r phi_r) / 2        dtheta = (r_r phi_r - r_l phi_l) / b (1 + c s)
    s = u / (|ds| + u)                      u = |r_r phi_r - r_l phi_l| / 2
    ```

    Args:
        increments: how far the wheels turn in each step (S, 2) [rad], left then right.
        parameters: (4,), in the order of `PARAMETERS`.
        count: how many of the parameters, from the first, to differentiate by: 3 or 4.

    Returns:
        Distances and turns, with their derivatives.

    Example:
        >>> dd.estimation.derivatives.motion([[1.0, 2.0]], [0.1, 0.1, 0.4, 0.0], count=3).d_turn.round(3)
        array([[-2.5  ],
               [ 5.   ],
               [-0.625]])
    """
    left, right = checks.array("increments", increments, "S", 2).T
    left_radius, right_radius, track, gain = checks.vector("parameters", parameters, 4)
    if abs(track) < checks.SMALLEST:
        raise InvalidValue(f"track_width = {track:g} m: must not be zero")
    if checks.whole("count", count) not in (3, 4):
        raise InvalidValue(f"count = {count}: must be 3 or 4")
    distance = (left_radius * left + right_radius * right) / 2
    plain = (right_radius * right - left_radius * left) / track
    d_distance, d_turn = np.zeros((count, len(left))), np.zeros((count, len(left)))
    d_distance[0], d_distance[1] = left / 2, right / 2
    d_turn[0], d_turn[1], d_turn[2] = -left / track, right / track, -plain / track
    if count == 3 and gain == 0:
        return Motion(distance, plain, d_distance, d_turn)
    # u does not depend on the track, and neither does s.
    along, rim = np.abs(distance), np.abs(plain) * track / 2
    total = np.where(along + rim > 0, along + rim, 1.0)
    share = rim / total
    d_rim = np.zeros_like(d_distance)
    d_rim[0], d_rim[1] = -left / 2 * np.sign(plain), right / 2 * np.sign(plain)
    d_share = (along / total * d_rim - share * d_distance * np.sign(distance)) / total
    d_turn = d_turn * (1 + gain * share) + plain * gain * d_share
    if count == 4:
        d_turn[3] = plain * share
    return Motion(distance, plain * (1 + gain * share), d_distance, d_turn)


@dataclass(frozen=True, eq=False)
class Chord:
    """Holds the chords of S steps and the derivatives by the first P parameters.

    Attributes:
        length: L (S,) [m].
        half_turn: how far the chord points to the left of the heading before the step (S,) [rad].
        d_length: derivatives of the lengths (P, S).
        d_half_turn: derivatives of the half turns (P, S).

    Example:
        >>> steps = dd.estimation.derivatives.motion([[1.0, 2.0]], [0.1, 0.1, 0.4, 0.0])
        >>> dd.estimation.derivatives.chord(steps).half_turn
        array([0.125])
    """

    length: Array
    half_turn: Array
    d_length: Array
    d_half_turn: Array


def chord(steps: Motion, fraction: ArrayLike = 1.0) -> Chord:
    """Compute the chord of each step's arc, or of the first part of it.

    ```
    h = f dtheta / 2        L = f ds sinc(h)        sinc'(h) = (cos(h) - sinc(h)) / h
    ```

    Args:
        steps: distances and turns of S steps.
        fraction: f, what part of each step (S,), or of all of them.

    Returns:
        Length and half turn of each chord, with their derivatives.

    Example:
        A quarter turn on a circle of 1 m radius has a chord of sqrt(2) m:

        >>> wheel_angles = np.pi / 2 * np.array([[8.0, 12.0]])
        >>> steps = dd.estimation.derivatives.motion(wheel_angles, [0.1, 0.1, 0.4, 0.0])
        >>> dd.estimation.derivatives.chord(steps).length
        array([1.4142])
    """
    checks.instance("steps", steps, Motion)
    part = checks.array("fraction", fraction)
    distance, half = part * steps.distance, part * steps.turn / 2
    d_distance, d_half = part * steps.d_distance, part * steps.d_turn / 2
    ratio = sinc(half)
    small = np.abs(half) < _SMALL
    near = half * polynomial.polyval(np.where(small, half, 0.0) ** 2, _SINC_SLOPE)
    slope = np.where(small, near, (np.cos(half) - ratio) / np.where(small, 1.0, half))
    return Chord(distance * ratio, half, d_distance * ratio + distance * slope * d_half, d_half)


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Holds M poses at the times of the true ones, seen from the encoder's first sample, and their derivatives.

    Attributes:
        poses: (M, 3) [m, m, rad].
        by_parameters: derivatives by the first P parameters (P, M, 3).
        velocity: derivatives by time (M, 3) [m/s, m/s, rad/s].

    Example:
        >>> drive = dd.Drive([0.0, 1.0], [[0.0, 0.0], [10.0, 10.0]], np.zeros((2, 3)))
        >>> dd.estimation.derivatives.trajectory(drive, [0.1, 0.1, 0.4, 0.0]).velocity[0]
        array([1., 0., 0.])
    """

    poses: Array
    by_parameters: Array
    velocity: Array


def trajectory(drive: Drive, parameters: ArrayLike, clock_offset: float = 0.0, count: int = 4) -> Trajectory:
    """Compute where odometry puts a robot at the times of its true poses, and how that depends on the parameters.

    Between two samples of the encoder the wheels are taken to turn evenly; at most the encoder's times are covered.

    Args:
        drive: with M true poses, of which only the times are read.
        parameters: (4,), in the order of `PARAMETERS`.
        clock_offset: the time of the true poses minus the encoder's, as in `sensors.Tracker` [s].
        count: how many of the parameters, from the first, to differentiate by: 3 or 4.

    Returns:
        Poses seen from the encoder's first sample, and their derivatives.

    Example:
        >>> drive = dd.Drive([0.0, 1.0], [[0.0, 0.0], [10.0, 10.0]], np.zeros((2, 3)), [0.0, 0.5])
        >>> path = dd.estimation.derivatives.trajectory(drive, [0.1, 0.1, 0.4, 0.0])
        >>> path.poses[-1]
        array([0.5, 0. , 0. ])
        >>> path.by_parameters[:, -1, 0]  # how x depends on the radii, the track and the gain
        array([2.5, 2.5, 0. , 0. ])
    """
    checks.instance("drive", drive, Drive)
    steps = motion(np.diff(drive.wheel_angles, axis=0), parameters, count)
    heading, d_heading = _summed(steps.turn), _summed(steps.d_turn)
    moved, d_moved = _advance(heading[:-1], d_heading[:, :-1], chord(steps))
    position, d_position = _summed(moved, axis=0), _summed(d_moved, axis=1)

    # From the last sample before each true pose it is part of a step further.
    at = np.clip(drive.clock - checks.number("clock_offset", clock_offset), drive.t[0], drive.t[-1])
    last = np.clip(np.searchsorted(drive.t, at, side="right") - 1, 0, len(drive.t) - 2)
    interval = drive.t[last + 1] - drive.t[last]
    step = Motion(steps.distance[last], steps.turn[last], steps.d_distance[:, last], steps.d_turn[:, last])
    part = chord(step, (at - drive.t[last]) / interval)
    moved, d_moved = _advance(heading[last], d_heading[:, last], part)
    theta, d_theta = heading[last] + 2 * part.half_turn, d_heading[:, last] + 2 * part.d_half_turn
    speed = step.distance / interval
    return Trajectory(
        poses=np.concatenate([position[last] + moved, theta[:, None]], axis=1),
        by_parameters=np.concatenate([d_position[:, last] + d_moved, d_theta[..., None]], axis=2),
        velocity=np.stack([speed * np.cos(theta), speed * np.sin(theta), step.turn / interval], axis=1),
    )


def _summed(steps: Array, axis: int = -1) -> Array:
    """Sums of the steps along an axis, from zero on."""
    return np.insert(np.cumsum(steps, axis=axis), 0, 0.0, axis=axis)


def _advance(heading: Array, d_heading: Array, chords: Chord) -> tuple[Array, Array]:
    """Chords from headings (S,) as steps of position (S, 2), and their derivatives (P, S, 2)."""
    direction, d_direction = heading + chords.half_turn, d_heading + chords.d_half_turn
    c, s = np.cos(direction), np.sin(direction)
    step = np.empty((len(c), 2))
    step[:, 0], step[:, 1] = chords.length * c, chords.length * s
    d_step = np.empty((*chords.d_length.shape, 2))
    d_step[..., 0] = chords.d_length * c - step[:, 1] * d_direction
    d_step[..., 1] = chords.d_length * s + step[:, 0] * d_direction
    return step, d_step
