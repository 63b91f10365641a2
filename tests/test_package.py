import importlib
import importlib.metadata
import subprocess
import sys

import pytest

import diffdrive_mj as dd

HEAVY = {"mujoco", "matplotlib", "scipy"}
LAZY_MODULES = {"course", "course_noise", "course_tracker", "model", "plots", "report", "simulation"}
LAZY = LAZY_MODULES | {"ClosedLoop", "Recording", "simulate"}
EAGER = {"Commands", "DiffdriveError", "Physics", "Push", "Robot", "SimulationDiverged", "World"} | {
    "errors",
    "kinematics",
    "maneuvers",
    "metrics",
    "odometry",
    "se2",
}


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


@pytest.mark.parametrize("name", sorted(LAZY | EAGER))
def test_names_are_there_and_listed(name):
    assert name in dir(dd)
    assert getattr(dd, name) is not None


@pytest.mark.parametrize("name", sorted(LAZY_MODULES))
def test_lazy_modules_are_the_modules(name):
    assert getattr(dd, name) is importlib.import_module(f"diffdrive_mj.{name}")


def test_dir_is_sorted():
    assert dir(dd) == sorted(dir(dd))


def test_unknown_names():
    with pytest.raises(AttributeError, match="'diffdrive_mj' has no attribute 'simulat'"):
        dd.simulat  # noqa: B018
    with pytest.raises(ImportError):
        from diffdrive_mj import nothing_of_the_kind  # noqa: F401


def test_version():
    assert dd.__version__ == importlib.metadata.version("diffdrive_mj")
