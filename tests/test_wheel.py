"""A wheel holds all that its user needs: the package, the models, the experiments, and the program."""

import importlib.util
import os
import re
import subprocess
import sys
import zipfile

import pytest
from helpers import ROOT


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """A wheel, built from the checkout as it is."""
    if importlib.util.find_spec("hatchling") is None:
        pytest.skip("hatchling is not installed: pip install hatchling")
    folder = tmp_path_factory.mktemp("wheel")
    subprocess.run(
        [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation", "--no-index",
         "--disable-pip-version-check", "--wheel-dir", folder, ROOT],
        check=True, timeout=120,
    )  # fmt: skip
    (built,) = folder.glob("*.whl")
    return built


@pytest.fixture(scope="module")
def installed(wheel, tmp_path_factory):
    """The environment of a Python that finds the package in the unpacked wheel, and nowhere else before."""
    folder = tmp_path_factory.mktemp("installed")
    zipfile.ZipFile(wheel).extractall(folder)
    return {**os.environ, "PYTHONPATH": str(folder), "PYTHONWARNINGS": "error"}


def run(*command, cwd, env):
    done = subprocess.run([sys.executable, *command], cwd=cwd, env=env, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_a_wheel_holds_what_its_user_needs(wheel):
    names = set(zipfile.ZipFile(wheel).namelist())
    for folder, pattern in (("diffdrive_mj", "**/*.py"), ("diffdrive_mj", "**/*.pyi"), ("diffdrive_mj", "**/web/*")):
        assert {str(path.relative_to(ROOT)) for path in (ROOT / folder).glob(pattern)} <= names
    for folder, pattern in (("experiments", "*.py"), ("models", "*.xml"), ("models", "robots/*.toml")):
        assert {f"diffdrive_mj/{path.relative_to(ROOT)}" for path in (ROOT / folder).glob(pattern)} <= names
    assert not [name for name in names if name.endswith(".png") or "tests" in name]


def test_its_description_needs_no_other_file(wheel):
    archive = zipfile.ZipFile(wheel)
    (metadata,) = [archive.read(name).decode() for name in archive.namelist() if name.endswith("/METADATA")]
    assert "\nRequires-Python: >=3.11\n" in metadata
    description = metadata.split("\n\n", 1)[1]
    assert "differential-drive" in description
    assert not re.search(r"\]\((?!http)", description)


def test_the_wheels_experiments_run(installed, tmp_path):
    where = run("-c", "import diffdrive_mj; print(diffdrive_mj.__file__)", cwd=tmp_path, env=installed)
    assert where.startswith(installed["PYTHONPATH"])
    listed = run("-m", "diffdrive_mj", "experiment", cwd=tmp_path, env=installed)
    for script in (ROOT / "experiments").glob("*.py"):
        assert f"  {script.stem} " in listed
    printed = run(
        "-m", "diffdrive_mj", "experiment", "mismatched_radii", "--distance", "3", cwd=tmp_path, env=installed
    )
    assert "written: results/mismatched_radii" in printed
    assert (tmp_path / "results" / "mismatched_radii" / "mismatched_radii.png").is_file()
    assert "diffdrive experiment mismatched_radii --distance 3" in (tmp_path / "results" / "index.html").read_text()


def test_the_wheels_presets_are_there(installed, tmp_path):
    assert "ct_bot" in run("-m", "diffdrive_mj", "explain", "ct_bot", cwd=tmp_path, env=installed)
