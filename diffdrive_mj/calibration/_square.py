"""The square driven both ways round: what its return errors say of a robot's corners and sides.

A robot that believes in wrong parameters turns by alpha too little at each corner of its square (type A: the track) and
by beta, counter-clockwise, along each side (type B: unequal wheels). Let the square of side L be driven s = +1
counter-clockwise or s = -1 clockwise, each side followed by its corner. In the frame of the start pose side k = 0 to 3
leads along s k pi / 2, and half-way along it the heading is off by (k + 1/2) beta - s k alpha. To first order that
shifts the rest by L times it, to the side, and the sum over the sides is how far truth ends from odometry:

    epsilon_x = 2 L (s beta - alpha)        epsilon_y = 2 L (s alpha - beta)        epsilon_theta = 4 (beta - s alpha)

The last is exact, since heading is linear in the wheel angles. Sums and differences over the two ways tell them apart.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from diffdrive_mj import _checks as checks
from diffdrive_mj import se2
from diffdrive_mj._checks import Array
from diffdrive_mj.drive import Drive
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.kinematics import body_twist
from diffdrive_mj.robot import Robot

LENGTH_TOLERANCE = 0.1


def return_errors(drives: Sequence[Drive], robot: Robot) -> Array:
    """How far truth ends from a robot's odometry, in the frame of the true start pose (N, 3) [m, m, rad].

    The heading is counted on from one true pose to the next, so that it may exceed half a turn if they are dense.
    """
    rows = []
    for drive in drives:
        odometry, truth = drive.odometry(robot), drive.truth
        gap = se2.rotate(truth[-1, :2] - odometry[-1, :2], -truth[0, 2])
        rows.append([*gap, se2.wrap_angle(np.diff(truth[:, 2] - odometry[:, 2])).sum()])
    return np.array(rows)


def ways_round(drives: Sequence[Drive], believed: Robot, side: float) -> Array:
    """Which way round each square was driven (N,): 1 counter-clockwise, -1 clockwise.

    Args:
        drives: one square each.
        believed: the robot whose odometry tells the shape.
        side: of the square [m].

    Raises:
        InvalidValue: a drive that is not such a square, or none of one way; the message names it.
    """
    ways = np.array([_way_round(drive, believed, checks.positive("side", side)) for drive in drives])
    missing = [name for name, way in (("counter-clockwise", 1.0), ("clockwise", -1.0)) if way not in ways]
    if missing:
        raise InvalidValue(f"drives: none {' and none '.join(missing)}: the square must be driven both ways round")
    return ways


def _way_round(drive: Drive, believed: Robot, side: float) -> float:
    if not np.ptp(drive.wheel_angles, axis=0).any():
        raise InvalidValue(f"{drive.name}: the wheels never turn: must be a square")
    kept = (drive.t >= drive.clock[0] - 1e-9) & (drive.t <= drive.clock[-1] + 1e-9)
    distance, turn = body_twist(np.diff(drive.wheel_angles[kept], axis=0), believed).T
    driven, heading = (np.concatenate([[0.0], np.cumsum(steps)]) for steps in (np.abs(distance), turn))
    length, turned = float(driven[-1]), float(heading[-1])
    if abs(abs(turned) - 2 * math.pi) > math.pi / 4:
        raise InvalidValue(f"{drive.name}: odometry turns by {turned:.3g} rad: must be a square, about 2 pi or -2 pi")
    if abs(length / (4 * side) - 1) > LENGTH_TOLERANCE:
        raise InvalidValue(f"{drive.name}: odometry drives {length:.4g} m: must be four sides of {side:g} m")
    way = math.copysign(1.0, turned)
    # On its sides, away from the corners, a robot within the method's limits turns by half of 0.3 rad at most.
    on_sides = np.interp(length / 4 * np.add.outer(np.arange(4), [0.25, 0.75]), driven, heading)
    along, corners = on_sides[:, 1] - on_sides[:, 0], np.diff([*on_sides.mean(axis=1), turned])
    for k in range(4):
        if abs(along[k]) > math.pi / 8 or abs(way * corners[k] - math.pi / 2) > math.pi / 4:
            raise InvalidValue(
                f"{drive.name}: odometry turns by {along[k]:.3g} rad along its side {k + 1} and by {corners[k]:.3g} "
                f"rad about the corner after it: must be a square, each side followed by its corner"
            )
    return way


def centroids(errors: Array, ways: Array) -> Array:
    """Mean return error of each way (2, 3) [m, m, rad]: counter-clockwise, clockwise."""
    return np.stack([errors[ways == way].mean(axis=0) for way in (1, -1)])


def largest_centroid(centers: Array) -> float:
    """E_max,syst [m]: how far the farther centroid of the two lies from zero (Borenstein and Feng 1996)."""
    return float(np.hypot(centers[:, 0], centers[:, 1]).max())


def corner_and_side(centers: Array, side: float) -> dict[str, Array]:
    """The angles (alpha, beta) [rad] by form: "x", "y" and "theta", the heading.

    alpha = (x_cw + x_ccw) / (-4 L) = (y_cw - y_ccw) / (-4 L) = (theta_cw - theta_ccw) / 8
    beta  = (x_cw - x_ccw) / (-4 L) = (y_cw + y_ccw) / (-4 L) = (theta_cw + theta_ccw) / 8

    Source: the module's sums solved; Borenstein and Feng 1996 have the forms in x and y, Jung and Chung 2011 the
    heading.
    """
    return {form: readout(form, side) @ centers.ravel() for form in ("x", "y", "theta")}


def readout(form: str, side: float, present: Array | None = None) -> Array:
    """What the centroids say of small changes of the angles, (alpha, beta) = W c, W (2, 6).

    Args:
        form: "x", "y", "both" (their mean), "theta", or "exact", the least-squares solution in x and y at the present
            angles, which is "both" where they are zero.
        side: [m].
        present: angles (2,) [rad].
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
    """Where the two ways end for angles (alpha, beta) of any size (2, 3) [m, m, rad]: counter-clockwise, clockwise.

    Side k is an arc of length L that turns by beta: a chord of L sinc(beta / 2) along
    s k (pi / 2 - alpha) + (k + 1/2) beta. The heading is what it is off by.
    """
    alpha, beta = angles
    k, s = np.arange(4), np.array([[1.0], [-1.0]])
    heading = s * k * (math.pi / 2 - alpha) + (k + 0.5) * beta
    chord = side * float(se2.sinc(np.asarray(beta / 2)))
    turned = 4 * (beta - s[:, 0] * alpha)
    return np.stack([chord * np.cos(heading).sum(axis=1), chord * np.sin(heading).sum(axis=1), turned], axis=-1)


