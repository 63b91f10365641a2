"""What a floor can be beside level and smooth."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from diffdrive_mj import _checks as checks
from diffdrive_mj._described import checked, described
from diffdrive_mj.errors import InvalidValue


def _steepness(name: str, value: object) -> float:
    angle = checks.number(name, value)
    if not 0 <= angle < math.pi / 2:
        hint = f"; in degrees? then {math.radians(angle):.4g} rad" if math.pi / 2 <= angle < 90 else ""
        raise InvalidValue(f"{name} = {angle:g} rad: must be from 0 to below pi/2{hint}")
    return angle


@described()
@dataclass(frozen=True, kw_only=True)
class Slope:
    """Describe a floor that rises evenly; the world's x and y axes lie in it.

    Args:
        angle: how steep it is [rad].
        direction: in which it rises, as a heading [rad]; 0 along x.

    Raises:
        InvalidValue: an angle that is negative or not below pi/2, or a number that is not finite.
        InvalidType: not a number.
        UnknownName: a field that a slope does not have.

    Example:
        >>> Slope(angle=0.1, direction=math.pi / 2)  # uphill to the left
        Slope(angle=0.1, direction=1.5707963267948966)
    """

    angle: float = field(metadata=checked(_steepness))
    direction: float = field(default=0.0, metadata=checked(checks.number))
