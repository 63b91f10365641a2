"""The import rules of `docs/architecture.md`: the package keeps them, and a package that does not is caught."""

import re
from pathlib import Path

import import_rules as rules
import pytest
from helpers import ROOT

import diffdrive_mj as dd

# Imports run from a row to itself or to a row before it.
ORDER = (
    {"__init__", "errors", "_*"},
    {
        "se2", "kinematics", "odometry", "metrics", "robot", "parts", "tolerances", "_scaling", "_former", "world",
        "terrain", "solver", "commands",
        "maneuvers", "controller", "grip", "recording", "drive", "gyro_log", "pose_log",
    },
    {"sensors", "logs"},
    {"physics", "estimation"},
    {"diagnosis"},
    {"calibration"},
    {"judging", "sweeps"},
    {"report", "play"},
    {"cli", "pytest_plugin", "testing", "__main__"},
)  # fmt: skip
WITHOUT_SIMULATOR = ("calibration", "diagnosis", "estimation", "logs")
MUJOCO, MATPLOTLIB = ("physics", "report.filming"), ("report",)
LONGEST = 300

PACKAGE = rules.Package.at(ROOT / "diffdrive_mj")
GRAPH = rules.read_imports(PACKAGE)
PAGE = (ROOT / "docs" / "architecture.md").read_text()


def listed() -> list[str]:
    """The modules that have a line in the map."""
    return re.findall(r"^\| `([\w.]+)` \|", PAGE.split("## The map")[1].split("\n## ")[0], re.MULTILINE)


def exported() -> set[str]:
    """The functions and classes among the package's own names."""
    return {name for name in dir(dd) if callable(getattr(dd, name))}


def test_imports_run_one_way():
    assert rules.unplaced(GRAPH, ORDER) == []
    assert rules.upward(GRAPH, ORDER) == []


def test_no_module_imports_itself_in_the_end():
    assert rules.circles(GRAPH) == []


@pytest.mark.parametrize("simulator", ["physics", "mujoco"])
def test_a_real_robot_needs_no_simulator(simulator):
    assert rules.reaching(GRAPH, WITHOUT_SIMULATOR, simulator) == []


def test_mujoco_and_matplotlib_stay_where_they_belong():
    assert rules.importing(GRAPH, "mujoco", MUJOCO) == []
    assert rules.importing(GRAPH, "matplotlib", MATPLOTLIB) == []
    # Both are imported at all: the reader sees them.
    assert any("mujoco" in targets for targets in GRAPH.values())
    assert any("matplotlib" in targets for targets in GRAPH.values())


def test_no_module_bears_the_name_of_a_function_or_class():
    assert rules.namesakes(rules.definitions(PACKAGE), exported(), commands="cli") == []


def test_every_module_reads_in_one_sitting():
    lines = {module: len(path.read_text().splitlines()) for module, path in PACKAGE.files.items()}
    assert rules.long(lines, LONGEST) == []


def test_every_public_module_has_its_line_in_the_map():
    assert sorted({module for module in PACKAGE.files if rules.public(module)} - set(listed())) == []
    assert len(listed()) == len(set(listed()))


def test_every_line_of_the_map_is_a_module():
    assert [module for module in listed() if module not in PACKAGE.files] == []


def test_the_page_has_the_order_that_is_tested():
    table = PAGE.split("## Import rules")[1].split("\n## ")[0]
    rows = [set(re.findall(r"`([^`]+)`", row)) for row in re.findall(r"^\| \d \| (`.*) \|$", table, re.MULTILINE)]
    there = {"_*", *(module.split(".")[0] for module in PACKAGE.files)}
    for printed, row in zip(rows, (row for row in ORDER if row & there), strict=True):
        assert row & there <= printed <= row


# What the rules catch.


def graph(**imports: str) -> dict[str, frozenset[str]]:
    """A made-up package: each module and what it imports, two underscores for a dot."""
    return {module.replace("__", "."): frozenset(targets.split()) for module, targets in imports.items()}


SOUND = graph(
    errors="", _checks="errors", robot="_checks", logs="", logs__csv="robot _checks", physics="",
    physics__model="robot mujoco", calibration="", calibration__paths="logs.csv", report="", report__plots="matplotlib",
    cli="report.plots calibration.paths physics.model",
)  # fmt: skip


def breaches(made_up):
    """What each rule says of a package."""
    return {
        "unplaced": rules.unplaced(made_up, ORDER),
        "upward": rules.upward(made_up, ORDER),
        "circles": rules.circles(made_up),
        "physics": rules.reaching(made_up, WITHOUT_SIMULATOR, "physics"),
        "mujoco": rules.importing(made_up, "mujoco", MUJOCO),
        "matplotlib": rules.importing(made_up, "matplotlib", MATPLOTLIB),
    }


def test_a_sound_package_passes():
    assert not any(breaches(SOUND).values())


