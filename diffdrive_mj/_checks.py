"""The checks of inputs: each returns the value as the package uses it, or raises naming the field."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from diffdrive_mj._text import a, shown
from diffdrive_mj.errors import InvalidType, InvalidValue, UnknownName

Array = NDArray[np.float64]
V = TypeVar("V")
S = TypeVar("S", bound=str)

# 28 hours at 100 Hz: 160 MB for two wheels.
MOST_SAMPLES = 10_000_000
# Beyond these the squares of numbers and their quotients are none; no robot comes near.
LARGEST, SMALLEST = 1e100, 1e-100
# Between two times [s]: less is rounding.
_SHORTEST = 1e-12

# What Python and numpy count among the integers all the same.
_NO_NUMBERS = (bool, np.timedelta64)

# What makes one kind of value of another.
_CURES = {
    ("str", "Robot"): "; Robot.load({value!r}) gives that preset",
    ("Recording", "Drive"): "; sensors.measure(recording) makes drives of it",
}


def number(name: str, value: object) -> float:
    """A finite number."""
    if isinstance(value, _NO_NUMBERS) or not isinstance(value, (int, float, np.integer, np.floating)):
        raise InvalidType(f"{name} = {shown(value)}: must be a number")
    try:
        result = float(value)
    except OverflowError:
        raise InvalidValue(f"{name}: must be finite, and an integer of {int(value).bit_length()} bits is not") from None
    if not abs(result) <= LARGEST:
        raise InvalidValue(f"{name} = {shown(value)}: {_too_large(result)}")
    return result


def positive(name: str, value: object) -> float:
    """A finite number above zero."""
    result = number(name, value)
    if result < SMALLEST:
        raise InvalidValue(f"{name} = {shown(value)}: {_too_small(result)}")
    return result


def not_negative(name: str, value: object) -> float:
    """A finite number, zero or above."""
    result = number(name, value)
    if result < 0:
        raise InvalidValue(f"{name} = {shown(value)}: must not be negative")
    return result


def limited(check: Callable[[str, object], float], most: float, unit: str) -> Callable[[str, object], float]:
    """The check of a number whose size is at most `most`; a larger one breaks the physics, and is a slip of a unit."""

    def checked(name: str, value: object) -> float:
        result = check(name, value)
        if abs(result) > most:
            raise InvalidValue(f"{name} = {result:g} {unit}: must be at most {most:g} {unit} in size")
        return result

    return checked


def whole(name: str, value: object, least: int = 1) -> int:
    """A whole number: a count of what must fit in memory, or from zero a seed of any size."""
    if isinstance(value, _NO_NUMBERS) or not isinstance(value, (int, np.integer)):
        raise InvalidType(f"{name} = {shown(value)}: must be a whole number")
    if value < least:
        raise InvalidValue(f"{name} = {shown(value)}: must be at least {least}")
    if least and value > MOST_SAMPLES:
        raise InvalidValue(f"{name} = {shown(value)}: must be at most {MOST_SAMPLES}")
    return int(value)


def instance(name: str, value: object, *kinds: type[V]) -> V:
    """An instance of one of the package's classes, or of one of several."""
    if isinstance(value, kinds):
        return value
    given = type(value).__name__
    simple = isinstance(value, (str, int, float, type(None)))
    cure = _CURES.get((given, kinds[0].__name__), "").format(value=value)
    wanted = " or ".join(a(kind.__name__) for kind in kinds)
    raise InvalidType(f"{name} = {shown(value) if simple else a(given)}: must be {wanted}{cure}")


def instances(name: str, values: Iterable[V], kind: type[V]) -> list[V]:
    """Several instances of one of the package's classes."""
    return [instance(f"{name}[{k}]", value, kind) for k, value in enumerate(several(name, values))]


def several(name: str, values: Iterable[V]) -> list[V]:
    """What a list, a generator or the like holds."""
    try:
        return list(values)
    except TypeError:
        raise InvalidType(f"{name} = {shown(values)}: must be a list") from None


