"""diffdrive_mj: how wrong a differential-drive robot's odometry will be, and why, before it drives."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

from diffdrive_mj import errors as errors
from diffdrive_mj import kinematics as kinematics
from diffdrive_mj import maneuvers as maneuvers
from diffdrive_mj import metrics as metrics
from diffdrive_mj import odometry as odometry
from diffdrive_mj import se2 as se2
from diffdrive_mj import tilt as tilt
from diffdrive_mj.errors import DiffdriveError as DiffdriveError
from diffdrive_mj.errors import SimulationDiverged as SimulationDiverged
from diffdrive_mj.maneuvers import Commands as Commands
from diffdrive_mj.robot import Robot as Robot
from diffdrive_mj.world import Patch as Patch
from diffdrive_mj.world import Physics as Physics
from diffdrive_mj.world import Push as Push
from diffdrive_mj.world import World as World

if TYPE_CHECKING:
    from diffdrive_mj import course as course
    from diffdrive_mj import course_noise as course_noise
    from diffdrive_mj import course_tracker as course_tracker
    from diffdrive_mj import model as model
    from diffdrive_mj import plots as plots
    from diffdrive_mj import report as report
    from diffdrive_mj import simulation as simulation
    from diffdrive_mj.simulation import ClosedLoop as ClosedLoop
    from diffdrive_mj.simulation import Recording as Recording
    from diffdrive_mj.simulation import simulate as simulate

__version__ = "0.1.0"

# Loaded when first used: these import mujoco, matplotlib or scipy.
_LAZY_MODULES = ("course", "course_noise", "course_tracker", "model", "plots", "report", "simulation")
_LAZY_NAMES = {"ClosedLoop": "simulation", "Recording": "simulation", "simulate": "simulation"}


def __getattr__(name: str) -> object:
    if name in _LAZY_MODULES:
        return importlib.import_module(f"diffdrive_mj.{name}")
    if name in _LAZY_NAMES:
        return getattr(importlib.import_module(f"diffdrive_mj.{_LAZY_NAMES[name]}"), name)
    raise AttributeError(f"module 'diffdrive_mj' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*globals(), *_LAZY_MODULES, *_LAZY_NAMES])
