"""Rounds of corrections on a square driven in both directions, and whether their outcome explains the drives."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj.calibration import _square as square
from diffdrive_mj.calibration._square import Form
from diffdrive_mj.calibration._square_drives import LARGEST_MISMATCH, centroids, driving_directions, return_errors
from diffdrive_mj.calibration._square_scatter import covariance, heading_ambiguity, outliers
from diffdrive_mj.calibration.result import Calibration
from diffdrive_mj.diagnosis.refusals import implausible, mixed_up, refuse, repeated
from diffdrive_mj.drive import Drive, checked_drives
from diffdrive_mj.errors import CalibrationRefused
from diffdrive_mj.metrics import stacked
from diffdrive_mj.robot import Robot

Update = Literal["composed", "published"]

_SLACK = 1.01  # The mismatch is itself an estimate.
_UNEXPLAINED = 0.1  # Of the side, or [rad]: what no scatter of a robot worth calibrating leaves.
_AMBIGUOUS = 0.5  # No wheels are that unequal without anybody noticing.
_MORE_ROUNDS = 30
_RISE = 0.02  # Of the side.


@dataclass(frozen=True, eq=False)
class Squares:
    """Drives along a square, the directions (N,) they go in, how their errors are read, and whether headings count."""

    drives: list[Drive]
    directions: Array
    side: float
    form: Form
    headings: bool

    def centroids(self, robot: Robot) -> Array:
        """Mean return error of each direction from a robot's odometry (2, 3) [m, m, rad]."""
        return centroids(return_errors(self.drives, robot), self.directions)

    def off(self, centers: Array) -> float:
        """What the rounds shall make small."""
        return square.largest_heading(centers) if self.form == "theta" else square.largest_centroid(centers)


@dataclass(frozen=True, eq=False)
class Outcome:
    """The corrected robot, the centroids that it leaves, the angles taken out so far, and in how many rounds."""

    robot: Robot
    centers: Array
    angles: Array
    rounds: int


def calibrated_on_squares(
    method: str,
    drives: Sequence[Drive],
    believed: Robot,
    side: float,
    form: Form,
    update: Update,
    rounds: int,
    reject_outliers: bool,
    anyway: bool,
    headings: bool = True,
) -> Calibration:
    """Calibrate on squares; see `squares`."""
    drives, believed = checked_drives(drives), checks.instance("believed", believed, Robot)
    side, reject_outliers = checks.positive("side", side), checks.boolean("reject_outliers", reject_outliers)
    rounds = checks.whole("rounds", rounds, 1)
    headings = checks.boolean("headings", headings)
    against = [*repeated(drives), *mixed_up(drives, believed, headings=headings)]
    refused = refuse(against, anyway=checks.boolean("anyway", anyway))
    directions = driving_directions(drives, believed, side)
    far = outliers(return_errors(drives, believed), directions)
    used = ~far if reject_outliers else np.ones(len(directions), dtype=bool)
    kept = [drive for drive, use in zip(drives, used, strict=True) if use]
    squares = Squares(kept, directions[used], side, form, headings)

    first = squares.centroids(believed)
    seen = {"mismatch": _refuse_mismatch(first, believed, side)} if headings else {}
    outcome = _iterate(squares, Outcome(believed, first, np.zeros(2), 0), update, rounds)
    converging = _refuse_unexplained(squares, outcome, believed, rounds)
    left = return_errors(squares.drives, outcome.robot)
    weights = square.readout(form, side, outcome.angles)
    spread, condition = covariance(squares.drives, squares.directions, left, outcome.robot, weights)
    outlying = [drive.name for drive, out in zip(drives, far, strict=True) if out]
    return Calibration(
        method=method,
        believed=believed,
        calibrated=outcome.robot,
        parameters=("radius_ratio", "track_width"),
        values=np.array([outcome.robot.radius_ratio, outcome.robot.track_width]),
        covariance=spread,
        residuals=left[:, 2] if form == "theta" else left[:, :2].ravel(),
        before=stacked(drive.drift(believed) for drive in squares.drives),
        after=stacked(drive.drift(outcome.robot) for drive in squares.drives),
        condition=condition,
        warnings=(
            *refused,
            *refuse([*implausible(believed, outcome.robot), *_worse(squares, first, outcome)], anyway=anyway),
            f"the mean radius is not observed: {1e3 * believed.mean_radius:.4g} mm is kept as believed, and the track "
            "is wrong in the same proportion as it is",
            *_outliers_named(outlying, reject_outliers),
            *converging,
            *_weak_evidence(squares, believed, spread),
        ),
        details=_details(squares, first, outcome, believed) | seen | {"rounds": float(outcome.rounds)},
    )


