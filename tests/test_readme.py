"""The pages do what they say: their Python runs, their links lead somewhere, their commands exist."""

import doctest
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from helpers import ROOT

import diffdrive_mj as dd
from diffdrive_mj.judging.standards import STANDARD_MANEUVERS, residual
from diffdrive_mj.robot import presets

PAGES = [
    ROOT / "README.md", ROOT / "experiments" / "README.md", ROOT / "models" / "README.md", ROOT / "CONTRIBUTING.md",
    ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").glob("*.md")),
]  # fmt: skip


def test_the_code_runs_from_top_to_bottom(capsys):
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL)
    scope = {}
    for block in blocks:
        exec(block, scope)
    printed = capsys.readouterr().out
    assert printed.count("largest position error") == 2
    assert "(4, 201, 3)" in printed


@pytest.mark.parametrize("page", PAGES[1:], ids=lambda page: str(page.relative_to(ROOT)))
def test_the_code_of_the_other_pages_runs(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for _, block in re.findall(r"^(`{3,})python\n(.*?)^\1$", page.read_text(), re.DOTALL | re.MULTILINE):
        scope = {"__name__": page.stem}
        exec(block, scope)
        for value in [value for value in scope.values() if getattr(value, "__module__", "") == page.stem]:
            for examples in doctest.DocTestFinder().find(value, value.__name__, globs=scope):
                assert doctest.DocTestRunner().run(examples).failed == 0


def linked(page):
    """The files and headings that a page links to; a heading is none where the whole file is meant."""
    for file, _, heading in re.findall(r"\]\((?!http)([^)#]*)(#([^)]+))?\)", page.read_text()):
        yield page.parent / file if file else page, heading


def anchors(page):
    """The headings of a page, as links name them."""
    headings = re.findall(r"^#+ (.*)$", page.read_text(), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_and_pictures_lead_somewhere(page):
    for file, heading in linked(page):
        assert file.exists(), file
        assert not heading or heading in anchors(file), heading


def test_the_front_page_leads_to_every_page():
    found, waiting = set(), [PAGES[0]]
    while waiting:
        page = waiting.pop()
        found.add(page.resolve())
        waiting += [file for file, _ in linked(page) if file.suffix == ".md" and file.resolve() not in found]
    assert {page.resolve() for page in PAGES} == found


def test_every_experiment_has_its_row_section_and_picture():
    front, inside = PAGES[0].read_text(), PAGES[1].read_text()
    for script in (ROOT / "experiments").glob("*.py"):
        assert f"| `{script.stem}` |" in front
        assert f"## {script.stem}" in inside
        assert (ROOT / "experiments" / "pictures" / f"{script.stem}.png").is_file()


def test_the_commands_exist():
    makefile = (ROOT / "Makefile").read_text()
    for command in re.findall(r"(?:^|`)make ([a-z]+)", PAGES[0].read_text() + PAGES[1].read_text(), re.MULTILINE):
        assert re.search(rf"^{command}:", makefile, re.MULTILINE), command


NUMBER = r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?"


def commands(page):
    """The commands of a page, block by block, each with what the page says that it prints, if it does."""
    return re.findall(r"^```sh\n(.*?)^```\n(?:\n```\n(.*?)^```\n)?", page.read_text(), re.DOTALL | re.MULTILINE)


def test_the_commands_run_as_printed_in_a_fresh_shell(tmp_path):
    (install, _), *blocks = commands(PAGES[0])
    assert "pip install ." in install
    assert Path(sys.executable).with_name("diffdrive").exists()
    shell = {"PATH": f"{Path(sys.executable).parent}:/usr/bin:/bin", "HOME": str(tmp_path), "PYTHONPATH": str(ROOT)}
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    for block, output in blocks:
        if re.search(r"^cc ", block, re.MULTILINE) and not shutil.which("cc"):
            continue  # what is compiled here is tried where there is a compiler
        done = subprocess.run(
            ["bash", "-ec", block], cwd=tmp_path, env=shell, capture_output=True, text=True, check=False
        )
        assert (done.returncode, done.stderr) == (0, ""), block
        if output:
            assert re.sub(NUMBER, "#", done.stdout) == re.sub(NUMBER, "#", output)
            # Processors differ in the last digits.
            printed, said = ([float(number) for number in re.findall(NUMBER, text)] for text in (done.stdout, output))
            np.testing.assert_allclose(printed, said, rtol=1e-5)
    assert {path.name for path in tmp_path.iterdir()} >= {"lab", "calibrated.toml", "results"}


def table(heading):
    """The rows of the table below a heading of the front page."""
    section = PAGES[0].read_text().split(f"\n## {heading}\n")[1].split("\n## ")[0]
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in section.splitlines() if line.startswith("|")]
    return rows[2:]


def test_the_presets_are_those_that_there_are():
    rows = table("Robots")
    assert sorted(row[0].strip("`") for row in rows) == list(presets())
    for name, radii, track, _ in rows:
        robot = dd.Robot.load(name.strip("`"))
        left, right = (float(radius) for radius in (radii.split(", ") * 2)[:2])
        assert (left, right, float(track)) == (robot.left_radius, robot.right_radius, robot.track_width)


def test_the_floor_is_what_the_physics_leaves():
    said = next(row[1:] for row in table("How clean the physics is") if row[0] == "as delivered")
    robot = dd.Robot.load("mismatched")
    for figure, commands_for in zip(said, STANDARD_MANEUVERS.values(), strict=True):
        measured = residual(dd.simulate(robot, commands_for(robot)), robot)
        assert float(figure) == pytest.approx(measured.position, rel=0.1)


def test_the_program_in_c_is_the_example():
    program = PAGES[0].read_text().split("cat > odometry.c << 'END'\n")[1].split("END\n")[0]
    assert program == (ROOT / "examples" / "odometry.c").read_text()
