"""Windows of about a second, and motions over them."""

import numpy as np
import pytest
from hypothesis import given
from strategies import numbers

import diffdrive_mj as dd
from diffdrive_mj.diagnosis._windows import misfit, motions, size, windows

ROBOT = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)


@pytest.mark.parametrize(
    ("rate", "samples", "ahead"),
    [(10.0, 31, 10), (4.0, 9, 4), (3.0, 9, 3), (0.8, 5, 1), (0.7, 5, 1)],
)
def test_a_window_ends_with_the_first_sample_a_second_later(rate, samples, ahead):
    pairs = windows(np.arange(samples) / rate)
    assert pairs.tolist() == [[k, k + ahead] for k in range(samples - ahead)]


def test_over_gaps_of_more_than_a_second_and_a_half_there_is_none():
    assert len(windows(np.arange(9) / 0.66)) == 0
    assert windows(np.array([0.0, 1.5, 3.1])).tolist() == [[0, 1]]


def test_motions_are_seen_from_the_windows_start_and_count_whole_turns():
    """A spin of ten turns, then a metre ahead: pi b a turn at each wheel, and no way of the middle."""
    spin = np.zeros((41, 3))
    spin[:, 2] = dd.se2.wrap_angle(np.linspace(0, 20 * np.pi, 41) + 1.0)
    straight = np.tile(spin[-1], (5, 1))
    straight[:, :2] += np.arange(1, 6)[:, None] * [np.cos(1.0), np.sin(1.0)]
    poses = np.concatenate([spin, straight])
    moved = motions(poses, np.array([[0, 40], [40, 45], [8, 0]]), ROBOT)
    assert moved == pytest.approx(np.array([[0, 0, 20 * np.pi * 0.2], [5, 0, 0], [0, 0, -4 * np.pi * 0.2]]), abs=1e-9)


@given(numbers(0.0, 3.0))
def test_a_misfit_is_the_share_that_two_motions_have_not_in_common(share):
    one = np.array([[3.0, 0, 0], [0, 4.0, 0], [0, 0, 5.0]])
    assert misfit(one, one) == 0
    assert misfit(one, -one) == pytest.approx(2)
    assert misfit(one, share * one) == misfit(share * one, one) == pytest.approx(abs(1 - share) / max(1, share))
    # Motions of 3 and 4 m that do not overlap: 7 m off, of 7 m.
    assert misfit(one * [1, 0, 0], one * [0, 1, 0]) == pytest.approx(1)
    assert misfit(0 * one, 0 * one) == 0
    assert size(one).tolist() == [3, 4, 5]
