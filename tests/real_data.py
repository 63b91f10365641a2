"""Recordings of a real robot, which the user has beside the project: tests that need them skip where they are not."""

import os
from pathlib import Path

import pytest
from helpers import ROOT


def optiodom_folder() -> Path:
    """The OptiOdom data set: DIFFDRIVE_OPTIODOM of the environment, or data/optiodom in a folder next to us."""
    given = os.environ.get("DIFFDRIVE_OPTIODOM")
    folder = Path(given) if given else next(ROOT.parent.glob("*/data/optiodom"), None)
    if folder is None or not folder.is_dir():
        pytest.skip("no OptiOdom recordings found: set DIFFDRIVE_OPTIODOM to their folder")
    return folder


def optiodom_recordings() -> list[Path]:
    """The folders of all recordings."""
    return sorted(path.parent for path in optiodom_folder().glob("*/*/*_metadata.csv"))