def strings(name: str, values: Iterable[str]) -> tuple[str, ...]:
    """Strings in a list or the like; a string alone would be its letters."""
    if isinstance(values, str):
        raise InvalidType(f"{name} = {shown(values)}: must be a list of strings")
    return tuple(string(name, value) for value in several(name, values))


def generator(name: str, value: object) -> np.random.Generator:
    """A source of random numbers."""
    if not isinstance(value, np.random.Generator):
        raise InvalidType(f"{name} = {shown(value)}: must be a numpy Generator, such as numpy.random.default_rng(seed)")
    return value


def boolean(name: str, value: object) -> bool:
    """True or False, and no word for them."""
    if not isinstance(value, (bool, np.bool_)):
        raise InvalidType(f"{name} = {shown(value)}: must be True or False")
    return bool(value)


def flags(name: str, value: ArrayLike, samples: int) -> NDArray[np.bool_]:
    """True or False for each of some samples (..., T), as bools and nothing like them."""
    with suppress(ValueError):
        if (given := np.asarray(value)).dtype == np.bool_ and given.shape[-1:] == (samples,):
            return given
    raise InvalidType(f"{name}: must be an array of bool, one for each of the {samples} samples")


def string(name: str, value: object) -> str:
    """A string, such as a name."""
    if not isinstance(value, str):
        raise InvalidType(f"{name} = {shown(value)}: must be a string")
    return value


def samples(name: str, duration: float, interval: float) -> int:
    """How many intervals cover a duration, in numbers that fit in memory."""
    count = duration / interval
    if not count <= MOST_SAMPLES:
        raise InvalidValue(
            f"{name} = {duration:g} s: {count:.3g} samples every {interval:g} s, must be at most {MOST_SAMPLES}"
        )
    # The slack keeps rounding from adding one.
    return math.ceil(count - 1e-9)


def duration(name: str, times: Array, rate: float) -> float:
    """What increasing times span [s], in samples of a rate that fit in memory."""
    result = float(times[-1] - times[0])
    samples(name, result, 1 / rate)
    return result


def one_of(kind: str, name: S, valid: Mapping[S, V]) -> V:
    """The value that a name stands for."""
    if not isinstance(name, str) or name not in valid:
        raise UnknownName(kind, name, valid)
    return valid[name]


def member(kind: str, name: S, valid: Iterable[S]) -> S:
    """A name among the valid ones."""
    return one_of(kind, name, {v: v for v in valid})


def array(name: str, value: ArrayLike, *shape: int | str) -> Array:
    """A finite float64 array whose last dimensions are `shape`.

    Args:
        name: how the message calls it.
        value: array-like.
        shape: the last dimensions; a number must match, a word such as "T" stands for any length.

    Raises:
        InvalidType: not numbers.
        InvalidValue: the dimensions do not fit, a dimension is empty, or a value is masked or not finite.
    """
    if _masked(value):
        raise InvalidValue(f"{name} has masked values: must have none; fill or drop them first")
    try:
        given = np.asarray(value)
    except (TypeError, ValueError) as error:
        raise InvalidType(f"{name}: must be an array of real numbers ({error})") from None
    if given.dtype.kind not in "fiu":
        raise InvalidType(f"{name}: must be an array of real numbers, not of {given.dtype}")
    if given.dtype == np.float64:
        result = given
    else:
        with np.errstate(over="ignore"):  # longer floats, which are refused below
            result = given.astype(np.float64)
    fits = result.ndim >= len(shape) and all(
        isinstance(want, str) or have == want
        for have, want in zip(result.shape[result.ndim - len(shape) :], shape, strict=True)
    )
    if not fits:
        raise InvalidValue(f"{name} has shape {result.shape}: must be {_dimensions(shape)}")
    if result.size == 0:
        wanted = f"{_dimensions(shape)} with at least one element"
        raise InvalidValue(f"{name} is empty, shape {result.shape}: must be {wanted}")
    if not (result.max() <= LARGEST and result.min() >= -LARGEST):
        where = tuple(int(i) for i in np.argwhere(~(np.abs(result) <= LARGEST))[0])
        place = f"[{', '.join(map(str, where))}]" if where else ""
        raise InvalidValue(f"{name}{place} = {result[where]}: {_too_large(float(result[where]))}")
    return result


