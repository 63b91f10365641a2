import math
import pickle

import numpy as np
import pytest
from helpers import refused
from hypothesis import given
from hypothesis import strategies as st
from strategies import sizes

from diffdrive_mj import _checks as checks
from diffdrive_mj import errors

# Numbers


@pytest.mark.parametrize("value", [3, 3.0, np.int8(3), np.uint64(3), np.float32(3), np.float64(3)])
@pytest.mark.parametrize("check", [checks.number, checks.positive, checks.not_negative])
def test_numbers_come_back_as_floats(check, value):
    assert check("length", value) == 3
    assert type(check("length", value)) is float


@pytest.mark.parametrize("check", [checks.number, checks.positive, checks.not_negative])
def test_what_is_no_number_is_refused(check):
    for value in ("3", None, True, np.True_, [3], np.array(3.0), 3j):
        with refused(TypeError, f"length = {value!r}", "must be a number"):
            check("length", value)
    for value in (math.nan, math.inf, -math.inf, np.float32("nan")):
        with refused(ValueError, f"length = {value!r}", "must be finite"):
            check("length", value)


def test_signs():
    assert checks.number("x", -3) == -3
    assert checks.not_negative("x", 0) == 0
    for value in (0, -0.0, -1e-300):
        with refused(ValueError, f"x = {value!r}", "must be positive"):
            checks.positive("x", value)
    with refused(ValueError, "x = -1e-300", "must not be negative"):
        checks.not_negative("x", -1e-300)


# Names


def test_names():
    valid = {"euler": 1, "midpoint": 2}
    assert checks.one_of("method", "midpoint", valid) == 2
    assert checks.member("method", "euler", valid) == "euler"
    for bad in ("Euler", "", None, 1, ["euler"]):
        for builtin in (KeyError, ValueError):
            with refused(builtin, f"unknown method {bad!r}", "choose from euler, midpoint"):
                checks.one_of("method", bad, valid)
            with refused(builtin, f"unknown method {bad!r}", "choose from euler, midpoint"):
                checks.member("method", bad, valid)


# Arrays


def test_arrays_come_back_as_float64():
    result = checks.array("poses", [[1, 2, 3]], "T", 3)
    assert result.dtype == np.float64
    assert result.shape == (1, 3)
    assert checks.array("theta", 2).shape == ()


@pytest.mark.parametrize("shape", [(4, 3), (1, 3), (2, 4, 3), (2, 5, 7, 3)])
def test_arrays_may_have_leading_dimensions(shape):
    assert checks.array("poses", np.ones(shape), "T", 3).shape == shape


@pytest.mark.parametrize("shape", [(), (3,), (4, 2), (3, 4), (4, 3, 1)])
def test_arrays_that_do_not_fit_are_refused(shape):
    with refused(ValueError, f"poses has shape {shape}", "must be (..., T, 3)"):
        checks.array("poses", np.ones(shape), "T", 3)


@pytest.mark.parametrize("shape", [(0, 3), (5, 0, 3), (0, 5, 3)])
def test_empty_arrays_are_refused(shape):
    with refused(ValueError, f"poses is empty, shape {shape}", "at least one"):
        checks.array("poses", np.ones(shape), "T", 3)


def test_the_first_value_that_is_not_finite_is_pointed_out():
    poses = np.zeros((2, 4, 3))
    poses[1, 2, 0], poses[1, 3, 1] = math.nan, math.inf
    with refused(ValueError, "poses[1, 2, 0] = nan", "must be finite"):
        checks.array("poses", poses, "T", 3)


@pytest.mark.parametrize("value", ["word", ["a", "b", "c"], [[1, 2, 3], [1, 2]], {"x": 1}, object()])
def test_what_is_no_array_is_refused(value):
    with refused(TypeError, "poses", "array of real numbers"):
        checks.array("poses", value, 3)


