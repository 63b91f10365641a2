"""Descriptions as TOML files: flat keys, a table for each part, an array of tables where there are several.

The kind of a description says which keys there are: a field's metadata names the kind of its parts (`_described`).
"""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Callable, Collection, Mapping
from dataclasses import MISSING, fields
from pathlib import Path
from typing import Any, TypeVar

from diffdrive_mj import _checks as checks
from diffdrive_mj._described import given, parts
from diffdrive_mj._files import as_path, write_whole
from diffdrive_mj._resources import MODELS
from diffdrive_mj._text import shown
from diffdrive_mj.errors import InvalidType, InvalidValue, MissingFile, UnknownName

T = TypeVar("T")
Fields = dict[str, Any]

# Of a file [bytes]: no reader waits for the end of /dev/zero.
_LARGEST = 1_000_000


def presets(kind: type) -> tuple[str, ...]:
    """The names that `load` knows of a kind of description."""
    return tuple(sorted(path.stem for path in _folder(kind).glob("*.toml")))


def summary(kind: type, preset: str) -> str:
    """What the comment at the head of a preset's file says first."""
    lines = (_folder(kind) / f"{preset}.toml").read_text(encoding="utf-8").splitlines()
    head = " ".join(line[2:] for line in lines[:2] if line.startswith("# "))
    return re.split("[:;]", head)[0].rstrip(".")


def load(kind: type[T], name_or_path: str | Path, prepare: Callable[[Path, Fields], None] | None = None) -> T:
    """The description in a preset or in a file of one's own; without a name there, it has the file's.

    Args:
        kind: of description.
        name_or_path: a preset's name, or a path that ends on .toml or has a folder.
        prepare: sees what the file holds first, and may refuse or replace some of it.

    Raises:
        UnknownName: no such preset, or a key that is not known.
        MissingFile: no file at the path.
        InvalidValue: not a TOML file, a needed field is missing, or one is out of its range.
        InvalidType: neither a name nor a path, or a field of the wrong type.
    """
    if not isinstance(name_or_path, str | Path):
        raise InvalidType(f"{_noun(kind)} = {shown(name_or_path)}: must be a preset's name or a path")
    path = as_path(_noun(kind), name_or_path)
    if path.suffix != ".toml" and len(path.parts) == 1:
        path = _folder(kind) / f"{checks.member('preset', str(path), presets(kind))}.toml"
    values = _read(path, _noun(kind))
    if prepare is not None:
        prepare(path, values)
    _refuse_unknown(f"key in {path.name}", values, kind)
    needed = [field.name for field in fields(kind) if field.default is MISSING]  # type: ignore[arg-type]
    if missing := [name for name in needed if name not in values]:
        words = ", ".join(missing)
        raise InvalidValue(f"{path}: {words} missing; a {_noun(kind)} needs {' and '.join(needed)}")
    return kind(**{"name": path.stem, **values})


def save(description: Any, path: str | Path) -> None:
    """Write the file, whole or not at all.

    Raises:
        InvalidType: not a path.
        InvalidValue: the file is not named .toml, or cannot be written.
    """
    path = as_path("path", path)
    if path.suffix != ".toml":
        raise InvalidValue(f"{path}: a {_noun(type(description))}'s file is named .toml")
    write_whole(path, description.to_toml())


def text(description: Any, table: str = "") -> str:
    """The TOML that `load` reads back: the name and what else was given, then the parts, each as a table of it.

    Args:
        description: a robot, a world.
        table: in which it stands, with a dot; "" for a file of its own.
    """
    values, kinds = {"name": description.name, **given(description)}, parts(type(description))
    flat = {name: value for name, value in values.items() if name not in kinds}
    tables = []
    for name in kinds:
        value = values.get(name)
        head, items = (f"[[{table}{name}]]", value) if isinstance(value, tuple) else (f"[{table}{name}]", (value,))
        tables += [f"\n{head}\n{rows(part)}" for item in items if (part := given(item))]
    return rows(flat) + "".join(tables)


def rows(values: Mapping[str, Any]) -> str:
    """A line of TOML for each value; a mapping is an inline table."""
    return "".join(f"{key} = {_written(value)}\n" for key, value in values.items())


def _noun(kind: type) -> str:
    return kind.__name__.lower()


def _folder(kind: type) -> Path:
    return MODELS / {"study": "studies"}.get(noun := _noun(kind), f"{noun}s")


def _read(path: Path, noun: str) -> Fields:
    try:
        with path.open("rb") as file:
            content = file.read(_LARGEST + 1)
        if len(content) > _LARGEST:
            raise ValueError(f"larger than {_LARGEST} bytes")
        return tomllib.loads(content.decode())
    except FileNotFoundError:
        raise MissingFile(f"{path}: no such {noun} file") from None
    except (OSError, ValueError, RecursionError) as error:  # also UTF-8's, and an integer of thousands of digits
        raise InvalidValue(f"{path}: not a {noun}'s TOML file ({error})") from None


def _refuse_unknown(where: str, values: Mapping[str, Any], kind: type) -> None:
    known = [field.name for field in fields(kind)]
    for key in values:
        if key not in known:
            raise UnknownName(where, key, known)
    for key, part in parts(kind).items():
        value = values.get(key)
        for item in value if isinstance(value, list) else [value]:
            if isinstance(item, dict):
                _refuse_unknown(f"{where} [{key}]", item, part)


def _written(value: object) -> str:
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, Mapping):
        return f"{{ {', '.join(f'{key} = {_written(item)}' for key, item in value.items())} }}"
    if isinstance(value, Collection):
        return f"[{', '.join(map(_written, value))}]"
    return str(value).lower() if isinstance(value, bool) else repr(value)
