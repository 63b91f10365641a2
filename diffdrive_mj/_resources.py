"""Where the models and the experiments lie: in the package in a wheel, beside it in a checkout."""

from __future__ import annotations

from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent


def _folder(name: str) -> Path:
    inside, beside = _PACKAGE / name, _PACKAGE.parent / name
    return inside if inside.is_dir() or not beside.is_dir() else beside


MODELS = _folder("models")
EXPERIMENTS = _folder("experiments")
