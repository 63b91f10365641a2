"""The notebook runs in a kernel and shows what is stored in it, figures and all."""

import base64
import io

import numpy as np
import pages
import pytest
from helpers import ROOT
from PIL import Image

nbformat = pytest.importorskip("nbformat", reason="nbformat is not installed: pip install '.[docs]'")
nbclient = pytest.importorskip("nbclient", reason="nbclient is not installed: pip install '.[docs]'")
pytest.importorskip("ipykernel", reason="ipykernel is not installed: pip install '.[docs]'")

import notebooks  # noqa: E402

STORED = nbformat.read(notebooks.NOTEBOOK, as_version=4)
LARGEST = 400_000  # bytes


def code(notebook):
    return [cell for cell in notebook.cells if cell.cell_type == "code"]


def text(output):
    """What an output says in words."""
    return "".join(output.get("text", output.get("data", {}).get("text/plain", "")))


def picture(output):
    return Image.open(io.BytesIO(base64.b64decode(output["data"]["image/png"])))


def test_it_is_small_and_stored_with_its_figures():
    assert notebooks.NOTEBOOK.stat().st_size < LARGEST
    pictures = [
        picture(output) for cell in code(STORED) for output in cell.outputs if "image/png" in output.get("data", {})
    ]
    assert len(pictures) == 2
    assert all(image.width >= 800 for image in pictures)
    assert all("execution" not in cell.metadata for cell in STORED.cells)
    assert not [cell.metadata.tags for cell in STORED.cells if "tags" in cell.metadata]  # one of which is to be skipped


def test_it_shows_what_is_stored():
    anew = notebooks.executed(notebooks.NOTEBOOK)
    for stored, made in zip(code(STORED), code(anew), strict=True):
        assert [output.output_type for output in made.outputs] == [output.output_type for output in stored.outputs]
        for now, then in zip(made.outputs, stored.outputs, strict=True):
            pages.compare(text(now), text(then))
            assert set(now.get("data", {})) == set(then.get("data", {}))
            if "image/png" in then.get("data", {}):
                assert picture(now).size == picture(then).size
                assert different(picture(now), picture(then)) < 0.01


def different(one, other):
    """The share of its range by which pictures differ, on a coarse grid, which another renderer's edges do not move."""
    coarse = [np.asarray(image.convert("L").resize((80, 60), Image.Resampling.BOX), float) for image in (one, other)]
    return np.abs(coarse[0] - coarse[1]).max() / 255


def test_another_picture_is_noticed():
    first, second = (
        picture(output) for cell in code(STORED) for output in cell.outputs if "image/png" in output.get("data", {})
    )
    shifted = Image.fromarray(np.roll(np.asarray(first), 8, axis=0))
    assert different(first, first) == 0
    assert different(first, shifted) > 0.05
    assert different(first, second.resize(first.size)) > 0.1


def test_a_cell_that_fails_is_noticed(tmp_path):
    broken = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell("1 / 0")], metadata=STORED.metadata)
    nbformat.write(broken, tmp_path / "broken.ipynb")
    with pytest.raises(nbclient.exceptions.CellExecutionError):
        notebooks.executed(tmp_path / "broken.ipynb")


def test_its_links_lead_somewhere():
    for cell in STORED.cells:
        for target in pages.re.findall(r"\]\((?!http)([^)#]+)", cell.source if cell.cell_type == "markdown" else ""):
            assert (ROOT / "docs" / target).is_file(), target
