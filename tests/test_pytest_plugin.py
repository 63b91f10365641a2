"""The plugin as a user's tests meet it: in a session of its own, with a failure that says what is wrong."""

import importlib
import importlib.util
import pkgutil
import subprocess
import sys
from importlib.metadata import entry_points
from pathlib import Path

import pytest

import diffdrive_mj as dd
from diffdrive_mj.judging.suite import cases

# Loaded before the sessions, which forget what they load themselves: NumPy cannot be loaded twice.
for module in pkgutil.walk_packages(dd.__path__, "diffdrive_mj."):
    if not module.name.endswith("__main__"):
        importlib.import_module(module.name)

# Installed, it is loaded by itself.
INSTALLED = any(point.name == "diffdrive_mj" for point in entry_points(group="pytest11"))
PLUGIN = (*(() if INSTALLED else ("-p", "diffdrive_mj.pytest_plugin")), "-p", "no:cacheprovider", "-p", "no:xdist")
MINE = """
import math
from diffdrive_mj.testing import assert_drift


class MyOdometry:
    def __init__(self, left_radius, right_radius, track_width, start):
        self.radii, self.track = (left_radius, right_radius), track_width
        self.x, self.y, self.theta = start
        self.last = None

    def update(self, wheels, t):
        before, self.last = self.last or wheels, wheels
        left, right = (r * (now - last) for r, now, last in zip(self.radii, wheels, before))
        distance, turn = (left + right) / 2, (right - left) / self.track
        chord = distance * (math.sin(turn / 2) / (turn / 2) if turn else 1.0)
        self.x += chord * math.cos(self.theta + AHEAD * turn)
        self.y += chord * math.sin(self.theta + AHEAD * turn)
        self.theta += turn
        return self.x, self.y, self.theta
"""
RIGHT = MINE.replace("AHEAD", "0.5")
EULER = MINE.replace("AHEAD", "0.0").replace(
    "distance * (math.sin(turn / 2) / (turn / 2) if turn else 1.0)", "distance"
)


def ran(pytester, code, *options, apart=False):
    """A session of a user's; apart, in a process of its own."""
    pytester.makepyfile(test_mine=code)
    return (pytester.runpytest_subprocess if apart else pytester.runpytest_inprocess)(*PLUGIN, *options)


def test_a_drift_within_its_bounds_passes_and_one_beyond_says_what_is_wrong(pytester):
    test = """
def test_mine(simulated_drive):
    assert_drift(simulated_drive("spin", robot="ct_bot"), MyOdometry, position=BOUND, heading=0.2)
"""
    ran(pytester, RIGHT + test.replace("BOUND", "0.05")).assert_outcomes(passed=1)
    result = ran(pytester, RIGHT + test.replace("BOUND", "1e-6"), "--diffdrive-pictures", "pictures")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(
        [
            "*AssertionError: MyOdometry: holds on 0 of 1 drives",
            "*drive *arithmetic *drift *heading",
            "*spin: position off by * mm, more than 1.00 *m",
            "*picture: *pictures*test_mine.py*spin.png",
        ]
    )
    (picture,) = Path(pytester.path, "pictures").rglob("*.png")
    assert picture.read_bytes().startswith(b"\x89PNG")
    # The traceback ends in the test, not in the package.
    assert "testing.py" not in result.stdout.str()


def test_without_bounds_the_arithmetic_counts_and_the_reason_is_named(pytester):
    test = """
def test_mine(simulated_drive):
    assert_drift(simulated_drive("slalom", robot="ct_bot"), MyOdometry)
"""
    ran(pytester, RIGHT + test).assert_outcomes(passed=1)
    result = ran(pytester, EULER + test)
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["*slalom: arithmetic off by *(Euler): use the exact arc*"])


def test_a_drive_is_simulated_once_a_session(pytester):
    code = """
import pytest
from diffdrive_mj.physics import simulation

calls, simulate = [], simulation.simulate
simulation.simulate = lambda *given, **named: calls.append(given) or simulate(*given, **named)

@pytest.mark.parametrize("again", range(3))
def test_once(simulated_drive, again):
    drives = [simulated_drive("spin", robot="ct_bot"), simulated_drive("spin", robot="ct_bot", rate=10.0)]
    assert drives[0] is simulated_drive("spin", "ct_bot")
    assert len(drives[0].t) > 4 * len(drives[1].t)
    assert len(calls) == 2
"""
    ran(pytester, code, apart=True).assert_outcomes(passed=3)


