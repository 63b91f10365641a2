"""Allan deviation: which noise a sensor has, seen by averaging its readings at rest over longer and longer times."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj.errors import InvalidValue


def allan_deviation(readings: ArrayLike, interval: float, averaging_time: ArrayLike) -> Array:
    """Compute the overlapping Allan deviation of evenly sampled readings.

    ```
    sigma^2(m dt) = mean of (x_(k+2m) - 2 x_(k+m) + x_k)^2 / (2 (m dt)^2),    x_k = dt sum of the first k readings
    ```

    On a log-log plot white noise falls as N / sqrt(tau) and a random walk of the bias climbs as K sqrt(tau / 3).

    Args:
        readings: (..., S), at rest, each the mean over its interval.
        interval: dt, from one reading to the next [s].
        averaging_time: tau (M,) [s], each rounded to a whole number of intervals, at most half of the readings.

    Returns:
        (..., M), in the readings' unit; rms over the runs is `sqrt(mean(result**2))`.

    Raises:
        InvalidType: not numbers.
        InvalidValue: an averaging time that is not positive, shorter than half of an interval, or longer than half of
            the readings.

    References:
        IEEE Std 952 (1997), annex C.

    Example:
        White noise, averaged over 100 readings, is a tenth of what it was:

        >>> readings = np.random.default_rng(0).standard_normal(100_000)
        >>> dd.sensors.allan_deviation(readings, 0.01, [0.01, 1.0]).round(2).tolist()
        [1.0, 0.1]
    """
    values = checks.array("readings", readings, "S")
    dt = checks.positive("interval", interval)
    times = np.atleast_1d(checks.positive_array("averaging_time", averaging_time))
    counts = np.round(times / dt)
    most = values.shape[-1] // 2
    for time in times[(counts < 1) | (counts > most)]:
        raise InvalidValue(
            f"averaging_time = {time:g} s: must be one interval, {dt:g} s, to half of the readings, {most * dt:g} s"
        )
    # Less their mean, which the second difference does not see and the sum would be rounded by.
    angle = np.concatenate([np.zeros_like(values[..., :1]), np.cumsum(values - values.mean(-1, keepdims=True), -1)], -1)
    found = []
    for m in counts.astype(int):
        second = angle[..., 2 * m :] - 2 * angle[..., m:-m] + angle[..., : -2 * m]
        found.append(np.sqrt((second**2).mean(axis=-1) / 2) / m)
    return np.stack(found, axis=-1)
