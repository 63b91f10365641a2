"""The law for readings, against a loop that follows it word by word."""

import math

import numpy as np
import pytest
from helpers import refused
from hypothesis import given
from hypothesis import strategies as st

from diffdrive_mj.judging.readings import counting, held, shortest, unwrapped

cells = st.sampled_from([0.0, 0.5, 1.0, 1.5, 2.0, 3.0, math.nan, math.inf])
rows = st.lists(st.tuples(cells, cells, cells), min_size=1, max_size=12)


def by_the_law(readings):
    """Which readings count, one after the other."""
    last, counts = -math.inf, []
    for t, left, right in readings:
        counts.append(all(map(math.isfinite, (t, left, right))) and t > last)
        last = t if counts[-1] else last
    return counts


@given(rows)
def test_the_readings_that_count_are_those_of_the_law(readings):
    t, wheels = np.array(readings)[:, 0], np.array(readings)[:, 1:]
    wanted = by_the_law(readings)
    if not any(wanted):
        with refused(ValueError, "no reading has a time and both wheels"):
            counting(t, wheels)
    else:
        assert counting(t, wheels).tolist() == wanted


def test_a_time_that_is_no_number_does_not_hide_the_times_before_it():
    assert counting([1.0, np.nan, 0.5, 2.0], np.zeros((4, 2))).tolist() == [True, False, False, True]
    # Nor does the time of a reading whose wheels are no numbers.
    assert counting([1.0, 9.0, 2.0], [(0, 0), (np.nan, 0), (1, 1)]).tolist() == [True, False, True]


def test_poses_are_held_where_a_reading_does_not_count():
    poses = np.arange(9.0).reshape(3, 3)
    counts = np.array([False, True, False, True, True, False])
    assert held(poses, counts)[:, 0].tolist() == [0, 0, 0, 3, 6, 6]


@pytest.mark.parametrize("bits", [16, 32])
@given(start=st.integers(-(2**31), 2**31), steps=st.lists(st.integers(-32767, 32767), max_size=8), low=st.booleans())
def test_counters_count_on_through_their_wraps(bits, start, steps, low):
    true = start + np.concatenate([[0], np.cumsum(steps)]).astype(np.int64)
    lowest = -(2 ** (bits - 1)) if low else 0
    shown = (true - lowest) % 2**bits + lowest
    counts = np.ones(len(shown), dtype=bool)
    assert unwrapped(np.stack([shown, -shown], axis=-1), counts, bits)[:, 0].tolist() == (true - start).tolist()


def test_a_reading_that_does_not_count_is_as_far_as_its_step_from_the_last_that_does():
    read = [(10.0, 0.0), (65530.0, 0.0), (20.0, 0.0), (np.nan, 1.0), (30.0, 0.0)]
    counts = np.array([True, False, True, False, True])
    assert unwrapped(read, counts, 16)[:, 0].tolist()[:3] == [0.0, -16.0, 10.0]
    assert np.isnan(unwrapped(read, counts, 16)[3, 0])
    assert unwrapped(read, counts, 16)[4, 0] == 20.0
    assert unwrapped(read, counts, None)[1, 0] == 65520.0


def test_the_shortest_step_is_in_a_half_open_range():
    assert shortest(np.array([-32769.0, 32767.0, 65535.0, 0.0]), 16).tolist() == [32767.0, 32767.0, -1.0, 0.0]


def test_readings_of_integers_of_any_size_are_the_numbers_that_they_are():
    assert counting([0.0, 1.0], [(2**70, 0), (2**70, None)]).tolist() == [True, False]
    narrow = np.array([(250, 3), (5, 1), (7, 0)], dtype=np.uint8)
    counts = np.ones(3, dtype=bool)
    assert unwrapped(narrow, counts, None).tolist() == [[0, 0], [-245, -2], [-243, -3]]
    assert unwrapped(narrow, counts, 8).tolist() == [[0, 0], [11, -2], [13, -3]]