def test_a_marked_test_runs_with_each_case_of_the_suite(pytester):
    test = """
import pytest

@pytest.mark.conformance
def test_mine(case):
    assert_drift(case, MyOdometry)

def test_other():
    pass
"""
    result = ran(pytester, RIGHT + test, "--strict-markers", "-v")
    outcomes = result.parseoutcomes()
    assert outcomes["passed"] > 15  # the others have readings that do not count, or counters that wrap
    result.stdout.fnmatch_lines(["*test_mine?straight? PASSED*", "*test_other PASSED*"])


def test_an_unknown_robot_or_drive_is_one_line(pytester):
    test = """
def test_robot(simulated_drive):
    simulated_drive("spin", robot="ct_bolt")

def test_drive(simulated_drive):
    simulated_drive("spine", robot="ct_bot")
"""
    result = ran(pytester, test)
    result.stdout.fnmatch_lines(["*unknown preset 'ct_bolt'*did you mean 'ct_bot'?", "*unknown drive 'spine'*'spin'?"])


def test_a_session_that_does_not_use_it_loads_nothing(pytester):
    """No NumPy, no MuJoCo: what is loaded is the plugin, and of the package its face."""
    code = """
import sys

def test_nothing():
    loaded = {name for name in sys.modules if name.partition(".")[0] in ("diffdrive_mj", "numpy", "scipy", "mujoco")}
    assert loaded <= {"diffdrive_mj", "diffdrive_mj._lazy", "diffdrive_mj.pytest_plugin"}, loaded
"""
    ran(pytester, code, "-p", "no:hypothesispytest", apart=True).assert_outcomes(passed=1)


def test_it_is_installed_with_the_package():
    pyproject = (Path(__file__).parent.parent / "pyproject.toml").read_text()
    assert '[project.entry-points.pytest11]\ndiffdrive_mj = "diffdrive_mj.pytest_plugin"' in pyproject


@pytest.mark.parametrize("tool", [[sys.executable, "-m", "pytest"]])
def test_its_options_are_in_the_help(tool, tmp_path):
    said = subprocess.run([*tool, *PLUGIN, "--help"], capture_output=True, text=True, check=True, cwd=tmp_path).stdout
    assert "--diffdrive-pictures" in said
    assert "@pytest.mark.conformance" in subprocess.run(
        [*tool, *PLUGIN, "--markers"], capture_output=True, text=True, check=True, cwd=tmp_path
    ).stdout.replace("\n", " ")


def test_of_what_answers_nothing_there_is_no_picture_and_no_folder(tmp_path, monkeypatch):
    robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
    monkeypatch.setenv("DIFFDRIVE_PICTURES", str(tmp_path / "pictures"))
    ahead = dd.Task("ahead", robot, [0.0, 1.0], [(0, 0), (10, 10)])
    with pytest.raises(AssertionError, match="raised ZeroDivisionError"):
        dd.testing.assert_drift(ahead, lambda wheels, t, robot: 1 / 0)
    assert not list(tmp_path.iterdir())
    with pytest.raises(AssertionError, match=r"picture: .*ahead\.png"):
        dd.testing.assert_drift(ahead, robot.replace(left_radius=0.2))
    assert len(list(tmp_path.rglob("*.png"))) == 1


@pytest.mark.skipif(importlib.util.find_spec("xdist") is None, reason="no pytest-xdist")
def test_workers_share_the_cases_and_the_folder_of_pictures(pytester):
    test = """
import pytest

@pytest.mark.conformance
class TestMine:
    def test_case(self, case):
        assert case.name != "spin"

@pytest.mark.parametrize("maneuver", ["spin", "straight"])
def test_drive(simulated_drive, maneuver):
    assert_drift(simulated_drive(maneuver, "ct_bot"), MyOdometry, position=1e-6)
"""
    pytester.makepyfile(test_mine=RIGHT + test)
    options = [option for option in PLUGIN if option != "no:xdist"][:-1]
    result = pytester.runpytest_subprocess(*options, "-n", "2", "--strict-markers", "--diffdrive-pictures", "pictures")
    result.assert_outcomes(passed=len(cases()) - 1, failed=3)
    assert sorted(path.name for path in Path(pytester.path, "pictures").rglob("*.png")) == ["spin.png", "straight.png"]
