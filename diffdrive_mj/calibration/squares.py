"""Calibration from the square driven in both directions: UMBmark, and its sister that looks at the headings.

Both find the radius ratio and the track of the robot that drove, from how far its odometry ends from the truth. The
mean radius is not seen: a closed path hides it. `_square` derives the formulas.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, get_args

from diffdrive_mj import _checks as checks
from diffdrive_mj.calibration._square_rounds import Update, calibrated_on_squares
from diffdrive_mj.calibration.result import Calibration
from diffdrive_mj.drive import Drive
from diffdrive_mj.robot import Robot

PositionForm = Literal["exact", "both", "x", "y"]


def umbmark(
    drives: Sequence[Drive],
    believed: Robot,
    *,
    side: float,
    update: Update = "composed",
    forms: PositionForm = "exact",
    rounds: int = 3,
    headings: bool = True,
    reject_outliers: bool = False,
    anyway: bool = False,
) -> Calibration:
    """Find radius ratio and track from the return positions of a square driven in both directions (UMBmark).

    Each round takes the mean return errors of the two directions, alpha and beta from them, E_d and E_b from these
    (`_square.error_ratios`), and corrects the robot with the mean radius m unchanged:

    ```
    composed:   radius ratio <- E_d * radius ratio                  track <- E_b * track
    published:  r_l = 2 m / (E_d + 1)    r_r = 2 m / (1 / E_d + 1)  track <- E_b * track
    ```

    The published one forgets the radius ratio that was known before, so that it is right only for wheels believed
    equal, and oscillates from others. The paper's alpha and beta are first order in themselves
    (`_square.corner_and_side`): "x", "y", or their mean, "both". "exact" is the least-squares solution in x and y for
    angles of any size (`_square.angles`), whose first order is "both". Further rounds, odometry of the same drives
    computed anew with the corrected robot, take out what is left, as long as E_max falls.

    Args:
        drives: squares, each side followed by its corner, in any order, at least one in each direction.
        believed: the robot to be corrected.
        side: of the square [m].
        update: "composed" or "published".
        forms: "exact", "both", "x" or "y".
        rounds: at most; the paper has one.
        headings: whether the final headings check the outcome; a tape measures none. The outcome itself comes from
            positions alone.
        reject_outliers: leave out runs far from the others in their direction; otherwise a warning names them.
        anyway: accept what would be refused, with a warning.

    Returns:
        Parameters radius_ratio and track_width [m]. residuals: the return errors left (2 N,) [m], x then y of each run.
        The covariance comes from the runs' scatter; NaN with fewer than two a direction. details: x and y of the
        centroids, E_max before and after [m], alpha and beta in each form [rad], E_d and E_b of the first round, and
        the mismatch side |1 - E_d| / track that the headings show, if they are read.

    Raises:
        InvalidType: not drives, not a robot, or an option of the wrong type.
        UnknownName: another form or update.
        InvalidValue: drives that are not such squares, or none in one direction.
        CalibrationRefused: columns or units that look mixed up, a drive given twice, or odometry that is worse than
            before; and, anyway or not, a mismatch above 0.3, where the sides are no longer straight, or an outcome that
            does not explain the drives.

    References:
        Borenstein and Feng 1996: E_max,syst; alpha, beta, R, E_d, E_b; the update.

    Example:
        >>> believed = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> true, drives = believed.replace(track_width=0.41), []
        >>> for corner in (np.pi / 2, -np.pi / 2):
        ...     steps = dd.kinematics.wheel_rates([(2.0, 0.0), (0.0, corner)] * 4, believed)
        ...     angles = np.vstack([np.zeros(2), np.cumsum(steps, axis=0)])
        ...     drives.append(dd.Drive(np.arange(9.0), angles, dd.odometry.integrate(angles, true)))
        >>> dd.calibration.umbmark(drives, believed, side=2.0).values.round(6)
        array([1.  , 0.41])
    """
    checks.member("form", forms, get_args(PositionForm))
    checks.member("update", update, get_args(Update))
    return calibrated_on_squares(
        "UMBmark", drives, believed, side, forms, update, rounds, reject_outliers, anyway, headings
    )


def jung_chung(
    drives: Sequence[Drive],
    believed: Robot,
    *,
    side: float,
    rounds: int = 3,
    reject_outliers: bool = False,
    anyway: bool = False,
) -> Calibration:
    """Find radius ratio and track from the final headings of a square driven in both directions.

    With heading errors (truth minus odometry) theta of the two directions

    ```
    alpha = (theta_cw - theta_ccw) / 8        beta = (theta_cw + theta_ccw) / 8
    ```

    whatever the size of the angles, since heading is linear in the wheel angles; E_d and E_b follow as in `umbmark`,
    composed with the present values. Published is a further term pi b beta / (4 L) in alpha: it belongs to a change of
    one radius alone, and vanishes where the mean radius is kept, as here.

    Args:
        drives: squares, each side followed by its corner, in any order, at least one in each direction.
        believed: the robot to be corrected.
        side: of the square [m].
        rounds: at most; exact drives need one.
        reject_outliers: leave out runs far from the others in their direction; otherwise a warning names them.
        anyway: accept what would be refused, with a warning.

    Returns:
        As `umbmark` returns; residuals: the heading errors left (N,) [rad].

    Raises:
        InvalidType: not drives, not a robot, or an option of the wrong type.
        InvalidValue: drives that are not such squares, or none in one direction.
        CalibrationRefused: columns or units that look mixed up, a drive given twice, or odometry that is worse than
            before; and, anyway or not, a mismatch above 0.3, where the sides are no longer straight, or an outcome that
            does not explain the drives.

    References:
        Jung and Chung 2011.

    Example:
        >>> believed = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> true, drives = believed.replace(track_width=0.41), []
        >>> for corner in (np.pi / 2, -np.pi / 2):
        ...     steps = dd.kinematics.wheel_rates([(2.0, 0.0), (0.0, corner)] * 4, believed)
        ...     angles = np.vstack([np.zeros(2), np.cumsum(steps, axis=0)])
        ...     drives.append(dd.Drive(np.arange(9.0), angles, dd.odometry.integrate(angles, true)))
        >>> dd.calibration.jung_chung(drives, believed, side=2.0).values.round(6)
        array([1.  , 0.41])
    """
    return calibrated_on_squares(
        "Jung and Chung", drives, believed, side, "theta", "composed", rounds, reject_outliers, anyway
    )