def _iterate(squares: Squares, start: Outcome, update: Update, rounds: int) -> Outcome:
    """Rounds of corrections, as long as they help."""
    now = start
    for done in range(rounds):
        alpha, beta = square.angles(squares.form, now.centers, squares.side, now.angles)
        ratio, track_ratio = square.error_ratios(alpha, beta, squares.side, now.robot.track_width)
        if update == "composed":
            ratio *= now.robot.radius_ratio
        robot = square.corrected(now.robot, ratio, track_ratio * now.robot.track_width)
        centers = squares.centroids(robot)
        # The first round is the published method, and is judged by the caller.
        if done and squares.off(centers) >= squares.off(now.centers):
            break
        now = Outcome(robot, centers, now.angles + np.array([alpha, beta]), done + 1)
    return now


def _refuse_mismatch(centers: Array, believed: Robot, side: float) -> float:
    """The mismatch side |1 - E_d| / track that the headings show, which are exact for angles of any size."""
    alpha, beta = square.corner_and_side(centers, side)["theta"]
    ratio, track_ratio = square.error_ratios(alpha, beta, side, believed.track_width)
    track, off = track_ratio * believed.track_width, abs(1 - ratio)
    if side * off / track > LARGEST_MISMATCH * _SLACK:
        raise CalibrationRefused(
            f"side = {side:g} m: the headings show a radius ratio off by {off:.3g}, so that side |1 - ratio| / track "
            f"= {side * off / track:.3g}: must be at most {LARGEST_MISMATCH:g}, or the sides are no longer straight; "
            f"drive a square of at most {LARGEST_MISMATCH * track / off:.2g} m",
            accept="",
        )
    return float(side * off / track)


def _refuse_unexplained(squares: Squares, outcome: Outcome, believed: Robot, rounds: int) -> list[str]:
    """A warning where more rounds explain the drives; an error where they do not."""
    if not _unexplained(squares, outcome, believed):
        return []
    more = _iterate(squares, outcome, "composed", _MORE_ROUNDS)
    if why := _unexplained(squares, more, believed):
        raise CalibrationRefused(why, accept="")
    left, would_leave = (1e3 * square.largest_centroid(found.centers) for found in (outcome, more))
    return [
        f"not converged: rounds = {rounds} leave E_max at {left:.3g} mm, {more.rounds} more would leave "
        f"{would_leave:.3g} mm"
    ]


def _unexplained(squares: Squares, outcome: Outcome, believed: Robot) -> str:
    """What is wrong with an outcome: it must lie within the limits itself and bring odometry to where the robot was."""
    side, robot = squares.side, outcome.robot
    off = square.largest_centroid(outcome.centers)
    turned = square.largest_heading(outcome.centers) if squares.headings else 0.0
    mismatch = side * abs(1 - robot.radius_ratio / believed.radius_ratio) / robot.track_width
    if mismatch <= LARGEST_MISMATCH * _SLACK and off <= _UNEXPLAINED * side and turned <= 4 * _UNEXPLAINED:
        return ""
    headings = f" and {turned:.3g} rad" if squares.headings else ""
    return (
        f"side = {side:g} m: a radius ratio of {robot.radius_ratio:.4g} and a track of {robot.track_width:.4g} m leave "
        f"odometry {off:.3g} m{headings} off: unequal wheels and a wrong track do not explain these drives "
        f"within the method's limits; drive a shorter side, or check the drives"
    )


def _outliers_named(names: list[str], rejected: bool) -> list[str]:
    if not names:
        return []
    return [f"far from the other runs in their direction: {', '.join(names)}{' (left out)' if rejected else ''}"]


def _worse(squares: Squares, first: Array, outcome: Outcome) -> list[str]:
    """That odometry ends further off than before, by more than what the scatter of the runs may do."""
    before, after = (square.largest_centroid(centers) for centers in (first, outcome.centers))
    if after <= before + _RISE * squares.side:
        return []
    return [
        f"E_max rises from {1e3 * before:.3g} to {1e3 * after:.3g} mm: keep the nominal values, or drive a shorter side"
    ]


def _weak_evidence(squares: Squares, believed: Robot, spread: Array) -> list[str]:
    found = []
    if squares.headings and (limit := heading_ambiguity(squares.drives, believed)) < _AMBIGUOUS:
        found.append(
            f"the true poses are too far apart to count turns: the radius ratio is assumed to be within "
            f"{100 * limit:.2g} % of the believed one"
        )
    if np.isnan(spread).any():
        found.append("no covariance: it takes at least two runs in each direction")
    return found


def _details(squares: Squares, first: Array, outcome: Outcome, believed: Robot) -> dict[str, float]:
    alpha, beta = square.angles(squares.form, first, squares.side, np.zeros(2))
    radius_ratio, track_ratio = square.error_ratios(alpha, beta, squares.side, believed.track_width)
    found = {f"{axis}_{way}": first[i, j] for i, way in enumerate(("ccw", "cw")) for j, axis in enumerate("xy")}
    found |= {"E_max_before": square.largest_centroid(first), "E_max_after": square.largest_centroid(outcome.centers)}
    found |= {"E_d": radius_ratio, "E_b": track_ratio}
    for seen, (corner, along) in square.corner_and_side(first, squares.side).items():
        if squares.headings or seen != "theta":
            found |= {f"alpha_{seen}": corner, f"beta_{seen}": along}
    return {name: float(value) for name, value in found.items()}
