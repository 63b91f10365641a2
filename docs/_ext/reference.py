"""A page for every public module, written from the docstrings before the pages are read."""

import importlib
import pkgutil
from pathlib import Path

from docstrings import translated

PACKAGE = "diffdrive_mj"
FOLDER = Path(__file__).parent.parent / "reference"


def setup(app):
    """Write the pages when a build begins."""
    app.connect("builder-inited", lambda _: _write())
    app.connect("autodoc-skip-member", _not_ours)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def modules():
    """The public modules, without the package's own name before them."""
    package = importlib.import_module(PACKAGE)
    found = (module.name for module in pkgutil.walk_packages(package.__path__, f"{PACKAGE}."))
    names = sorted(name.removeprefix(f"{PACKAGE}.") for name in found)
    return [name for name in names if not any(part.startswith("_") for part in name.split("."))]


def _write():
    """Write what has changed, so that only that is built again, and take out what is no longer there."""
    FOLDER.mkdir(exist_ok=True)
    names = modules()
    pages = {f"{name}.rst": _page(name, [inner for inner in names if inner.startswith(f"{name}.")]) for name in names}
    for path in FOLDER.iterdir():
        if path.name not in pages:
            path.unlink()
    for name, text in pages.items():
        path = FOLDER / name
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


def _page(name, inside):
    lines = [name, "=" * len(name), "", f".. automodule:: {PACKAGE}.{name}"]
    lines += ["   :members:", "   :ignore-module-all:", ""]
    if inside:
        lines += [f"* :doc:`{module}`: {_purpose(module)}" for module in inside]
        lines += ["", ".. toctree::", "   :hidden:", "   :titlesonly:", "", *(f"   {module}" for module in inside), ""]
    return "\n".join(lines)


def _purpose(module):
    """The first line of a module's docstring."""
    (line,) = translated([importlib.import_module(f"{PACKAGE}.{module}").__doc__.splitlines()[0]])
    return line


def _not_ours(_app, _what, _name, member, skip, _options):
    """Leave out what a class has from other packages."""
    return True if not getattr(member, "__module__", PACKAGE).startswith(PACKAGE) else None
