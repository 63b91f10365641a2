import itertools
import math

import numpy as np
import pytest
from helpers import refused
from hypothesis import given
from scipy.integrate import quad
from scipy.optimize import minimize_scalar
from scipy.special import ive
from strategies import numbers, sizes

from diffdrive_mj import se2
from diffdrive_mj.estimation import course
from diffdrive_mj.estimation.course_noise import (
    best_baseline,
    direction_density,
    direction_std,
    end_std,
    first_order_std,
)

EPS = np.finfo(float).eps
ROOT2 = math.sqrt(2)

# How well the fixes tell the course


@given(sizes(1e-3, 1e3))
def test_the_density_is_one(ratio):
    noise, moments = 1 / (ROOT2 * ratio), {}
    breaks = [min(1.0, k / ratio) for k in (1, 4, 12)]
    for name, weight in {"area": lambda t: 1.0, "cosine": math.cos, "square": lambda t: t * t}.items():
        values = [
            quad(lambda t, f=weight: f(t) * direction_density(t, noise, 1.0), a, b, epsabs=1e-15, epsrel=1e-12)[0]
            for a, b in zip([0, *breaks], [*breaks, np.pi], strict=True)
        ]
        moments[name] = 2 * sum(values)
    assert math.isclose(moments["area"], 1, rel_tol=1e-11)
    # The mean resultant length in closed form (Mardia and Jupp 2000).
    quarter = ratio**2 / 4
    resultant = math.sqrt(np.pi / 8) * ratio * (ive(0, quarter) + ive(1, quarter))
    assert math.isclose(moments["cosine"], resultant, rel_tol=1e-11)
    assert math.isclose(direction_std(noise, 1.0), math.sqrt(moments["square"]), rel_tol=1e-10)


@given(numbers(-np.pi, np.pi), sizes(1e-2, 10))
def test_the_density_is_the_integral_over_the_lengths(t, ratio):
    """Closed form against the displaced Gaussian in polar coordinates, integrated along a ray."""

    def along_the_ray(r):
        return r * math.exp(-(r**2 - 2 * r * ratio * math.cos(t) + ratio**2) / 2) / (2 * np.pi)

    peak = max(ratio * math.cos(t), 0)
    expected = sum(quad(along_the_ray, a, b, epsabs=1e-15)[0] for a, b in ((0, peak + 2), (peak + 2, peak + 12)))
    assert math.isclose(direction_density(t, 0.5, ratio * 0.5 * ROOT2), expected, rel_tol=1e-9, abs_tol=1e-14)


def test_the_limits_of_the_exact_standard_deviation():
    assert math.isclose(direction_std(1.0, 1e-9), np.pi / math.sqrt(3), rel_tol=1e-8)
    assert direction_std(0.0, 1.0) == 0
    np.testing.assert_allclose(
        direction_std([1e-12, 1e-9, 1e-7], 1.0), ROOT2 * np.array([1e-12, 1e-9, 1e-7]), rtol=1e-13
    )


@given(sizes(1e-7, 0.1))
def test_first_order_is_low_by_the_square_of_the_relative_noise(relative_noise):
    """By s^2 of itself to leading order: 1 % at s = 0.1, within the next term."""
    first_order, exact = first_order_std(relative_noise, 1.0), direction_std(relative_noise, 1.0)
    assert math.isclose(first_order, ROOT2 * relative_noise)
    assert abs(exact / first_order - 1 - relative_noise**2) <= 10 * relative_noise**4 + 1e-13


def test_the_exact_standard_deviation_grows_with_the_noise():
    stds = direction_std(np.geomspace(1e-10, 1e3, 2000), 1.0)
    assert (np.diff(stds) > 0).all()
    assert stds[-1] < np.pi / math.sqrt(3)


@pytest.mark.parametrize("baseline", [0.01, 0.05, 0.1, 0.3, 1.0, 3.0])
def test_simulated_courses_have_the_predicted_distribution(baseline):
    """Standard deviation within three standard errors, and the density by a chi-square test."""
    rng = np.random.default_rng([7, round(100 * baseline)])
    runs, noise, yaw = 40_000, 0.03, 2.5
    fixes = noise * rng.normal(size=(2, runs, 2))
    fixes[1] += baseline * np.array([np.cos(yaw), np.sin(yaw)])
    error = se2.wrap_angle(course.from_fixes(*fixes, baseline, fix_noise=noise).yaw - yaw)
    square = error**2
    predicted = direction_std(noise, baseline)
    assert abs(square.mean() - predicted**2) < 3 * square.std() / math.sqrt(runs)
    edges = np.quantile(error, np.linspace(0, 1, 21)[1:-1]).round(3)
    edges = np.concatenate([[-np.pi], np.unique(edges), [np.pi]])
    counts, _ = np.histogram(error, edges)
    expected = runs * np.array(
        [quad(direction_density, a, b, args=(noise, baseline))[0] for a, b in itertools.pairwise(edges)]
    )
    # 20 cells at most: 43.8 is passed once in a thousand times.
    assert ((counts - expected) ** 2 / expected).sum() < 43.8


