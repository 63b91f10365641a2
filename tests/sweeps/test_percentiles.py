"""Percentiles and shares against binomial sums, exact cases, and how often their limits hold."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from diffdrive_mj.sweeps.percentiles import Estimate, percentile, share_of, trials_needed


def below(count, trials, share):
    """The binomial probability of at most some successes, as a plain sum."""
    return math.fsum(math.comb(trials, k) * share**k * (1 - share) ** (trials - k) for k in range(count + 1))


@given(trials=st.integers(5, 400), share=st.floats(0.05, 0.995), confidence=st.sampled_from([0.8, 0.95, 0.99]))
def test_limits_are_the_narrowest_trials_that_hold_whatever_the_distribution(trials, share, confidence):
    found, tail = percentile(np.arange(1, trials + 1), share, confidence), (1 - confidence) / 2
    assert found.value == max(1, math.ceil(trials * share - 1e-9))
    # The trial number l is a lower limit where fewer than l of the trials lie below the percentile rarely enough.
    if math.isfinite(found.low):
        assert below(int(found.low) - 1, trials, share) <= tail + 1e-12
        assert below(int(found.low), trials, share) > tail - 1e-12
    else:
        assert below(0, trials, share) > tail - 1e-12
    if math.isfinite(found.high):
        assert below(int(found.high) - 1, trials, share) >= 1 - tail - 1e-12
    else:
        assert below(trials - 1, trials, share) < 1 - tail + 1e-12


@pytest.mark.parametrize(("share", "trials"), [(0.5, 50), (0.9, 200), (0.99, 1000)])
def test_limits_hold_as_often_as_they_say(share, trials):
    drawn = np.random.default_rng(0).exponential(size=(trials, 4000))  # 4000 sweeps side by side
    found, true = percentile(drawn, share), -math.log(1 - share)
    held = float(np.mean((found.low <= true) & (true <= found.high)))
    assert held >= 0.95 - 4 * math.sqrt(0.05 * 0.95 / 4000)
    assert held < 0.985  # and they are not wider than needed


def test_lost_robots_are_beyond_any_percentile():
    found = percentile([0.1, 0.2, math.inf, math.inf], 0.5)
    assert (found.value, percentile([0.1, math.inf], 0.9).value) == (0.2, math.inf)


@pytest.mark.parametrize("share", [0.9, 0.99])
def test_as_many_trials_as_needed_give_an_upper_limit(share):
    least = trials_needed(share)
    assert math.isinf(percentile(np.arange(least - 1), share).high)
    assert percentile(np.arange(least), share).high == least - 1


@given(trials=st.integers(1, 300), data=st.data(), confidence=st.sampled_from([0.8, 0.95, 0.99]))
def test_a_share_has_clopper_and_pearsons_limits(trials, data, confidence):
    count = data.draw(st.integers(0, trials))
    found, tail = share_of(count, trials, confidence), (1 - confidence) / 2
    assert found.value == count / trials
    if count < trials:
        assert below(count, trials, float(found.high)) == pytest.approx(tail, rel=1e-6)
    else:
        assert found.high == 1
    if count:
        assert 1 - below(count - 1, trials, float(found.low)) == pytest.approx(tail, rel=1e-6)
    else:
        assert found.low == 0


def test_none_of_three_hundred_is_the_rule_of_three():
    assert share_of(0, 300, 0.90).high == pytest.approx(3 / 300, rel=0.01)


def test_an_estimate_reads_well():
    assert (
        Estimate(np.float64(3033.2), np.float64(2751.9), np.float64(3286.1)).text("mm") == "3030 mm (2750 to 3290 mm)"
    )
    assert Estimate(np.float64(1.0), np.float64(-np.inf), np.float64(np.inf)).text("mm") == "1 mm"
    assert str(percentile(np.zeros((9, 4)), 0.5)) == "(4,) estimates"


def test_bad_input_is_refused():
    for share in (0.0, 1.0, 99):
        with pytest.raises(ValueError, match="between 0 and 1"):
            percentile([1.0], share)
    for values in ([], 3.0, [math.nan]):
        with pytest.raises(ValueError, match="at least one"):
            percentile(values, 0.5)
    with pytest.raises(TypeError, match="numbers"):
        percentile(["far"], 0.5)
    with pytest.raises(ValueError, match="at most trials"):
        share_of(3, 2)
