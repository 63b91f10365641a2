"""Descriptions: keyword-only dataclasses that check their fields one by one and remember what they were given."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

from diffdrive_mj import _checks as checks
from diffdrive_mj._text import shown
from diffdrive_mj.errors import InvalidType, InvalidValue, UnknownName

T = TypeVar("T")
Check = Callable[[str, Any], Any]
Fields = dict[str, Any]

# The default of a field that scales with the robot: None until the robot, which knows its size, fills it in.
SCALES: Any = None


def checked(check: Check) -> Fields:
    """The metadata of a field whose value is what `check(name, value)` returns."""
    return {"check": check}


def span(name: str, value: Any) -> tuple[float, float]:
    """From and to [m], the smaller first."""
    low, high = checks.vector(name, value, 2).tolist()
    if low >= high:
        raise InvalidValue(f"{name} = ({low:g}, {high:g}): must go from a smaller to a larger number")
    return low, high


def one(kind: type, or_none: bool = False) -> Fields:
    """The metadata of a field that is a description of some kind, or None where that may be."""

    def check(name: str, value: object) -> Any:
        return None if or_none and value is None else described_as(kind, name, value)

    return {"check": check, "kind": kind}


def several(kind: type) -> Fields:
    """The metadata of a field that is a tuple of descriptions of some kind."""

    def check(name: str, value: object) -> tuple[Any, ...]:
        if not isinstance(value, (tuple, list)):
            raise InvalidType(f"{name} = {shown(value)}: must be a tuple of {kind.__name__}")
        return tuple(described_as(kind, f"{name}[{k}]", item) for k, item in enumerate(value))

    return {"check": check, "kind": kind}


def parts(kind: type) -> dict[str, type]:
    """The fields of a kind of description that are descriptions themselves, each with its kind."""
    found = {field.name: field.metadata.get("kind") for field in dataclasses.fields(kind)}
    return {name: part for name, part in found.items() if part is not None}


def described(prepare: Callable[[Fields], Fields] = dict) -> Callable[[type[T]], type[T]]:
    """Wrap a dataclass's constructor, so that whatever is wrong with its arguments is one error of the package.

    Every field says in its metadata how it is checked. None stands for "not given" where it is the default.

    Args:
        prepare: sees the arguments first.
    """

    def decorate(cls: type[T]) -> type[T]:
        make = cls.__init__
        fields = {field.name: field for field in dataclasses.fields(cls)}  # type: ignore[arg-type]
        needed = [name for name, field in fields.items() if field.default is dataclasses.MISSING]

        @functools.wraps(make)
        def construct(self: T, *unnamed: Any, **arguments: Any) -> None:
            kind = cls.__name__
            if unnamed:
                first = shown(unnamed[0])
                example = f"{kind}({next(iter(fields))}={first})"
                raise InvalidType(f"{kind}({first}, ...): takes its fields by name, such as {example}")
            arguments = prepare(arguments)
            for name in arguments:
                if name not in fields:
                    raise UnknownName(f"{kind} field", name, fields)
            if missing := [name for name in needed if name not in arguments]:
                raise InvalidType(f"{kind}(...): {', '.join(missing)} missing")
            given = {
                name: field.metadata["check"](f"{kind}.{name}", arguments[name])
                for name, field in fields.items()
                if name in arguments and not (arguments[name] is None and field.default is SCALES)
            }
            object.__setattr__(self, "_given", given)
            make(self, **given)

        cls.__init__ = construct  # type: ignore[method-assign, assignment]
        cls.__repr__ = _shown  # type: ignore[method-assign]
        return cls

    return decorate


def described_as(kind: type[T], name: str, value: object) -> T:
    """A description of some kind, or the mapping of its fields that a TOML table is."""
    if isinstance(value, Mapping):
        return kind(**{str(key): item for key, item in value.items()})
    if not isinstance(value, kind):
        raise InvalidType(f"{name} = {shown(value)}: must be {kind.__name__}(...) or a mapping of its fields")
    return value


def given(description: object) -> Fields:
    """The fields that a description was given, in the order of its class."""
    return dict(getattr(description, "_given", {}))


def filled(description: T, scaled: Mapping[str, Any]) -> T:
    """The description with the fields that it was not given."""
    return type(description)(**{**scaled, **given(description)})


def _shown(description: object) -> str:
    values = ", ".join(f"{name}={value!r}" for name, value in given(description).items())
    return f"{type(description).__name__}({values})"