# How far to drive


@given(sizes(1e-4, 0.1), sizes(1e-7, 1e-2))
def test_the_best_baseline_is_the_minimum(noise, random_walk):
    best = best_baseline(noise, random_walk)
    assert math.isclose(best, (12 * noise**2 / random_walk) ** (1 / 3), rel_tol=1e-12)
    found = minimize_scalar(
        lambda w: math.log(end_std(noise, math.exp(w), random_walk)), bracket=(math.log(best) - 1, math.log(best) + 1)
    )
    assert math.isclose(math.exp(found.x), best, rel_tol=1e-6)
    # There the random walk contributes twice what the fixes do.
    least = end_std(noise, best, random_walk)
    assert math.isclose(least**2, random_walk * best / 2, rel_tol=1e-12)
    assert math.isclose(least**2, 3 * first_order_std(noise, best) ** 2, rel_tol=1e-12)
    for factor in (0.9, 1.1):
        assert end_std(noise, factor * best, random_walk) > least


def test_without_a_random_walk_the_fixes_alone_count():
    np.testing.assert_allclose(end_std(0.01, [0.5, 1, 5], 0), first_order_std(0.01, [0.5, 1, 5]), rtol=EPS)


def test_a_heading_that_is_a_random_walk_is_known_as_predicted():
    """Random walks of the heading, straight pieces between: the standard deviation within three standard errors."""
    rng, random_walk, length, steps, noise, runs = np.random.default_rng(3), 1e-3, 2.0, 100, 0.01, 20_000
    turns = rng.normal(size=(runs, steps)) * math.sqrt(random_walk * length / steps)
    heading = np.cumsum(turns, axis=1)
    middle = heading - turns / 2
    end = length / steps * np.stack([np.cos(middle), np.sin(middle)], axis=-1).sum(axis=1)
    fixes = noise * rng.normal(size=(2, runs, 2))
    result = course.from_fixes(fixes[0], fixes[1] + end, length, fix_noise=noise)
    square = se2.wrap_angle(result.yaw - heading[:, -1]) ** 2
    assert abs(square.mean() - end_std(noise, length, random_walk) ** 2) < 3 * square.std() / math.sqrt(runs)


# Bad input


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: first_order_std(-1, 1), ("fix_noise = -1",)),
        (lambda: first_order_std(1, 0), ("baseline = 0", "positive")),
        (lambda: first_order_std([1, 2], [1, 2, 3]), ("baseline (3,)", "broadcast")),
        (lambda: direction_std(1, -2), ("baseline = -2", "positive")),
        (lambda: direction_std(math.inf, 1), ("fix_noise", "inf")),
        (lambda: direction_density(0, 0, 1), ("fix_noise = 0", "positive")),
        (lambda: direction_density(math.nan, 1, 1), ("angle", "nan")),
        (lambda: direction_density([0, 1], [1, 2, 3], 1), ("angle (2,)", "broadcast")),
        (lambda: end_std(1, 1, -1), ("random_walk = -1", "not be negative")),
        (lambda: end_std(-1, 1, 1), ("fix_noise = -1",)),
        (lambda: end_std([1, 2], 1, [1, 2, 3]), ("random_walk (3,)", "broadcast")),
        (lambda: best_baseline(0.01, 0), ("random_walk = 0", "positive")),
        (lambda: best_baseline(0.01, -1), ("random_walk = -1", "positive")),
        (lambda: best_baseline(-0.01, 1), ("fix_noise = -0.01", "positive")),
        (lambda: best_baseline(0.01, math.nan), ("random_walk", "nan")),
        (lambda: best_baseline([1, 2], [1, 2, 3]), ("random_walk (3,)", "broadcast")),
    ],
)
def test_bad_values_are_refused(call, words):
    with refused(ValueError, *words):
        call()
