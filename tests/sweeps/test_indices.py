"""Sobol' indices against closed forms, SciPy and SALib, and with rows that were not driven to their end."""

import math

import numpy as np
import pytest
from scipy import stats

import diffdrive_mj as dd
from diffdrive_mj.sweeps import Trials
from diffdrive_mj.sweeps.indices import indices_of, sobol_indices


def ishigami(x):
    """A function of three numbers between -pi and pi, whose indices are known."""
    return np.sin(x[0]) + 7 * np.sin(x[1]) ** 2 + 0.1 * x[2] ** 4 * np.sin(x[0])


def design(rows, seed=0, numbers=3):
    """Blocks A, B, AB_1 to AB_D of numbers between -pi and pi, (D + 2, D, rows)."""
    u = 2 * np.pi * stats.qmc.Sobol(2 * numbers, rng=seed).random(rows).T - np.pi
    a, b = u[:numbers], u[numbers:]
    return [a, b, *(np.where(np.arange(numbers)[:, None] == k, b, a) for k in range(numbers))]


def values(rows, seed=0):
    a, b, *ab = (ishigami(block) for block in design(rows, seed))
    return a, b, np.array(ab)


# With a = 7 and b = 0.1: V = a^2/8 + b pi^4/5 + b^2 pi^8/18 + 1/2.
_B = 0.1 * math.pi**4
VARIANCE = 49 / 8 + _B / 5 + _B**2 / 18 + 0.5
FIRST = np.array([(1 + _B / 5) ** 2 / 2, 49 / 8, 0.0]) / VARIANCE
TOTAL = FIRST + np.array([_B**2 * (1 / 18 - 1 / 50), 0.0, _B**2 * (1 / 18 - 1 / 50)]) / VARIANCE


def test_the_indices_of_ishigamis_function_are_known():
    first, total = sobol_indices(*values(2**15))
    np.testing.assert_allclose(first.value, FIRST, atol=0.01)
    np.testing.assert_allclose(total.value, TOTAL, atol=0.01)


def test_limits_hold_as_often_as_they_say():
    rng, held = np.random.default_rng(1), []
    for seed in range(40):
        a, b = rng.uniform(-np.pi, np.pi, (2, 3, 500))  # chance, where Sobol' points scatter less
        ab = [ishigami(np.where(np.arange(3)[:, None] == k, b, a)) for k in range(3)]
        for found, true in zip(sobol_indices(ishigami(a), ishigami(b), ab, seed=seed), (FIRST, TOTAL), strict=True):
            held.append((found.low <= true) & (true <= found.high))
    assert np.mean(held) > 0.90  # 240 limits that are no independent ones


def test_scipy_has_the_same_numbers():
    a, b, ab = values(256)
    first, total = sobol_indices(a, b, ab)
    theirs = stats.sobol_indices(func={"f_A": a[None], "f_B": b[None], "f_AB": ab[:, None]}, n=256)
    np.testing.assert_allclose(first.value, theirs.first_order, atol=1e-12)
    np.testing.assert_allclose(total.value, theirs.total_order, atol=1e-12)


def test_salib_has_the_same_numbers_and_limits():
    sobol = pytest.importorskip("SALib.analyze.sobol")
    a, b, ab = values(2048)
    first, total = sobol_indices(a, b, ab)
    problem = {"num_vars": 3, "names": ["x", "y", "z"], "bounds": [[-np.pi, np.pi]] * 3}
    theirs = sobol.analyze(
        problem, np.stack([a, *ab, b], axis=1).ravel(), calc_second_order=False, seed=1, num_resamples=1000
    )
    # SALib takes off another mean, which makes no difference but for chance.
    np.testing.assert_allclose(first.value, theirs["S1"], atol=1e-3)
    np.testing.assert_allclose(total.value, theirs["ST"], atol=1e-3)
    np.testing.assert_allclose((first.high - first.low) / 2, theirs["S1_conf"], rtol=0.2)
    np.testing.assert_allclose((total.high - total.low) / 2, theirs["ST_conf"], rtol=0.2)


