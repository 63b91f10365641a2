"""The README does what it says: its Python runs, its links lead somewhere, its commands exist."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
PAGES = [ROOT / "README.md", ROOT / "experiments" / "README.md", ROOT / "models" / "README.md"]


def test_the_code_runs_from_top_to_bottom(capsys):
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL)
    scope = {}
    for block in blocks:
        exec(block, scope)
    printed = capsys.readouterr().out
    assert printed.count("largest position error") == 2
    assert "(4, 201, 3)" in printed


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_and_pictures_lead_somewhere(page):
    for link in re.findall(r"\]\((?!http)([^)#]+)\)", page.read_text()):
        assert (page.parent / link).exists(), link


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
