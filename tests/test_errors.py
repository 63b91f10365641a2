"""How a program ends: one line on stderr and a status that says why."""

import subprocess
import sys
from pathlib import Path

import pytest

from diffdrive_mj.errors import InvalidValue, exit_on_error


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
