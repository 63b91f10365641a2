"""Reports: bounds that can break, results whole or not at all, exit states without a traceback."""

import json
import math

import numpy as np
import pytest

from diffdrive_mj import report
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.report import Bound, Report, plots


def made(value=1.0, **fields):
    return Report("Why?", "So.", "a table", [Bound("height", value, 2.0, "mm")], **fields)


@pytest.mark.parametrize(
    ("value", "limit", "at_least", "holds"),
    [(1, 2, False, True), (2, 2, False, True), (3, 2, False, False), (3, 2, True, True), (1, 2, True, False)],
)
def test_a_bound_holds_up_to_its_limit(value, limit, at_least, holds):
    bound = Bound("height", value, limit, "mm", at_least)
    assert bound.holds is holds
    assert ("ok" if holds else "BROKEN") in str(bound)
    assert "mm" in str(bound)


@pytest.mark.parametrize("at_least", [False, True])
def test_what_is_not_a_number_breaks_every_bound(at_least):
    assert not Bound("height", math.nan, 1.0, at_least=at_least).holds


def test_a_report_is_written_whole(tmp_path):
    figure, _ = plots.figure("A finding")
    metrics = {"list": np.arange(3), "infinite": math.inf, "nested": {"x": np.float64(0.5)}}
    made(metrics=metrics, pictures={"one": figure}).write(tmp_path / "results" / "it")
    written = tmp_path / "results" / "it"
    assert sorted(path.name for path in written.iterdir()) == ["metrics.json", "one.png"]
    content = json.loads((written / "metrics.json").read_text())
    assert content["list"] == [0, 1, 2]
    assert content["infinite"] is None
    assert content["bounds"][0]["holds"] is True
    assert [path.name for path in (tmp_path / "results").iterdir()] == ["it"]


class Unwritable:
    def savefig(self, *args, **kwargs):
        raise OSError(28, "No space left on device")


def test_a_failed_write_leaves_the_earlier_results_alone(tmp_path):
    folder = tmp_path / "it"
    made(metrics={"run": 1}).write(folder)
    with pytest.raises(OSError, match="No space"):
        made(metrics={"run": 2}, pictures={"one": Unwritable()}).write(folder)
    assert json.loads((folder / "metrics.json").read_text())["run"] == 1
    assert [path.name for path in tmp_path.iterdir()] == ["it"]


def test_a_table_lines_up():
    text = report.table(["name", "x [m]"], [["first", 1.23456], ["second one", 12]])
    assert text.splitlines() == ["name        x [m]", "-----------------", "first       1.235", "second one     12"]


def program(monkeypatch, run, *arguments):
    monkeypatch.setattr("sys.argv", ["experiment", *map(str, arguments)])
    with pytest.raises(SystemExit) as raised:
        report.main(run)
    return raised.value.code


def experiment(value: float = 1.0) -> Report:
    """Ask a question."""
    if value < 0:
        raise InvalidValue(f"value = {value:g}: must not be negative")
    return made(value)


@pytest.mark.parametrize(("value", "code"), [(1.0, 0), (5.0, 1)])
def test_the_exit_status_tells_whether_the_bounds_hold(monkeypatch, tmp_path, capsys, value, code):
    assert program(monkeypatch, experiment, "--output", tmp_path, "--value", value) == code
    printed = capsys.readouterr().out
    assert ("BROKEN" in printed) is bool(code)
    assert (tmp_path / "test_report" / "metrics.json").is_file()


def test_bad_input_is_one_line_and_writes_nothing(monkeypatch, tmp_path, capsys):
    assert program(monkeypatch, experiment, "--output", tmp_path, "--value", -1) == 2
    streams = capsys.readouterr()
    assert streams.err == "test_report: value = -1: must not be negative\n"
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_cannot_be_written_is_named(monkeypatch, tmp_path, capsys):
    (tmp_path / "file").write_text("")
    assert program(monkeypatch, experiment, "--output", tmp_path / "file") == 2
    assert "cannot be written" in capsys.readouterr().err


def test_options_that_make_no_sense_are_refused(monkeypatch, capsys):
    assert program(monkeypatch, experiment, "--value", "much") == 2
    assert "Traceback" not in capsys.readouterr().err
