"""The page's own scripts and styles, made part of it."""

from __future__ import annotations

import base64
import hashlib
import json
from pathlib import Path

WEB = Path(__file__).parent / "web"
# Modules import each other as "#web/name.mjs": in a page an import map leads from there to their text, in node that of
# package.json to their files.
_MODULES = (
    "camera", "colours", "quantities", "outline", "odometry", "replay", "scene", "stage", "timeline", "player",
    "settings", "by_hand", "by_hand_form", "page",
)  # fmt: skip
_START = 'import "#web/page.mjs"'


def styles() -> str:
    """The style sheet."""
    return (WEB / "page.css").read_text(encoding="utf-8")


def template() -> str:
    """The page without its contents, as a `string.Template`."""
    return (WEB / "page.html").read_text(encoding="utf-8")


def scripts() -> str:
    """The scripts as elements of the page: where the modules are, and the one that starts them."""
    return f'<script type="importmap">{_import_map()}</script>\n<script type="module">{_START}</script>'


def policy() -> str:
    """What the page may do: run these scripts and no others, show pictures of its own, and reach no network."""
    allowed = {"script": [_digest(_import_map()), _digest(_START), "data:"], "style": [_digest(styles())]}
    sources = "; ".join(f"{kind}-src {' '.join(each)}" for kind, each in allowed.items())
    return f"default-src 'none'; {sources}; img-src data:; base-uri 'none'; form-action 'none'"


def _import_map() -> str:
    modules = {f"#web/{name}.mjs": _data(WEB / f"{name}.mjs") for name in _MODULES}
    return json.dumps({"imports": modules})


def _data(path: Path) -> str:
    return f"data:text/javascript;base64,{base64.b64encode(path.read_bytes()).decode()}"


def _digest(text: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"
