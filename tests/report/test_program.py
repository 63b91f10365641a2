"""An experiment as a program: options, exit statuses, refusals in one line before any work."""

import inspect
import json
import os
import platform
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from diffdrive_mj import report
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.report import Bound, Report
from diffdrive_mj.report.program import _program

CALLS = []


def experiment(value: float = 1.0, seed: int = 0, robot: str = "mine", other_folder: Path = Path(".")) -> Report:
    """Ask a question.

    Args:
        value: of the bound,
            100 % of it [mm].
        seed: of nothing.
        robot: a name.
    """
    CALLS.append((value, seed, robot, other_folder))
    if value < 0:
        raise InvalidValue(f"value = {value:g}: must not be negative")
    return Report("Why?", "So.", "a table", [Bound("height", value, 2.0, "mm")])


def program(monkeypatch, *arguments):
    """The exit status, and what the function was called with."""
    CALLS.clear()
    monkeypatch.setattr("sys.argv", ["experiment", *map(str, arguments)])
    with pytest.raises(SystemExit) as raised:
        report.main(experiment)
    return raised.value.code, CALLS[0] if CALLS else None


@pytest.mark.parametrize(("value", "code"), [(1.0, 0), (5.0, 1)])
def test_the_exit_status_says_whether_the_bounds_hold(monkeypatch, tmp_path, capsys, value, code):
    assert program(monkeypatch, "--output", tmp_path, "--value", value)[0] == code
    printed = capsys.readouterr().out
    assert ("BROKEN" in printed) is bool(code)
    assert (tmp_path / "test_program" / "metrics.json").is_file()
    assert printed.endswith(f"written: {tmp_path}/test_program/metrics.json\npage: {tmp_path}/index.html\n\n")
    assert ("✗ BROKEN" in (tmp_path / "index.html").read_text()) is bool(code)


def test_results_say_what_made_them(monkeypatch, tmp_path):
    """The command as it was typed, every option, the versions, and when."""
    before = datetime.now(UTC).replace(microsecond=0)
    program(monkeypatch, "--output", tmp_path, "--robot", "a b", "--other-folder", "x")
    made = json.loads((tmp_path / "test_program" / "metrics.json").read_text())["provenance"]
    assert made["command"] == f"python experiment --output {tmp_path} --robot 'a b' --other-folder x"
    assert made["options"] == {"value": 1.0, "seed": 0, "robot": "a b", "other_folder": "x"}
    assert made["versions"]["python"] == platform.python_version()
    assert made["versions"]["numpy"] == np.__version__
    assert made["versions"]["diffdrive_mj"] == "0.1.0"
    assert before <= datetime.fromisoformat(made["date"]) <= datetime.now(UTC)


def test_options_have_the_types_of_the_parameters(monkeypatch, tmp_path):
    options = ["--value", "1e-3", "--seed", "7", "--robot", "a b", "--other-folder", "x", f"--output={tmp_path}"]
    assert program(monkeypatch, *options) == (0, (0.001, 7, "a b", Path("x")))
    assert program(monkeypatch, "--output", tmp_path) == (0, (1.0, 0, "mine", Path(".")))


def test_the_help_has_the_question_of_the_file_and_every_option(monkeypatch, capsys):
    assert program(monkeypatch, "--help") == (0, None)
    shown = " ".join(capsys.readouterr().out.split())
    assert "An experiment as a program: options" in shown
    assert "--value FLOAT of the bound, 100 % of it [mm]. (default: 1.0)" in shown
    assert "--other-folder PATH" in shown
    assert "--output PATH" in shown