@pytest.mark.parametrize(
    ("change", "rule", "breach"),
    [
        ({"tools": ""}, "unplaced", "tools: has no row in the order"),
        ({"errors": "robot"}, "upward", "errors imports robot from a later row"),
        ({"_checks": "se2", "se2": ""}, "upward", "_checks imports se2 from a later row"),
        ({"logs__csv": "physics.model"}, "upward", "logs.csv imports physics.model from a later row"),
        ({"report": "cli"}, "upward", "report imports cli from a later row"),
        ({"robot": "world", "world": "robot"}, "circles", "robot -> world -> robot"),
        ({"calibration__paths": "calibration.result", "calibration__result": "calibration.paths"}, "circles",
         "calibration.paths -> calibration.result -> calibration.paths"),
        ({"sensors__encoder": "logs.csv", "logs__optiodom": "sensors.encoder"}, "circles", "logs -> sensors -> logs"),
        ({"calibration__paths": "physics.model"}, "physics",
         "calibration.paths reaches physics.model by calibration.paths"),
        ({"calibration__paths": "drive", "drive": "physics.model"}, "physics",
         "calibration.paths reaches physics.model by drive"),
        ({"logs": "physics.model"}, "physics", "logs.csv reaches physics.model by logs"),
        ({"robot": "mujoco"}, "mujoco", "robot imports mujoco"),
        ({"report__plots": "mujoco"}, "mujoco", "report.plots imports mujoco"),
        ({"calibration__paths": "matplotlib"}, "matplotlib", "calibration.paths imports matplotlib"),
        ({"cli": "matplotlib"}, "matplotlib", "cli imports matplotlib"),
    ],
)  # fmt: skip
def test_a_breach_is_caught(change, rule, breach):
    found = breaches({**SOUND, **graph(**change)})[rule]
    assert any(set(breach.split(" -> ")) == set(line.split(" -> ")) for line in found), found


def test_filming_may_import_mujoco():
    assert rules.importing(graph(report__filming="mujoco"), "mujoco", MUJOCO) == []


@pytest.mark.parametrize(
    ("defined", "caught"),
    [
        ({"calibration.umbmark": {"umbmark", "error"}}, True),
        ({"physics.simulate": {"drive_on"}}, True),
        ({"cli.simulate": {"command"}}, False),
        ({"cli.simulate": {"simulate"}}, True),
        ({"drive": {"Drive"}}, False),
    ],
)
def test_namesakes_are_caught(defined, caught):
    assert bool(rules.namesakes(defined, {"simulate", "Drive"}, commands="cli")) == caught


def test_long_modules_are_caught():
    assert rules.long({"short": 300, "long": 301}, LONGEST) == ["long: 301 lines, at most 300"]


def write(folder: Path, **files: str) -> rules.Package:
    """A package on disk: each file's text, two underscores in a keyword for a folder."""
    for name, text in files.items():
        path = folder / "made" / f"{name.replace('__', '/')}.py"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    for place in (folder / "made", *(path for path in (folder / "made").iterdir() if path.is_dir())):
        (place / "__init__.py").touch()
    (folder / "made" / "__init__.pyi").write_text(
        "from made import a as a\nfrom made.a import Thing as Thing\nfrom made.b import c as _c\nother = _c\n"
    )
    return rules.Package.at(folder / "made")


@pytest.mark.parametrize(
    ("text", "imports"),
    [
        ("import mujoco.batch\nimport json", {"mujoco"}),
        ("from matplotlib.figure import Figure", {"matplotlib"}),
        ("import made.a", {"a"}),
        ("from made import a, b", {"a", "b"}),
        ("from made.b import c", {"b.c"}),
        ("from made.b.c import name", {"b.c"}),
        ("from made import Thing", {"a", "__init__"}),
        ("from made import other", {"b.c", "__init__"}),
        ("import made as m", {"a", "b.c", "__init__"}),
        ("def f():\n    from made import a\n    import mujoco", {"a", "mujoco"}),
        ("from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from made.b import c", {"b.c"}),
        ("NAMES = {'one': 'made.b.c', 'two': 'made.nothing'}", {"b.c"}),
        ('"""As made.b.c does."""', set()),
        ("from ..a import x\nfrom . import c", {"a", "b.c"}),
        ("from .c import name", {"b.c"}),
    ],
)
def test_the_reader_sees_every_kind_of_import(text, imports, tmp_path):
    package = write(tmp_path, a="class Thing: ...", b__c="", b__module=text)
    assert rules.read_imports(package)["b.module"] == imports


def test_the_reader_knows_public_names(tmp_path):
    package = write(tmp_path, a="class A: ...\ndef b(): ...\ndef _c(): ...\nD = 1", _hidden="")
    assert rules.definitions(package)["a"] == {"A", "b"}
    assert [module for module in package.files if rules.public(module)] == ["a"]
