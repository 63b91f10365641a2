"""Names that are loaded when first used: from a stub, aliases among them; errors of what is loaded show."""

import sys

import pytest

STUB = """
from pack.deep import value as value, Shape as Round
from pack import tools as tools
from pack import broken as broken
from pack.deep import _own as _own
from json import dumps as dumps
other = Round
"""
INIT = """
from diffdrive_mj._lazy import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
"""
FILES = {
    "__init__.py": INIT,
    "__init__.pyi": STUB,
    "deep.py": "value = []\n_own = 1\n\n\nclass Shape:\n    pass\n",
    "tools.py": "name = 'tools'\n",
    "broken.py": "import nowhere_to_be_found\n",
}


@pytest.fixture
def pack(tmp_path, monkeypatch):
    (tmp_path / "pack").mkdir()
    for name, text in FILES.items():
        (tmp_path / "pack" / name).write_text(text)
    monkeypatch.syspath_prepend(tmp_path)
    import pack

    yield pack
    for name in [name for name in sys.modules if name.split(".")[0] == "pack"]:
        del sys.modules[name]


def test_the_stub_lists_the_public_names(pack):
    assert pack.__all__ == dir(pack) == ["Round", "broken", "dumps", "other", "tools", "value"]
    assert pack._own == 1


def test_nothing_is_loaded_before_it_is_used_and_then_once(pack):
    assert "pack.deep" not in sys.modules
    assert pack.value is sys.modules["pack.deep"].value
    assert vars(pack)["value"] is pack.value  # found at once from now on
    assert pack.tools.name == "tools"
    assert pack.dumps([1]) == "[1]"


def test_a_second_name_is_the_same_thing(pack):
    assert pack.other is pack.Round is sys.modules["pack.deep"].Shape


def test_a_name_that_is_not_there_and_a_module_that_fails(pack):
    with pytest.raises(AttributeError, match="module 'pack' has no attribute 'nothing'"):
        pack.nothing  # noqa: B018
    with pytest.raises(ModuleNotFoundError, match="nowhere_to_be_found"):
        pack.broken  # noqa: B018
