"""Reports: bounds that can break, and results that are written whole or not at all."""

import json
import math
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from threading import Barrier

import matplotlib.image
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


class Drawn:
    def savefig(self, file, **options):
        file.write(b"a picture")


class Unwritable:
    def savefig(self, *args, **kwargs):
        raise OSError(28, "No space left on device")


def test_a_failed_write_leaves_the_earlier_results_alone(tmp_path):
    folder = tmp_path / "it"
    made(metrics={"run": 1}).write(folder)
    with pytest.raises(InvalidValue, match="it: cannot be written \\(No space left on device\\)"):
        made(metrics={"run": 2}, pictures={"one": Unwritable()}).write(folder)
    assert json.loads((folder / "metrics.json").read_text())["run"] == 1
    assert [path.name for path in tmp_path.iterdir()] == ["it"]


def test_what_an_earlier_run_left_is_replaced_and_nothing_else(tmp_path):
    """A user's own file stays, and so does a picture that no run has listed."""
    folder = tmp_path / "it"
    made(pictures={"one": Drawn(), "two": Drawn()}).write(folder)
    for name in ("thesis.txt", "mine.png"):
        (folder / name).write_text("years of work")
    made(metrics={"run": 2}, pictures={"one": Drawn()}).write(folder)
    assert sorted(path.name for path in folder.iterdir()) == ["metrics.json", "mine.png", "one.png", "thesis.txt"]
    assert json.loads((folder / "metrics.json").read_text())["run"] == 2


LIST = {"question": "Why?", "finding": "So.", "bounds": [], "pictures": []}


@pytest.mark.parametrize("pictures", [3, [3, None], ["../a.png"], ["sub/a.png"], ["thesis.txt"]])
def test_whatever_is_listed_nothing_but_pictures_of_the_folder_is_removed(pictures, tmp_path):
    folder = tmp_path / "it"
    (folder / "sub").mkdir(parents=True)
    others = [tmp_path / "a.png", folder / "sub" / "a.png", folder / "thesis.txt"]
    for path in others:
        path.write_text("years of work")
    (folder / "metrics.json").write_text(json.dumps(LIST | {"pictures": pictures}))
    with suppress(InvalidValue):
        made().write(folder)
    assert all(path.read_text() == "years of work" for path in others)


@pytest.mark.parametrize("left", ["no JSON", "[]", "{}", '{"pictures": []}', "[" * 100_000, "\xff"])
@pytest.mark.parametrize("name", ["metrics.json", "one.png"])
def test_a_file_that_no_run_has_written_is_never_replaced(left, name, tmp_path):
    (tmp_path / name).write_bytes(left.encode("latin-1"))
    with pytest.raises(InvalidValue, match=f"{name}: was not written by an experiment"):
        made(pictures={"one": Drawn()}).write(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == [name]
    assert (tmp_path / name).read_bytes() == left.encode("latin-1")


def test_links_are_followed_and_permissions_kept(tmp_path):
    folder, elsewhere = tmp_path / "it", tmp_path / "elsewhere"
    made(metrics={"run": 1}).write(elsewhere)
    (tmp_path / "it").symlink_to(elsewhere)
    (elsewhere / "metrics.json").rename(tmp_path / "kept.json")
    (tmp_path / "kept.json").chmod(0o600)
    (elsewhere / "metrics.json").symlink_to(tmp_path / "kept.json")
    made(metrics={"run": 2}).write(folder)
    assert folder.is_symlink()
    assert (elsewhere / "metrics.json").is_symlink()
    assert json.loads((tmp_path / "kept.json").read_text())["run"] == 2
    assert (tmp_path / "kept.json").stat().st_mode & 0o777 == 0o600


def test_a_file_in_the_place_of_the_folder_stays(tmp_path):
    (tmp_path / "it").write_text("years of work")
    with pytest.raises(InvalidValue, match="it: cannot be written"):
        made().write(tmp_path / "it")
    assert (tmp_path / "it").read_text() == "years of work"


def test_two_runs_at_once_leave_whole_results(tmp_path):
    """Into a folder that is not there yet."""
    seen, begin, drawn = [], Barrier(3), Drawn()

    def write(folder, run):
        begin.wait()
        metrics = {"run": run, "long": list(range(2000))}
        made(metrics=metrics, pictures={"one": drawn, "two": drawn}).write(folder)

    def read(folder):
        begin.wait()
        for _ in range(100):
            with suppress(FileNotFoundError):
                seen.append(json.loads((folder / "metrics.json").read_text())["run"])

    with ThreadPoolExecutor(3) as pool:
        for k in range(8):
            folder = tmp_path / str(k)
            for job in [pool.submit(write, folder, 1), pool.submit(write, folder, 2), pool.submit(read, folder)]:
                job.result()
            assert sorted(path.name for path in folder.iterdir()) == ["metrics.json", "one.png", "two.png"]
    assert set(seen) <= {1, 2}


def test_the_question_is_the_first_paragraph_of_a_docstring():
    asked = Report("Where\n    does it go?\n\n    Details.", "So.", "a table", [])
    assert asked.question == "Where does it go?"
    assert str(asked).startswith("Where does it go?\n\na table")


def test_a_table_lines_up():
    text = report.table(["name", "x [m]"], [["first", 1.23456], ["second one", 12]])
    assert text.splitlines() == ["name        x [m]", "-----------------", "first       1.235", "second one     12"]


@pytest.mark.parametrize("at_least", [True, False])
def test_a_bound_holds_at_its_limit(at_least):
    assert Bound("x", 2.0, 2.0, at_least=at_least).holds


def test_metrics_are_for_people_and_programs(tmp_path):
    Report("Why?", "So.", "", [], metrics={"a": 1.5}).write(tmp_path / "mine")
    lines = (tmp_path / "mine" / "metrics.json").read_text().splitlines()
    assert lines[1] == ' "question": "Why?",'
    assert ' "a": 1.5,' in lines


@pytest.mark.parametrize("name", ["question", "table", "provenance", "replays"])
def test_metrics_do_not_take_the_names_of_the_report(name):
    with pytest.raises(InvalidValue, match=f"Report.metrics: '{name}' is what the report itself writes"):
        made(metrics={name: 1})


def test_what_is_not_recorded_is_left_empty(tmp_path):
    made().write(tmp_path)
    content = json.loads((tmp_path / "metrics.json").read_text())
    assert (content["provenance"]["command"], content["provenance"]["options"], content["table"]) == ("", {}, "a table")
    made().write(tmp_path, command="make mine")
    assert json.loads((tmp_path / "metrics.json").read_text())["provenance"]["command"] == "make mine"


def test_pictures_have_a_hundred_and_fifty_dots_an_inch(tmp_path):
    made, _ = plots.figure("A finding", size=(4.0, 3.0))
    Report("Why?", "So.", "", [], pictures={"one": made}).write(tmp_path)
    assert matplotlib.image.imread(tmp_path / "one.png").shape[:2] == (450, 600)
