"""Judges that share no code with the package: exact arithmetic, matrices, and what a refusal must be."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from decimal import Decimal, localcontext
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from diffdrive_mj.errors import DiffdriveError

ROOT = Path(__file__).resolve().parent.parent


def experiment(name: str) -> ModuleType:
    """One of the scripts in `experiments`."""
    spec = importlib.util.spec_from_file_location(name, ROOT / "experiments" / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # dataclasses look their module up
    spec.loader.exec_module(module)
    return module


@contextmanager
def refused(builtin: type[Exception], *words: object) -> Iterator[None]:
    """The block raises one of the family's errors that is also `builtin` and whose message holds the words."""
    with pytest.raises(DiffdriveError) as info:
        yield
    assert isinstance(info.value, builtin)
    for word in words:
        assert str(word) in str(info.value)


def matrix(pose: np.ndarray) -> np.ndarray:
    """A pose as the homogeneous 3x3 matrix."""
    x, y, theta = pose
    return np.array([[np.cos(theta), -np.sin(theta), x], [np.sin(theta), np.cos(theta), y], [0, 0, 1]])


def exact_arc(forward: float, left: float, theta: float) -> tuple[float, float]:
    """Where a constant twist ends, from Taylor series in 120 digits: the textbook form, with its 0 / 0 at zero."""
    with localcontext(prec=120):
        u, w, turn = Decimal(forward), Decimal(left), Decimal(theta)
        if turn == 0:
            return forward, left
        cosine, sine = cos_sin(turn)
        return float((u * sine - w * (1 - cosine)) / turn), float((u * (1 - cosine) + w * sine) / turn)


def cos_sin(angle: Decimal) -> tuple[Decimal, Decimal]:
    sums, term, n = [Decimal(0), Decimal(0)], Decimal(1), 0
    while n <= abs(angle) or abs(term) > Decimal("1e-70"):
        sums[n % 2] += term if n % 4 < 2 else -term
        n += 1
        term *= angle / n
    return sums[0], sums[1]
