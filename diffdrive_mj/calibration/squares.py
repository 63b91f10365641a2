"""Calibration from the square driven both ways round: UMBmark, and its sister that looks at the headings.

Both find the radius ratio and the track of the robot that drove, from how far its odometry ends from the truth. The
mean radius is not seen: a closed path hides it. `bidirectional` derives the formulas.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj.calibration import _square as square
from diffdrive_mj.calibration._square_scatter import alias, covariance, outliers
from diffdrive_mj.calibration.result import Calibration
from diffdrive_mj.drive import Drive, checked_drives
from diffdrive_mj.errors import InvalidType, InvalidValue
from diffdrive_mj.metrics import stacked
from diffdrive_mj.robot import Robot

LIMIT = 0.3
_SLACK = 1.01  # The mismatch is itself an estimate.
_UNEXPLAINED = 0.1  # Of the side, or [rad]: what no scatter of a robot worth calibrating leaves.
_ALIAS = 0.5  # No wheels are that unequal unawares.
_MORE_ROUNDS = 30

FORMS = ("exact", "both", "x", "y")
UPDATES = ("composed", "published")


def umbmark(
    drives: Sequence[Drive],
    believed: Robot,
    *,
    side: float,
    update: str = "composed",
    forms: str = "exact",
    rounds: int = 3,
    reject_outliers: bool = False,
) -> Calibration:
    """UMBmark: radius ratio and track from the return positions of a square driven both ways round.

    Each round takes the mean return errors of the two ways, alpha and beta from them, E_d and E_b from these
    (`bidirectional.error_ratios`), and corrects the robot with the mean radius m unchanged:

        composed:   radius ratio <- E_d * radius ratio,            track <- E_b * track
        published:  r_l = 2 m / (E_d + 1), r_r = 2 m / (1 / E_d + 1), track <- E_b * track

    The published one forgets the radius ratio that was known before, so that it is right only for wheels believed
    equal, and oscillates from others. The paper's alpha and beta are first order in themselves
    (`bidirectional.corner_and_side`): "x", "y", or their mean, "both". "exact" is the least-squares solution in x and y
    for angles of any size (`bidirectional.angles`), whose first order is "both". Further rounds, odometry of the
    same drives computed anew with the corrected robot, take out what is left, as long as E_max falls.

    Args:
        drives: squares, each side followed by its corner, in any order, at least one each way.
        believed: the robot to be corrected.
        side: of the square [m].
        update: "composed" or "published".
        forms: "exact", "both", "x" or "y".
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
    checks.member("form", forms, FORMS)
    composed = checks.member("update", update, UPDATES) == "composed"
    return _calibrate("UMBmark", drives, believed, side, forms, composed, rounds, reject_outliers)


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
    return _calibrate("Jung and Chung", drives, believed, side, "theta", True, rounds, reject_outliers)


