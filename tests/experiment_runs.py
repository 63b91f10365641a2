"""Experiments called with options of a user's own: the right answer, or one clear line."""

from __future__ import annotations

import atexit
import re
import tempfile
import zlib
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from figure_checks import check_layout

from diffdrive_mj.errors import DiffdriveError
from diffdrive_mj.judging.random_drives import random_cases
from diffdrive_mj.judging.standards import PRESETS
from diffdrive_mj.report import Report

Pick = Callable[[np.random.Generator], object]
_FILES = tempfile.TemporaryDirectory()
atexit.register(_FILES.cleanup)


def robot_file(name: str, seed: int, **changes: object) -> str:
    """A TOML file of a robot that nobody chose."""
    (case,) = random_cases(1, seed)
    path = Path(_FILES.name, f"{name}.toml")
    case.robot.replace(name=name, **changes).save(path)
    return str(path)


# What `--robot` takes: every preset, and files, of which one robot's wheels speed up unequally.
ROBOTS = {
    **{name: name for name in PRESETS},
    "random": robot_file("random", 6),
    "unlike": robot_file("unlike", 4, servo={"gains": "equal", "law": "P"}),
}
# All but one of the presets are left to `make test-all`.
each_robot = pytest.mark.parametrize(
    "robot", [pytest.param(name, marks=pytest.mark.slow if name in PRESETS[1:] else ()) for name in ROBOTS]
)
# What is said of a robot that does not keep its grip or its balance.
SLIPS = "wheels must roll|lies on its chassis|tilts by more"


def even(low: float, high: float) -> Pick:
    """Numbers between two others."""
    return lambda rng: float(rng.uniform(low, high))


def sizes(low: float, high: float) -> Pick:
    """Positive numbers, evenly over the powers of ten."""
    return lambda rng: float(np.exp(rng.uniform(np.log(low), np.log(high))))


def whole(low: int, high: int) -> Pick:
    """Whole numbers, both limits included."""
    return lambda rng: int(rng.integers(low, high + 1))


def right_or_refused(script: ModuleType, robot: str, refusals: str = SLIPS, **picks: Pick) -> None:
    """With options drawn for a robot, other ones for each, all bounds hold, or one of the refusals is said.

    Pictures are looked at for the robots that nobody chose.
    """
    rng = np.random.default_rng(zlib.crc32(f"{script.__name__} {robot}".encode()))
    found = answer(script, robot=ROBOTS[robot], **{name: pick(rng) for name, pick in picks.items()})
    if isinstance(found, str):
        assert re.search(refusals, found)
    elif robot not in PRESETS:
        for picture in found.pictures.values():
            check_layout(picture)


def answer(script: ModuleType, **options: object) -> Report | str:
    """The report, whose bounds all hold, or the line that refuses the options."""
    try:
        report = script.run(**options)
    except DiffdriveError as error:
        line = str(error)
    else:
        assert report.bounds
        assert broken(report) == []
        return report
    assert len(line.splitlines()) == 1
    return line


def broken(report: Report) -> list[str]:
    """The bounds that do not hold."""
    return [str(bound) for bound in report.bounds if not bound.holds]
