"""`diffdrive experiment` lists the experiments and runs one with its own options."""

import sys

import pytest

from diffdrive_mj import cli
from diffdrive_mj.cli import experiment

SCRIPT = '''"""Does the robot
drift?

A longer text.
"""
import sys
from dataclasses import dataclass


@dataclass
class Answer:
    status: int


if __name__ == "__main__":
    print(__name__, sys.argv[1:])
    sys.exit(Answer(int(sys.argv[-1])).status)
'''


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Two experiments in place of the package's."""
    (tmp_path / "drift.py").write_text(SCRIPT)
    (tmp_path / "slip.py").write_text('"""Does it slip?"""')
    (tmp_path / "README.md").write_text("no experiment")
    monkeypatch.setattr(experiment, "EXPERIMENTS", tmp_path)
    return tmp_path


@pytest.mark.parametrize("arguments", [[], ["--help"], ["-h"]])
def test_they_are_listed_with_their_questions(folder, arguments, capsys):
    cli.main(["experiment", *arguments])
    assert "\n  drift  Does the robot drift?\n  slip   Does it slip?\n\n" in capsys.readouterr().out


@pytest.mark.parametrize("status", [0, 1, 2])
def test_options_and_exit_status_are_the_experiments_own(folder, status, capsys):
    before = list(sys.argv)
    with pytest.raises(SystemExit) as raised:
        cli.main(["experiment", "drift", "--help", "--foo", str(status)])
    assert raised.value.code == status
    assert capsys.readouterr().out == f"__main__ ['--help', '--foo', '{status}']\n"
    assert sys.argv == before


@pytest.mark.parametrize("name", ["drif", "../drift", "drift.py", "README"])
def test_another_name_is_one_line(folder, name, capsys):
    with pytest.raises(SystemExit) as raised:
        cli.main(["experiment", name])
    assert raised.value.code == 2
    error = capsys.readouterr().err
    assert error.startswith(f"diffdrive: unknown experiment '{name}': choose from drift, slip")
    assert error.count("\n") == 1
