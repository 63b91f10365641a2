"""What hypothesis draws: robots, poses, angles and drives as they may come, none of them degenerate by accident."""

from __future__ import annotations

import math

from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import diffdrive_mj as dd


def numbers(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high, allow_subnormal=False)


def sizes(low: float, high: float) -> st.SearchStrategy[float]:
    """Positive numbers, evenly over the powers of ten."""
    return numbers(math.log10(low), math.log10(high)).map(lambda exponent: 10.0**exponent)


signs = st.sampled_from((-1.0, 1.0))
robots = st.builds(
    dd.Robot, left_radius=numbers(0.02, 0.3), right_radius=numbers(0.02, 0.3), track_width=numbers(0.1, 1.0)
)
angles = numbers(-20.0, 20.0)
poses = st.tuples(numbers(-10.0, 10.0), numbers(-10.0, 10.0), angles)
twists = st.tuples(numbers(-3.0, 3.0), numbers(-5.0, 5.0))
wheel_rates = st.tuples(numbers(-30.0, 30.0), numbers(-30.0, 30.0))


def drives(most: int = 12, least: int = 2) -> st.SearchStrategy[list]:
    """Wheel angles (T, 2) [rad] that change by at most 2 rad a sample."""
    shape = st.tuples(st.integers(least, most), st.just(2))
    return hnp.arrays(float, shape, elements=numbers(-2.0, 2.0)).map(lambda steps: steps.cumsum(axis=0))
