"""How `diffdrive` begins and ends: the arguments of the command line, and an interruption at any time."""

import runpy
import sys
from pathlib import Path

import pytest

import diffdrive_mj as dd
from diffdrive_mj.cli import program


def test_without_arguments_those_of_the_command_line_are_taken(monkeypatch):
    given = []
    monkeypatch.setattr(program, "_main", given.append)
    monkeypatch.setattr(sys, "argv", ["diffdrive", "robots", "list"])
    program.main()
    program.main(("robots", "show"))
    program.main([])
    assert given == [["robots", "list"], ["robots", "show"], []]


def test_an_interruption_before_anything_is_loaded_is_one_line_too(monkeypatch, capsys):
    def interrupted(given):
        raise KeyboardInterrupt

    monkeypatch.setattr(program, "_main", interrupted)
    with pytest.raises(SystemExit) as ended:
        program.main(["explain"])
    assert ended.value.code == 130
    assert capsys.readouterr().err == "diffdrive: interrupted\n"


@pytest.mark.parametrize(("name", "runs"), [("__main__", True), ("diffdrive_mj.__main__", False)])
def test_the_package_runs_as_a_program_and_not_when_it_is_imported(monkeypatch, capsys, name, runs):
    monkeypatch.setattr(sys, "argv", ["diffdrive", "--version"])
    runpy.run_path(str(Path(dd.__file__).with_name("__main__.py")), run_name=name)
    assert capsys.readouterr().out.startswith("diffdrive ") is runs
