import math

import numpy as np
import pytest
from helpers import exact_arc, matrix, refused
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm
from strategies import angles, numbers, poses, signs, sizes

from diffdrive_mj import se2

ORIGIN = np.zeros(3)
EPS = np.finfo(float).eps
same = {"rtol": 0, "atol": 1e-12}
short_turns = st.tuples(numbers(-10, 10), numbers(-10, 10), numbers(-3.14, 3.14))


# The group


@given(poses, poses, poses)
def test_composing_is_associative(a, b, c):
    np.testing.assert_allclose(se2.compose(se2.compose(a, b), c), se2.compose(a, se2.compose(b, c)), **same)


@given(poses)
def test_the_origin_changes_nothing(a):
    np.testing.assert_array_equal(se2.compose(a, ORIGIN), a)
    np.testing.assert_array_equal(se2.compose(ORIGIN, a), a)


@given(poses)
def test_the_inverse_undoes(a):
    np.testing.assert_allclose(se2.compose(a, se2.inverse(a)), ORIGIN, **same)
    np.testing.assert_allclose(se2.compose(se2.inverse(a), a), ORIGIN, **same)


@given(poses, poses)
def test_between_undoes_compose(a, b):
    np.testing.assert_allclose(se2.between(a, se2.compose(a, b)), b, **same)
    np.testing.assert_allclose(se2.compose(a, se2.between(a, b)), b, **same)
    np.testing.assert_allclose(se2.between(a, b), se2.compose(se2.inverse(a), b), **same)


@given(poses, poses)
def test_composing_is_multiplying_matrices(a, b):
    np.testing.assert_allclose(matrix(se2.compose(a, b)), matrix(a) @ matrix(b), **same)
    np.testing.assert_allclose(matrix(se2.inverse(a)), np.linalg.inv(matrix(a)), **same)


def test_headings_are_never_wrapped():
    assert se2.compose((0, 0, 3), (0, 0, 9))[2] == 12
    assert se2.between((0, 0, 3), (0, 0, 12))[2] == 9


# The exponential and the logarithm


def test_exp_of_a_quarter_circle():
    np.testing.assert_allclose(se2.exp((5 * np.pi / 2, 0, np.pi / 2)), (5, 5, np.pi / 2), rtol=1e-15)


def test_exp_sideways():
    """A quarter circle driven sideways, to the left, ends at (-r, r)."""
    np.testing.assert_allclose(se2.exp((0, 5 * np.pi / 2, np.pi / 2)), (-5, 5, np.pi / 2), rtol=1e-15)


@given(st.tuples(numbers(-2, 2), numbers(-2, 2), numbers(-10, 10)))
def test_exp_is_the_matrix_exponential(xi):
    u, w, theta = xi
    generator = np.array([[0, -theta, u], [theta, 0, w], [0, 0, 0]])
    np.testing.assert_allclose(matrix(se2.exp(xi)), expm(generator), rtol=0, atol=1e-12)


@given(numbers(-5, 5), numbers(-5, 5), sizes(1e-12, 1e2), signs)
def test_exp_keeps_all_digits_of_the_path(u, w, size, sign):
    """Within 2e-15 of the path's length for turns from 1e-12 to 100 rad: no threshold, no cancellation."""
    theta = sign * size
    error = np.subtract(se2.exp((u, w, theta))[:2], exact_arc(u, w, theta))
    assert np.hypot(*error) <= 2e-15 * math.hypot(u, w)


@given(sizes(1e-12, 1.0), signs)
def test_exp_keeps_all_digits_of_each_coordinate(size, sign):
    """The sideways part of a slight arc is tiny, and yet has all its digits."""
    np.testing.assert_allclose(se2.exp((1, 0, sign * size))[:2], exact_arc(1, 0, sign * size), rtol=4 * EPS)


def test_exp_without_a_turn_is_exact():
    np.testing.assert_array_equal(se2.exp((0.3, -0.7, 0)), (0.3, -0.7, 0))


@given(short_turns)
def test_log_undoes_exp(xi):
    np.testing.assert_allclose(se2.log(se2.exp(xi)), xi, **same)


@given(poses)
def test_exp_undoes_log_but_for_whole_turns(pose):
    again = se2.exp(se2.log(pose))
    np.testing.assert_allclose(matrix(again), matrix(pose), **same)


@given(poses)
def test_log_takes_the_shorter_turn(pose):
    assert -np.pi < se2.log(pose)[2] <= np.pi


@given(short_turns, numbers(-1, 1), numbers(-1, 1))
def test_parts_of_one_twist_add_up(xi, s, t):
    parts = se2.compose(se2.exp(np.multiply(s, xi)), se2.exp(np.multiply(t, xi)))
    np.testing.assert_allclose(parts, se2.exp(np.multiply(s + t, xi)), **same)


# Angles


@given(numbers(-1e6, 1e6))
def test_wrapped_angles_point_the_same_way(theta):
    wrapped = se2.wrap_angle(theta)
    assert -np.pi < wrapped <= np.pi
    # 1e6 rad has an ulp of 1.2e-10, and the float 2 pi is off by 2.4e-16 a turn.
    assert math.isclose(math.cos(wrapped), math.cos(theta), abs_tol=2e-10)
    assert math.isclose(math.sin(wrapped), math.sin(theta), abs_tol=2e-10)


@given(st.integers(-1000, 1000), st.integers(-30, 30))
def test_wrapped_angles_stay_inside_at_every_seam(turns, ulps):
    seam = (2 * turns + 1) * np.pi
    wrapped = se2.wrap_angle(seam + ulps * np.spacing(seam))
    assert -np.pi < wrapped <= np.pi


