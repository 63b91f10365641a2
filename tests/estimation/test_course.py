import math
from dataclasses import FrozenInstanceError

import numpy as np
import pytest
from helpers import refused
from hypothesis import assume, given
from hypothesis import strategies as st
from strategies import angles, numbers, sizes

from diffdrive_mj import se2
from diffdrive_mj.estimation import course
from diffdrive_mj.estimation.course_noise import direction_std

EPS = np.finfo(float).eps
ROOT2 = math.sqrt(2)
points = st.tuples(numbers(-10, 10), numbers(-10, 10))
vectors = st.tuples(numbers(-10, 10), numbers(-10, 10)).filter(lambda v: math.hypot(*v) > 1e-6)

# x, y, bearing and yaw in degrees.
COMPASS = [
    (0, 1, 0, 90),
    (1, 1, 45, 45),
    (1, 0, 90, 0),
    (1, -1, 135, -45),
    (0, -1, 180, -90),
    (-1, -1, 225, -135),
    (-1, 0, 270, 180),
    (-1, 1, 315, 135),
]


def off(a, b):
    """How far two directions are apart."""
    return np.abs(se2.wrap_angle(np.subtract(a, b)))


def drive(start, length, bend=0.0, **options):
    """The course of an arc driven from a pose, and the pose at its end."""
    end = se2.compose(start, se2.exp((length, 0, bend)))
    return course.from_fixes(start[:2], end[:2], length, **{"fix_noise": 0.01, **options}), end


# Bearing and yaw


@pytest.mark.parametrize(("x", "y", "bearing", "yaw"), COMPASS)
@pytest.mark.parametrize("size", [1e-9, 1.0, 1e6])
def test_the_compass(x, y, bearing, yaw, size):
    vector = (size * x, size * y)
    assert math.isclose(course.bearing_of(vector), math.radians(bearing), abs_tol=EPS)
    assert math.isclose(course.yaw_of(vector), math.radians(yaw), abs_tol=EPS)
    assert math.isclose(course.bearing_by_arccos(vector), math.radians(bearing), abs_tol=1e-7)
    assert math.isclose(course.yaw_from_bearing(math.radians(bearing)), math.radians(yaw), abs_tol=EPS)
    assert math.isclose(course.bearing_from_yaw(math.radians(yaw)), math.radians(bearing), abs_tol=EPS)


@given(vectors)
def test_bearing_and_yaw_are_one_direction(vector):
    bearing, yaw = course.bearing_of(vector), course.yaw_of(vector)
    assert 0 <= bearing < 2 * np.pi
    assert -np.pi < yaw <= np.pi
    assert off(yaw, np.pi / 2 - bearing) <= 4 * EPS
    assert off(course.yaw_from_bearing(bearing), yaw) <= 4 * EPS
    assert off(course.bearing_from_yaw(yaw), bearing) <= 4 * EPS
    np.testing.assert_allclose(np.hypot(*vector) * np.array([np.sin(bearing), np.cos(bearing)]), vector, atol=1e-14)


@given(angles)
def test_bearing_to_yaw_and_back(angle):
    bearing, yaw = course.bearing_from_yaw(angle), course.yaw_from_bearing(angle)
    assert 0 <= bearing < 2 * np.pi
    assert -np.pi < yaw <= np.pi
    assert off(course.yaw_from_bearing(bearing), angle) <= 1e-14
    assert off(course.bearing_from_yaw(yaw), angle) <= 1e-14


@pytest.mark.parametrize(
    ("vector", "bearing", "yaw"),
    [((-1e-320, 1), 0, np.pi / 2), ((-0.0, -1), np.pi, -np.pi / 2), ((-1, -0.0), 1.5 * np.pi, np.pi)],
)
def test_the_seams_lie_inside(vector, bearing, yaw):
    """A hair west of north is no full circle, and a negative zero changes no side."""
    assert course.bearing_of(vector) == bearing
    assert course.yaw_of(vector) == yaw
    assert course.bearing_from_yaw(np.nextafter(np.pi / 2, 2)) == 0
    assert course.yaw_from_bearing(1.5 * np.pi) == np.pi


