"""The five documents stand in `docs/references.md` under their keys, and are cited where it says."""

import re

import pytest
from helpers import ROOT

PAGE = (ROOT / "docs" / "references.md").read_text()
CHAPTER = PAGE.split("## The five documents")[1].split("### Letters and signs")[0]
SECTIONS = dict(re.findall(r"^### \[(.+?)\]\n(.*?)(?=^### |\Z)", CHAPTER, re.MULTILINE | re.DOTALL))
PACKAGE, PRESETS = ROOT / "diffdrive_mj", ROOT / "models" / "robots"


def files():
    """What may cite, by the name that the page calls it: modules and presets."""
    for path in PACKAGE.rglob("*.py"):
        parts = path.relative_to(PACKAGE).with_suffix("").parts
        yield ".".join(parts[:-1] if parts[-1] == "__init__" else parts), path
    for path in PRESETS.glob("*.toml"):
        yield path.stem, path


def test_the_five_keys():
    assert set(SECTIONS) == {"ct-Sim", "Petersen 2013", "Behnke", "Odometrie wiki 2016", "Greek notes"}


@pytest.mark.parametrize("key", SECTIONS)
def test_a_document_is_cited_where_the_page_says(key):
    told = set(re.findall(r"`([\w.]+)`", SECTIONS[key].split("**Cited in**")[1].split("\n- ")[0]))
    citing = {name for name, path in files() if f"[{key}]" in path.read_text()}
    assert citing <= told
    assert told <= {name for name, _ in files()}


def test_letters_and_signs_are_given_for_each():
    header = PAGE.split("### Letters and signs\n\n")[1].splitlines()[0]
    assert [cell.strip() for cell in header.split("|")[3:-1]] == [f"[{key}]" for key in SECTIONS]
