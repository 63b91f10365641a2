"""What a bend hides: chords in exact arithmetic, laws for small bends, and where epsilon sees one."""

import math
from fractions import Fraction

import numpy as np
import pytest
from helpers import refused
from hypothesis import given
from hypothesis import strategies as st
from strategies import numbers, signs, sizes

from diffdrive_mj import se2
from diffdrive_mj.estimation import course, straightness

EPS = np.finfo(float).eps
ROOT2 = math.sqrt(2)


@given(sizes(1e-9, 2 * np.pi), signs, sizes(0.01, 100))
def test_the_chord_of_an_arc_is_shorter(bend, sign, length):
    """Exact against the series in rational arithmetic, and against the chord of `se2.exp`."""
    shortening = straightness.chord_shortening(sign * bend, length)
    half = Fraction(bend) / 2
    term, total = Fraction(1), Fraction(0)
    for n in range(1, 30):
        term *= -(half**2) / ((2 * n) * (2 * n + 1))
        term = term.limit_denominator(10**60)
        total -= term
    assert math.isclose(shortening, length * float(total), rel_tol=1e-14, abs_tol=1e-50)
    chord = np.hypot(*se2.exp((length, 0, sign * bend))[:2])
    assert math.isclose(length - shortening, chord, rel_tol=8 * EPS, abs_tol=8 * EPS * length)


@given(sizes(1e-6, 0.5), sizes(0.01, 100))
def test_the_shortening_is_a_24th_of_the_square(bend, length):
    """w beta^2 / 24, high by a part beta^2 / 80 of itself at most."""
    law = length * bend**2 / 24
    assert law * (1 - bend**2 / 80 - 1e-14) <= straightness.chord_shortening(bend, length) <= law * (1 + 1e-14)


def test_ten_degrees_over_a_metre_hide_in_a_millimetre():
    assert math.isclose(straightness.chord_shortening(np.radians(10), 1.0), 1.27e-3, rel_tol=2e-3)
    # Of a full circle there is no chord.
    assert math.isclose(straightness.chord_shortening(2 * np.pi, 3.0), 3.0, rel_tol=1e-13)


@given(numbers(-3, 3), numbers(-6, 6), sizes(0.1, 10))
def test_a_bend_puts_the_course_off_by_half_of_it(yaw, bend, length):
    """And epsilon of fixes without noise is the shortening."""
    end = se2.compose((1, 2, yaw), se2.exp((length, 0, bend)))
    result = course.from_fixes((1, 2), end[:2], length, fix_noise=0)
    assert abs(se2.wrap_angle(end[2] - result.yaw - bend / 2)) <= 1e-13
    assert math.isclose(result.epsilon, straightness.chord_shortening(bend, length), abs_tol=1e-13)


@given(sizes(1e-12, 0.235), sizes(0.01, 100), st.sampled_from((1.0, 3.0)))
def test_the_smallest_visible_bend_shortens_by_the_threshold(relative_noise, length, sigmas):
    noise = relative_noise * length
    bend = straightness.smallest_visible_bend(noise, length, sigmas)
    assert 0 < bend <= 2 * np.pi * (1 + 1e-12)
    shortening = straightness.chord_shortening(min(bend, 2 * np.pi), length)
    assert math.isclose(shortening, sigmas * ROOT2 * noise, rel_tol=1e-12)
    assert straightness.hidden_course_error(noise, length, sigmas) == min(bend / 2, np.pi)


@given(sizes(1e-12, 1e-4))
def test_a_small_visible_bend_follows_the_root_law(relative_noise):
    law = math.sqrt(72 * ROOT2 * relative_noise)
    assert law <= straightness.smallest_visible_bend(relative_noise, 1.0) <= law * (1 + law**2 / 100)


def test_epsilon_sees_the_bend_at_its_own_threshold():
    """Of paths without noise in their fixes, those above the smallest visible bend are flagged."""
    for noise in (0.001, 0.01, 0.03):
        bend = straightness.smallest_visible_bend(noise, 1.0)
        for factor, seen in ((0.999, False), (1.001, True)):
            end = se2.exp((1.0, 0, factor * bend))
            assert bool(course.from_fixes((0, 0), end[:2], 1.0, fix_noise=noise).straight) is not seen


def test_noise_may_hide_every_bend():
    bends = straightness.smallest_visible_bend([0.0, 0.01, 0.235, 0.236], 1.0)
    assert bends[0] == 0
    assert bends[2] < 2 * np.pi
    assert bends[3] == np.inf
    full_circle = (1 - 1e-15) / (3 * ROOT2)
    assert math.isclose(straightness.smallest_visible_bend(full_circle, 1.0), 2 * np.pi, rel_tol=1e-13)
    np.testing.assert_array_equal(straightness.hidden_course_error([0.0, 0.236, 100.0], 1.0), (0, np.pi, np.pi))


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: straightness.chord_shortening(6.3, 1), ("bend = 6.3", "full circle")),
        (lambda: straightness.chord_shortening([0.1, -6.3], 1), ("bend = 6.3", "full circle")),
        (lambda: straightness.chord_shortening(math.nan, 1), ("bend", "nan")),
        (lambda: straightness.chord_shortening(1, 0), ("travelled = 0", "positive")),
        (lambda: straightness.chord_shortening([1, 2], [1, 2, 3]), ("bend (2,)", "broadcast")),
        (lambda: straightness.smallest_visible_bend(-1, 1), ("fix_noise = -1", "not be negative")),
        (lambda: straightness.smallest_visible_bend(0.1, -1), ("travelled = -1", "positive")),
        (lambda: straightness.smallest_visible_bend(0.1, 1, sigmas=0), ("sigmas = 0", "positive")),
        (lambda: straightness.smallest_visible_bend([0.1, 0.2], [1, 2, 3]), ("fix_noise (2,)", "broadcast")),
        (lambda: straightness.hidden_course_error(0.1, math.inf), ("travelled", "inf")),
    ],
)
def test_bad_values_are_refused(call, words):
    with refused(ValueError, *words):
        call()
