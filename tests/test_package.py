import importlib
import importlib.metadata
import re
import subprocess
import sys
import tomllib

import pytest
from helpers import ROOT

import diffdrive_mj as dd

HEAVY = {"mujoco", "matplotlib", "scipy"}
# Names of modules that people use, and where the modules are.
MODULES = {
    "calibration": "calibration", "commands": "commands", "controller": "controller", "diagnosis": "diagnosis",
    "drive": "drive", "errors": "errors", "kinematics": "kinematics", "logs": "logs", "maneuvers": "maneuvers",
    "metrics": "metrics", "odometry": "odometry", "parts": "parts", "report": "report", "se2": "se2",
    "bidirectional": "calibration._square", "closed_forms": "estimation.closed_forms",
    "compensation": "calibration.straights", "course": "estimation.course",
    "course_noise": "estimation.course_noise", "course_tracker": "estimation.course_tracker",
    "encoder": "sensors.encoder", "export": "calibration.export", "least_squares": "calibration.paths",
    "model": "physics.model", "optical_flow": "sensors.optical_flow", "plots": "report.plots",
    "simulation": "physics.simulation", "tilt": "physics.tilt", "umbmark": "calibration.squares",
}  # fmt: skip
NAMES = {
    "Caster", "ClosedLoop", "Commands", "DiffdriveError", "Drive", "Encoder", "FlowSensor", "GoToPose", "Motor",
    "Patch", "Payload", "Physics", "Push", "Recording", "Robot", "Servo", "SimulationDiverged", "SkidSteer", "Tyres",
    "WheelEncoder", "World", "simulate",
}  # fmt: skip


def _run(code):
    """Code in a fresh interpreter, and what it printed."""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    return done.stdout.split()


@pytest.fixture(scope="module")
def light():
    """The modules that importing the package and doing maths with it loads."""
    code = (
        "import sys, diffdrive_mj as dd\n"
        "robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)\n"
        "path = dd.odometry.integrate([(0, 0), (1, 2)], robot)\n"
        "dd.metrics.drift(path, path), dd.maneuvers.square(robot), dd.World(), dd.Physics(), dir(dd)\n"
        "print(*sys.modules)"
    )
    return set(_run(code))


@pytest.mark.parametrize("module", sorted(HEAVY))
def test_the_maths_loads_nothing_heavy(light, module):
    assert "numpy" in light
    assert module not in light


def test_physics_loads_when_it_is_used():
    modules = _run("import sys, diffdrive_mj as dd; dd.simulate; print(*sys.modules)")
    assert "mujoco" in modules
    assert "matplotlib" not in modules


@pytest.mark.parametrize("name", sorted({*MODULES, *NAMES}))
def test_names_are_there_and_listed(name):
    assert name in dir(dd)
    assert getattr(dd, name) is not None


@pytest.mark.parametrize("name", sorted(MODULES))
def test_modules_are_where_the_map_says(name):
    assert getattr(dd, name) is importlib.import_module(f"diffdrive_mj.{MODULES[name]}")


def test_dir_is_sorted_and_holds_nothing_else():
    assert dir(dd) == sorted(dir(dd))
    assert not {"importlib", "annotations", "TYPE_CHECKING", "attach"} & set(dir(dd))
    assert [name for name in dir(dd) if name.startswith("_")] == []


def test_unknown_names():
    with pytest.raises(AttributeError, match="'diffdrive_mj' has no attribute 'simulat'"):
        dd.simulat  # noqa: B018
    with pytest.raises(ImportError):
        from diffdrive_mj import nothing_of_the_kind  # noqa: F401


def test_version():
    assert dd.__version__ == importlib.metadata.version("diffdrive_mj")


def test_the_citation_file():
    """Valid in form (Citation File Format 1.2.0): its required keys, in a layout that any YAML reader takes."""
    lines = (ROOT / "CITATION.cff").read_text().splitlines()
    keys = dict(re.fullmatch(r"([a-z-]+):(?: (.+))?", line).groups() for line in lines if not line.startswith("  "))
    assert {"cff-version", "message", "title", "authors"} <= set(keys)
    assert keys["cff-version"] == "1.2.0"
    assert keys["version"] == dd.__version__
    assert keys["license"] == "MIT"
    assert all(re.match(r"  (- )?\S", line) for line in lines if line.startswith(" "))
    assert "\t" not in "".join(lines)


def test_the_source_archive_has_the_pages():
    build = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["hatch"]["build"]["targets"]["sdist"]
    tracked = {path.name for path in ROOT.iterdir() if path.suffix in (".md", ".cff")}
    assert tracked | {"docs"} <= set(build["include"])
