"""Distributions: quantiles and densities against SciPy's, what scaling keeps, how often values are chosen."""

import numpy as np
import pytest
from helpers import refused
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats
from scipy.integrate import quad
from strategies import numbers, sizes

import diffdrive_mj as dd
from diffdrive_mj.sweeps import Choice, Grid, LogNormal, Normal, Uniform
from diffdrive_mj.sweeps.distributions import DISTRIBUTIONS, Distribution, distribution

SHARES = np.linspace(0.001, 0.999, 201)
normals = st.builds(Normal, mean=numbers(-5.0, 5.0), sigma=sizes(1e-3, 10.0))
lognormals = st.builds(LogNormal, median=sizes(1e-3, 1e3), sigma=sizes(1e-3, 1.0))
uniforms = st.tuples(numbers(-5.0, 5.0), sizes(1e-3, 10.0)).map(lambda at: Uniform(low=at[0], high=at[0] + at[1]))
SAME = {
    Normal: lambda d: stats.norm(d.mean, d.sigma),
    LogNormal: lambda d: stats.lognorm(d.sigma, scale=d.median),
    Uniform: lambda d: stats.uniform(d.low, d.high - d.low),
}
CENTRE = {Normal: lambda d: d.mean, LogNormal: lambda d: d.median, Uniform: lambda d: (d.low + d.high) / 2}


@given(normals | lognormals | uniforms)
def test_quantiles_and_densities_are_scipys(spread):
    other, values = SAME[type(spread)](spread), spread.at(SHARES)
    assert np.allclose(values, other.ppf(SHARES), rtol=1e-12, atol=1e-12)
    inside = values[1:-1]
    assert np.allclose(spread.density(inside), other.pdf(inside), rtol=1e-9)


@pytest.mark.parametrize(
    "spread", [Normal(mean=2.0, sigma=0.3), LogNormal(median=0.6, sigma=0.5), Uniform(low=-1.0, high=3.0)]
)
def test_between_two_quantiles_lies_the_share_between(spread):
    low, high = spread.at([0.1, 0.7])
    assert quad(spread.density, low, high)[0] == pytest.approx(0.6, rel=1e-8)


@given(normals | lognormals | uniforms, sizes(0.1, 3.0))
def test_scaling_moves_every_quantile_away_from_the_centre_by_the_factor(spread, factor):
    centre = CENTRE[type(spread)](spread)
    before, after = spread.at(SHARES), spread.scaled(factor).at(SHARES)
    if isinstance(spread, LogNormal):
        before, after, centre = np.log(before), np.log(after), np.log(centre)
    assert np.allclose(after - centre, factor * (before - centre), rtol=1e-9, atol=1e-9)


def test_a_lognormal_number_is_never_negative_and_dense_nowhere_below():
    spread = LogNormal(median=0.6, sigma=2.0)
    assert (spread.at(np.linspace(0, 0.999, 100)) >= 0).all()
    assert spread.density([-1.0, 0.0]).tolist() == [0.0, 0.0]


@given(st.lists(st.integers(1, 9), min_size=1, max_size=5))
def test_values_are_chosen_as_often_as_they_weigh(weights):
    values = [f"tyre {k}" for k in range(len(weights))]
    chosen = Choice(values=values, weights=weights).at((np.arange(9000) + 0.5) / 9000)
    often = np.array([(chosen == value).sum() for value in values])
    assert np.abs(often - 9000 * np.array(weights) / sum(weights)).max() <= 1


@given(st.integers(1, 7))
def test_a_grid_has_each_value_on_an_equal_part_and_the_last_at_one(count):
    grid = Grid(values=range(count))
    assert grid.at((np.arange(count) + 0.5) / count).tolist() == list(range(count))
    assert grid.at([0.0, 1.0]).tolist() == [0, count - 1]


@pytest.mark.parametrize(
    "values", [(1, 2), (0.5, 2.0), ("PI", "P"), (True, False), (1, 0.5)], ids=["int", "float", "str", "bool", "mixed"]
)
def test_values_keep_their_kind(values):
    assert all(type(value) is type(values[-1]) for value in Choice(values=values).at([0.1, 0.9]).tolist())


@given(normals | lognormals | uniforms)
def test_they_print_as_they_are_made_and_are_made_of_tables(spread):
    assert eval(repr(spread)) == spread
    name = next(name for name, kind in DISTRIBUTIONS.items() if type(spread) is kind)
    fields = {field: getattr(spread, field) for field in type(spread).__dataclass_fields__}
    assert distribution("x", {"distribution": name, **fields}) == spread
    assert isinstance(spread, Distribution)


@pytest.mark.parametrize(
    ("make", "kind", "words"),
    [
        (lambda: Normal(mean=0.0, sigma=0.0), ValueError, "Normal.sigma = 0.0: must be positive"),
        (lambda: Normal(mean=0.0, sigma="1"), TypeError, "must be a number"),
        (lambda: Normal(mean=0.0, sd=1.0), KeyError, "unknown Normal field 'sd'"),
        (lambda: Normal(mean=0.0, sigma=1.0).at(1.5), ValueError, "share = 1.5: must lie between 0 and 1"),
        (lambda: Normal(mean=0.0, sigma=1.0).scaled(0), ValueError, "factor = 0: must be positive"),
        (lambda: LogNormal(median=-1.0, sigma=1.0), ValueError, "LogNormal.median = -1.0: must be positive"),
        (lambda: Uniform(low=1.0, high=1.0), ValueError, "high must be above low"),
        (lambda: Choice(values=()), ValueError, "Choice.values is empty"),
        (lambda: Choice(values="PI"), TypeError, "must be a list of values"),
        (lambda: Choice(values=("PI", 1)), TypeError, "all numbers, all strings, or all True or False"),
        (lambda: Choice(values=(1, 2), weights=(1,)), ValueError, "1 weights of 2 values: must be as many"),
        (lambda: Choice(values=(1, 2), weights=(1, 0)), ValueError, "Choice.weights = 0: must be positive"),
        (lambda: Grid(values=(1.0, np.nan)), ValueError, "must be finite"),
        (lambda: Grid(values=(10**30,)), ValueError, "must be below 2^63"),
        (lambda: distribution("x", {"distribution": "gauss"}), KeyError, "unknown distribution of x 'gauss'"),
        (lambda: distribution("x", 0.1), TypeError, "x = 0.1: must be a distribution of dd.sweeps"),
        (lambda: distribution("x", dd.sweeps.Normal), TypeError, "must be a distribution of dd.sweeps"),
    ],
)
def test_what_they_cannot_be(make, kind, words):
    with refused(kind, words):
        make()
