"""What chance may do: quantiles against their textbook forms, and against many random figures."""

import math

import numpy as np
import pytest
from helpers import refused
from scipy import stats

from diffdrive_mj.report import chance
from diffdrive_mj.report.chance import Expected

TAIL = chance.ODDS / 2


def test_the_odds_are_one_in_a_million():
    assert chance.ODDS == 1e-6
    assert stats.norm.sf(chance.SIGMAS) == pytest.approx(TAIL)
    assert stats.t.sf(chance.sigmas(7), 7) == pytest.approx(TAIL)
    assert chance.sigmas(1e7) == pytest.approx(chance.SIGMAS, rel=1e-5)


@pytest.mark.parametrize("count", [1, 2, 10, 300])
def test_a_root_mean_square_of_normal_errors_is_chi_distributed(count):
    limit = 1 + chance.rms_tolerance(count)
    assert stats.chi2.sf(limit**2 * count, count) == pytest.approx(TAIL)
    # It is never off that far below.
    assert limit - 1 > 1 - math.sqrt(stats.chi2.ppf(TAIL, count) / count)


def test_the_tolerance_falls_with_the_root_of_the_number():
    tolerances = [chance.rms_tolerance(4**k) for k in range(6, 12)]
    assert np.divide(tolerances[:-1], tolerances[1:]) == pytest.approx(2.0, abs=0.1)


def test_errors_with_long_tails_are_allowed_more():
    """A counter that errs rarely: the scatter of its root mean square is that of the kurtosis."""
    rng, odds, count = np.random.default_rng(0), 0.02, 500
    errors = rng.random((4000, count)) < odds
    off = np.sqrt(errors.mean(axis=1) / odds) - 1
    sigma = chance.rms_tolerance(count, kurtosis=1 / odds) / chance.SIGMAS
    assert off.std() == pytest.approx(sigma, rel=0.25)
    assert np.abs(off).max() < chance.rms_tolerance(count, kurtosis=1 / odds)


def test_the_ratio_of_two_variances_is_f_distributed():
    assert stats.f.sf(1 + chance.ratio_tolerance(9), 9, 9) == pytest.approx(TAIL)


@pytest.mark.parametrize("count", [1, 3, 100, 5000])
@pytest.mark.parametrize("share", [0.0, 1e-4, 0.05, 0.5, 0.9545, 1.0])
def test_a_share_is_within_its_tolerance_but_once_in_a_million(count, share):
    most = count * float(chance.share_tolerance(share, count))
    above = stats.binom.sf(math.floor(count * share + most), count, share)
    below = stats.binom.cdf(math.ceil(count * share - most) - 1, count, share)
    assert above + below <= chance.ODDS


def test_bounds_break_for_what_chance_does_not_do():
    errors = np.random.default_rng(1).normal(size=(3, 1000))
    assert chance.rms_bound("all", Expected(errors, 1.0)).holds
    assert chance.rms_bound("all", Expected(errors, 1.0), Expected(2 * errors, 2.0)).holds
    assert not chance.rms_bound("all", Expected(1.2 * errors, 1.0)).holds
    assert chance.rms_bound("all", Expected(1.2 * errors, 1.0), beyond=0.2).holds
    assert chance.worst_bound("each", errors, np.ones(3)).holds
    assert not chance.worst_bound("each", errors, [1.0, 1.0, 1.3]).holds


def test_numbers_of_no_errors_are_refused():
    for function in (chance.rms_tolerance, chance.ratio_tolerance, chance.sigmas):
        with refused(ValueError, "must be positive"):
            function(0)


def test_what_a_law_is_off_itself_is_allowed_on_top():
    errors = np.full((2, 600), 1.02)
    for bound in (lambda beyond: chance.worst_bound("x", errors, [1.0, 1.0], beyond=beyond),
                  lambda beyond: chance.rms_bound("x", Expected(errors, law=1.0), beyond=beyond)):  # fmt: skip
        assert bound(0.1).limit == pytest.approx(bound(0.0).limit + 10)
