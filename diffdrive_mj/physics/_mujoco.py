"""MuJoCo, loaded even where MUJOCO_GL names an OpenGL that cannot be used: physics needs none."""

from __future__ import annotations

import importlib
import os

__all__ = ["Batch", "SimulationError", "mujoco"]


def _load() -> None:
    try:
        importlib.import_module("mujoco")
    except Exception:  # whatever the binding of that OpenGL raises
        chosen = os.environ.get("MUJOCO_GL")
        if chosen is None:
            raise
        os.environ["MUJOCO_GL"] = "disabled"
        try:
            importlib.import_module("mujoco")
        finally:
            os.environ["MUJOCO_GL"] = chosen


_load()

import mujoco  # noqa: E402
from mujoco.batch import Batch, SimulationError  # noqa: E402
