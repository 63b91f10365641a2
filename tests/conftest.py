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
