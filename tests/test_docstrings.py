"""Every public function and class has an example in its docstring, and every example runs and says what it prints."""

import doctest
import importlib
import inspect
import pkgutil

import numpy as np
import pytest

import diffdrive_mj as dd

# A command of several, whose examples are their help; hooks, which pytest calls.
WITHOUT_EXAMPLE = ("cli.robots", "cli.worlds", "pytest_plugin")


def public_modules():
    found = (module.name for module in pkgutil.walk_packages(dd.__path__, "diffdrive_mj."))
    return [name for name in found if not any(part.startswith("_") for part in name.split("."))]


def examples(module):
    """The docstrings of a module's own functions, classes and their methods, by name."""
    finder = doctest.DocTestFinder(exclude_empty=False)
    return {test.name: test for test in finder.find(module, extraglobs={"dd": dd, "np": np})}


def public(module):
    """What a module defines and a user may call."""
    for name, value in vars(module).items():
        own = getattr(value, "__module__", None) == module.__name__
        if own and not name.startswith("_") and (inspect.isfunction(value) or inspect.isclass(value)):
            yield f"{module.__name__}.{name}"


@pytest.mark.parametrize("name", public_modules())
def test_every_example_runs(name):
    runner = doctest.DocTestRunner(verbose=False, optionflags=doctest.ELLIPSIS | doctest.REPORT_ONLY_FIRST_FAILURE)
    said = []
    with np.printoptions(precision=4, suppress=True, floatmode="maxprec", linewidth=100):
        for test in examples(importlib.import_module(name)).values():
            runner.run(test, out=said.append)
    assert not runner.failures, "".join(said)


@pytest.mark.parametrize("name", public_modules())
def test_every_public_function_and_class_has_an_example(name):
    if f"{name}.".startswith(tuple(f"diffdrive_mj.{left_out}." for left_out in WITHOUT_EXAMPLE)):
        pytest.skip("its examples are still to be written")
    module = importlib.import_module(name)
    found = examples(module)
    without = [item for item in public(module) if not (item in found and found[item].examples)]
    assert not without


def test_what_is_left_out_exists():
    for name in WITHOUT_EXAMPLE:
        importlib.import_module(f"diffdrive_mj.{name}")