@given(vectors)
def test_the_rule_of_360_degrees(vector):
    """The document's arccos, turned round where x is negative, is the same bearing to half the digits."""
    assert off(course.bearing_by_arccos(vector), course.bearing_of(vector)) <= 4 * math.sqrt(EPS)


@given(vectors.filter(lambda v: v[0] < 0))
def test_without_the_rule_the_side_is_lost(vector):
    mirrored = (-vector[0], vector[1])
    assert off(course.bearing_by_arccos(vector), -course.bearing_by_arccos(mirrored)) <= 4 * EPS


@pytest.mark.parametrize("y", [1.0, -1.0])
def test_arccos_loses_half_the_digits_near_the_poles(y):
    """Where the cosine is one to the last bit, arccos says 0 (or 180 degrees); atan2 keeps every digit."""
    x = np.geomspace(1e-12, 1e-4, 400)
    vectors = np.stack([x, np.full_like(x, y)], axis=-1)
    exact = np.arctan(x) if y > 0 else np.pi - np.arctan(x)
    np.testing.assert_allclose(course.bearing_of(vectors), exact, rtol=4 * EPS)
    lost = np.abs(course.bearing_by_arccos(vectors) - exact).max()
    assert math.sqrt(EPS) / 4 < lost < 4 * math.sqrt(EPS)
    assert course.bearing_by_arccos((5e-9, y)) == course.bearing_of((0, y))


# From fixes


def test_a_worked_example():
    """From (1, 2) by 3-4-5 triangle to (-2, 6): 36.87 degrees west of north, that is 323.13."""
    result = course.from_fixes((1, 2), (-2, 6), 5.001, fix_noise=0.01)
    assert math.isclose(result.bearing, 2 * np.pi - math.atan2(3, 4))
    assert math.isclose(result.yaw, math.atan2(4, -3))
    assert result.baseline == 5
    assert math.isclose(result.epsilon, 0.001, rel_tol=1e-9)
    assert math.isclose(result.threshold, 0.03 * ROOT2)
    assert result.straight
    assert math.isclose(result.std, 0.01 * ROOT2 / 5.001, rel_tol=1e-5)
    text = str(result)
    for word in ("323.1 deg", "126.9 deg", "0.162 deg", "5 m between", "5.001 m driven", "1 mm", "42.43 mm: straight"):
        assert word in text


def test_a_path_that_is_not_straight_is_flagged():
    result, _ = drive((0, 0, 0), 1.0, bend=2.0)
    assert not result.straight
    assert str(result).endswith(" mm: NOT straight")
    many = course.from_fixes((0, 0), [(1, 0), (0.5, 0)], 1.0, fix_noise=0.01)
    np.testing.assert_array_equal(many.straight, (True, False))
    assert str(many).endswith(" mm: 1 of 2 NOT straight")
    assert "0.5 to 1 m between" in str(many)


def test_the_threshold_is_a_constant_that_may_be_given():
    assert course.from_fixes((0, 0), (1, 0), 1.1, fix_noise=0.01, threshold=0.11).straight
    assert not course.from_fixes((0, 0), (1, 0), 1.1, fix_noise=0.1, threshold=0.09).straight
    assert course.from_fixes((0, 0), (1, 0), 1, fix_noise=0.1, threshold=0).straight


def test_fixes_without_noise_forgive_rounding_only():
    """Thirds of a metre do not add up to the last bit; ten ppm of the distance are no rounding."""
    a, b = np.array((1 / 3, 1 / 7)), np.array((2 / 3, 22 / 7))
    length = math.hypot(1 / 3, 3)
    assert course.from_fixes(a, b, length * (1 + 4 * EPS), fix_noise=0).straight
    assert course.from_fixes(a, b, length, fix_noise=0).std == 0
    assert not course.from_fixes(a, b, length * (1 + 1e-5), fix_noise=0).straight


