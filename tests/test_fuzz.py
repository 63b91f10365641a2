"""Some of the fuzzer's cases, and that it notices what it is there for; `python benchmarks/fuzz.py` runs many more."""

import random
import sys
import warnings
from collections import Counter
from pathlib import Path

import pytest
from helpers import ROOT

import diffdrive_mj as dd
from diffdrive_mj.errors import InvalidValue


@pytest.fixture(scope="module")
def fuzz():
    """The program, imported."""
    sys.path.insert(0, str(ROOT / "benchmarks"))
    try:
        import fuzz

        yield fuzz
    finally:
        sys.path.remove(str(ROOT / "benchmarks"))


def words(fuzz, count):
    """What the cases lead to, and the kinds of faults."""
    with fuzz.workplace():
        outcomes = [fuzz.outcome(random.Random(f"test {case}")) for case in range(count)]
    return Counter(word for word, _ in outcomes), {kind for _, kind in outcomes} - {""}


def test_no_case_ends_in_a_fault(fuzz):
    seen, faults = words(fuzz, 400)
    assert not faults
    # It reaches all three, and is neither refused throughout nor accepted.
    assert len(seen) == 6


def broken(error):
    def function(*arguments, **options):
        raise error

    return function


@pytest.mark.parametrize(
    ("error", "kind"), [(ZeroDivisionError("no"), "ZeroDivisionError"), (KeyError("a\nb"), "KeyError")]
)
def test_another_error_is_noticed(fuzz, monkeypatch, error, kind):
    monkeypatch.setattr(dd.logs, "read_csv", broken(error))
    assert any(fault.startswith(kind) for fault in words(fuzz, 60)[1])


def test_a_message_of_two_lines_is_noticed(fuzz, monkeypatch):
    monkeypatch.setattr(InvalidValue, "__str__", lambda error: "two\nlines")
    assert any("InvalidValue" in fault for fault in words(fuzz, 60)[1])


def test_a_warning_is_noticed(fuzz, monkeypatch):
    monkeypatch.setattr(dd.logs, "read_csv", lambda *arguments: warnings.warn("slow", RuntimeWarning, stacklevel=1))
    assert any("RuntimeWarning" in fault for fault in words(fuzz, 60)[1])


def test_a_file_that_a_refused_command_leaves_is_noticed(fuzz, monkeypatch):
    def write(*arguments):
        Path("half").write_text("written")
        raise InvalidValue("too late")

    monkeypatch.setattr(fuzz.cli, "main", lambda arguments: dd.errors.exit_on_error("diffdrive")(write)())
    assert any("Fault" in fault for fault in words(fuzz, 100)[1])


def test_every_public_function_is_called(fuzz):
    called = {function.__qualname__ for function in fuzz.CALLABLES}
    assert {"simulate", "least_squares", "Robot.load", "Encoder.read", "compile_model", "Patch", "from_fixes"} <= called
