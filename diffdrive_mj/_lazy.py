"""A package's public names, listed once in its `.pyi` file and loaded when first used."""

from __future__ import annotations

import ast
import importlib
import sys
from collections.abc import Callable
from pathlib import Path


def attach(package: str, file: str) -> tuple[Callable[[str], object], Callable[[], list[str]], list[str]]:
    """`__getattr__`, `__dir__` and `__all__` of a package from the stub beside it.

    In the stub, `from module import name as name` is one public name, and `other = name` a second name for it. MuJoCo,
    Matplotlib and SciPy are thus loaded by whoever first asks for a name that needs them.

    Args:
        package: its `__name__`.
        file: its `__file__`.
    """
    stub = ast.parse(Path(file).with_suffix(".pyi").read_text(encoding="utf-8"))
    sources = {
        alias.asname or alias.name: (node.module or "", alias.name)
        for node in stub.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    for node in stub.body:
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.Name):
            sources.update(
                {target.id: sources[node.value.id] for target in node.targets if isinstance(target, ast.Name)}
            )

    def load(name: str) -> object:
        if name not in sources:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        value = _imported(*sources[name])
        setattr(sys.modules[package], name, value)
        return value

    names = sorted(name for name in sources if not name.startswith("_"))
    return load, lambda: names, names


def _imported(module: str, name: str) -> object:
    """The module `module.name`, or what `module` calls so."""
    try:
        return importlib.import_module(f"{module}.{name}")
    except ModuleNotFoundError as error:
        if error.name != f"{module}.{name}":
            raise
    return getattr(importlib.import_module(module), name)
