"""Recordings of a real robot, which the user has beside the project: tests that need them skip where they are not."""

import os
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent


def optiodom_folder() -> Path:
    """The OptiOdom data set: the environment's DIFFDRIVE_OPTIODOM, or shared/data/optiodom next to the checkout."""
    given = os.environ.get("DIFFDRIVE_OPTIODOM")
    folder = Path(given) if given else ROOT.parent / "shared" / "data" / "optiodom"
    if not folder.is_dir():
        pytest.skip(f"no OptiOdom recordings at {folder}: set DIFFDRIVE_OPTIODOM to their folder")
    return folder
