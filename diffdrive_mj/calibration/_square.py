"""The geometry of a square driven in both directions: what its return errors say of a robot's corners and sides.

A robot that believes in wrong parameters turns by alpha too little at each corner of its square (type A: the track) and
by beta, counter-clockwise, along each side (type B: unequal wheels). Let the square of side L be driven s = +1
counter-clockwise or s = -1 clockwise, each side followed by its corner. In the frame of the start pose side k = 0 to 3
leads along s k pi / 2, and half-way along it the heading is off by (k + 1/2) beta - s k alpha. To first order that
shifts the rest by L times it, to the side, and the sum over the sides is how far truth ends from odometry:

```
epsilon_x = 2 L (s beta - alpha)        epsilon_y = 2 L (s alpha - beta)        epsilon_theta = 4 (beta - s alpha)
```

The last is exact, since heading is linear in the wheel angles. Sums and differences over the directions separate them.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from diffdrive_mj import se2
from diffdrive_mj._checks import Array
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.robot import Robot

Form = Literal["exact", "both", "x", "y", "theta"]


def largest_centroid(centers: Array) -> float:
    """E_max,syst [m]: how far the farther centroid of the two lies from zero (Borenstein and Feng 1996)."""
    return float(np.hypot(centers[:, 0], centers[:, 1]).max())


def largest_heading(centers: Array) -> float:
    """The heading error of the worse direction [rad]."""
    return float(np.abs(centers[:, 2]).max())


def corner_and_side(centers: Array, side: float) -> dict[str, Array]:
    """The angles (alpha, beta) [rad] by form: "x", "y" and "theta", the heading.

    ```
    alpha = (x_cw + x_ccw) / (-4 L) = (y_cw - y_ccw) / (-4 L) = (theta_cw - theta_ccw) / 8
    beta  = (x_cw - x_ccw) / (-4 L) = (y_cw + y_ccw) / (-4 L) = (theta_cw + theta_ccw) / 8
    ```

    Args:
        centers: mean return error of each direction (2, 3) [m, m, rad]: counter-clockwise, clockwise.
        side: L [m].

    References:
        The module's sums solved; Borenstein and Feng 1996 have the forms in x and y, Jung and Chung 2011 the heading.
    """
    forms: tuple[Form, ...] = ("x", "y", "theta")
    return {form: readout(form, side) @ centers.ravel() for form in forms}


def readout(form: Form, side: float, present: Array | None = None) -> Array:
    """What the centroids say of small changes of the angles, (alpha, beta) = W c.

    Args:
        form: "x", "y", "both" (their mean), "theta", or "exact", the least-squares solution in x and y at the present
            angles, which is "both" where they are zero.
        side: [m].
        present: angles (2,) [rad].

    Returns:
        W (2, 6).
    """
    result = np.zeros((2, 2, 3))  # (alpha, beta), (counter-clockwise, clockwise), (x, y, theta)
    if form in ("x", "both"):
        result[..., 0] = np.array([[-1, -1], [1, -1]]) / (4 * side)
    if form in ("y", "both"):
        result[..., 1] = np.array([[1, -1], [-1, -1]]) / (4 * side)
    if form == "both":
        result /= 2
    if form == "theta":
        result[..., 2] = np.array([[-1, 1], [1, 1]]) / 8
    if form == "exact":
        at, step = np.zeros(2) if present is None else present, 1e-6
        moved = [square_ends(at + d, side) - square_ends(at - d, side) for d in step * np.eye(2)]
        slopes = np.stack(moved, axis=-1)[:, :2] / (2 * step)
        result[..., :2] = np.linalg.pinv(slopes.reshape(4, 2)).reshape(2, 2, 2)
    return result.reshape(2, 6)


def square_ends(angles: Array, side: float) -> Array:
    """Where the two directions end for angles (alpha, beta) of any size.

    Side k is an arc of length L that turns by beta: a chord of L sinc(beta / 2) along
    s k (pi / 2 - alpha) + (k + 1/2) beta.

    Args:
        angles: (alpha, beta) (2,) [rad].
        side: L [m].

    Returns:
        Counter-clockwise, clockwise (2, 3) [m, m, rad]; the heading is what it is off by.
    """
    alpha, beta = angles
    k, s = np.arange(4), np.array([[1.0], [-1.0]])
    heading = s * k * (math.pi / 2 - alpha) + (k + 0.5) * beta
    chord = side * float(se2.sinc(np.asarray(beta / 2)))
    turned = 4 * (beta - s[:, 0] * alpha)
    return np.stack([chord * np.cos(heading).sum(axis=1), chord * np.sin(heading).sum(axis=1), turned], axis=-1)


def angles(form: Form, centers: Array, side: float, present: Array) -> Array:
    """By how much the angles (alpha, beta) must change to explain the centroids that are left.

    Args:
        form: as in `readout`.
        centers: mean return errors from the odometry of the robot that has the present angles (2, 3) [m, m, rad].
        side: [m].
        present: the angles taken out so far (2,) [rad]; read by "exact" alone, which assumes no small angle.

    Returns:
        (2,) [rad].
    """
    first_order = readout(form, side, present) @ centers.ravel()
    if form != "exact":
        return first_order
    target, solution = square_ends(present, side) + centers, present + first_order
    for _ in range(20):
        step = readout(form, side, solution) @ (target - square_ends(solution, side)).ravel()
        solution = solution + step
        if np.abs(step).max() < 1e-13:
            break
    return solution - present


def error_ratios(alpha: float, beta: float, side: float, track_width: float) -> tuple[float, float]:
    """E_d and E_b: radius ratio and track of the true robot over those of the believed one.

    ```
    E_b = (pi / 2) / (pi / 2 - alpha)    E_d = (R + b / 2) / (R - b / 2)    R = L / beta    b = E_b track_width
    ```

    The wheels roll along an arc of length L about a centre R to the left, on circles b / 2 to each side of it, b being
    the true track; the quarter turn that the robot believes in turns it by 1 / E_b of a quarter. Both are exact for
    headings. The paper takes L for the chord, R = L / (2 sin(beta / 2)), which is beta^2 / 24 longer.

    Args:
        alpha: missing at each corner [rad].
        beta: turned along each side [rad].
        side: L [m].
        track_width: believed [m].

    Raises:
        InvalidValue: no robot turns so.

    References:
        Borenstein and Feng 1996 (there with the believed b in E_d).
    """
    if not alpha < math.pi / 2:
        raise InvalidValue(f"the drives turn by {alpha:.3g} rad too little at each corner: they have no corners left")
    track_ratio = (math.pi / 2) / (math.pi / 2 - alpha)
    lean = beta * track_ratio * track_width / (2 * side)
    if abs(lean) >= 1:
        raise InvalidValue(f"the drives turn by {beta:.3g} rad along each side: the robot must turn on one wheel")
    return (1 + lean) / (1 - lean), track_ratio


def corrected(robot: Robot, radius_ratio: float, track_width: float) -> Robot:
    """The robot of the same mean radius with another radius ratio and track [m]."""
    left = 2 * robot.mean_radius / (1 + radius_ratio)
    return robot.replace(left_radius=left, right_radius=radius_ratio * left, track_width=track_width)
