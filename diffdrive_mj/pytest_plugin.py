"""A plugin for pytest: drives that are simulated once a session, and the conformance suite as a parameter.

Nothing of the package is loaded before a test asks for it.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from diffdrive_mj.judging.tasks import Task
    from diffdrive_mj.robot import Robot


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the folder of pictures to the options."""
    group = parser.getgroup("diffdrive_mj")
    group.addoption("--diffdrive-pictures", metavar="DIR", help="folder for the pictures of drifts beyond their bounds")


def pytest_configure(config: pytest.Config) -> None:
    """Declare the marker, and tell the assertion where pictures go."""
    config.addinivalue_line("markers", "conformance: run with each case of the conformance suite, as the argument case")
    if folder := config.getoption("--diffdrive-pictures"):
        patch = pytest.MonkeyPatch()
        patch.setenv("DIFFDRIVE_PICTURES", str(Path(folder).absolute()))
        config.add_cleanup(patch.undo)


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Give a test that is marked so each case of the conformance suite."""
    if metafunc.definition.get_closest_marker("conformance"):
        from diffdrive_mj.judging.suite import cases

        metafunc.parametrize("case", cases(), ids=lambda case: case.name)


@pytest.fixture(scope="session")
def simulated_drive() -> Callable[..., Task]:
    """Simulate a drive: `simulated_drive("square", robot="ct_bot", rate=50.0, seed=0)`, each of them once a session."""
    from diffdrive_mj.judging.by_name import simulated

    made: dict[tuple[object, ...], Task] = {}

    def drive(maneuver: str, robot: Robot | str | Path, *, rate: float = 50.0, seed: int = 0) -> Task:
        key = (maneuver, robot, rate, seed)
        if key not in made:
            made[key] = simulated(maneuver, robot, rate=rate, seed=seed)
        return made[key]

    return drive
