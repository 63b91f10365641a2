"""What is kept of a trial: figures of its drift, by name."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from diffdrive_mj._checks import Array
from diffdrive_mj.metrics import Drift

# Where along its way a trial's errors are kept.
ALONG = np.linspace(0.0, 1.0, 101)


def position_along(drift: Drift) -> Array:
    """Interpolate the position error at even shares of the distance driven.

    Args:
        drift: of one run.

    Returns:
        (101,) [m], from the start to the end.

    Example:
        >>> drift = dd.metrics.drift([(0, 0, 0), (2, 0, 0)], [(0, 0, 0), (2, 0.02, 0)])
        >>> position_along(drift)[[0, 50, 100]].tolist()
        [0.0, 0.01, 0.02]
    """
    return np.interp(ALONG * float(drift.distance), drift.travelled, drift.position_error)


FIGURES: dict[str, Callable[[Drift], float | Array]] = {
    "final_position": lambda drift: float(drift.final_position),
    "final_heading": lambda drift: float(drift.final_heading),
    "max_position": lambda drift: float(drift.max_position),
    "max_heading": lambda drift: float(drift.max_heading),
    "final_position_per_metre": lambda drift: float(drift.final_position_per_metre),
    "max_position_per_metre": lambda drift: float(drift.max_position_per_metre),
    "distance": lambda drift: float(drift.distance),
    "position_along": position_along,
}