def test_signs_of_arrays():
    assert checks.positive_array("x", [[1, 2]]).tolist() == [[1, 2]]
    assert checks.not_negative_array("x", 0).shape == ()
    for value in (0, [1, 0], [[3], [0], [-1]]):
        with refused(ValueError, "x = 0: must be positive"):
            checks.positive_array("x", value)
    for value in (-2, [0, -2, -3]):
        with refused(ValueError, "x = -2: must not be negative"):
            checks.not_negative_array("x", value)
    for check in (checks.positive_array, checks.not_negative_array):
        with refused(ValueError, "x[1] = nan", "must be finite"):
            check("x", [1, math.nan])


def test_vectors_have_no_leading_dimensions():
    assert checks.vector("rates", (1, 2), 2).tolist() == [1, 2]
    with refused(ValueError, "rates has shape (1, 2)", "must be (2,)"):
        checks.vector("rates", [(1, 2)], 2)
    with refused(ValueError, "rates has shape (3,)", "(..., 2)"):
        checks.vector("rates", (1, 2, 3), 2)


def test_leading_dimensions_that_fit():
    assert checks.broadcast(a=np.ones((4, 1)), b=np.ones(5)) == (4, 5)
    with refused(ValueError, "a (4,)", "b (5,)", "must broadcast"):
        checks.broadcast(a=np.ones(4), b=np.ones(5))


# Multiples


@given(st.integers(1, 10000), sizes(1e-4, 1.0))
def test_whole_multiples(count, unit):
    assert checks.multiple("period", count * unit, "timestep", unit) == count


@pytest.mark.parametrize(
    ("value", "unit", "nearest"),
    [
        (0.015, 0.01, "0.01 or 0.02"),
        (0.004, 0.01, "0.01 or 0.02"),
        (0.0333, 0.002, "0.032 or 0.034"),
        (1.001, 0.5, "1 or 1.5"),
    ],
)
def test_other_multiples_are_answered_with_the_nearest(value, unit, nearest):
    with refused(ValueError, f"period = {value:g} s", f"timestep = {unit:g} s", f"such as {nearest}"):
        checks.multiple("period", value, "timestep", unit)


@pytest.mark.parametrize("value", [0, -0.01, 1e-12])
def test_no_time_at_all_is_no_multiple(value):
    with refused(ValueError, f"period = {value:g} s", "such as 0.01 or 0.02"):
        checks.multiple("period", value, "timestep", 0.01)


# The family of errors


@pytest.mark.parametrize(
    ("error", "builtins"),
    [
        (errors.InvalidValue, [ValueError]),
        (errors.InvalidType, [TypeError]),
        (errors.UnknownName, [KeyError, ValueError]),
        (errors.MissingFile, [FileNotFoundError]),
        (errors.SimulationDiverged, [RuntimeError]),
    ],
)
def test_every_error_is_one_of_the_family_and_a_builtin(error, builtins):
    for base in (errors.DiffdriveError, *builtins):
        assert issubclass(error, base)


def test_unknown_names_read_as_a_sentence():
    error = errors.UnknownName("method", "eular", ["midpoint", "euler"])
    assert str(error) == "unknown method 'eular': choose from euler, midpoint; did you mean 'euler'?"
    assert str(errors.UnknownName("method", 7, ["euler"])) == "unknown method 7: choose from euler"


@pytest.mark.parametrize(
    "error",
    [errors.InvalidValue("x = 0: must be positive"), errors.UnknownName("method", "eular", ["euler"])],
)
def test_errors_travel_between_processes(error):
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is type(error)
    assert str(again) == str(error)


def test_the_largest_numbers_are_allowed_themselves():
    assert checks.whole("n", checks.MOST_SAMPLES, least=1) == checks.MOST_SAMPLES
    with refused(ValueError, "n"):
        checks.whole("n", checks.MOST_SAMPLES + 1, least=1)
    both = [checks.LARGEST, -checks.LARGEST]
    assert checks.array("a", both).tolist() == both
    for beyond in (1.001 * checks.LARGEST, -1.001 * checks.LARGEST):
        with refused(ValueError, "a[1]"):
            checks.array("a", [0.0, beyond])
