"""The files that the page is made of: its own, and two packages of npm that are found or asked for."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

from diffdrive_mj.errors import InvalidValue

# With these versions the tests compare the page's poses with Python's.
PACKAGES = {"@mujoco/mujoco": "3.14.0", "three": "0.187.0"}
_HERE = Path(__file__).resolve().parent
_OWN = _HERE.parent
_TYPES = {
    ".html": "text/html; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".mjs": "text/javascript; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".wasm": "application/wasm",
}
_OF_PACKAGES = {
    "/mujoco/mujoco.js": "@mujoco/mujoco/mujoco.js",
    "/mujoco/mujoco.wasm": "@mujoco/mujoco/mujoco.wasm",
    "/three/three.module.js": "three/build/three.module.js",
    "/three/three.core.js": "three/build/three.core.js",
}


def node_modules(given: Path | None = None) -> Path:
    """Find the folder `node_modules` that holds the page's packages.

    Args:
        given: a folder that holds it, or it itself; otherwise it is looked for in the current folder and those above
            it, where npm may have put it, then in the checkout.

    Returns:
        The folder.

    Raises:
        InvalidValue: none holds both packages in the right versions; the message says how to get them.

    Example:
        >>> node_modules(Path("/no/such/folder"))
        Traceback (most recent call last):
        ...
        diffdrive_mj.errors.InvalidValue: diffdrive play needs @mujoco/mujoco 3.14.0: ...
    """
    places = [given] if given is not None else [here := Path.cwd(), *here.parents, _OWN.parent]
    found = [folder for place in places for folder in (place / "node_modules", place) if folder.is_dir()]
    lacks = [list(_lacking(folder)) for folder in found] or [[f"{name} {want}" for name, want in PACKAGES.items()]]
    for folder, lacking in zip(found, lacks, strict=False):
        if not lacking:
            return folder
    install = " ".join(f"{name}@{version}" for name, version in PACKAGES.items())
    raise InvalidValue(
        f"diffdrive play needs {min(lacks, key=len)[0]}: make play gets it in a checkout, npm install {install} "
        "elsewhere; the page of diffdrive report has a version without physics that needs neither"
    )


def _lacking(folder: Path) -> Iterator[str]:
    for name, wanted in PACKAGES.items():
        try:
            version = json.loads((folder / name / "package.json").read_text(encoding="utf-8"))["version"]
        except (OSError, ValueError, KeyError, TypeError):
            version = None
        if version != wanted:
            yield f"{name} {wanted}" + (f" ({folder} has {version})" if version else "")


def served(packages: Path) -> dict[str, Path]:
    """List every file that the server gives out, by the path under which it does.

    Args:
        packages: a folder `node_modules`.

    Returns:
        Paths of the page's own files as in the package, so that they import each other there and in node alike.

    Example:
        >>> served(Path("node_modules"))["/three/three.core.js"].as_posix()
        'node_modules/three/build/three.core.js'
    """
    own = [*sorted((_HERE / "web").iterdir()), _OWN / "report" / "web" / "odometry.mjs"]
    listed = {f"/{path.relative_to(_OWN).as_posix()}": path for path in own if path.suffix in _TYPES}
    return {"/": _HERE / "web" / "index.html", **listed} | {url: packages / path for url, path in _OF_PACKAGES.items()}


def content_type(path: Path) -> str:
    """Return the type under which a file is sent.

    Args:
        path: its ending counts.

    Example:
        >>> content_type(Path("mujoco.wasm"))
        'application/wasm'
    """
    return _TYPES[path.suffix]