@given(points, vectors, points, angles, sizes(1e-3, 1e3))
def test_moving_turning_and_scaling_the_plane(start, vector, moved, turn, scale):
    """Both fixes moved change nothing, turned turn the yaw (and the bearing backwards), scaled scale the lengths."""
    assume(math.hypot(*vector) > 1e-3)
    fixes = np.array([start, np.add(start, vector)])
    before = course.from_fixes(*fixes, 2.0, fix_noise=0.02)
    after = course.from_fixes(*(scale * se2.rotate(fixes, turn) + moved), 2.0 * scale, fix_noise=0.02 * scale)
    assert off(after.yaw, before.yaw + turn) <= 1e-9
    assert off(after.bearing, before.bearing - turn) <= 1e-9
    for field in ("baseline", "travelled", "epsilon", "threshold"):
        assert math.isclose(
            getattr(after, field), scale * getattr(before, field), rel_tol=1e-9, abs_tol=1e-11 * (1 + scale)
        )


@given(points, vectors)
def test_the_way_back_is_the_other_way(start, vector):
    end = np.add(start, vector)
    assume((end != start).any())
    there, back = (course.from_fixes(*pair, 1, fix_noise=0) for pair in ((start, end), (end, start)))
    assert off(there.yaw, back.yaw + np.pi) <= 4 * EPS
    assert there.baseline == back.baseline


def test_the_result_predicts_by_the_odometer_when_the_path_was_straight():
    """Noise makes the distance between the fixes longer; the odometer's is nearly the true one."""
    noisy = course.from_fixes((0, 0), (0.12, 0), 0.1, fix_noise=0.02)
    assert noisy.straight
    assert noisy.std == direction_std(0.02, 0.1)
    bent = course.from_fixes((0, 0), (0.12, 0), 1.0, fix_noise=0.02)
    assert not bent.straight
    assert bent.std == direction_std(0.02, 0.12)


def test_leading_dimensions_broadcast():
    rng = np.random.default_rng(1)
    first, second, travelled = rng.normal(size=(4, 1, 2)), rng.normal(size=(5, 2)), rng.uniform(0.1, 3, (4, 5))
    noise = rng.uniform(0.001, 0.5, (3, 1, 1))
    many = course.from_fixes(first, second, travelled, fix_noise=noise)
    for field in ("bearing", "yaw", "baseline", "travelled", "epsilon", "threshold", "fix_noise", "straight", "std"):
        assert getattr(many, field).shape == (3, 4, 5)
    for i, j, k in np.ndindex(3, 4, 5):
        one = course.from_fixes(first[j, 0], second[k], travelled[j, k], fix_noise=noise[i, 0, 0])
        for field in ("bearing", "yaw", "epsilon", "threshold", "straight", "std"):
            assert math.isclose(getattr(many, field)[i, j, k], getattr(one, field), rel_tol=1e-12)


def test_a_course_cannot_be_changed():
    result, _ = drive((0, 0, 1), 1.0)
    with pytest.raises(FrozenInstanceError):
        result.yaw = 2.0


# The missing angle


@pytest.mark.parametrize(("x", "y", "bearing", "yaw"), COMPASS)
def test_the_missing_angle_to_every_quarter(x, y, bearing, yaw):
    assert math.isclose(course.missing_angle(0, (2, 3), (2 + x, 3 + y)), math.radians(yaw), abs_tol=EPS)
    assert math.isclose(
        float(off(course.missing_angle(np.pi / 2, (2, 3), (2 + x, 3 + y)), -math.radians(bearing))), 0, abs_tol=4 * EPS
    )


@given(angles, points, points)
def test_after_the_missing_angle_the_robot_faces_its_goal(yaw, position, goal):
    assume(math.dist(position, goal) > 1e-6)
    turn = course.missing_angle(yaw, position, goal)
    assert -np.pi < turn <= np.pi
    seen = se2.rotate(np.subtract(goal, position), -(yaw + turn))
    np.testing.assert_allclose(seen, (math.dist(position, goal), 0), atol=1e-13 * (1 + abs(yaw)))


def test_a_goal_behind_is_a_half_turn_to_the_left():
    assert course.missing_angle(0, (0, 0), (-1, 0)) == np.pi
    assert course.missing_angle(0, (0, 0), (-1, -0.0)) == np.pi


def test_many_missing_angles_at_once():
    turns = course.missing_angle([[0.0], [1.0]], np.zeros((3, 2)), (0, 1))
    np.testing.assert_allclose(turns, [[np.pi / 2] * 3, [np.pi / 2 - 1] * 3])


# Bad input


