"""A function's parameters as options, and what is said of wrong ones."""

import os
import pty
import subprocess
import sys

import pytest

from diffdrive_mj._options import parsed
from diffdrive_mj.errors import InvalidValue


def brew(beans: int, /, *, strong: bool = False, cups: float = 1.0) -> str:
    """Brew coffee.

    Args:
        beans: how many; a text that is long enough to be wrapped, since the help of an option does not belong in a line
            that says what is wrong with it.
        strong: whether.
        cups: how many.
    """
    print("brewing", file=sys.stderr)
    return f"{beans} {strong} {cups}"


def test_options_become_parameters(capsys):
    prepared = parsed(brew, "coffee", ["12", "--strong", "--cups", "2"])
    assert capsys.readouterr().err == ""  # not called yet
    assert prepared() == "12 True 2.0"
    assert capsys.readouterr().err == "brewing\n"


def test_the_programs_own_arguments_are_the_default(monkeypatch):
    monkeypatch.setattr(sys, "argv", ["coffee", "3"])
    assert parsed(brew, "coffee")() == "3 False 1.0"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "Missing from coffee: INT"),
        (["--beans", "1"], "Missing: BEANS, which is given by its place, without --beans"),
        (["1", "--milk"], "Unrecognized options: --milk"),
        (["1", "--cups"], "Missing value for argument '--cups'. Expected 1 values"),
        (["1", "--cups", "two"], "could not convert string to float: 'two'"),
    ],
)
def test_wrong_options_are_refused_in_one_line(arguments, message, monkeypatch):
    for columns in ("40", "200"):
        monkeypatch.setenv("COLUMNS", columns)
        with pytest.raises(InvalidValue) as info:
            parsed(brew, "coffee", arguments)
        assert str(info.value) == f"{message}; see coffee --help"


def test_the_colours_that_a_terminal_gets_do_not_show():
    terminal, end = pty.openpty()
    program = "from diffdrive_mj.cli import main; main(['explain'])"
    environment = {**os.environ, "TERM": "xterm-256color"}
    done = subprocess.run([sys.executable, "-c", program], stdout=end, stderr=subprocess.PIPE, env=environment,
                          text=True, check=False)  # fmt: skip
    os.close(end)
    os.close(terminal)
    assert done.stderr == "diffdrive: Missing from diffdrive explain: ROBOT; see diffdrive explain --help\n"
