"""Studies as TOML files: flat keys, and a table for each part; the robots and worlds that they name are looked up."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

from diffdrive_mj import _described_file as files
from diffdrive_mj._described import given
from diffdrive_mj._text import a
from diffdrive_mj.errors import InvalidType, InvalidValue, UnknownName
from diffdrive_mj.robot import Robot
from diffdrive_mj.solver import Physics
from diffdrive_mj.sweeps._study_fields import NONE, PHYSICS
from diffdrive_mj.sweeps.distributions import DISTRIBUTIONS, Distribution
from diffdrive_mj.world import World

T = TypeVar("T")

# What a study may name in the place of a table.
_NAMED: dict[str, type[Robot] | type[World]] = {"robot": Robot, "world": World}


def load(kind: type[T], name_or_path: str | Path) -> T:
    """The study in a preset or in a file of one's own; without a name there, it has the file's."""
    with _in_file(name_or_path):
        return files.load(kind, name_or_path, _look_up)


def _look_up(path: Path, values: dict[str, Any]) -> None:
    """Put robots and worlds in the place of their names: presets, or files beside the study's."""
    for key, kind in _NAMED.items():
        name = values.get(key)
        if isinstance(name, str):
            is_file = name.endswith(".toml") or "/" in name
            values[key] = kind.load(path.parent / name if is_file else name)


@contextmanager
def _in_file(name_or_path: object) -> Iterator[None]:
    """Let what is wrong with a file's content name the file."""
    file = str(name_or_path)
    try:
        yield
    except UnknownName as error:
        kind, name, valid = error.args
        if name == name_or_path or Path(file).name in kind:
            raise
        raise UnknownName(f"{kind} in {Path(file).name}", name, valid) from None
    except (InvalidValue, InvalidType) as error:
        raise error if file in str(error) else type(error)(f"{file}: {error}") from None


def text(study: Any) -> str:
    """The TOML that `load` reads back: every field, in the order of the class, then the tables."""
    flat: dict[str, Any] = {}
    tables = {
        "maneuver": files.rows({"name": study.maneuver.name, **study.maneuver.options}),
        "vary": files.rows({f'"{name}"': _as_table(spread) for name, spread in study.vary.items()}),
    }
    for field in dataclasses.fields(study):
        value = getattr(study, field.name)
        if isinstance(value, Physics):
            name = next((name for name, setting in PHYSICS.items() if setting == value), None)
            if name is None:
                tables["physics"] = files.rows(
                    {key: NONE if item is None else item for key, item in vars(value).items()}
                )
            else:
                flat["physics"] = name
        elif field.name in ("encoder", "gyro"):
            if value is not None:
                tables[field.name] = files.rows(_fields(value))
        elif field.name not in ("maneuver", "vary", "robot", "world"):
            flat[field.name] = value
    described = "".join(f"\n[{name}]\n{files.text(getattr(study, name), f'{name}.')}" for name in _NAMED)
    return files.rows(flat) + "".join(f"\n[{name}]\n{rows}" for name, rows in tables.items()) + described


def _fields(value: Any) -> dict[str, Any]:
    """What a description has, but for what is None and so by default."""
    found = {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}
    return {name: item for name, item in found.items() if item is not None}


def _as_table(spread: Distribution) -> Mapping[str, Any]:
    name = next((name for name, kind in DISTRIBUTIONS.items() if type(spread) is kind), None)
    if name is None:
        raise InvalidType(
            f"Study.vary: {a(type(spread).__name__)} has no name in a file; these have: {', '.join(DISTRIBUTIONS)}"
        )
    return {"distribution": name, **{key: value for key, value in given(spread).items() if value is not None}}