@given(st.floats(np.nextafter(-np.pi, 0), np.pi))
def test_wrapping_keeps_every_bit_inside(theta):
    wrapped = se2.wrap_angle(theta)
    assert wrapped == theta
    assert np.signbit(wrapped) == np.signbit(theta)


@pytest.mark.parametrize(
    ("theta", "expected"),
    [
        (np.pi, np.pi),
        (-np.pi, np.pi),
        (np.nextafter(-np.pi, 0), np.nextafter(-np.pi, 0)),
        (np.nextafter(np.pi, 4), np.nextafter(np.pi, 4) - 2 * np.pi),
        (2 * np.pi, 0),
        (-3 * np.pi / 2, np.pi / 2),
    ],
)
def test_wrapping_at_the_seam(theta, expected):
    assert se2.wrap_angle(theta) == expected


@given(angles)
def test_rotating_is_counter_clockwise(theta):
    np.testing.assert_array_equal(se2.rotate((1, 0), theta), (np.cos(theta), np.sin(theta)))
    np.testing.assert_array_equal(se2.rotate((0, 1), theta), (-np.sin(theta), np.cos(theta)))


@given(sizes(1e-12, 1e2))
def test_sinc(x):
    assert math.isclose(se2.sinc(np.float64(x)), math.sin(x) / x, rel_tol=0, abs_tol=4 * EPS)
    assert se2.sinc(np.float64(0)) == 1


# Shapes and bad input


@pytest.mark.parametrize("shapes", [((3,), (5, 3)), ((5, 3), (3,)), ((4, 1, 3), (5, 3)), ((2, 5, 3), (2, 5, 3))])
@pytest.mark.parametrize("operation", [se2.compose, se2.between])
def test_leading_dimensions_broadcast(operation, shapes):
    rng = np.random.default_rng(1)
    a, b = (rng.uniform(-2, 2, shape) for shape in shapes)
    result = operation(a, b)
    full_a, full_b = np.broadcast_arrays(a, b)
    assert result.shape == full_a.shape
    for index in np.ndindex(result.shape[:-1]):
        np.testing.assert_allclose(result[index], operation(full_a[index], full_b[index]), rtol=0, atol=1e-15)


@pytest.mark.parametrize("operation", [se2.inverse, se2.exp, se2.log])
def test_many_poses_at_once(operation):
    many = np.random.default_rng(2).uniform(-2, 2, (4, 5, 3))
    result = operation(many)
    assert result.shape == many.shape
    np.testing.assert_allclose(result[3, 1], operation(many[3, 1]), rtol=0, atol=1e-15)


def test_input_is_not_changed():
    a, b = np.array([1.0, 2.0, 4.0]), np.array([3.0, 4.0, 5.0])
    for operation in (se2.compose, se2.between):
        operation(a, b)
    for operation in (se2.inverse, se2.exp, se2.log, se2.wrap_angle):
        operation(a)
    np.testing.assert_array_equal(a, (1, 2, 4))
    np.testing.assert_array_equal(b, (3, 4, 5))


@pytest.mark.parametrize(
    ("call", "name"),
    [
        (lambda bad: se2.compose(bad, ORIGIN), "a"),
        (lambda bad: se2.compose(ORIGIN, bad), "b"),
        (lambda bad: se2.between(bad, ORIGIN), "a"),
        (lambda bad: se2.between(ORIGIN, bad), "b"),
        (se2.inverse, "a"),
        (se2.exp, "twist_times_dt"),
        (se2.log, "pose"),
    ],
)
def test_bad_poses_are_refused(call, name):
    with refused(ValueError, f"{name} has shape (2,)", "(..., 3)"):
        call((1, 2))
    with refused(ValueError, f"{name}[2] = nan", "finite"):
        call((1, 2, math.nan))
    with refused(ValueError, f"{name}[0] = -inf", "finite"):
        call((-math.inf, 2, 0))
    with refused(ValueError, f"{name} is empty"):
        call(np.empty((0, 3)))
    with refused(TypeError, name, "numbers"):
        call("north")


def test_bad_angles_are_refused():
    with refused(ValueError, "theta", "nan", "finite"):
        se2.wrap_angle(math.nan)
    with refused(ValueError, "theta[1] = inf"):
        se2.rotate((1, 0), [0, math.inf])
    with refused(ValueError, "points has shape (3,)"):
        se2.rotate((1, 0, 0), 0)


def test_shapes_that_do_not_fit_are_refused():
    two, four = np.zeros((2, 3)), np.zeros((4, 3))
    for operation in (se2.compose, se2.between):
        with refused(ValueError, "a (2,)", "b (4,)", "broadcast"):
            operation(two, four)
    with refused(ValueError, "points (2,)", "theta (3,)"):
        se2.rotate(np.zeros((2, 2)), np.zeros(3))


def test_headings_are_unwrapped_as_they_were_before_wrapping():
    steps = np.random.default_rng(0).uniform(-3.1, 3.1, (4, 50))
    poses = np.zeros((4, 50, 3))
    poses[..., 2] = np.cumsum(steps, axis=-1)
    poses[..., :2] = steps[..., None]
    wrapped = poses.copy()
    wrapped[:, 1:, 2] = se2.wrap_angle(poses[:, 1:, 2])
    np.testing.assert_allclose(se2.unwrapped(wrapped), poses, atol=1e-12)