def trials(rows=256, lost=()):
    drawn = np.concatenate(design(rows), axis=1)
    outcome = np.full(5 * rows, "ok", dtype="<U8")
    outcome[list(lost)] = "fell"
    figure = np.where(outcome == "ok", ishigami(drawn), np.nan)
    names = ("robot.mean_radius", "robot.radius_ratio", "robot.track_width")
    return Trials(
        np.arange(5 * rows), dict(zip(names, drawn, strict=True)), {"final_heading": figure}, outcome, outcome
    )


def test_trials_of_a_design_know_their_blocks():
    found, (first, total) = indices_of(trials(), "final_heading"), sobol_indices(*values(256))
    np.testing.assert_allclose(found.first.value, first.value, rtol=1e-12)
    np.testing.assert_allclose(found.total.value, total.value, rtol=1e-12)
    assert (found.rows, found.dropped) == (256, 0)
    assert len(trials().sizes("final_heading")) == 512  # A and B, which are independent
    assert "final heading error" in found.finding


def test_a_robot_that_was_lost_takes_its_row_out_of_all_blocks():
    found = indices_of(trials(lost=(3, 256 + 7, 4 * 256 + 7)), "final_heading")
    kept = np.delete(np.arange(256), [3, 7])
    a, b, ab = values(256)
    expected, _ = sobol_indices(a[kept], b[kept], ab[:, kept])
    np.testing.assert_allclose(found.first.value, expected.value, rtol=1e-12)
    assert (found.rows, found.dropped) == (254, 2)
    assert "2 more left out" in str(found)


@pytest.mark.parametrize("order", [1, -1])
def test_a_study_makes_the_design_that_is_read(order):
    spread = {
        name: dd.sweeps.Normal(mean=1.0, sigma=0.001 * (1 + k))
        for k, name in enumerate(("robot.radius_ratio", "believed.radius_ratio"))
    }
    study = dd.sweeps.Study(
        robot=dd.Robot.load("matched"), maneuver=dd.sweeps.Maneuver("straight", {"speed": 0.5, "distance": 1.0}),
        vary=dict(list(spread.items())[::order]), trials=4 * 64, design="saltelli", truth="kinematics",
    )  # fmt: skip
    found = indices_of(dd.sweep(study), "final_heading")
    # The error is the difference of the two, of standard deviations 1 and 2.
    expected = {"robot.radius_ratio": 0.2, "believed.radius_ratio": 0.8}
    np.testing.assert_allclose(found.total.value, [expected[name] for name in found.names], atol=0.05)


def test_the_size_of_a_sum_belongs_to_no_number_alone():
    a, b = np.random.default_rng(0).normal(size=(2, 2, 8192))
    ab = np.array([[b[0], a[1]], [a[0], b[1]]])
    signed, _ = sobol_indices(a.sum(axis=0), b.sum(axis=0), ab.sum(axis=1))
    size, total = sobol_indices(np.abs(a.sum(axis=0)), np.abs(b.sum(axis=0)), np.abs(ab.sum(axis=1)))
    assert signed.value.sum() == pytest.approx(1, abs=0.05)
    # With phi and Phi of the normal distribution E|z + z'| = 2 phi(z) + z (2 Phi(z) - 1), whose variance is this part
    # of that of |z + z'|, 2 - 4 / pi.
    assert size.value == pytest.approx([0.224, 0.224], abs=0.03)
    assert total.value == pytest.approx([0.776, 0.776], abs=0.05)


def test_bad_input_is_refused():
    a, b, ab = values(64)
    with pytest.raises(ValueError, match="shapes"):
        sobol_indices(a, b[1:], ab)
    with pytest.raises(ValueError, match="does not vary"):
        sobol_indices(np.ones(64), np.ones(64), np.ones((1, 64)))
    with pytest.raises(ValueError, match="at least 16"):
        sobol_indices(a[:8], b[:8], ab[:, :8])
    of_chance = trials()
    of_chance.drawn["robot.track_width"][-1] += 1e-9
    with pytest.raises(ValueError, match="saltelli"):
        indices_of(of_chance, "final_heading")
    with pytest.raises(LookupError, match="figure"):
        indices_of(trials(), "final_position")
