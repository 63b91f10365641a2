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
    from diffdrive_mj import bidirectional as bidirectional
    from diffdrive_mj import calibration as calibration
    from diffdrive_mj import closed_forms as closed_forms
    from diffdrive_mj import compensation as compensation
    from diffdrive_mj import controller as controller
    from diffdrive_mj import course as course
    from diffdrive_mj import course_noise as course_noise
    from diffdrive_mj import course_tracker as course_tracker
    from diffdrive_mj import diagnosis as diagnosis
    from diffdrive_mj import drive as drive
    from diffdrive_mj import encoder as encoder
    from diffdrive_mj import export as export
    from diffdrive_mj import least_squares as least_squares
    from diffdrive_mj import logs as logs
    from diffdrive_mj import model as model
    from diffdrive_mj import optical_flow as optical_flow
    from diffdrive_mj import plots as plots
    from diffdrive_mj import report as report
    from diffdrive_mj import simulation as simulation
    from diffdrive_mj import umbmark as umbmark
    from diffdrive_mj.controller import GoToPose as GoToPose
    from diffdrive_mj.drive import Drive as Drive
    from diffdrive_mj.encoder import Encoder as Encoder
    from diffdrive_mj.optical_flow import FlowSensor as FlowSensor
    from diffdrive_mj.simulation import ClosedLoop as ClosedLoop
    from diffdrive_mj.simulation import Recording as Recording
    from diffdrive_mj.simulation import simulate as simulate

__version__ = "0.1.0"

# Loaded when first used: mujoco, matplotlib and scipy wait until then.
_LAZY_MODULES = (
    "bidirectional",
    "calibration",
    "closed_forms",
    "compensation",
    "controller",
    "course",
    "course_noise",
    "course_tracker",
    "diagnosis",
    "drive",
    "encoder",
    "export",
    "least_squares",
    "logs",
    "model",
    "optical_flow",
    "plots",
    "report",
    "simulation",
    "umbmark",
)
_LAZY_NAMES = {
    "ClosedLoop": "simulation",
    "Drive": "drive",
    "Encoder": "encoder",
    "FlowSensor": "optical_flow",
    "GoToPose": "controller",
    "Recording": "simulation",
    "simulate": "simulation",
}


def __getattr__(name: str) -> object:
    if name in _LAZY_MODULES:
        return importlib.import_module(f"diffdrive_mj.{name}")
    if name in _LAZY_NAMES:
        return getattr(importlib.import_module(f"diffdrive_mj.{_LAZY_NAMES[name]}"), name)
    raise AttributeError(f"module 'diffdrive_mj' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*globals(), *_LAZY_MODULES, *_LAZY_NAMES])