def _dimensions(shape: Iterable[int | str]) -> str:
    return f"(..., {', '.join(map(str, shape))})"


def _too_large(value: float) -> str:
    return f"must be within {LARGEST:g} of zero" if math.isfinite(value) else "must be finite"


def _too_small(value: float) -> str:
    return f"must be at least {SMALLEST:g}" if value > 0 else "must be positive"


def _masked(value: object) -> bool:
    """Whether numpy would pass over a mask."""
    if isinstance(value, (list, tuple)):
        kinds = set(map(type, value))
        return any(issubclass(kind, (list, tuple, np.ma.MaskedArray)) for kind in kinds) and any(map(_masked, value))
    return isinstance(value, np.ma.MaskedArray) and bool(np.ma.is_masked(value))


def positive_array(name: str, value: ArrayLike) -> Array:
    """A finite float64 array of any shape, all of it above zero."""
    result = array(name, value)
    return _refuse(name, result, result < SMALLEST, _too_small(float(result.min())))


def not_negative_array(name: str, value: ArrayLike) -> Array:
    """A finite float64 array of any shape, all of it zero or above."""
    return _refuse(name, result := array(name, value), result < 0, "must not be negative")


def _refuse(name: str, value: Array, bad: NDArray[np.bool_], why: str) -> Array:
    if np.any(bad):
        raise InvalidValue(f"{name} = {value[bad][0]:g}: {why}")
    return value


def vector(name: str, value: ArrayLike, length: int) -> Array:
    """A finite float64 array (length,), with no leading dimensions."""
    result = array(name, value, length)
    if result.ndim != 1:
        raise InvalidValue(f"{name} has shape {result.shape}: must be ({length},)")
    return result


def increasing(name: str, value: ArrayLike) -> Array:
    """Times (T,) [s] that increase, two at least."""
    times = array(name, value, "T")
    if times.ndim != 1 or len(times) < 2:
        raise InvalidValue(f"{name} has shape {times.shape}: must be (T,) with at least two times")
    back = np.flatnonzero(np.diff(times) < _SHORTEST)
    if back.size:
        k = int(back[0])
        raise InvalidValue(
            f"{name}[{k + 1}] = {times[k + 1]:g} s after {times[k]:g} s: times must increase by a picosecond or more"
        )
    return times


def broadcast(**leading: NDArray[Any]) -> tuple[int, ...]:
    """The common shape of arrays whose shapes are leading dimensions, each named as the message calls it."""
    try:
        return np.broadcast_shapes(*(value.shape for value in leading.values()))
    except ValueError:
        shapes = ", ".join(f"{name} {value.shape}" for name, value in leading.items())
        raise InvalidValue(f"leading dimensions of {shapes}: must broadcast") from None


def multiple(name: str, value: float, unit_name: str, unit: float) -> int:
    """How many times `unit` goes into `value`, which must be a whole number, at least one."""
    ratio = value / unit
    if not ratio <= MOST_SAMPLES * 1e6:
        raise InvalidValue(f"{name} = {value:g} s: {ratio:.3g} times {unit_name} = {unit:g} s is too long")
    count = round(ratio)
    if count < 1 or abs(count * unit - value) > 1e-9 * value:
        low = max(1, math.floor(value / unit))
        raise InvalidValue(
            f"{name} = {value:g} s: must be a whole multiple of {unit_name} = {unit:g} s, "
            f"such as {low * unit:g} or {(low + 1) * unit:g}"
        )
    return count
