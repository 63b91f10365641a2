"""How far a path may bend before two position fixes and an odometer notice.

The chord of a path that bends by beta is hardly shorter than the path, so that epsilon, the difference of the two, is
nearly blind: 10 degrees over a metre shorten it by 1.3 mm and put the course at its end off by 5 degrees. A fix is off
by an isotropic Gaussian of standard deviation `fix_noise` on each axis, and epsilon by sqrt(2) times as much.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import ArrayLike
from scipy.special import chndtr

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array, array, broadcast, not_negative_array, positive_array
from diffdrive_mj.errors import InvalidValue

# The threshold of epsilon, in standard deviations of it.
SIGMAS = 3.0
# 1 - sinc(x) = x^2 / 3! - x^4 / 5! + ..., whose digits the difference would lose; to the last of them for x <= pi.
_SHORTENING = np.array([0.0, *((-1) ** n / math.factorial(2 * n + 3) for n in range(15))])
_SHORTENING_SLOPE = polynomial.polyder(_SHORTENING)


def chord_shortening(bend: ArrayLike, travelled: ArrayLike) -> Array:
    """Compute how much shorter the chord of an arc is than the arc.

    ```
    w (1 - sinc(beta / 2))        about w beta^2 / 24
    ```

    The heading at the arc's end is beta / 2 off the chord's direction, which is taken for the course.

    Args:
        bend: beta, how far the heading turns along the path (...) [rad], at most a full circle.
        travelled: the arc's length w (...) [m].

    Returns:
        (...) [m], to the last digit however small the bend.

    Raises:
        InvalidValue: a bend of more than a full circle, or a length that is not positive.

    References:
        [ct-Sim], equation 1.12, for the exact chord; [Petersen 2013] for epsilon.

    Example:
        >>> round(1e3 * float(dd.estimation.straightness.chord_shortening(np.radians(10), 1.0)), 2)  # [mm]
        1.27
    """
    beta, length = array("bend", bend), positive_array("travelled", travelled)
    broadcast(bend=beta, travelled=length)
    if (np.abs(beta) > 2 * np.pi).any():
        raise InvalidValue(f"bend = {np.abs(beta).max():g} rad: must be at most a full circle, 2 pi")
    return length * polynomial.polyval((beta / 2) ** 2, _SHORTENING)


def smallest_visible_bend(fix_noise: ArrayLike, travelled: ArrayLike, sigmas: float = SIGMAS) -> Array:
    """Compute the smallest bend that epsilon sees: it shortens the chord by the threshold.

    ```
    w (1 - sinc(beta / 2)) = 3 sqrt(2) fix_noise        beta about sqrt(72 sqrt(2) fix_noise / w)
    ```

    Half the paths that bend so far are accepted as straight all the same, and nearly all that bend half as far.

    Args:
        fix_noise: standard deviation of a fix on each axis (...) [m].
        travelled: w (...) [m].
        sigmas: the threshold in standard deviations of epsilon, sqrt(2) fix_noise each.

    Returns:
        beta (...) [rad], infinite where not even a full circle is seen.

    Raises:
        InvalidValue: negative noise, a length or a threshold that is not positive.

    Example:
        With fixes good to 1 cm, a path of a metre may bend by almost 60 degrees unseen:

        >>> round(float(np.degrees(dd.estimation.straightness.smallest_visible_bend(0.01, 1.0))))
        58
    """
    noise, length = not_negative_array("fix_noise", fix_noise), positive_array("travelled", travelled)
    broadcast(fix_noise=noise, travelled=length)
    lost = checks.positive("sigmas", sigmas) * math.sqrt(2) * noise / length
    wanted = np.minimum(lost, 1.0)
    # Newton for (beta / 2)^2 from below: the shortening is concave in it, so that no step overshoots.
    squared = 6 * wanted
    for _ in range(8):
        gap = wanted - polynomial.polyval(squared, _SHORTENING)
        squared = squared + gap / polynomial.polyval(squared, _SHORTENING_SLOPE)
    return np.where(lost > 1, np.inf, 2 * np.sqrt(squared))[()]


def hidden_course_error(fix_noise: ArrayLike, travelled: ArrayLike, sigmas: float = SIGMAS) -> Array:
    """Compute how far off the course may be at the end of a path that epsilon accepts as straight: beta / 2.

    Args:
        fix_noise: standard deviation of a fix on each axis (...) [m].
        travelled: w (...) [m].
        sigmas: the threshold in standard deviations of epsilon, sqrt(2) fix_noise each.

    Returns:
        (...) [rad], at most pi.

    Raises:
        InvalidValue: negative noise, a length or a threshold that is not positive.

    Example:
        >>> round(float(np.degrees(dd.estimation.straightness.hidden_course_error(0.01, 1.0))))
        29
    """
    return np.minimum(smallest_visible_bend(fix_noise, travelled, sigmas) / 2, np.pi)


def share_noticed(chord: ArrayLike, travelled: ArrayLike, fix_noise: ArrayLike, sigmas: float = SIGMAS) -> Array:
    """Compute how often epsilon passes its threshold on a path: the distance of two noisy fixes is Rice distributed.

    Args:
        chord: the true distance between the path's ends (...) [m].
        travelled: w (...) [m].
        fix_noise: standard deviation of a fix on each axis (...) [m].
        sigmas: the threshold in standard deviations of epsilon, sqrt(2) fix_noise each.

    Returns:
        (...), 0 to 1.

    Raises:
        InvalidValue: lengths, noise or a threshold that are not positive.

    Example:
        Of metres that bend by 60 degrees, fixes good to 1 cm notice half:

        >>> chord = 1 - dd.estimation.straightness.chord_shortening(np.radians(60), 1.0)
        >>> round(float(dd.estimation.straightness.share_noticed(chord, 1.0, 0.01)), 2)
        0.57
    """
    distance, length = positive_array("chord", chord), positive_array("travelled", travelled)
    sigma = math.sqrt(2) * positive_array("fix_noise", fix_noise)
    broadcast(chord=distance, travelled=length, fix_noise=sigma)
    threshold = checks.positive("sigmas", sigmas) * sigma
    below, above = (
        chndtr((np.maximum(edge, 0.0) / sigma) ** 2, 2, (distance / sigma) ** 2)
        for edge in (length - threshold, length + threshold)
    )
    return np.asarray(1 - (above - below))[()]
