"""The mutants of the benchmark: one fault each, the same ones for a seed, none in words or annotations."""

import ast
import difflib
import sys

import pytest
from helpers import ROOT

sys.path.insert(0, str(ROOT / "benchmarks"))
from mutants import mutants

SOURCE = '''"""Words - 3."""
import math
def area(radius: float = 2.0, *, squared: bool = True) -> float:
    """Not 1 + 1."""
    if radius < 0 or not squared:
        raise ValueError(f"radius {radius + 1}")
    return math.pi * radius**2 if squared else math.copysign(radius, -1.0)
'''


def test_every_mutant_differs_in_one_line_and_can_be_read():
    found = mutants(SOURCE, 100, "a")
    assert len(found) > 10
    for mutant in found:
        ast.parse(mutant.source)
        changed = [line for line in difflib.ndiff(SOURCE.splitlines(), mutant.source.splitlines()) if line[0] in "+-"]
        assert len(changed) == 2
        assert mutant.line in (3, 5, 6, 7)


@pytest.mark.parametrize(
    "fault",
    [
        "radius: float = 4.0", "squared: bool = False", "(radius <= 0)", "(radius < 0 and (not squared))", "(squared):",
        "pass", "(math.pi / radius ** 2)", "radius**3", "(not (squared))", "math.copysign(-1.0, radius)", "(1.0))",
    ],
)  # fmt: skip
def test_faults_of_each_kind_are_made(fault):
    assert any(fault in mutant.after for mutant in mutants(SOURCE, 100, "a"))


def test_a_seed_makes_the_same_choice_whatever_else_is_run():
    assert mutants(SOURCE, 5, "a") == mutants(SOURCE, 5, "a")
    assert mutants(SOURCE, 5, "a") != mutants(SOURCE, 5, "b")
    assert len(mutants(SOURCE, 5, "a")) == 5
