"""A drive's odometry as a function of the robot's parameters, with its derivatives.

theta_k = sum of dtheta, x_k = sum of L cos(m), y_k = sum of L sin(m), with the chord L = ds sinc(dtheta / 2) and its
direction m = theta + dtheta / 2: every derivative is a sum along the drive too. The poses are taken where the truth
was measured, part of the way through an encoder's step.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from diffdrive_mj._checks import Array
from diffdrive_mj.drive import Drive
from diffdrive_mj.robot import Robot
from diffdrive_mj.se2 import sinc

PARAMETERS = ("left_radius", "right_radius", "track_width", "turning_gain")


def parameters_of(robot: Robot) -> Array:
    """Radii, track and turning gain (4,), in the order of `PARAMETERS`."""
    return np.array([getattr(robot, name) for name in PARAMETERS])


@dataclass(frozen=True, eq=False)
class Motion:
    """Steps of a robot and their derivatives.

    Attributes:
        length, turn: (S,) [m], [rad].
        d_length, d_turn: by the parameters (P, S).
    """

    length: Array
    turn: Array
    d_length: Array
    d_turn: Array


def motion(increments: Array, parameters: Array, count: int = 4) -> Motion:
    """Distance and turn of steps of wheel angles (S, 2) [rad] for (r_l, r_r, b, c): `kinematics.body_twist`.

    Args:
        increments: (S, 2) [rad].
        parameters: (4,).
        count: of how many of them, from the first, the derivatives are wanted.
    """
    left_radius, right_radius, track, gain = parameters
    left, right = increments[:, 0], increments[:, 1]
    length = (left_radius * left + right_radius * right) / 2
    plain = (right_radius * right - left_radius * left) / track
    d_length, d_turn = np.zeros((count, len(left))), np.zeros((count, len(left)))
    d_length[0], d_length[1] = left / 2, right / 2
    d_turn[0], d_turn[1], d_turn[2] = -left / track, right / track, -plain / track
    if count == 3 and gain == 0:
        return Motion(length, plain, d_length, d_turn)
    # s = u / (a + u) with a = |ds| and u = |dtheta| b / 2, which does not depend on b.
    a, u = np.abs(length), np.abs(plain) * track / 2
    total = np.where(a + u > 0, a + u, 1.0)
    share = u / total
    d_u = np.zeros_like(d_length)
    d_u[0], d_u[1] = -left / 2 * np.sign(plain), right / 2 * np.sign(plain)
    d_share = (a * d_u - u * d_length * np.sign(length)) / total**2
    d_turn = d_turn * (1 + gain * share) + plain * gain * d_share
    if count == 4:
        d_turn[3] = plain * share
    return Motion(length, plain * (1 + gain * share), d_length, d_turn)


def chord(step: Motion, fraction: Array | float = 1.0) -> tuple[Array, Array, Array, Array]:
    """Chord and half turn of a part of each step, and their derivatives: L, h (S,), dL, dh (P, S)."""
    length, half = fraction * step.length, fraction * step.turn / 2
    d_length, d_half = fraction * step.d_length, fraction * step.d_turn / 2
    ratio = sinc(half)
    # sinc'(h) = (cos h - sinc h) / h, whose digits are lost near zero: -h / 3 + h^3 / 30 there.
    small = np.abs(half) < 1e-2
    safe = np.where(small, 1.0, half)
    slope = np.where(small, -half / 3 + half**3 / 30, (np.cos(half) - ratio) / safe)
    return length * ratio, half, d_length * ratio + length * slope * d_half, d_half


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Poses at the truth's times, seen from the encoder's first sample, and their derivatives.

    Attributes:
        poses: (M, 3) [m, m, rad].
        by_parameters: (P, M, 3).
        velocity: (M, 3), by time [per s].
    """

    poses: Array
    by_parameters: Array
    velocity: Array


def trajectory(drive: Drive, parameters: Array, clock_offset: float = 0.0, count: int = 4) -> Trajectory:
    """Where odometry with (r_l, r_r, b, c) puts a robot when its true poses were measured.

    Args:
        drive: with M true poses.
        parameters: (4,).
        clock_offset: what the truth's clock is behind the encoder's [s].
        count: of how many of the parameters the derivatives are wanted.
    """
    steps = motion(np.diff(drive.wheel_angles, axis=0), parameters, count)
    length, half, d_length, d_half = chord(steps)
    heading = np.concatenate([[0.0], np.cumsum(steps.turn)])
    d_heading = np.concatenate([np.zeros((count, 1)), np.cumsum(steps.d_turn, axis=1)], axis=1)
    position, d_position = _advance(heading[:-1] + half, d_heading[:, :-1] + d_half, length, d_length)
    position = np.concatenate([np.zeros((1, 2)), np.cumsum(position, axis=0)])
    d_position = np.concatenate([np.zeros((count, 1, 2)), np.cumsum(d_position, axis=1)], axis=1)

    at = np.clip(drive.clock + clock_offset, drive.t[0], drive.t[-1])
    place = np.clip(np.searchsorted(drive.t, at, side="right") - 1, 0, len(drive.t) - 2)
    interval = drive.t[place + 1] - drive.t[place]
    fraction = (at - drive.t[place]) / interval
    part = Motion(steps.length[place], steps.turn[place], steps.d_length[:, place], steps.d_turn[:, place])
    length, half, d_length, d_half = chord(part, fraction)
    extra, d_extra = _advance(heading[place] + half, d_heading[:, place] + d_half, length, d_length)
    theta = heading[place] + 2 * half
    poses = np.concatenate([position[place] + extra, theta[:, None]], axis=1)
    d_theta = d_heading[:, place] + 2 * d_half
    derivatives = np.concatenate([d_position[:, place] + d_extra, d_theta[..., None]], axis=2)
    speed = part.length / interval
    velocity = np.stack([speed * np.cos(theta), speed * np.sin(theta), part.turn / interval], axis=1)
    return Trajectory(poses, derivatives, velocity)


def _advance(direction: Array, d_direction: Array, length: Array, d_length: Array) -> tuple[Array, Array]:
    """Steps of a length in a direction (S, 2), and their derivatives (P, S, 2)."""
    c, s = np.cos(direction), np.sin(direction)
    step = np.empty((len(length), 2))
    step[:, 0], step[:, 1] = length * c, length * s
    d_step = np.empty((*d_length.shape, 2))
    d_step[..., 0] = d_length * c - step[:, 1] * d_direction
    d_step[..., 1] = d_length * s + step[:, 0] * d_direction
    return step, d_step
