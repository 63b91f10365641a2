"""How `diffdrive` begins and ends: the arguments of the command line, and an interruption at any time."""

import sys

import pytest

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
