"""Where the models and the experiments lie: inside the package in a wheel, beside it in a checkout."""

import pytest

from diffdrive_mj import _resources


@pytest.mark.parametrize(
    ("there", "found"),
    [(["beside"], "beside"), (["inside"], "inside"), (["inside", "beside"], "inside"), ([], "inside")],
)
def test_a_folder_inside_the_package_comes_first(monkeypatch, tmp_path, there, found):
    package = tmp_path / "package"
    places = {"inside": package / "models", "beside": tmp_path / "models"}
    package.mkdir()
    for name in there:
        places[name].mkdir()
    monkeypatch.setattr(_resources, "_PACKAGE", package)
    assert _resources._folder("models") == places[found]
