"""Calibration from the square driven both ways round: UMBmark, and its sister that looks at the headings.

Both find the radius ratio and the track of the robot that drove, from how far its odometry ends from the truth. The
mean radius is not seen: a closed path hides it. `bidirectional` derives the formulas.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from diffdrive_mj import bidirectional as square
from diffdrive_mj import checks
from diffdrive_mj.calibration import Calibration
from diffdrive_mj.checks import Array
from diffdrive_mj.drive import Drive, judge
from diffdrive_mj.errors import InvalidType, InvalidValue
from diffdrive_mj.robot import Robot

LIMIT = 0.3
_SLACK = 1.01  # The mismatch is itself an estimate.
_UNEXPLAINED = 0.1  # Of the side, or [rad]: what no scatter of a robot worth calibrating leaves.
_OUTLIER = 8.0  # Robust standard deviations; with five runs a group 1 % of the good ones are that far out.

FORMS = {"both": (0.5, 0.5, 0.0), "x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0)}
_HEADING = (0.0, 0.0, 1.0)
UPDATES = ("composed", "published")


def umbmark(
    drives: Sequence[Drive],
    believed: Robot,
    *,
    side: float,
    update: str = "composed",
    forms: str = "both",
    rounds: int = 3,
    reject_outliers: bool = False,
) -> Calibration:
    """UMBmark: radius ratio and track from the return positions of a square driven both ways round.

    Each round takes the mean return errors of the two ways, alpha and beta from them (`bidirectional.corner_and_side`),
    E_d and E_b from these (`bidirectional.error_ratios`), and corrects the robot with the mean radius m unchanged:

        composed:   radius ratio <- E_d * radius ratio,            track <- E_b * track
        published:  r_l = 2 m / (E_d + 1), r_r = 2 m / (1 / E_d + 1), track <- E_b * track

    The published one forgets the radius ratio that was known before, so that it is right only for wheels believed
    equal, and oscillates from others. The angles are small ones; further rounds, odometry of the same drives computed
    anew with the corrected robot, take out what that leaves, as long as E_max falls.

    Args:
        drives: squares, each side followed by its corner, in any order, at least one each way.
        believed: the robot to be corrected.
        side: of the square [m].
        update: "composed" or "published".
        forms: "both" (the mean of the forms in x and in y), "x" or "y".
        rounds: at most; the paper has one.
        reject_outliers: leave out runs far from the others of their way; else a warning names them.

    Returns:
        parameters radius_ratio, track_width [m]; residuals: the return errors left (2 N,) [m], x then y of each run;
        covariance from the runs' scatter, NaN with fewer than two a way. details: x and y of the centroids, E_max
        before and after [m], alpha and beta in each form [rad], E_d and E_b of the first round, and the mismatch
        side |1 - E_d| / track that the headings show.

    Raises:
        InvalidType, UnknownName, InvalidValue: bad input; drives that are not such squares, or none one way; a mismatch
            above 0.3, where the angles are not small; an outcome that does not explain the drives.

    Source: J. Borenstein and L. Feng, Measurement and correction of systematic odometry errors in mobile robots, IEEE
        Transactions on Robotics and Automation 12(6), 1996: E_max,syst; alpha, beta, R, E_d, E_b; the update.
    """
    weights = checks.one_of("form", forms, FORMS)
    composed = checks.member("update", update, UPDATES) == "composed"
    return _calibrate("UMBmark", drives, believed, side, weights, composed, rounds, reject_outliers)


def jung_chung(
    drives: Sequence[Drive], believed: Robot, *, side: float, rounds: int = 3, reject_outliers: bool = False
) -> Calibration:
    """Radius ratio and track from the final headings of a square driven both ways round.

    With heading errors (truth minus odometry) theta of the two ways

        alpha = (theta_cw - theta_ccw) / 8,  beta = (theta_cw + theta_ccw) / 8

    whatever the size of the angles, since heading is linear in the wheel angles; E_d and E_b follow as in `umbmark`,
    composed with the present values. Published is a further term pi b beta / (4 L) in alpha: it belongs to a change of
    one radius alone, and vanishes where the mean radius is kept, as here.

    Args:
        drives, believed, side, rounds, reject_outliers: as of `umbmark`.

    Returns:
        As of `umbmark`; residuals: the heading errors left (N,) [rad].

    Raises:
        As of `umbmark`.

    Source: C. Jung and W. Chung, Calibration of kinematic parameters for two wheel differential mobile robots, Journal
        of Mechanical Science and Technology 25(6), 2011.
    """
    return _calibrate("Jung and Chung", drives, believed, side, _HEADING, True, rounds, reject_outliers)


def _calibrate(
    method: str,
    drives: Sequence[Drive],
    believed: Robot,
    side: float,
    weights: tuple[float, ...],
    composed: bool,
    rounds: int,
    reject_outliers: bool,
) -> Calibration:
    side = checks.positive("side", side)
    if not isinstance(believed, Robot):
        raise InvalidType(f"believed = {believed!r}: must be a Robot")
    if isinstance(rounds, bool) or not isinstance(rounds, int):
        raise InvalidType(f"rounds = {rounds!r}: must be a whole number")
    checks.positive("rounds", rounds)
    ways = square.ways_round(drives, believed, side)
    errors = square.return_errors(drives, believed)
    warnings = [
        f"the mean radius is not observed: {1e3 * believed.mean_radius:.4g} mm is taken as believed, and the track is "
        "wrong in the proportion in which that is"
    ]
    far = _outliers(errors, ways)
    if far.any():
        names = ", ".join(drive.name for drive, out in zip(drives, far, strict=True) if out)
        warnings.append(f"far from the other runs of their way: {names}{' (left out)' if reject_outliers else ''}")
    used = ~far if reject_outliers else np.ones(len(ways), dtype=bool)
    kept, ways = [drive for drive, use in zip(drives, used, strict=True) if use], ways[used]

    first = square.centroids(errors[used], ways)
    mismatch = _refuse_mismatch(first, believed, side)
    robot, last, done = _iterate(kept, ways, believed, side, weights, composed, rounds)
    e_first, e_last = (square.largest_centroid(centers) for centers in (first, last))
    _refuse_unexplained(last, robot, believed, side)
    if e_last > e_first:
        warnings.append(
            f"E_max rises from {1e3 * e_first:.3g} to {1e3 * e_last:.3g} mm: the correction is not worth it"
        )
    left = square.return_errors(kept, robot)
    covariance, condition = _covariance(kept, ways, left, robot, side, weights)
    if np.isnan(covariance).any():
        warnings.append("no covariance: it takes at least two runs each way")

    angles = square.corner_and_side(first, side)
    radius_ratio, track_ratio = square.error_ratios(*(np.array(weights) @ angles), side, believed.track_width)
    details = {f"{axis}_{way}": first[i, j] for i, way in enumerate(("ccw", "cw")) for j, axis in enumerate("xy")}
    details |= {"E_max_before": e_first, "E_max_after": e_last, "E_d": radius_ratio, "E_b": track_ratio}
    for form, (alpha, beta) in zip(("x", "y", "theta"), angles, strict=True):
        details |= {f"alpha_{form}": alpha, f"beta_{form}": beta}
    return Calibration(
        method=method,
        believed=believed,
        calibrated=robot,
        parameters=("radius_ratio", "track_width"),
        values=np.array([robot.radius_ratio, robot.track_width]),
        covariance=covariance,
        residuals=left[:, 2] if weights is _HEADING else left[:, :2].ravel(),
        before=judge(kept, believed),
        after=judge(kept, robot),
        condition=condition,
        warnings=tuple(warnings),
        details={**{k: float(v) for k, v in details.items()}, "mismatch": mismatch, "rounds": float(done)},
    )


def _iterate(
    drives: Sequence[Drive],
    ways: Array,
    robot: Robot,
    side: float,
    weights: tuple[float, ...],
    composed: bool,
    rounds: int,
) -> tuple[Robot, Array, int]:
    """The corrected robot, the centroids that it leaves, and the rounds that it took."""
    measure: Callable[[Array], float] = (
        (lambda centers: float(np.abs(centers[:, 2]).max())) if weights is _HEADING else square.largest_centroid
    )
    centers = square.centroids(square.return_errors(drives, robot), ways)
    for done in range(rounds):
        angles = np.array(weights) @ square.corner_and_side(centers, side)
        ratio, track_ratio = square.error_ratios(*angles, side, robot.track_width)
        if composed:
            ratio *= robot.radius_ratio
        tried = square.corrected(robot, ratio, track_ratio * robot.track_width)
        new = square.centroids(square.return_errors(drives, tried), ways)
        # The first round is the published method, and is judged by the caller.
        if done and measure(new) >= measure(centers):
            return robot, centers, done
        robot, centers = tried, new
    return robot, centers, rounds


def _refuse_mismatch(centers: Array, believed: Robot, side: float) -> float:
    """side |1 - E_d| / track from the headings, which know no small angle."""
    alpha, beta = square.corner_and_side(centers, side)[2]
    ratio, track_ratio = square.error_ratios(alpha, beta, side, believed.track_width)
    track = track_ratio * believed.track_width
    mismatch = side * abs(1 - ratio) / track
    if mismatch > LIMIT * _SLACK:
        raise InvalidValue(
            f"side = {side:g} m: the headings show a radius ratio off by {abs(1 - ratio):.3g}, so that side |1 - ratio| "
            f"/ track = {mismatch:.3g}: must be at most {LIMIT:g}, or the sides are no lines; drive a square of at most "
            f"{LIMIT * track / abs(1 - ratio):.2g} m"
        )
    return float(mismatch)


def _refuse_unexplained(centers: Array, robot: Robot, believed: Robot, side: float) -> None:
    """What is found must lie within the limits itself, and bring odometry to where the robot was."""
    off, turned = square.largest_centroid(centers), float(np.abs(centers[:, 2]).max())
    mismatch = side * abs(1 - robot.radius_ratio / believed.radius_ratio) / robot.track_width
    if mismatch > LIMIT * _SLACK or off > _UNEXPLAINED * side or turned > 4 * _UNEXPLAINED:
        raise InvalidValue(
            f"a radius ratio of {robot.radius_ratio:.4g} and a track of {robot.track_width:.4g} m leave odometry "
            f"{off:.3g} m and {turned:.3g} rad off on a square of {side:g} m: no unequal wheels and wrong track within "
            f"the method's limits explain these drives; try a shorter side"
        )


def _covariance(
    drives: Sequence[Drive], ways: Array, left: Array, robot: Robot, side: float, weights: tuple[float, ...]
) -> tuple[Array, float]:
    """Of radius ratio and track, from the scatter of the runs, and the condition of the scaled problem.

    The outcome is where the angles A c of the centroids c vanish, so a change dc moves it by -(A dc/dp)^-1 A dc.
    """
    step = 1e-5
    scale = np.array([robot.radius_ratio, robot.track_width])
    select = np.array(weights)

    def angles(errors: Array) -> Array:
        return select @ square.corner_and_side(square.centroids(errors, ways), side)

    slopes = []
    for i in range(2):
        moved = [square.corrected(robot, *(scale * (1 + sign * step * np.eye(2)[i]))) for sign in (1, -1)]
        up, down = (angles(square.return_errors(drives, other)) for other in moved)
        slopes.append((up - down) / (2 * step))
    jacobian = np.array(slopes).T
    counts = np.array([np.count_nonzero(ways == way) for way in (1, -1)])
    if counts.min() < 2:
        return np.full((2, 2), math.nan), float(np.linalg.cond(jacobian))
    # One run moves its way's centroid, and with it the angles, by its share.
    shares = []
    for i in range(len(left)):
        only = left.copy()
        mine = ways == ways[i]
        only[:] = 0.0
        only[i] = left[i] - left[mine].mean(axis=0)
        shares.append(angles(only) * math.sqrt(mine.sum() / (mine.sum() - 1)))
    moves = np.linalg.solve(jacobian, np.array(shares).T) * scale[:, None]
    return moves @ moves.T, float(np.linalg.cond(jacobian))


def _outliers(errors: Array, ways: Array) -> NDArray[np.bool_]:
    """Runs whose return position is far from their way's median, by the median of the distances; four runs at least."""
    far = np.zeros(len(ways), dtype=bool)
    for way in (1, -1):
        mine = np.flatnonzero(ways == way)
        if len(mine) >= 4:
            away = errors[mine, :2] - np.median(errors[mine, :2], axis=0)
            distance = np.hypot(away[:, 0], away[:, 1])
            # Of a round normal scatter the median distance is 1.1774 standard deviations.
            far[mine] = distance > _OUTLIER * max(float(np.median(distance)) / 1.1774, 1e-9)
    return far
