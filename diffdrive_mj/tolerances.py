"""How well a robot is known: what its odometry may take it for."""

from __future__ import annotations

from dataclasses import dataclass, field

from diffdrive_mj import _checks as checks
from diffdrive_mj._described import checked, described

LARGEST = 0.5  # beyond, nobody knows the robot
_PART = checked(checks.limited(checks.not_negative, LARGEST, "of the value"))


@described()
@dataclass(frozen=True, kw_only=True)
class Tolerances:
    """Say how well a robot is known: by what part its odometry may take a number to be too large.

    The three are what odometry can tell apart, and each is an error of its own: the mean radius is off where tyres wear
    or sink, the ratio where two tyres differ, which no caliper sees, and the track where tyres are wide.

    Args:
        radius: of the mean radius, relative.
        radius_ratio: of the ratio of the radii, the mean radius kept, relative.
        track_width: relative.

    Raises:
        InvalidValue: a negative number, one that is not finite, or one above a half.
        InvalidType: not a number.
        UnknownName: a field that tolerances do not have.

    Example:
        >>> Tolerances(radius=0.005, radius_ratio=0.001).track_width
        0.01
    """

    radius: float = field(default=0.01, metadata=_PART)
    radius_ratio: float = field(default=0.01, metadata=_PART)
    track_width: float = field(default=0.01, metadata=_PART)
