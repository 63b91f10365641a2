"""The options that experiments share, checked before anything is computed."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from diffdrive_mj._checks import whole
from diffdrive_mj.errors import MissingFile

__all__ = ["folder", "seeded", "whole"]


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
