"""How a program ends: one line on stderr and a status that says why."""

import subprocess
import sys
from pathlib import Path

import pytest

from diffdrive_mj.errors import InvalidValue, RobotFell, exit_on_error


def ended(capsys, error):
    """The status and the one line of a program that meets an error."""
    with pytest.raises(SystemExit) as info, exit_on_error("prog"):
        raise error
    out, err = capsys.readouterr()
    assert not out
    assert err.startswith("prog: ")
    assert err.endswith("\n")
    assert err.count("\n") == 1
    return info.value.code, err[6:-1]


@pytest.mark.parametrize(
    ("error", "status", "line"),
    [
        (InvalidValue("x = 0: must be positive"), 2, "x = 0: must be positive"),
        (InvalidValue("log\x1b[31m\nname.csv: empty"), 2, "log\\x1b[31m\\nname.csv: empty"),
        (InvalidValue("l\u00f6g\udcff.csv: empty"), 2, "l\u00f6g\\udcff.csv: empty"),
        (RobotFell("robot 0 lies on its chassis"), 2, "robot 0 lies on its chassis"),
        (KeyboardInterrupt(), 130, "interrupted"),
        (MemoryError(), 2, "not enough memory"),
        (OSError(28, "No space left on device"), 2, "[Errno 28] No space left on device"),
    ],
)
def test_a_program_ends_in_one_line(capsys, error, status, line):
    assert ended(capsys, error) == (status, line)


def test_a_mistake_of_ours_is_not_hidden():
    with pytest.raises(ZeroDivisionError), exit_on_error("prog"):
        raise ZeroDivisionError


def unread():
    """A program that is told that nobody reads what it prints."""
    with exit_on_error("prog"):
        print("what nobody reads")
        raise BrokenPipeError


def test_a_program_whose_output_is_not_read_ends_silently_with_its_own_status(monkeypatch, tmp_path):
    with (tmp_path / "out").open("w") as file:
        monkeypatch.setattr(sys, "stdout", file)
        with pytest.raises(SystemExit) as info:
            unread()
        assert info.value.code == 141
        file.write("what is left")  # goes nowhere
    assert (tmp_path / "out").read_text() == "what nobody reads\n"


def test_what_cannot_be_written_shows_before_the_program_has_ended(monkeypatch, capsys):
    with Path("/dev/full").open("w") as full:
        monkeypatch.setattr(sys, "stdout", full)
        with pytest.raises(SystemExit) as info, exit_on_error("prog"):
            print("a line")
        assert info.value.code == 2
    assert capsys.readouterr().err == "prog: [Errno 28] No space left on device\n"


@pytest.mark.parametrize("stream", ["stdout", "stderr"])
def test_what_is_written_to_a_closed_stream_goes_nowhere(monkeypatch, stream):
    monkeypatch.setattr(sys, stream, None)
    with exit_on_error("prog"):
        print("a line", file=getattr(sys, stream))


def test_what_a_terminal_cannot_show_is_shown_by_its_number(monkeypatch, tmp_path):
    with (tmp_path / "out").open("w", encoding="ascii") as file:
        monkeypatch.setattr(sys, "stdout", file)
        with exit_on_error("prog"):
            print("\u03c0")
    assert (tmp_path / "out").read_text() == "\\u03c0\n"


PROGRAM = """
from diffdrive_mj.errors import exit_on_error
with exit_on_error("prog"):
    for _ in range(100_000):
        print("a line, \\u03c0")
"""


def test_output_that_nobody_reads_ends_silently():
    shell = f"{sys.executable} -c '{PROGRAM}' | head -n 1; echo ${{PIPESTATUS[0]}}"
    done = subprocess.run(["bash", "-c", shell], capture_output=True, text=True, check=False)
    assert done.stdout.splitlines()[-1] == "141"
    assert done.stderr == ""


@pytest.mark.parametrize("lines", ["100_000", "1"])
def test_a_full_disk_is_said_in_one_line(lines):
    command = [sys.executable, "-c", PROGRAM.replace("100_000", lines)]
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr == "prog: [Errno 28] No space left on device\n"


def test_a_terminal_without_greek_shows_its_number():
    short = PROGRAM.replace("100_000", "1")
    done = subprocess.run(
        [sys.executable, "-c", short], env={"PYTHONIOENCODING": "ascii"}, capture_output=True, text=True, check=False
    )
    assert done.stdout == "a line, \\u03c0\n"
