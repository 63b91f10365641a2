"""Prices of tolerances against closed forms, robots driven again, and what cannot be priced."""

import math

import numpy as np
import pytest

import diffdrive_mj as dd
from diffdrive_mj.sweeps import Choice, Grid, LogNormal, Maneuver, Normal, Study, Trials, Uniform, budget
from diffdrive_mj.sweeps.linear import first_order
from diffdrive_mj.sweeps.prices import effective_number, prices_of, tightened, weights_when_tightened

ROBOT = dd.Robot.load("matched")
SPREADS = {
    "robot.mean_radius": Normal(mean=0.1, sigma=0.001),
    "robot.radius_ratio": Normal(mean=1.0, sigma=0.02),
    "robot.track_width": Uniform(low=0.398, high=0.402),
}


def study(trials=1000, design="random", **changes):
    square = Maneuver("square", {"side": 0.5, "yaw_rate": 2.0})
    given = {"vary": SPREADS, "maneuver": square, "sample_rate": 20.0, **changes}
    return Study(robot=ROBOT, trials=trials, design=design, truth="kinematics", **given)


def made_up(outcome, sigmas=(3.0, 1.0), design="random"):
    """Trials whose figure is the sum of two normal numbers, and their study."""
    names = ("robot.left_radius", "robot.right_radius")
    of = study(len(outcome), design, vary={name: Normal(mean=0.1, sigma=1e-3) for name in names})
    drawn = of.drawn(0, len(outcome))
    total = sum(sigma * (drawn[name] - 0.1) / 1e-3 for sigma, name in zip(sigmas, names, strict=True))
    figure = np.where(outcome == "ok", total, np.nan)
    return of, Trials(np.arange(len(outcome)), drawn, {"final_heading": figure}, outcome, outcome)


OK = np.full(4000, "ok", dtype="<U8")


@pytest.mark.parametrize("spread", [Normal(mean=0.4, sigma=0.01), LogNormal(median=0.4, sigma=0.1), *SPREADS.values()])
@pytest.mark.parametrize("factor", [0.5, 0.8])
def test_weighted_trials_are_trials_of_the_narrower_spread(spread, factor):
    shares = (np.arange(200_000) + 0.5) / 200_000
    drawn, narrow = spread.at(shares), spread.scaled(factor).at(shares)
    weights = weights_when_tightened(spread, drawn, factor)
    assert weights.mean() == pytest.approx(1, abs=1e-3)
    assert weights.max() <= 1 / factor + 1e-9  # no trial stands for many
    for power in (1, 2):
        assert (weights * drawn**power).mean() == pytest.approx((narrow**power).mean(), rel=1e-4)
    # Of a normal spread they are worth the share c sqrt(2 - c^2), of an even one c.
    worth = factor if isinstance(spread, Uniform) else factor * math.sqrt(2 - factor**2)
    assert effective_number(weights) / len(weights) == pytest.approx(worth, rel=1e-3)


@pytest.mark.parametrize("design", ["random", "saltelli"])
def test_the_price_of_a_part_of_a_sum_is_known(design):
    of, trials = made_up(OK, design=design)
    found = prices_of(of, trials, "final_heading")
    # Every percentile of a normal sum is in proportion to its standard deviation.
    fall = 1 - np.sqrt([(1.5**2 + 1) / 10, (9 + 0.5**2) / 10])
    assert np.all((found.fall.low < fall) & (fall < found.fall.high))
    assert np.all(found.fall.high - found.fall.low < 0.2)
    assert found.effective == pytest.approx(0.6614 * (4000 if design == "random" else 2000), rel=0.05)


def test_limits_hold_as_often_as_they_say():
    fall, held = 1 - math.sqrt((1.5**2 + 1) / 10), []
    for seed in range(100):
        of, _ = made_up(OK[:1000])
        of = of.replace(seed=seed)
        drawn = of.drawn(0, 1000)
        total = 1e3 * (3 * (drawn["robot.left_radius"] - 0.1) + drawn["robot.right_radius"] - 0.1)
        trials = Trials(np.arange(1000), drawn, {"final_heading": total}, OK[:1000], OK[:1000])
        found = prices_of(of, trials, "final_heading", share=0.95, seed=seed).fall[0]
        held.append(found.low <= fall <= found.high)
    assert np.mean(held) > 0.95 - 4 * math.sqrt(0.05 * 0.95 / 100)


@pytest.fixture(scope="module")
def driven():
    return dd.sweep(study())


def test_trials_that_hang_together_are_resampled_together():
    of, trials = made_up(OK, sigmas=(3.0, 0.0), design="saltelli")
    # The second number does nothing, so that every robot is there twice.
    twice, once = (
        prices_of(of, each, "final_heading", share=0.9).fall[0] for each in (trials, trials.where(half(trials)))
    )
    assert twice.value == pytest.approx(once.value, rel=1e-9)
    assert twice.high - twice.low == pytest.approx(once.high - once.low, rel=0.2)


