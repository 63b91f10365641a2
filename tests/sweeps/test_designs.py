"""Designs: points that do not depend on how they are asked for, and are as even as they are said to be."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats
from scipy.stats import _sensitivity_analysis as scipys

from diffdrive_mj.sweeps.designs import DESIGNS, placed, random_points, saltelli_points, sobol_points

NAMES = ["robot.mean_radius", "robot.track_width", "world.friction"]
designs = st.sampled_from(list(DESIGNS))


@given(designs, st.integers(0, 2**64), st.lists(st.integers(1, 39), max_size=4, unique=True))
def test_a_trial_is_the_same_in_whatever_parts_the_trials_are_asked_for(design, seed, cuts):
    whole = DESIGNS[design](seed, NAMES, 0, 40, 40)
    edges = [0, *sorted(cuts), 40]
    parts = [DESIGNS[design](seed, NAMES, *edge, 40) for edge in itertools.pairwise(edges)]
    assert (np.concatenate(parts) == whole).all()
    assert whole.shape == (40, 3)
    assert whole.min() > 0 < 1 - whole.max()


@given(st.sampled_from(["random", "sobol"]), st.integers(1, 100))
def test_more_trials_leave_the_earlier_ones_as_they_were(design, trials):
    grids = {"maneuver.speed": 3, **dict.fromkeys(NAMES, 0)}
    assert (placed(design, 1, grids, 0, trials, trials) == placed(design, 1, grids, 0, 300, 300)[:trials]).all()


def test_what_else_varies_does_not_change_a_numbers_draws():
    alone, together = random_points(3, NAMES[1:2], 0, 50, 50), random_points(3, NAMES, 0, 50, 50)
    assert (alone[:, 0] == together[:, 1]).all()
    assert not (random_points(4, NAMES, 0, 50, 50) == together).any()


def test_chance_is_even_and_its_columns_are_independent():
    points = random_points(0, NAMES, 0, 20_000, 20_000)
    assert all(stats.kstest(column, "uniform").pvalue > 1e-4 for column in points.T)
    assert np.abs(np.corrcoef(points.T) - np.eye(3)).max() < 5 / np.sqrt(20_000)
    assert np.abs(np.corrcoef(points[1:, 0], points[:-1, 0])[0, 1]) < 5 / np.sqrt(20_000)


@given(st.integers(0, 1000), st.integers(1, 9))
def test_of_two_to_the_k_points_one_lies_in_each_part(seed, k):
    count = 2**k
    points = sobol_points(seed, NAMES, 0, count, count)
    for column in points.T:
        assert (np.sort(np.floor(column * count)) == np.arange(count)).all()


def test_means_converge_as_one_over_n_where_chance_leaves_a_root():
    def off(design, count):
        means = [np.prod(1 + (DESIGNS[design](s, NAMES, 0, count, count) - 0.5), axis=1).mean() for s in range(30)]
        return np.std(means)

    assert off("random", 256) / off("random", 4096) == pytest.approx(4, rel=0.5)
    assert off("sobol", 256) / off("sobol", 4096) > 12


@given(st.integers(1, 20), st.integers(1, 4))
def test_the_blocks_are_scipys(rows, numbers):
    names = [f"world.{k}" for k in range(numbers)]
    trials = rows * (numbers + 2)
    blocks = saltelli_points(5, names, 0, trials, trials).reshape(numbers + 2, rows, numbers)
    a, b = blocks[0].T, blocks[1].T
    assert (blocks[2:].swapaxes(1, 2) == scipys.sample_AB(a, b)).all()
    assert not np.isin(b, a).any()


@given(st.lists(st.integers(0, 4), min_size=1, max_size=4), st.integers(1, 5))
def test_every_combination_of_the_grids_is_driven_by_the_same_draws(sizes, repeats):
    grids = {f"world.{k}": size for k, size in enumerate(sizes)}
    combinations = int(np.prod([max(size, 1) for size in sizes]))
    shares = placed("random", 0, grids, 0, combinations * repeats, combinations * repeats)
    of_grids = [k for k, size in enumerate(sizes) if size]
    free = [k for k, size in enumerate(sizes) if not size]
    for turn in shares.reshape(repeats, combinations, len(sizes)):
        assert len(np.unique(turn[:, of_grids], axis=0)) == combinations
        assert (turn[:, free] == turn[0, free]).all()
    assert len(np.unique(shares[:, free], axis=0)) == (repeats if free else 1)
