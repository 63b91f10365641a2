"""What tests of the page need beside Python, and the line with which they skip where it is missing."""

import shutil
import subprocess

import pytest
from helpers import ROOT

from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.play.files import node_modules


def node() -> str:
    """The program, with the page's packages beside it."""
    program = shutil.which("node")
    if program is None:
        pytest.skip("node is not installed: tests of diffdrive play in JavaScript are left out")
    try:
        assert node_modules(ROOT).parent == ROOT
    except InvalidValue as error:
        pytest.skip(f"{error}: npm ci gets them")
    return program


def chromium() -> str:
    """The browser, driven by playwright-core and judged by axe-core."""
    program = shutil.which("chromium")
    if program is None:
        pytest.skip("chromium is not installed: tests of diffdrive play in a browser are left out")
    for package in ("playwright-core", "axe-core"):
        if not (ROOT / "node_modules" / package).is_dir():
            pytest.skip(f"{package} is not installed: npm ci gets it")
    return program


def run_node(script: str, *arguments: str, given: str = "", timeout: float = 120) -> str:
    """What a script of this folder prints."""
    done = subprocess.run([node(), ROOT / "tests" / "play" / script, *arguments], input=given, capture_output=True,
                          text=True, cwd=ROOT, timeout=timeout, check=False)  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout
