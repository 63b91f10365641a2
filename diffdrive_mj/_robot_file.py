"""A robot's TOML file: flat keys, and a table for each part."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Collection, Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

from diffdrive_mj._described import given
from diffdrive_mj._former import refuse_keys
from diffdrive_mj.errors import InvalidValue, MissingFile, UnknownName
from diffdrive_mj.parts import PARTS

# Of a robot's file [bytes]: no reader waits for the end of /dev/zero.
_LARGEST = 1_000_000


def read(path: Path, known: Collection[str], needed: Collection[str]) -> dict[str, Any]:
    """The fields in a robot's file; without a name there, it is the file's.

    Raises:
        MissingFile: no file at the path.
        InvalidValue: not a TOML file, a former name, or a needed field is missing.
        UnknownName: a key that is not known.
    """
    try:
        with path.open("rb") as file:
            content = file.read(_LARGEST + 1)
        if len(content) > _LARGEST:
            raise ValueError(f"larger than {_LARGEST} bytes")
        values = tomllib.loads(content.decode())
    except FileNotFoundError:
        raise MissingFile(f"{path}: no such robot file") from None
    except (OSError, ValueError, RecursionError) as error:  # also UTF-8's, and an integer of thousands of digits
        raise InvalidValue(f"{path}: not a robot's TOML file ({error})") from None
    refuse_keys(path, values)
    _refuse_unknown(f"key in {path.name}", values, known)
    for key, kind in PARTS.items():
        if isinstance(values.get(key), dict):
            _refuse_unknown(f"key in {path.name} [{key}]", values[key], [field.name for field in fields(kind)])
    if missing := [key for key in needed if key not in values]:
        raise InvalidValue(f"{path}: {', '.join(missing)} missing; a robot needs its radii and track width")
    return {"name": path.stem, **values}


def text(values: Mapping[str, Any]) -> str:
    """The TOML that `read` reads back: the fields, then each part as a table of what it was given."""
    flat = {key: value for key, value in values.items() if key not in PARTS}
    tables = [f"\n[{key}]\n{_rows(part)}" for key in PARTS if (part := given(values.get(key)))]
    return _rows(flat) + "".join(tables)


def _rows(values: Mapping[str, Any]) -> str:
    return "".join(
        f"{key} = {_quoted(value) if isinstance(value, str) else repr(value)}\n" for key, value in values.items()
    )


def _quoted(value: str) -> str:
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")


def _refuse_unknown(kind: str, keys: Collection[str], known: Collection[str]) -> None:
    for key in keys:
        if key not in known:
            raise UnknownName(kind, key, known)
