"""The website builds without a warning, holds a reference to all that is public, and fetches nothing."""

import fcntl
import importlib
import importlib.util
import json
import os
import re
import subprocess
import sys

import pytest
from helpers import ROOT
from test_docstrings import public, public_modules

import diffdrive_mj as dd

pytest.importorskip("sphinx", reason="Sphinx is not installed: pip install '.[docs]'")
pytest.importorskip("myst_parser", reason="MyST is not installed: pip install '.[docs]'")
pytest.importorskip("furo", reason="furo is not installed: pip install '.[docs]'")


def extension(name):
    """One of the extensions of the build."""
    spec = importlib.util.spec_from_file_location(name, ROOT / "docs" / "_ext" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


# What `make docs` runs, but for the folders.
BUILD = re.search(r"python (-m sphinx .*) -c docs \. docs/_build/html$", (ROOT / "Makefile").read_text(), re.M)[
    1
].split()


@pytest.fixture(scope="session")
def site(tmp_path_factory):
    """The website, built as `make docs` builds it, once for all workers of a session: the others wait for the first."""
    mine = tmp_path_factory.getbasetemp()
    shared = mine.parent if "PYTEST_XDIST_WORKER" in os.environ else mine
    html, said = shared / "site", shared / "site.json"
    with open(shared / "site.lock", "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not said.exists():
            command = [sys.executable, *BUILD, "--doctree-dir", shared / "doctrees", "-c", ROOT / "docs", ROOT, html]
            done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=ROOT)
            said.write_text(json.dumps([done.returncode, done.stderr]))
    assert json.loads(said.read_text()) == [0, ""]
    return html


@pytest.fixture(scope="session")
def pages(site):
    """The text of each page, by its path."""
    return {page.relative_to(site).as_posix(): page.read_text() for page in site.rglob("*.html")}


@pytest.fixture(scope="session")
def defined(site):
    """The names that have an entry in the reference."""
    from sphinx.util.inventory import InventoryFile

    inventory = InventoryFile.loads((site / "objects.inv").read_bytes(), uri="")
    return {name for kind, entries in inventory.data.items() if kind.startswith("py:") for name in entries}


def test_warnings_are_errors():
    assert "--fail-on-warning" in BUILD
    assert "suppress_warnings" not in (ROOT / "docs" / "conf.py").read_text()


def test_all_that_is_public_is_in_the_reference(defined):
    modules = set(public_modules())
    names = {name for module in modules for name in public(importlib.import_module(module))}
    assert len(names) > 200
    assert modules - defined == set()
    assert names - defined == set()
    assert not [name for name in defined if any(part.startswith("_") for part in name.split("."))]


def test_the_methods_of_classes_are_in_the_reference(defined):
    assert {"diffdrive_mj.recording.Recording.drift", "diffdrive_mj.odometry.Odometer.update"} <= defined


def test_the_reference_page_lists_the_names_of_the_package():
    page = (ROOT / "docs" / "reference.md").read_text()
    assert set(re.findall(r"`dd\.(\w+)`", page)) == set(dir(dd))


def test_nothing_is_fetched_by_a_reader(pages):
    for page, text in pages.items():
        for tag in re.findall(r"<(?:script|link|img|iframe|source)\b[^>]*>", text):
            # Links to where the project is are no resources.
            assert not re.search(r'(?:src|href)="(?:https?:)?//', tag), (page, tag)
            assert "mathjax" not in tag.lower(), page


def test_formulas_are_drawn_and_names_are_links(pages):
    theory = pages["docs/theory.html"]
    assert theory.count("<math") > 40
    assert "$" not in re.sub(r"<pre.*?</pre>", "", theory, flags=re.DOTALL).split("<article")[1].split("</article>")[0]
    assert 'href="reference/kinematics.html#diffdrive_mj.kinematics.body_twist"' in theory
    assert 'href="reference/metrics.drifts.html#diffdrive_mj.metrics.drifts.Drift"' in pages["docs/glossary.html"]


def test_docstrings_render(pages):
    """Fences are blocks, sections are fields, signs are themselves."""
    text = pages["docs/reference/kinematics.html"]
    assert "```" not in text
    assert "system-message" not in "".join(pages.values())
    assert "|omega| b / 2" in re.sub(r"<[^>]+>", "", text)


def test_the_notebook_is_a_page_with_its_pictures(pages, site):
    assert len(re.findall(r"<img [^>]*src=", pages["docs/notebook.html"])) == 2


def test_the_front_door(pages):
    assert 'url=docs/index.html"' in pages["index.html"]


FUNCTIONS = re.findall(r"\| ((?:`[\w.]+`(?:, )?)+) \|$", (ROOT / "docs" / "theory.md").read_text(), re.MULTILINE)


def test_every_formula_has_a_function_that_exists():
    names = [name for cell in FUNCTIONS for name in re.findall(r"`([\w.]+)`", cell)]
    assert len(names) > 30
    assert all(callable(resolved(name)) for name in names)


def resolved(name):
    """What a name of the theory means, as in `dd.name`."""
    found = dd
    for part in name.split("."):
        found = getattr(found, part) if hasattr(found, part) else importlib.import_module(f"{found.__name__}.{part}")
    return found


def test_every_formula_of_a_docstring_is_in_the_theory():
    indexed = {resolved(name) for cell in FUNCTIONS for name in re.findall(r"`([\w.]+)`", cell)}
    with_formula = set()
    for module in map(importlib.import_module, public_modules()):
        for name, found in vars(module).items():
            if getattr(found, "__module__", "") == module.__name__ and not name.startswith("_"):
                members = vars(found).values() if isinstance(found, type) else ()
                with_formula |= {each for each in (found, *members) if "```" in (getattr(each, "__doc__", "") or "")}
    assert len(with_formula) > 25
    assert {f"{found.__module__}.{found.__qualname__}" for found in with_formula - indexed} == set()


def test_no_sentence_has_become_a_list(pages):
    """A line that begins with a number and a full stop, such as 30., begins a list."""
    assert [page for page, text in pages.items() if re.search(r'<ol [^>]*start="\d\d', text)] == []


def test_functions_in_formulas_are_set_off():
    latex2mathml = pytest.importorskip("docutils.utils.math.latex2mathml")
    set_off = extension("mathml").spaced(latex2mathml.tex2mathml(r"R\cos t + \sin(t)"))
    assert (
        re.sub(r"\s|</?m[a-z]+[^>]*>", "", set_off.replace(extension("mathml").GAP, "_"))
        == "R_cos&ApplyFunction;_t+sin&ApplyFunction;(t)"
    )


@pytest.mark.parametrize(
    ("docstring", "rest"),
    [
        (["A sum |a| * b_.", ""], [r"A sum \|a\| \* b\_.", ""]),
        (["```", "a_ = |b|", "```"], ["::", "", "    a_ = |b|", ""]),
        (["`x_ | y` and z", ">>> 1 * 2"], ["`x_ | y` and z", ">>> 1 * 2"]),
        (["Returns:", "    x: one,", "    two."], [":returns: x: one,", "    two."]),
        (["References:", "    [A]: one,", "    still one.", "    [B]: two."],
         ["References:", "    * [A]: one,", "      still one.", "    * [B]: two."]),
    ],
)  # fmt: skip
def test_docstrings_are_translated(docstring, rest):
    assert extension("docstrings").translated(docstring) == rest
