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
# Robots that say more about themselves, each something else.
laden_robots = st.builds(
    lambda robot, changes: robot.replace(**changes),
    robots,
    st.fixed_dictionaries(
        {},
        optional={
            "name": st.text(max_size=20),
            "body_mass": sizes(0.1, 100.0),
            "center_of_mass_height": sizes(0.01, 1.0),
            "turning_gain": numbers(-0.4, 0.4),
            "tyres": st.fixed_dictionaries({}, optional={"width": sizes(0.001, 0.1), "mass": sizes(0.001, 10.0)}),
            "caster": st.fixed_dictionaries({}, optional={"x": numbers(0.05, 1.0), "radius": sizes(0.001, 0.1)}),
            "motor": st.fixed_dictionaries({"rotor_inertia": numbers(0.0, 1.0)}),
            "servo": st.fixed_dictionaries(
                {},
                optional={
                    "law": st.sampled_from(("PI", "P")),
                    "bandwidth": sizes(1.0, 100.0),
                    "gains": st.sampled_from(("matched", "equal")),
                },
            ),
            "encoder": st.fixed_dictionaries(
                {}, optional={"ticks_per_revolution": sizes(1.0, 1e6), "gear": sizes(0.1, 1000.0)}
            ),
            "payload": st.fixed_dictionaries({"mass": numbers(0.0, 0.01), "height": numbers(0.0, 1.0)}),
        },
    ),
)
angles = numbers(-20.0, 20.0)
poses = st.tuples(numbers(-10.0, 10.0), numbers(-10.0, 10.0), angles)
twists = st.tuples(numbers(-3.0, 3.0), numbers(-5.0, 5.0))
wheel_rates = st.tuples(numbers(-30.0, 30.0), numbers(-30.0, 30.0))


def drives(most: int = 12, least: int = 2) -> st.SearchStrategy[list]:
    """Wheel angles (T, 2) [rad] that change by at most 2 rad a sample."""
    shape = st.tuples(st.integers(least, most), st.just(2))
    return hnp.arrays(float, shape, elements=numbers(-2.0, 2.0)).map(lambda steps: steps.cumsum(axis=0))
