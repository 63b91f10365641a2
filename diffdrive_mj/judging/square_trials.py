"""Methods of calibration tried on squares: what each is worth, and which squares it refuses."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from diffdrive_mj.calibration.result import Calibration
from diffdrive_mj.drive import Drive
from diffdrive_mj.errors import CalibrationRefused
from diffdrive_mj.robot import Robot


@dataclass(frozen=True)
class Trial:
    """What a method makes of one square.

    Attributes:
        bent: how far its sides are bent, side |1 - radius ratio| / track [rad].
        gain: how many times smaller E_max becomes; NaN if the square is refused.
        refusal: why the square is refused, or "".

    Example:
        >>> Trial(0.05, gain=24.5).refusal
        ''
    """

    bent: float
    gain: float = float("nan")
    refusal: str = ""


def trial(
    method: Callable[..., Calibration], drives: Sequence[Drive], believed: Robot, *, side: float, bent: float
) -> Trial:
    """Try a method on a square; what it refuses for another reason than the square itself is an error all the same.

    Args:
        method: `umbmark`, `jung_chung`, or one of them with options.
        drives: along the square, in both directions.
        believed: the robot to be corrected.
        side: of the square [m].
        bent: how far its sides are bent [rad].

    Returns:
        What the method makes of it.

    Raises:
        InvalidValue: drives that are not such squares, or a bad option.

    Example:
        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> commands = [dd.maneuvers.square(robot, side=2.0, clockwise=way) for way in (False, True)]
        >>> drives = dd.sensors.measure(dd.simulate([robot.replace(right_radius=0.09)] * 2, commands))
        >>> trial(dd.calibration.umbmark, drives, robot, side=2.0, bent=0.5).refusal
        'side = 2 m: ... or the sides are no longer straight; drive a square of at most 1.3 m'
    """
    try:
        details = method(drives, believed, side=side).details
    except CalibrationRefused as refusal:
        return Trial(bent, refusal=refusal.reason)
    return Trial(bent, details["E_max_before"] / details["E_max_after"])


def median_gain(trials: Iterable[Trial], bent: float) -> float:
    """Compute how many times smaller E_max becomes, in the median of the squares that are bent by so much.

    Args:
        trials: of one method.
        bent: how far the squares' sides are bent [rad].

    Returns:
        The median of those that are answered; NaN if none is.

    Example:
        >>> median_gain([Trial(0.1, 4.0), Trial(0.1, 6.0), Trial(0.1, refusal="too bent"), Trial(0.2, 99.0)], 0.1)
        5.0
    """
    answered = [one.gain for one in trials if one.bent == bent and not one.refusal]
    return float(np.median(answered)) if answered else float("nan")
