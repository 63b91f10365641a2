"""The program's commands: a file each, found and listed without being loaded."""

import contextlib
import subprocess
import sys
from pathlib import Path

import pytest
from helpers import ROOT

import diffdrive_mj as dd
from diffdrive_mj import cli

FILES = (ROOT / "diffdrive_mj" / "cli").glob("*.py")
COMMANDS = sorted({path.stem for path in FILES if path.stem[0] != "_"} - {"program"})


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
        *(
            ([name, "--help"], {"scipy", "mujoco", "matplotlib", "mpmath"})
            for name in ("calibrate", "evaluate", "judge", "robots", "simulate", "suite", "sweep")
        ),
    ],
)
def test_only_what_a_command_needs_is_loaded(arguments, heavy):
    code = (
        "import atexit, sys; atexit.register(lambda: print('\\n', *sys.modules)); from diffdrive_mj.cli import main; "
        f"main({arguments})"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = set(done.stdout.splitlines()[-1].split())
    assert "diffdrive_mj.cli.program" in loaded
    assert not heavy & loaded


@pytest.mark.parametrize("command", [["-m", "diffdrive_mj"], ["-c", "from diffdrive_mj.cli import main; main()"]])
def test_it_runs_as_a_program(command):
    done = subprocess.run([sys.executable, "-W", "error", *command, "explain", "nothing"],
                          capture_output=True, text=True, check=False)  # fmt: skip
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("diffdrive: unknown preset 'nothing'")


ENDS = {
    "calibrate": "calibrate {log} --robot matched --export ros2 --output new.toml",
    "calibrate --help": "calibrate --help",
    "explain": "explain ct_bot",
    "robots": "robots list",
    "experiment": "experiment",
    "experiment --help": "experiment integrators --help",
    "--help": "--help",
    "--version": "--version",
}


def ended(arguments, redirection, folder):
    """Exit status, stdout and stderr of the program in a shell that redirects its output."""
    rows = "".join(f"{k / 10},{k},{k},{k / 10},0,0\n" for k in range(20))
    (folder / "log.csv").write_text(f"t,left,right,x,y,theta\n{rows}")
    program = f"{sys.executable} -m diffdrive_mj {arguments.format(log='log.csv')} {redirection}"
    done = subprocess.run(["bash", "-c", program], cwd=folder, capture_output=True, text=True, check=False)
    return done.returncode, done.stdout, done.stderr


@pytest.mark.parametrize("arguments", ENDS.values(), ids=ENDS)
def test_an_output_that_cannot_be_written_ends_in_one_line_or_silently(arguments, tmp_path):
    status, _, said = ended(arguments, "> /dev/full", tmp_path)
    assert status == 2
    assert said.endswith(": [Errno 28] No space left on device\n")
    assert said.count("\n") == 1
    assert ended(arguments, "| true; exit ${PIPESTATUS[0]}", tmp_path) == (141, "", "")
    assert ended(arguments, ">&-", tmp_path) == (0, "", "")


def test_a_closed_stderr_does_not_send_the_message_elsewhere(tmp_path):
    assert ended("explain nothing", "2>&-", tmp_path) == (2, "", "")


def test_an_interrupted_program_ends_in_one_line(tmp_path):
    """A helper interrupts the program, once while it loads what handles errors and once while it works."""
    for place in ("diffdrive_mj._text", "numpy"):
        code = f"""
import signal, sys
class Interrupting:
    def find_spec(self, name, path=None, target=None):
        if name == {place!r}:
            sys.meta_path.remove(self)
            signal.raise_signal(signal.SIGINT)
sys.meta_path.insert(0, Interrupting())
from diffdrive_mj.cli import main
main(["explain", "ct_bot"])
"""
        done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False)
        assert (done.returncode, done.stdout, done.stderr) == (130, "", "diffdrive: interrupted\n")


def test_names_reach_a_terminal_without_their_control_characters(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    name = "a\x1b[31mb\rc"
    dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4, name=name).save("r.toml")
    rows = "".join(f"{k / 10},{k},{k},{k / 10 + (k > 10)},0,0\n" for k in range(40))
    Path(f"{name}.csv").write_text(f"t,left,right,x,y,theta\n{rows}")
    for arguments in (["explain", "r.toml"], ["robots", "show", "r.toml"],
                      ["calibrate", f"{name}.csv", "--robot", "r.toml", "--anyway", "--export", "toml"]):  # fmt: skip
        cli.main(arguments)
        printed = capsys.readouterr().out
        assert all(line.isprintable() for line in printed.split("\n"))
        assert "\\x1b[31mb\\rc" in printed or "\\u001b[31mb\\rc" in printed
