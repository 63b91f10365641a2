"""A notebook is a page: its text, its code, and the outputs and pictures that are stored in it."""

import json

from myst_parser.parsers.sphinx_ import MystParser


def setup(app):
    """Read .ipynb files as pages."""
    app.add_source_suffix(".ipynb", "notebook")
    app.add_source_parser(NotebookParser)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


class NotebookParser(MystParser):
    """Reads a notebook as the Markdown page that says the same."""

    supported = ("notebook",)

    def parse(self, inputstring, document):
        """Parse the cells one after the other."""
        cells = json.loads(inputstring)["cells"]
        super().parse("\n\n".join(part for cell in cells for part in _parts(cell)), document)


def _parts(cell):
    """A cell and its outputs, as Markdown."""
    source = "".join(cell["source"])
    if cell["cell_type"] == "markdown":
        yield source
        return
    yield _fenced("python", source)
    for output in cell["outputs"]:
        data = output.get("data", {})
        if "image/png" in data:
            label, picture = "".join(data.get("text/plain", "figure")), "".join(data["image/png"]).strip()
            yield f"![{label}](data:image/png;base64,{picture})"
        elif text := "".join(output.get("text", data.get("text/plain", ""))):
            yield _fenced("text", text.rstrip("\n"))


def _fenced(language, text):
    return f"````{language}\n{text}\n````"
