"""The options that experiments share, checked before anything is computed."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from diffdrive_mj.errors import InvalidType, InvalidValue, MissingFile


def whole(name: str, value: object, least: int = 1) -> int:
    """Return a whole number, such as a number of runs.

    Args:
        name: what the message calls it.
        value: the option.
        least: the smallest that is allowed.

    Raises:
        InvalidType: not a whole number.
        InvalidValue: too small.

    Example:
        >>> whole("runs", 5)
        5
    """
    if isinstance(value, bool) or not isinstance(value, int):
        raise InvalidType(f"{name} = {value!r}: must be a whole number")
    if value < least:
        raise InvalidValue(f"{name} = {value}: must be at least {least}")
    return value


def seeded(seed: object) -> np.random.Generator:
    """Return the random numbers of a seed.

    Args:
        seed: a whole number, zero or above.

    Example:
        >>> print(f"{seeded(0).random():.4f}")
        0.6370
    """
    return np.random.default_rng(whole("seed", seed, least=0))


def folder(option: str, path: str, parts: Iterable[str] = ()) -> Path | None:
    """Return the folder of some data, or None if the option is empty.

    Args:
        option: its name.
        path: of the folder; "" for none.
        parts: folders that must be in it.

    Raises:
        MissingFile: it is not there, or lacks a part; the message names it.

    Example:
        >>> folder("data", "") is None
        True
    """
    if not path:
        return None
    root = Path(path)
    for place in (root, *(root / part for part in parts)):
        if not place.is_dir():
            raise MissingFile(f"{option} = {path}: {place} is not a folder")
    return root
