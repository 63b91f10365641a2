from hypothesis import settings

# The same examples every time, whatever the machine's load.
settings.register_profile("tests", derandomize=True, deadline=None, max_examples=20, database=None)
settings.load_profile("tests")