@pytest.mark.parametrize("function", [course.bearing_of, course.bearing_by_arccos, course.yaw_of])
def test_bad_vectors_are_refused(function):
    with refused(ValueError, "vector has length zero"):
        function([(1, 0), (0, -0.0)])
    with refused(ValueError, "vector has shape (3,)", "(..., 2)"):
        function((1, 2, 3))
    with refused(ValueError, "vector[1] = nan"):
        function((1, math.nan))
    with refused(TypeError, "vector", "numbers"):
        function("north")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"second": (1, 2)}, ("first and second coincide at (1, 2)",)),
        ({"first": [(0, 0), (1, 2)], "second": [(0, 1), (1, 2)]}, ("coincide at (1, 2)",)),
        ({"first": (math.nan, 0)}, ("first[0] = nan", "finite")),
        ({"second": (0, math.inf)}, ("second[1] = inf", "finite")),
        ({"first": (1, 2, 3)}, ("first has shape (3,)", "(..., 2)")),
        ({"second": 3.0}, ("second has shape ()",)),
        ({"second": np.empty((0, 2))}, ("second is empty",)),
        ({"first": np.zeros((2, 2)), "second": np.ones((3, 2))}, ("first (2,)", "second (3,)", "broadcast")),
        ({"travelled": np.ones(3), "second": np.zeros((2, 2))}, ("travelled (3,)", "broadcast")),
        ({"travelled": -1.0}, ("travelled = -1", "positive")),
        ({"travelled": [1.0, 0.0]}, ("travelled = 0", "positive")),
        ({"travelled": math.nan}, ("travelled", "nan", "finite")),
        ({"travelled": math.inf}, ("travelled", "inf", "finite")),
        ({"fix_noise": -0.01}, ("fix_noise = -0.01", "not be negative")),
        ({"fix_noise": math.nan}, ("fix_noise", "nan")),
        ({"fix_noise": [0.1, 0.2], "travelled": [1, 2, 3]}, ("fix_noise (2,)", "broadcast")),
        ({"threshold": -0.1}, ("threshold = -0.1", "not be negative")),
        ({"threshold": math.nan}, ("threshold", "nan")),
        ({"threshold": [1, 2], "fix_noise": [1, 2, 3]}, ("threshold (2,)", "broadcast")),
    ],
)
def test_bad_fixes_are_refused(change, words):
    with refused(ValueError, *words):
        course.from_fixes(**{"first": (1, 2), "second": (3, 4), "travelled": 2.8, "fix_noise": 0.01, **change})


@pytest.mark.parametrize("change", [{"first": "here"}, {"second": None}, {"travelled": "far"}, {"fix_noise": "low"}])
def test_what_is_no_number_is_refused(change):
    values = {"first": (1, 2), "second": (3, 4), "travelled": 2.8, "fix_noise": 0.01, **change}
    (name,) = change
    with refused(TypeError, name, "numbers"):
        course.from_fixes(**values)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: course.yaw_from_bearing(math.nan), ("bearing", "nan")),
        (lambda: course.bearing_from_yaw(math.inf), ("yaw", "inf")),
        (lambda: course.missing_angle(0, (1, 1), (1, 1)), ("position and goal coincide at (1, 1)",)),
        (lambda: course.missing_angle(0, (1, 1), (math.inf, 1)), ("goal[0] = inf", "finite")),
        (lambda: course.missing_angle(0, (math.nan, 1), (1, 1)), ("position[0] = nan", "finite")),
        (lambda: course.missing_angle(math.nan, (0, 1), (1, 1)), ("yaw", "nan")),
        (lambda: course.missing_angle([0, 1], np.zeros((3, 2)), (1, 1)), ("yaw (2,)", "position (3,)", "broadcast")),
    ],
)
def test_bad_values_are_refused(call, words):
    with refused(ValueError, *words):
        call()


def test_input_is_not_changed():
    first, second = np.array([[0.0, 0.0], [1.0, 1.0]]), np.array([[3.0, 4.0], [5.0, 6.0]])
    kept = first.copy(), second.copy()
    course.from_fixes(first, second, 5.0, fix_noise=0.01)
    course.missing_angle(0.0, first, second)
    np.testing.assert_array_equal((first, second), kept)
