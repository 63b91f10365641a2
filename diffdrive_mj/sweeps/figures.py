"""What is kept of a trial: figures of its drift, by name."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj.metrics import Drift

# Where along its way a trial's errors are kept.
ALONG = np.linspace(0.0, 1.0, 101)


def position_along(drift: Drift) -> Array:
    """Interpolate the position error at even shares of the distance driven.

    Args:
        drift: of one run or many.

    Returns:
        (..., 101) [m], from the start to the end.

    Example:
        >>> drift = dd.metrics.drift([(0, 0, 0), (2, 0, 0)], [(0, 0, 0), (2, 0.02, 0)])
        >>> position_along(drift)[[0, 50, 100]].tolist()
        [0.0, 0.01, 0.02]
    """
    checks.instance("drift", drift, Drift)
    along = np.empty((*drift.distance.shape, len(ALONG)))
    for run in np.ndindex(drift.distance.shape):
        at = ALONG * float(drift.distance[run])
        along[run] = np.interp(at, drift.travelled[run], drift.position_error[run])
    return along


# Each of a drift with leading dimensions (...) has these, and whatever it keeps of a run behind them.
FIGURES: dict[str, Callable[[Drift], Array]] = {
    "final_position": lambda drift: drift.final_position,
    "final_heading": lambda drift: drift.final_heading,
    "max_position": lambda drift: drift.max_position,
    "max_heading": lambda drift: drift.max_heading,
    "final_position_per_metre": lambda drift: drift.final_position_per_metre,
    "max_position_per_metre": lambda drift: drift.max_position_per_metre,
    "distance": lambda drift: drift.distance,
    "position_along": position_along,
}
