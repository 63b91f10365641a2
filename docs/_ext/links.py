"""What reads well on a code host becomes more in the build: a list of pages the contents, a name a link."""

import importlib
import re
from pathlib import Path

from docutils import nodes
from reference import PACKAGE, modules
from sphinx.transforms.post_transforms import SphinxPostTransform
from sphinx.util.nodes import make_refnode

REFERENCE = "docs/reference"


def setup(app):
    """Register all of it."""
    app.connect("source-read", _contents)
    app.add_post_transform(NamesToReference)
    app.connect("build-finished", _front_door)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _contents(app, docname, source):
    """Make the sections of the index, which are lists of links, the table of contents."""
    if docname == app.config.root_doc:
        for heading, section in re.findall(r"^## ([^\n]+)\n(.*?)(?=^## |\Z)", source[0], re.MULTILINE | re.DOTALL):
            pages = re.findall(r"^- \[([^\]]*)\]\(([^)#]+)\.(?:md|ipynb)\)", section, re.MULTILINE)
            if pages:
                source[0] += _toctree(f":caption: {heading}", [f"{title} <{page}>" for title, page in pages])
    if docname == REFERENCE:
        source[0] += _toctree(":caption: Modules", [f"reference/{name}" for name in modules() if "." not in name])


def _toctree(caption, pages):
    return "\n".join(["\n```{toctree}", caption, ":hidden:", ":titlesonly:", "", *pages, "```\n"])


def _front_door(app, _error):
    """Let the folder itself lead to the index, which lies where it lies in the sources."""
    if app.builder.format == "html":
        there = f'<meta http-equiv="refresh" content="0; url={app.config.root_doc}.html">'
        text = f"<!doctype html><title>{app.config.project}</title>{there}"
        (Path(app.outdir) / "index.html").write_text(text + "\n", encoding="utf-8")


class NamesToReference(SphinxPostTransform):
    """Names of modules, functions and classes, in code font, lead to the reference."""

    default_priority = 5

    def run(self, **_):
        """Replace the names in a page."""
        objects = self.env.get_domain("py").objects
        for literal in list(self.document.findall(nodes.literal)):
            entry = objects.get(_full_name(literal.astext()))
            if entry is not None and not isinstance(literal.parent, nodes.reference):
                args = (self.app.builder, self.env.docname, entry.docname, entry.node_id, literal.deepcopy())
                literal.replace_self(make_refnode(*args, literal.astext()))


def _full_name(text):
    """Where a name such as `dd.metrics.drift` or `kinematics.body_twist(...)` is defined."""
    match = re.fullmatch(rf"(dd\.|{PACKAGE}\.)?([A-Za-z]\w*(?:\.\w+)*)(?:\(.*\))?", text, re.DOTALL)
    if match is None:
        return ""
    prefix, path = match.groups()
    if not prefix and path.islower() and "." not in path:
        return f"{PACKAGE}.{path}"  # a module; other names in small letters are words of their own
    found = importlib.import_module(PACKAGE)
    try:
        for name in path.split("."):
            found = getattr(found, name)
    except (AttributeError, ImportError):
        return f"{PACKAGE}.{path}"
    inside = getattr(found, "__qualname__", "")
    return f"{found.__module__}.{inside}" if inside else getattr(found, "__name__", "")
