"""The program's commands: a file each, found and listed without being loaded."""

import contextlib
import subprocess
import sys

import pytest
from helpers import ROOT

import diffdrive_mj as dd
from diffdrive_mj import cli

COMMANDS = sorted({path.stem for path in (ROOT / "diffdrive_mj" / "cli").glob("*.py")} - {"__init__", "program"})


def refused(capsys, *arguments):
    with pytest.raises(SystemExit) as raised:
        cli.main(list(arguments))
    assert raised.value.code == 2
    streams = capsys.readouterr()
    assert streams.out == ""
    assert streams.err.count("\n") == 1
    return streams.err


@pytest.mark.parametrize("option", ["-h", "--help"])
def test_the_help_has_a_line_for_each_command(option, capsys):
    cli.main([option])
    printed = capsys.readouterr().out
    listed = dict(line.split(maxsplit=1) for line in printed.split("commands:\n")[1].split("\n\n")[0].splitlines())
    assert sorted(listed) == COMMANDS
    assert all(what.endswith(".") and len(what) > 20 for what in listed.values())


def test_the_example_of_the_help_runs(capsys):
    cli.main(["--help"])
    (example,) = [line.split() for line in capsys.readouterr().out.splitlines() if line.startswith("  diffdrive ")]
    cli.main(example[1:])
    assert "worst" in capsys.readouterr().out


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_help_of_its_own(command, capsys):
    with contextlib.suppress(SystemExit):
        cli.main([command, "--help"])
    assert f"usage: diffdrive {command}" in capsys.readouterr().out


def test_the_version(capsys):
    cli.main(["--version"])
    assert capsys.readouterr().out == f"diffdrive {dd.__version__}\n"


def test_what_is_not_a_command(capsys):
    assert "a command is missing: choose from calibrate, " in refused(capsys)
    assert "did you mean 'calibrate'?" in refused(capsys, "calibrat")
    assert "unknown command 'program'" in refused(capsys, "program")
    assert "unknown command '../robots'" in refused(capsys, "../robots")
    assert "unknown command '--robot'" in refused(capsys, "--robot")


@pytest.mark.parametrize(
    ("arguments", "heavy"),
    [
        (["--help"], {"numpy", "tyro", "scipy", "mujoco", "matplotlib"}),
        (["experiment"], {"numpy", "tyro", "scipy", "mujoco", "matplotlib"}),
        (["explain", "matched"], {"scipy", "mujoco", "matplotlib"}),
    ],
)
def test_only_what_a_command_needs_is_loaded(arguments, heavy):
    code = f"import sys; from diffdrive_mj.cli import main; main({arguments}); print(); print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not heavy & set(done.stdout.splitlines()[-1].split())


@pytest.mark.parametrize("command", [["-m", "diffdrive_mj"], ["-c", "from diffdrive_mj.cli import main; main()"]])
def test_it_runs_as_a_program(command):
    done = subprocess.run([sys.executable, "-W", "error", *command, "explain", "nothing"],
                          capture_output=True, text=True, check=False)  # fmt: skip
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("diffdrive: unknown preset 'nothing'")
