from hypothesis import settings

# The same examples in every run, and no deadline: machines may be busy.
settings.register_profile("tests", derandomize=True, deadline=None, max_examples=15, database=None)
settings.load_profile("tests")

pytest_plugins = ("pytester",)
