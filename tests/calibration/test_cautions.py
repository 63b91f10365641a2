"""Cautions: each said where its reason is there, with its figures, and not a little before."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest
from planted import BELIEVED, TRUE, ideal, mixed, noisy

import diffdrive_mj as dd
from diffdrive_mj.calibration._cautions import _slow_encoder, cautions, speed_at_first
from diffdrive_mj.calibration._fit import refine
from diffdrive_mj.calibration._problem import Problem
from diffdrive_mj.estimation.derivatives import parameters_of


@pytest.fixture(scope="module")
def fit():
    """Of four drives with noise, about which there is nothing to say."""
    rng = np.random.default_rng(0)
    drives = [noisy(ideal(TRUE, mixed(period=0.05)), 1e-3, rng) for _ in range(4)]
    drives = [dataclasses.replace(drive, name=f"run {k}", truth_t=drive.clock) for k, drive in enumerate(drives)]
    problem = Problem(drives, BELIEVED, start="estimated", clock_offset=False, headings=True)
    fit = refine(problem, parameters_of(TRUE), 3)
    return dataclasses.replace(fit, outliers=[0] * 4)


def said(fit, **changes):
    return list(cautions(dataclasses.replace(fit, **changes), BELIEVED))


def test_of_a_good_fit_nothing_is_said(fit):
    assert said(fit) == []


@pytest.mark.parametrize(("worse", "reported"), [(2.9, False), (3.1, True)])
def test_a_drive_that_fits_three_times_worse_is_odd_among_three(fit, worse, reported):
    spreads = [1.0, 1.0, worse, 1.0]
    assert said(fit, spreads=spreads) == [f"run 2: fits {worse} times worse than the other drives"] * reported
    # Of two drives nobody knows which is the odd one.
    assert list(_odd_of(fit, [0.1, worse])) == []


def _odd_of(fit, spreads):
    two = fit.problem.on(fit.problem.drives[:2])
    return cautions(dataclasses.replace(fit, problem=two, spreads=spreads, outliers=[0, 0]), BELIEVED)


def test_outliers_are_counted_with_their_share(fit):
    count = len(fit.problem.drives[1].truth)
    (words,) = said(fit, outliers=[0, 71, 0, 0])
    assert words == f"run 1: 71 true poses ({100 * 71 / count:.1f} %) lie more than 6 sigma off"
    assert 5 < 100 * 71 / count < 50


@pytest.mark.parametrize(("relative", "seen"), [(0.049, True), (0.051, False)])
def test_what_is_known_to_less_than_a_twentieth_is_not_shown(fit, relative, seen):
    covariance = fit.uncertainty.covariance.copy()
    covariance[2, 2] = (relative * BELIEVED.track_width) ** 2
    found = said(fit, uncertainty=dataclasses.replace(fit.uncertainty, covariance=covariance))
    assert [words.startswith("the drives do not show track_width (condition ") for words in found] == [True] * (
        not seen
    )


@pytest.mark.parametrize("readings", [19, 20])
def test_a_slow_encoder_is_named_with_its_rate_if_it_has_been_read_often_enough(readings):
    """Readings a second apart on a slalom; the path's curvature changes in between."""
    t = np.arange(0.0, readings - 1 + 1e-9, 0.05)
    rates = np.stack([5 + 4 * np.sin(t), 5 - 4 * np.sin(t)], axis=-1)
    angles = np.concatenate([np.zeros((1, 2)), np.cumsum(rates * 0.05, axis=0)])[:-1]
    truth = dd.odometry.integrate(angles, TRUE)
    drive = dd.Drive(t[::20], angles[::20], truth[::20])
    assert len(drive.t) == readings
    problem = Problem([drive], BELIEVED, start="estimated", clock_offset=False, headings=True)
    fit = refine(problem, parameters_of(TRUE), 3)
    # As if its residuals said that it were exact.
    uncertainty = dataclasses.replace(fit.uncertainty, covariance=1e-12 * np.eye(3), rough=False)
    fit = dataclasses.replace(fit, outliers=[0], uncertainty=uncertainty)
    found = list(cautions(fit, BELIEVED))
    assert [words.startswith("the encoder is read slowly for this path (1 Hz)") for words in found] == [True] * (
        readings == 20
    )


@pytest.mark.parametrize(
    ("bias", "said"), [((0.9e-6, 1e-7, 1e-7), False), ((1.5e-6, 1e-7, 1e-7), True), ((1e-7, 1.5e-6, 1e-7), True)]
)
def test_a_bias_is_said_from_a_millionth_on(fit, bias, said):
    assert bool([*_slow_encoder(_biased(fit, bias, 1e-9))]) == said


@pytest.mark.parametrize(("sigmas", "said"), [(1.9, False), (2.5, True)])
def test_a_bias_is_said_from_twice_the_stated_deviation_on(fit, sigmas, said):
    assert bool([*_slow_encoder(_biased(fit, (1e-4 * sigmas, 0.0, 0.0), 1e-4))]) == said


def _biased(fit, relative, std):
    """A fit whose bias is so large, and whose deviations are, relative to the parameters."""
    problem = SimpleNamespace(drives=fit.problem.drives, sampling_bias=lambda x: np.array(relative) * x)
    return SimpleNamespace(problem=problem, free=fit.free, std=std * fit.free)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("every", [25, 50])
def test_the_bias_of_a_slow_encoder_is_what_the_parameters_are_off_by(seed, every):
    """On slaloms whose encoder is read at 20 and 10 Hz, with poses that are exact."""
    rng = np.random.default_rng(seed)
    t, (left, right, rate) = np.arange(0, 20, 0.002), rng.uniform(2, 4, 3)
    rates = np.stack([5 + left * np.sin(rate * t / 2), 5 - right * np.sin(rate * t / 2 + 0.5)], axis=-1)
    angles = np.concatenate([np.zeros((1, 2)), np.cumsum(0.002 * rates, axis=0)])[:-1]
    truth = dd.odometry.integrate(angles, TRUE)
    drive = dd.Drive(t[::every], angles[::every], truth[::every])
    fit = refine(Problem([drive], BELIEVED, start="truth", clock_offset=False, headings=True), parameters_of(TRUE), 3)
    off = fit.free - parameters_of(TRUE)[:3]
    assert fit.problem.sampling_bias(fit.free) == pytest.approx(off, rel=0.4)


@pytest.mark.parametrize(("share", "moving"), [(0.0, False), (0.09, False), (0.12, True), (1.0, True)])
@pytest.mark.parametrize("way", [1, -1])
def test_a_log_begins_in_motion_from_a_tenth_of_the_fastest_speed_on(share, moving, way):
    t = np.arange(0.0, 10.0, 0.02)
    rates = np.where(t < 0.3, share, 1.0) * 5 * way
    angles = np.stack([np.cumsum(rates) * 0.02] * 2, axis=-1)
    drive = dd.Drive(t, angles, dd.odometry.integrate(angles, BELIEVED))
    speed = speed_at_first(drive, BELIEVED)
    assert speed == (pytest.approx(0.5 * share) if moving else 0.0)
    assert isinstance(speed, float)