def _calibrate(
    method: str,
    drives: Sequence[Drive],
    believed: Robot,
    side: float,
    form: str,
    composed: bool,
    rounds: int,
    reject_outliers: bool,
) -> Calibration:
    side = checks.positive("side", side)
    drives, believed = checked_drives(drives), checks.instance("believed", believed, Robot)
    if isinstance(rounds, bool) or not isinstance(rounds, int):
        raise InvalidType(f"rounds = {rounds!r}: must be a whole number")
    checks.positive("rounds", rounds)
    ways = square.ways_round(drives, believed, side)
    errors = square.return_errors(drives, believed)
    warnings = [
        f"the mean radius is not observed: {1e3 * believed.mean_radius:.4g} mm is taken as believed, and the track is "
        "wrong in the proportion in which that is"
    ]
    far = outliers(errors, ways)
    if far.any():
        names = ", ".join(drive.name for drive, out in zip(drives, far, strict=True) if out)
        warnings.append(f"far from the other runs of their way: {names}{' (left out)' if reject_outliers else ''}")
    used = ~far if reject_outliers else np.ones(len(ways), dtype=bool)
    kept, ways = [drive for drive, use in zip(drives, used, strict=True) if use], ways[used]

    first = square.centroids(errors[used], ways)
    mismatch = _refuse_mismatch(first, believed, side)
    robot, last, found, done = _iterate(kept, ways, believed, side, form, composed, rounds)
    e_first, e_last = (square.largest_centroid(centers) for centers in (first, last))
    if _unexplained(last, robot, believed, side):
        further, there, _, more = _iterate(kept, ways, robot, side, form, True, _MORE_ROUNDS, found)
        if why := _unexplained(there, further, believed, side):
            raise InvalidValue(why)
        warnings.append(
            f"not there yet: rounds = {rounds} leave E_max at {1e3 * e_last:.3g} mm, {more} more would leave "
            f"{1e3 * square.largest_centroid(there):.3g} mm"
        )
    if e_last > e_first:
        warnings.append(f"E_max rises from {1e3 * e_first:.3g} to {1e3 * e_last:.3g} mm: better keep what you believed")
    if (limit := alias(kept, believed)) < _ALIAS:
        warnings.append(
            f"the true poses are too far apart to count turns: taken for granted is that the radius ratio is within "
            f"{100 * limit:.2g} % of the believed one"
        )
    left = square.return_errors(kept, robot)
    spread, condition = covariance(kept, ways, left, robot, square.readout(form, side, found))
    if np.isnan(spread).any():
        warnings.append("no covariance: it takes at least two runs each way")

    alpha, beta = square.angles(form, first, side, np.zeros(2))
    radius_ratio, track_ratio = square.error_ratios(alpha, beta, side, believed.track_width)
    details = {f"{axis}_{way}": first[i, j] for i, way in enumerate(("ccw", "cw")) for j, axis in enumerate("xy")}
    details |= {"E_max_before": e_first, "E_max_after": e_last, "E_d": radius_ratio, "E_b": track_ratio}
    for seen, (corner, along) in square.corner_and_side(first, side).items():
        details |= {f"alpha_{seen}": corner, f"beta_{seen}": along}
    return Calibration(
        method=method,
        believed=believed,
        calibrated=robot,
        parameters=("radius_ratio", "track_width"),
        values=np.array([robot.radius_ratio, robot.track_width]),
        covariance=spread,
        residuals=left[:, 2] if form == "theta" else left[:, :2].ravel(),
        before=stacked(drive.drift(believed) for drive in kept),
        after=stacked(drive.drift(robot) for drive in kept),
        condition=condition,
        warnings=tuple(warnings),
        details={**{k: float(v) for k, v in details.items()}, "mismatch": mismatch, "rounds": float(done)},
    )


def _iterate(
    drives: Sequence[Drive],
    ways: Array,
    robot: Robot,
    side: float,
    form: str,
    composed: bool,
    rounds: int,
    found: Array | None = None,
) -> tuple[Robot, Array, Array, int]:
    """The corrected robot, the centroids that it leaves, the angles taken out, and the rounds that it took."""
    off = square.largest_heading if form == "theta" else square.largest_centroid
    found = np.zeros(2) if found is None else found
    centers = square.centroids(square.return_errors(drives, robot), ways)
    for done in range(rounds):
        alpha, beta = square.angles(form, centers, side, found)
        ratio, track_ratio = square.error_ratios(alpha, beta, side, robot.track_width)
        if composed:
            ratio *= robot.radius_ratio
        tried = square.corrected(robot, ratio, track_ratio * robot.track_width)
        left = square.centroids(square.return_errors(drives, tried), ways)
        # The first round is the published method, and is judged by the caller.
        if done and off(left) >= off(centers):
            return robot, centers, found, done
        robot, centers, found = tried, left, found + np.array([alpha, beta])
    return robot, centers, found, rounds


def _refuse_mismatch(centers: Array, believed: Robot, side: float) -> float:
    """The mismatch side |1 - E_d| / track that the headings show, which know no small angle."""
    alpha, beta = square.corner_and_side(centers, side)["theta"]
    ratio, track_ratio = square.error_ratios(alpha, beta, side, believed.track_width)
    track, off = track_ratio * believed.track_width, abs(1 - ratio)
    if side * off / track > LIMIT * _SLACK:
        raise InvalidValue(
            f"side = {side:g} m: the headings show a radius ratio off by {off:.3g}, so that side |1 - ratio| / track "
            f"= {side * off / track:.3g}: must be at most {LIMIT:g}, or the sides are no lines; drive a square of at "
            f"most {LIMIT * track / off:.2g} m"
        )
    return float(side * off / track)


def _unexplained(centers: Array, robot: Robot, believed: Robot, side: float) -> str:
    """What is wrong with an outcome: it must lie within the limits itself and bring odometry to where the robot was."""
    off, turned = square.largest_centroid(centers), square.largest_heading(centers)
    mismatch = side * abs(1 - robot.radius_ratio / believed.radius_ratio) / robot.track_width
    if mismatch <= LIMIT * _SLACK and off <= _UNEXPLAINED * side and turned <= 4 * _UNEXPLAINED:
        return ""
    return (
        f"side = {side:g} m: a radius ratio of {robot.radius_ratio:.4g} and a track of {robot.track_width:.4g} m leave "
        f"odometry {off:.3g} m and {turned:.3g} rad off: no unequal wheels and wrong track within the method's limits "
        f"explain these drives; must be shorter, or the drives are not what they seem"
    )
