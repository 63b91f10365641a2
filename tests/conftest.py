import os
import subprocess
import sys

import pytest
from hypothesis import settings

# The same examples in every run, and no deadline: machines may be busy.
settings.register_profile("tests", derandomize=True, deadline=None, max_examples=15, database=None)
settings.load_profile("tests")

pytest_plugins = ("pytester",)


@pytest.fixture(scope="session", autouse=True)
def pictures(tmp_path_factory):
    """Pictures of assertions that fail on purpose are not left in the system's folder for temporary files."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("DIFFDRIVE_PICTURES", str(tmp_path_factory.mktemp("pictures")))
        yield


@pytest.fixture(scope="session")
def opengl():
    """Tests that draw films are skipped where there is no OpenGL."""
    code = "import mujoco; mujoco.GLContext(8, 8).make_current()"
    tried = subprocess.run(
        [sys.executable, "-c", code], env={**os.environ, "MUJOCO_GL": "egl"}, capture_output=True, check=False
    )
    if tried.returncode:
        pytest.skip("there is no OpenGL without a screen: install libegl1 and libgl1-mesa-dri")
