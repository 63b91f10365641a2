"""The pages do what they say: their Python runs, their links lead somewhere, their commands exist."""

import doctest
import re
import shlex

import numpy as np
import pytest
from helpers import ROOT

import diffdrive_mj as dd
from diffdrive_mj import cli

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
def test_the_code_of_the_other_pages_runs(page):
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


def own_log(path, robot, commands):
    """A log as the README shows it: ticks of 16 bits every 20 ms, a pose in degrees with every fifth."""
    angles = np.concatenate([[[0, 0]], np.cumsum(commands.wheel_rates * commands.period, axis=0)])
    truth = dd.odometry.integrate(angles, robot)
    counts = np.round(angles * robot.encoder.ticks_per_wheel_turn / (2 * np.pi)).astype(int) % 2**16
    rows = ["stamp,enc_l,enc_r,x,y,yaw"]
    for k, ((left, right), (x, y, theta)) in enumerate(zip(counts, truth, strict=True)):
        pose = f"{x:.4f},{y:.4f},{np.degrees(theta):.2f}" if k % 5 == 0 else ",,"
        rows.append(f"{1e3 * commands.period * k:.0f},{left},{right},{pose}")
    path.write_text("\n".join(rows))


def test_the_calibration_runs_as_it_says(tmp_path, monkeypatch, capsys):
    page = PAGES[0].read_text()
    (command,) = re.findall(r"```sh\n(diffdrive .*?)```", page, re.DOTALL)
    (nominal,) = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "nominal.toml").write_text(nominal)
    true = dd.Robot(left_radius=0.0331, right_radius=0.0327, track_width=0.163)
    own_log(tmp_path / "left.csv", true, dd.maneuvers.figure_eight(true, radius=0.5, speed=0.2, period=0.02))
    own_log(tmp_path / "right.csv", true, dd.maneuvers.square(true, side=1.0, speed=0.2, clockwise=True, period=0.02))
    cli.main(shlex.split(command.replace("\\\n", " "))[1:])
    printed = capsys.readouterr().out
    assert "wheel_separation_multiplier: 1.0187" in printed
    found = dd.Robot.load("calibrated.toml")
    for field in ("left_radius", "right_radius", "track_width"):
        assert getattr(found, field) == pytest.approx(getattr(true, field), rel=1e-4)
        assert re.search(rf"^  {field} .* \+- ", printed, re.MULTILINE)
