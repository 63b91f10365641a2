"""Bounds: which are there, and that a drift as large as its bound keeps it."""

import math

import pytest

import diffdrive_mj as dd
from diffdrive_mj.judging.bounds import Bounds

# Half a metre and half a radian off after two metres.
DRIFT = dd.metrics.drift([(0, 0, 0), (2, 0, 0)], [(0, 0, 0), (2.5, 0, 0.5)])


@pytest.mark.parametrize(("name", "exactly"), [("position", 0.5), ("heading", 0.5), ("position_per_metre", 0.25)])
def test_a_drift_as_large_as_its_bound_keeps_it(name, exactly):
    assert Bounds(**{name: exactly}).broken(DRIFT) == ()
    (said,) = Bounds(**{name: math.nextafter(exactly, 0)}).broken(DRIFT)
    assert said.startswith(f"{name.replace('_', ' ')} off by ")


def test_one_bound_is_enough_to_be_bounded():
    assert not Bounds()
    assert Bounds(heading=1.0)
    assert Bounds(position=1.0, heading=1.0, position_per_metre=1.0)


def test_what_stands_still_may_be_off_by_nothing_per_metre():
    still = dd.metrics.drift([(0, 0, 0), (0, 0, 0)], [(0, 0, 0), (0.001, 0, 0)])
    assert len(Bounds(position_per_metre=1e6).broken(still)) == 1