def angles(form: str, centers: Array, side: float, present: Array) -> Array:
    """By how much the angles (alpha, beta) must change to explain the centroids that are left (2,) [rad].

    Args:
        form: as of `readout`.
        centers: mean return errors from the odometry of the robot that has the present angles (2, 3).
        side: [m].
        present: the angles taken out so far (2,) [rad]; read by "exact" alone, which knows no small angle.
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

    E_b = (pi / 2) / (pi / 2 - alpha),  E_d = (R + b / 2) / (R - b / 2),  R = L / beta,  b = E_b track_width

    The wheels roll along an arc of length L about a centre R to the left, on circles b / 2 to each side of it, b being
    the true track; the quarter turn that the robot believes in turns it by 1 / E_b of a quarter. Both are exact for
    headings. The paper takes L for the chord, R = L / (2 sin(beta / 2)), which is beta^2 / 24 longer.

    Args:
        alpha, beta: [rad].
        side: L [m].
        track_width: believed [m].

    Raises:
        InvalidValue: no robot turns so.

    Source: Borenstein and Feng 1996 (there with the believed b in E_d).
    """
    if not alpha < math.pi / 2:
        raise InvalidValue(f"the drives turn by {alpha:.3g} rad too little at each corner: they have no corners left")
    track_ratio = (math.pi / 2) / (math.pi / 2 - alpha)
    lean = beta * track_ratio * track_width / (2 * side)
    if abs(lean) >= 1:
        raise InvalidValue(f"the drives turn by {beta:.3g} rad along each side: the robot must turn on one wheel")
    return (1 + lean) / (1 - lean), track_ratio


def largest_heading(centers: Array) -> float:
    """The heading error of the worse way [rad]."""
    return float(np.abs(centers[:, 2]).max())


def corrected(robot: Robot, radius_ratio: float, track_width: float) -> Robot:
    """The robot of the same mean radius with another radius ratio and track."""
    left = 2 * robot.mean_radius / (1 + radius_ratio)
    return robot.replace(left_radius=left, right_radius=radius_ratio * left, track_width=track_width)
