"""What a package imports, read from its source, and the rules that the imports must keep.

`read_imports` gives a graph: each module's name, without the package's, and the modules that it imports. The rules are
functions over such a graph; each returns what breaks it, one line a breach, so that an empty list is a pass.
"""

from __future__ import annotations

import ast
import graphlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path

Graph = Mapping[str, frozenset[str]]
FACE = "__init__"  # the package's own __init__, which users import
HEAVY = ("mujoco", "matplotlib")


@dataclass(frozen=True)
class Package:
    """The source of a package: its modules by name, and the names that its stubs load lazily with their modules."""

    name: str
    files: Mapping[str, Path]
    lazy: Mapping[str, Mapping[str, tuple[str, str]]]

    @classmethod
    def at(cls, root: Path) -> Package:
        """The package in a folder."""
        files = {_name(path.relative_to(root)): path for path in sorted(root.rglob("*.py"))}
        stubs = {_name(path.relative_to(root)): path for path in sorted(root.rglob("*.pyi"))}
        return cls(root.name, files, {name: _names(ast.parse(path.read_text())) for name, path in stubs.items()})

    def target(self, module: str, name: str | None = None) -> set[str]:
        """The modules that an import of a module, or of a name from it, reaches; of others, the heavy ones."""
        if module != self.name and not module.startswith(f"{self.name}."):
            return {head(module)} & set(HEAVY)
        own = module.removeprefix(self.name).removeprefix(".") or FACE
        inner = name if own == FACE else f"{own}.{name}"
        if name is not None and inner in self.files:
            return {inner}
        lazy = self.lazy.get(own, {})
        # `import package` may use any of its names.
        wanted = lazy.values() if name is None else [lazy[name]] if name in lazy else []
        return ({own} & set(self.files)).union(*(self.target(*source) for source in wanted))


def read_imports(package: Package) -> Graph:
    """The imports of every module: at the top, in functions, for type checkers, and by a module's name in a string."""
    return {
        module: frozenset(found for node in ast.walk(ast.parse(path.read_text())) for found in _of(node, path, package))
        - {module}
        for module, path in package.files.items()
    }


def _of(node: ast.AST, path: Path, package: Package) -> Iterator[str]:
    if isinstance(node, ast.Import):
        for alias in node.names:
            yield from package.target(alias.name)
    elif isinstance(node, ast.ImportFrom):
        module = node.module or ""
        if node.level:
            parts = [package.name, *path.relative_to(package.files[FACE].parent).parts]
            module = ".".join([*parts[: -node.level], *filter(None, [node.module])])
        for alias in node.names:
            yield from package.target(module, alias.name)
    elif isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value.startswith(f"{package.name}."):
        name = node.value.removeprefix(f"{package.name}.")
        yield from {name} & set(package.files)


def head(module: str) -> str:
    """The first part of a module's name: its folder, or itself."""
    return module.partition(".")[0]


def _name(path: Path) -> str:
    parts = path.with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" and len(parts) > 1 else parts)


def _names(stub: ast.Module) -> dict[str, tuple[str, str]]:
    imports = [node for node in stub.body if isinstance(node, ast.ImportFrom)]
    names = {alias.asname or alias.name: (node.module or "", alias.name) for node in imports for alias in node.names}
    for node in stub.body:  # `other = name`, a second name
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.Name):
            names |= {target.id: names[node.value.id] for target in node.targets if isinstance(target, ast.Name)}
    return names


def public(module: str) -> bool:
    """Whether users may import a module: no part of its name starts with an underscore."""
    return not any(part.startswith("_") for part in module.split("."))


def definitions(package: Package) -> dict[str, set[str]]:
    """The public functions and classes that each module defines."""
    kinds = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)
    return {
        module: {
            node.name for node in ast.parse(path.read_text()).body if isinstance(node, kinds) and public(node.name)
        }
        for module, path in package.files.items()
    }


def row_of(module: str, order: Sequence[Iterable[str]]) -> int | None:
    """The row of a module in the order, by the first part of its name; the name itself comes before a pattern."""
    for match in (str.__eq__, fnmatchcase):
        for k, row in enumerate(order):
            if any(match(head(module), pattern) for pattern in row):
                return k
    return None


def unplaced(graph: Graph, order: Sequence[Iterable[str]]) -> list[str]:
    """Modules that are in no row of the order."""
    return [f"{module}: has no row in the order" for module in graph if row_of(module, order) is None]


def upward(graph: Graph, order: Sequence[Iterable[str]]) -> list[str]:
    """Imports from a later row of the order."""
    rows = {module: row_of(module, order) for module in graph}
    return [
        f"{module} imports {target} from a later row"
        for module, targets in graph.items()
        for target in sorted(targets & set(graph))
        if (here := rows[module]) is not None and (there := rows[target]) is not None and there > here
    ]


def reached(graph: Graph, module: str) -> dict[str, str]:
    """What importing a module loads in the end, each with the module that asks for it; packages' __init__ included."""
    found: dict[str, str] = {}
    waiting = [module]
    while waiting:
        asking = waiting.pop()
        folders = [asking.rsplit(".", k)[0] for k in range(1, asking.count(".") + 1)]
        for target in sorted(graph.get(asking, frozenset()).union(folders)):
            if target not in found and target != module:
                found[target] = asking
                waiting.append(target)
    return found


def reaching(graph: Graph, folders: Sequence[str], forbidden: str) -> list[str]:
    """Modules of some folders that load a forbidden folder, a module of it, or a library, however far away."""
    return [
        f"{module} reaches {target} by {asking}"
        for module in graph
        if head(module) in folders
        for target, asking in reached(graph, module).items()
        if head(target) == forbidden
    ]


def importing(graph: Graph, library: str, allowed: Sequence[str]) -> list[str]:
    """Modules that import a library and are not allowed to; allowed are modules and folders."""
    return [
        f"{module} imports {library}"
        for module, targets in graph.items()
        if library in targets and not any(f"{module}.".startswith(f"{name}.") for name in allowed)
    ]


def circles(graph: Graph) -> list[str]:
    """Modules that import each other in a circle, and packages that do."""
    folders: dict[str, set[str]] = {}
    for module, targets in graph.items():
        folders.setdefault(head(module), set()).update({head(t) for t in targets & set(graph)} - {head(module)})
    return [" -> ".join(circle) for part in (graph, folders) if (circle := _circle(part))]


def _circle(graph: Mapping[str, Iterable[str]]) -> list[str]:
    try:
        graphlib.TopologicalSorter(graph).prepare()
    except graphlib.CycleError as error:
        return list(reversed(error.args[1]))
    return []


def namesakes(defined: Mapping[str, set[str]], exported: set[str], commands: str) -> list[str]:
    """Modules that bear the name of a function or class: their own, or one that users get from the package itself.

    With names loaded when first used the second access would give the module. The files of the command line are named
    after its commands, and only their own names matter.
    """
    breaches = []
    for module, names in defined.items():
        last = module.split(".")[-1]
        if last in names or (last in exported and not module.startswith(f"{commands}.")):
            breaches.append(f"{module}: bears the name of a function or class")
    return breaches


def long(lines: Mapping[str, int], most: int) -> list[str]:
    """Modules of too many lines."""
    return [f"{module}: {count} lines, at most {most}" for module, count in lines.items() if count > most]
