"""`diffdrive suite` writes what runners read, says where, and refuses in one line."""

import re
import sys

import pytest
from helpers import ROOT

import diffdrive_mj as dd
from diffdrive_mj import cli
from diffdrive_mj.judging import suite

# A program over the pipe around the odometry of the example's runner.
PIPE = """
import sys
sys.path.insert(0, {folder!r})
from suite import Odometry
for line in sys.stdin:
    if line.startswith("#"):
        header = dict(pair.split("=") for pair in line.split()[3:])
        odometry = Odometry({{name: value if name == "unit" else float(value) for name, value in header.items()}})
    else:
        t, left, right = map(float, line.split(","))
        print(*odometry.update((left, right), t), sep=",")
"""


def test_the_suite_is_written_and_its_place_is_said(capsys, tmp_path):
    cli.main(["suite", str(tmp_path / "my cases")])
    said = capsys.readouterr().out
    assert said == (
        f"written: {len(suite.cases())} drives as CSV files into '{tmp_path}/my cases'; README.md there has the rules\n"
    )
    assert len(list((tmp_path / "my cases").glob("*.csv"))) == len(suite.cases())
    cli.main(["suite", str(tmp_path / "my cases")])  # again


def test_the_page_has_the_rules_and_an_example_that_is_true(tmp_path):
    suite.write(tmp_path)
    page = (tmp_path / "README.md").read_text()
    header = (tmp_path / "wrap_16_fast.csv").read_text().splitlines()[0]
    for pair in header.split(" ")[3:]:
        assert re.search(rf"^\| (\w+, )*{pair.partition('=')[0]}(, \w+)* \|", page, re.MULTILINE), pair
    for words in ("t is later", "modulo 2^n", "hypot(", "holds the pose"):
        assert words in page


def test_what_is_in_the_way_is_refused_in_one_line(capsys, tmp_path):
    (tmp_path / "nan.csv").write_text("mine")
    with pytest.raises(SystemExit) as ended:
        cli.main(["suite", str(tmp_path)])
    out, err = capsys.readouterr()
    assert (ended.value.code, out, err.count("\n")) == (2, "", 1)
    assert "nan.csv: was not written by diffdrive suite: move it, or choose another folder" in err
    assert [path.name for path in tmp_path.iterdir()] == ["nan.csv"]


def test_a_variable_that_is_empty_does_not_fill_the_folder_one_is_in(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as ended:
        cli.main(["suite", ""])
    assert (ended.value.code, *capsys.readouterr()) == (
        2, "", "diffdrive: folder = '': must name a file or a folder\n",
    )  # fmt: skip
    assert not list(tmp_path.iterdir())


def test_a_program_over_the_pipe_takes_the_whole_suite():
    program = [sys.executable, "-c", PIPE.format(folder=str(ROOT / "examples"))]
    few = [
        case for case in suite.cases() if case.name in ("winding", "nan", "zero_dt", "wrap_32_forwards", "ten_hours")
    ]
    verdict = dd.judge(program, few)
    assert verdict.holds, verdict
