"""What the noise of the wheels' ways makes of a step's distance and turn."""

from __future__ import annotations

from typing import Any


def variances(left: Any, right: Any, track_width: float) -> tuple[Any, Any, Any]:
    """The variance of the distance D [m^2], the covariance of D and the turn W [m rad], the variance of W [rad^2].

    V_D = (v_l + v_r) / 4        cov(D, W) = (v_r - v_l) / (2 b)        V_W = (v_l + v_r) / b^2

    with the variances v_l and v_r of the wheels' ways [m^2], numbers or arrays (...), and the track width b [m].
    """
    both = left + right
    return both / 4, (right - left) / (2 * track_width), both / track_width**2