def half(trials):
    return np.arange(len(trials)) < len(trials) / 2  # blocks A and B


@pytest.mark.parametrize("name", SPREADS)
def test_robots_that_are_tighter_show_the_price(name, driven):
    of, share = study(), 0.95
    prices = prices_of(of, driven, "final_position", share=share)
    fall = prices.fall[prices.names.index(name)]
    before, after = (each.percentile("final_position", share).value for each in (driven, dd.sweep(tightened(of, name))))
    assert fall.low <= 1 - after / before <= fall.high


def test_robots_that_fell_are_beyond_and_those_that_cannot_be_are_left_out():
    outcome = OK.copy()
    outcome[:200] = "fell"  # 5 %
    of, trials = made_up(outcome)
    with pytest.raises(ValueError, match="no tolerance changes that"):
        prices_of(of, trials, "final_heading", share=0.96)
    ordinary = prices_of(*made_up(OK[200:]), "final_heading", share=0.94 / 0.95)
    assert prices_of(of, trials, "final_heading", share=0.94).percentile == pytest.approx(ordinary.percentile, rel=0.2)
    outcome[:200] = "refused"
    of, trials = made_up(outcome)
    assert prices_of(of, trials, "final_heading").percentile == pytest.approx(2.576 * math.sqrt(10), rel=0.1)


@pytest.mark.parametrize("design", ["random", "saltelli"])
def test_a_budget_names_the_dearest_tolerance(design):
    of = study(5 * 200, design)
    found = budget(of, dd.sweep(of), share=0.9)
    assert found.dearest == "robot.radius_ratio"
    assert found.finding.startswith("Halve the spread of the radius ratio, and the 90th percentile")
    text, page = str(found), found._repr_html_()
    assert text.index("radius ratio ") < text.index("track width ")
    assert ("with the others" in text) == (design == "saltelli") == ("with the others" in page)
    assert found.as_dict()["tolerances"]["robot.radius_ratio"]["spread"] == pytest.approx(0.02, rel=0.1)


def test_a_choice_has_shares_but_no_price():
    heavy = {"robot.radius_ratio": Normal(mean=1.0, sigma=0.004), "robot.track_width": Choice(values=(0.39, 0.41))}
    of = study(4 * 256, "saltelli", vary=heavy)
    found = budget(of, dd.sweep(of), "final_heading", share=0.9)
    assert found.prices.names == ("robot.radius_ratio",)
    assert set(found.indices.names) == set(heavy)
    assert "track width" in str(found)


def test_each_value_of_a_grid_has_a_budget_of_its_own():
    of = study(2000, vary={**SPREADS, "maneuver.side": Grid(values=(0.5, 1.0))})
    trials = dd.sweep(of, workers=1, chunk=500)
    with pytest.raises(ValueError, match=r"2 values of the grid maneuver.side: .*trials.by\('maneuver.side'\)"):
        budget(of, trials, share=0.9)
    for (side,), part in trials.by("maneuver.side").items():
        alone = study(1000, maneuver=Maneuver("square", {**of.maneuver.options, "side": side}))
        expected = budget(alone, dd.sweep(alone, workers=1, chunk=500), share=0.9)
        assert str(budget(of, part, share=0.9)) == str(expected)


def test_first_order_is_the_scatter_of_small_tolerances():
    small = {name: spread.scaled(0.1) for name, spread in SPREADS.items()}
    of = study(512, "sobol", vary=small)
    trials, theory = dd.sweep(of), first_order(of)
    rms = {name: math.sqrt(np.mean(values**2)) for name, values in trials.figures.items()}
    # Evenly spread points leave little to chance, and the next order is far below it.
    assert rms["final_heading"] == pytest.approx(theory.heading_sigma, rel=0.01)
    assert rms["final_position"] == pytest.approx(theory.position_rms, rel=0.01)
    with pytest.raises(ValueError, match="first order knows"):
        first_order(of.replace(vary={"world.friction": Uniform(low=0.5, high=0.7)}))


def test_bad_input_is_refused():
    of, trials = made_up(OK)
    with pytest.raises(ValueError, match="at most 1"):
        prices_of(of, trials, "final_heading", factor=2)
    with pytest.raises(ValueError, match="drive more"):
        prices_of(*made_up(OK[:300]), "final_heading")
    with pytest.raises(ValueError, match="nothing varies whose spread"):
        budget(study(3, vary={}), dd.sweep(study(3, vary={})))
    with pytest.raises(ValueError, match="of this study"):
        prices_of(of.replace(seed=1), trials, "final_heading")
    with pytest.raises(ValueError, match="no width"):
        tightened(of.replace(vary={"robot.track_width": Choice(values=(0.39, 0.41))}), "robot.track_width")
