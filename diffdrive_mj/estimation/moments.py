"""The exact mean and covariance of the pose under noise of the wheels, without linearising.

With the position as a complex number p, and steps whose noises are independent of each other,

    p' = p + e^(i theta) c,    theta' = theta + a

where a is the turn of a step and c its chord seen from its first heading. Everything that the mean and the covariance
need closes among itself: the means of e^(i theta), e^(2 i theta), p, p e^(i theta), p e^(-i theta), p^2, |p|^2, theta,
theta^2, theta p and theta e^(i theta) follow from those before a step and the step's own moments. Only these take a
quadrature, over the noise of two wheels.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj._described import checked, described
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.kinematics import body_twist
from diffdrive_mj.robot import Robot
from diffdrive_mj.se2 import sinc

# Nodes for each wheel: the noise of a step is small against a radian, so that few are exact to rounding.
_NODES = 7


@described()
@dataclass(frozen=True, kw_only=True)
class WheelNoise:
    """Describe noise that grows as a random walk with each wheel's own way, in turns on the spot too.

    ```
    variance of a wheel's way s = k^2 |s|
    ```

    Args:
        left: k of the left wheel [m / sqrt(m)].
        right: k of the right wheel [m / sqrt(m)].

    Raises:
        InvalidValue: a number that is negative or not finite.
        InvalidType: not a number.
        UnknownName: a field that noise does not have.

    References:
        Chong and Kleeman (1997), Accurate odometry and error modelling for a mobile robot.

    Example:
        >>> WheelNoise(left=0.002, right=0.002).left
        0.002
    """

    left: float = field(metadata=checked(checks.not_negative))
    right: float = field(metadata=checked(checks.not_negative))


@dataclass(frozen=True, eq=False)
class PoseMoments:
    """Hold how a pose is distributed, at every sample.

    Attributes:
        mean: (T, 3) [m, m, rad].
        covariance: (T, 3, 3), of x, y and theta.

    Example:
        >>> PoseMoments(np.zeros((1, 3)), np.zeros((1, 3, 3))).sigma.tolist()
        [[0.0, 0.0, 0.0]]
    """

    mean: Array
    covariance: Array

    @property
    def sigma(self) -> Array:
        """The standard deviations (T, 3) [m, m, rad]."""
        return np.sqrt(np.diagonal(self.covariance, axis1=-2, axis2=-1))


def pose_moments(
    wheel_angles: ArrayLike, robot: Robot, noise: WheelNoise, start: ArrayLike = (0.0, 0.0, 0.0)
) -> PoseMoments:
    """Compute the mean and the covariance of the true pose, given the wheel angles that were read.

    Args:
        wheel_angles: (T, 2) [rad]; the way that a wheel truly makes in a step is the one read plus its noise.
        robot: with the radii and the track width.
        noise: of the wheels.
        start: (3,) [m, m, rad], known exactly.

    Returns:
        Both at every sample; exact for arcs between the samples, whatever the noise.

    Raises:
        InvalidType: not numbers, a robot and noise.
        InvalidValue: shapes that do not fit, or values that are not finite.

    Example:
        On a straight line the mean falls short of the way, to (b^2 / k^2) (1 - exp(-k^2 L / b^2)):

        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> angles = np.linspace(0.0, 500.0, 1001)[:, None] * (1.0, 1.0)  # 50 m
        >>> found = pose_moments(angles, robot, WheelNoise(left=0.002, right=0.002))
        >>> round(50 - found.mean[-1, 0].item(), 4), round(50 - 4e4 * (1 - math.exp(-50 / 4e4)), 4)
        (0.0312, 0.0312)
    """
    angles = checks.array("wheel_angles", wheel_angles, "T", 2)
    if angles.ndim != 2:
        raise InvalidValue(f"wheel_angles has shape {angles.shape}: must be (T, 2), one drive")
    checks.instance("robot", robot, Robot)
    checks.instance("noise", noise, WheelNoise)
    x, y, theta = checks.vector("start", start, 3).tolist()
    steps = _step_moments(np.diff(angles, axis=0), robot, noise)
    # Seen from the start: numbers stay small, and the start is put in front at the end.
    means = np.empty((len(angles), _PARTS), dtype=complex)
    means[0] = (1, 1, *[0] * (_PARTS - 2))
    for k, step in enumerate(steps.tolist()):
        means[k + 1] = _after(means[k].tolist(), step)
    return _gathered(means, complex(x, y), theta)


# The means that are carried along, in this order: of e^(i theta), e^(2 i theta), p, p e^(i theta), p e^(-i theta), p^2,
# |p|^2, theta, theta^2, theta p, theta e^(i theta).
_PARTS = 11


def _step_moments(angles: Array, robot: Robot, noise: WheelNoise) -> Array:
    """The means over each step's own noise (S, 11), complex, of its turn a and its chord c.

    In this order: of e^(ia), e^(2ia), c, c e^(ia), c e^(-ia), c^2, |c|^2, a, a^2, a c, a e^(ia).
    """
    nodes, weights = np.polynomial.hermite_e.hermegauss(_NODES)
    weights = np.outer(weights, weights).ravel() / weights.sum() ** 2
    radii = np.array([robot.left_radius, robot.right_radius])
    sigma = np.array([noise.left, noise.right]) * np.sqrt(np.abs(angles * radii)) / radii
    drawn = np.stack(np.meshgrid(nodes, nodes, indexing="ij"), axis=-1).reshape(-1, 2)
    way, turn = np.moveaxis(body_twist(angles[:, None] + sigma[:, None] * drawn, robot), -1, 0)
    turned = np.exp(1j * turn)
    chord = way * sinc(turn / 2) * np.exp(0.5j * turn)
    parts = (
        turned, turned**2, chord, chord * turned, chord / turned, chord**2, np.abs(chord) ** 2, turn, turn**2,
        turn * chord, turn * turned,
    )  # fmt: skip
    return np.stack([part @ weights for part in parts], axis=-1)


def _after(means: list[complex], step: list[complex]) -> tuple[complex, ...]:
    """What is carried along, after a step."""
    e, ee, p, pe, p_e, pp, p2, t, tt, tp, te = means
    a, aa, c, ca, c_a, cc, c2, w, ww, wc, wa = step
    return (
        e * a,
        ee * aa,
        p + e * c,
        pe * a + ee * ca,
        p_e * a.conjugate() + c_a,
        pp + 2 * pe * c + ee * cc,
        p2 + 2 * (p_e.conjugate() * c).real + c2,
        t + w,
        tt + 2 * t * w + ww,
        tp + w * p + te * c + e * wc,
        te * a + e * wa,
    )


def _gathered(means: Array, place: complex, heading: float) -> PoseMoments:
    """Means and covariances of x, y and theta, of those seen from a start."""
    turn = complex(math.cos(heading), math.sin(heading))
    _, _, p, _, _, pp, p2, t, tt, tp, _ = means.T
    theta = t.real
    spread, squared = p2.real - np.abs(p) ** 2, (pp - p**2) * turn**2
    along = (tp - theta * p) * turn
    variance = [(spread + squared.real) / 2, (spread - squared.real) / 2, tt.real - theta**2]
    xy = squared.imag / 2
    covariance = np.array([
        [variance[0], xy, along.real], [xy, variance[1], along.imag], [along.real, along.imag, variance[2]],
    ])  # fmt: skip
    where = place + turn * p
    return PoseMoments(np.stack([where.real, where.imag, heading + theta], axis=-1), np.moveaxis(covariance, -1, 0))