def test_bad_input_is_one_line_and_writes_nothing(monkeypatch, tmp_path, capsys):
    assert program(monkeypatch, "--output", tmp_path, "--value", -1)[0] == 2
    assert capsys.readouterr().err == "test_program: value = -1: must not be negative\n"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "options", ["--value much", "--value", "--seed 1.5", "--val 1", "--foo", "more", "--robot", "--value=1 2"]
)
def test_options_that_make_no_sense_are_refused_in_one_line(monkeypatch, capsys, options):
    assert program(monkeypatch, *options.split()) == (2, None)
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.startswith("test_program: ")
    assert said.err.endswith("; see test_program.py --help\n")
    assert said.err.count("\n") == 1


def test_a_folder_that_cannot_be_written_is_named_before_the_work(monkeypatch, tmp_path, capsys):
    (tmp_path / "file").write_text("")
    for folder in (tmp_path / "file", tmp_path / "file" / "deeper"):
        assert program(monkeypatch, "--output", folder) == (2, None)
        said = capsys.readouterr().err
        assert f"{folder}/test_program: cannot be written" in said
        assert said.count("\n") == 1


def test_a_file_of_the_users_own_is_named_before_the_work(monkeypatch, tmp_path, capsys):
    (tmp_path / "test_program").mkdir()
    (tmp_path / "test_program" / "metrics.json").write_text("my own")
    assert program(monkeypatch, "--output", tmp_path) == (2, None)
    assert "metrics.json: was not written by an experiment" in capsys.readouterr().err


def test_a_page_of_the_users_own_is_named_before_the_work(monkeypatch, tmp_path, capsys):
    (tmp_path / "index.html").write_text("my own")
    assert program(monkeypatch, "--output", tmp_path) == (2, None)
    assert "index.html: is not a page of results: move it" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["index.html"]


@pytest.mark.skipif(os.geteuid() == 0, reason="the administrator may write anywhere")
def test_a_folder_that_is_read_only_is_named_before_the_work(monkeypatch, tmp_path, capsys):
    tmp_path.chmod(0o500)
    assert program(monkeypatch, "--output", tmp_path) == (2, None)
    assert "read-only" in capsys.readouterr().err


def annotated(value: "float" = 1.0) -> "Report":
    """Ask with types that are written as words.

    Args:
        value: of the bound.
    """
    return Report("Why?", "So.", "a table", [Bound("height", value, 2.0, "mm")])


def test_types_may_be_written_as_words_and_what_is_written_is_said(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr("sys.argv", ["experiment", "--value", "1.5", "--output", str(tmp_path)])
    with pytest.raises(SystemExit) as ended:
        report.main(annotated)
    assert ended.value.code == 0
    assert f"written: {tmp_path / 'test_program'}/metrics.json\n" in capsys.readouterr().out


def test_a_folder_that_may_not_be_written_or_entered_is_named(monkeypatch, tmp_path, capsys):
    """Whoever the tests run as."""
    for allowed in (os.W_OK, os.X_OK, 0):
        monkeypatch.setattr(os, "access", lambda path, mode, granted=allowed: mode & ~granted == 0)
        assert program(monkeypatch, "--output", tmp_path) == (2, None)
        assert f"cannot be written ({tmp_path} is read-only)" in capsys.readouterr().err


def test_annotations_that_are_words_become_types():
    """As `from __future__ import annotations` makes them."""
    code = "from __future__ import annotations\ndef run(robot: str = 'mine', count: int = 3) -> object: ..."
    exec(code, names := {"__name__": __name__})
    made = _program(names["run"], "mine")
    kinds = {name: each.annotation for name, each in inspect.signature(made).parameters.items()}
    assert kinds == {"output": Path, "robot": str, "count": int}


@pytest.mark.parametrize("folder", ["a\0b", "long" * 100])
def test_a_folder_that_cannot_be_is_refused_before_the_work(monkeypatch, capsys, folder):
    code, called = program(monkeypatch, "--output", folder)
    assert (code, called) == (2, None)
    assert capsys.readouterr().err.startswith("test_program: output = ")
    with pytest.raises(InvalidValue, match="folder = "):
        Report("Why?", "So.", "a table", []).write(folder)
