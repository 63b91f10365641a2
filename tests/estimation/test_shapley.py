"""Parts of a total: against the mean over all orders, and what they must be by their axioms."""

import itertools

import numpy as np
import pytest
from helpers import refused
from hypothesis import given
from hypothesis import strategies as st

from diffdrive_mj.estimation import shapley


def by_orders(outcomes):
    """What each cause adds, for every order in which they can be switched on (orders, n, M)."""
    n = outcomes.ndim - 1
    found = []
    for order in itertools.permutations(range(n)):
        on, before = [0] * n, outcomes[(0,) * n]
        steps = np.empty((n, outcomes.shape[-1]))
        for cause in order:
            on[cause] = 1
            steps[cause] = outcomes[tuple(on)] - before
            before = outcomes[tuple(on)]
        found.append(steps)
    return np.array(found)


games = st.integers(1, 5).flatmap(
    lambda n: st.integers(0, 2**32 - 1).map(lambda seed: np.random.default_rng(seed).normal(size=(*(2,) * n, 3)))
)


@given(games)
def test_parts_are_the_mean_over_all_orders(outcomes):
    np.testing.assert_allclose(shapley.parts(outcomes), by_orders(outcomes).mean(axis=0), atol=1e-13)


@given(games)
def test_what_is_added_is_what_the_orders_add(outcomes):
    orders, added = by_orders(outcomes), shapley.added(outcomes)
    for cause in range(len(added)):
        want, have = ({tuple(row) for row in rows.round(12)} for rows in (orders[:, cause], added[cause]))
        assert want == have
    alone = np.array([outcomes[tuple(np.eye(len(added), dtype=int)[k])] for k in range(len(added))])
    np.testing.assert_allclose(added[:, 0], alone - outcomes[(0,) * len(added)], atol=1e-13)


def test_a_cause_without_effect_has_no_part_and_equal_causes_have_equal_ones():
    parts = shapley.parts(np.array([[[0.0], [0.0]], [[3.0], [3.0]]]))
    np.testing.assert_array_equal(parts, [[3.0], [0.0]])
    np.testing.assert_allclose(shapley.parts(np.array([[[0.0], [1.0]], [[1.0], [7.0]]])), [[3.5], [3.5]])


@pytest.mark.parametrize("shape", [(3,), (3, 2), (2, 3, 1)])
def test_outcomes_of_another_shape_are_refused(shape):
    with refused(ValueError, "off and on for each cause"):
        shapley.parts(np.zeros(shape))
