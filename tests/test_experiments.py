"""Every experiment runs, keeps its bounds, and hands in pictures: the same scripts that people run."""

import os
import subprocess
import sys

import pytest
from experiment_runs import broken
from figure_checks import check_layout
from helpers import ROOT, experiment

SCRIPTS = sorted((ROOT / "experiments").glob("*.py"))


# Fewer runs than by default, of which the bounds know; the defaults are left to `make test-all`.
FEWER = {
    "calibration": {"robots": 3},
    "drift_percentiles": {"trials": 60},
    "error_budget": {"rows": 64, "share": 0.9},
    "physics_floor": {"random": 4},
}


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.stem)
def test_the_experiment_keeps_its_bounds(script, tmp_path):
    report = experiment(script.stem).run(**FEWER.get(script.stem, {}))
    assert report.bounds
    assert broken(report) == []
    for picture in report.pictures.values():
        check_layout(picture)
    report.write(tmp_path / script.stem)
    assert (tmp_path / script.stem / "metrics.json").is_file()
    assert list((tmp_path / script.stem).glob("*.png"))


@pytest.mark.slow
@pytest.mark.parametrize("name", FEWER)
def test_the_experiment_keeps_its_bounds_with_as_many_runs_as_by_default(name):
    report = experiment(name).run()
    assert report.bounds
    assert broken(report) == []


def test_an_experiment_runs_as_a_program_from_anywhere(tmp_path):
    script = ROOT / "experiments" / "mismatched_radii.py"
    environment = {**os.environ, "PYTHONWARNINGS": "error"}
    done = subprocess.run(
        [sys.executable, script, "--distance", "5"],
        cwd=tmp_path, env=environment, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert sorted(p.name for p in (tmp_path / "results" / "mismatched_radii").iterdir()) == [
        "metrics.json",
        "mismatched_radii.png",
        "replays.json",
    ]
    assert sorted(p.name for p in (tmp_path / "results").iterdir()) == ["index.html", "mismatched_radii"]
    assert done.stdout.endswith(
        "written: results/mismatched_radii/*.png and metrics.json\npage: results/index.html\n\n"
    )
    assert "diffdrive experiment mismatched_radii --distance 5" in (tmp_path / "results" / "index.html").read_text()
    assert sorted(os.listdir(tmp_path)) == ["results"]


def test_a_bad_option_ends_in_a_message(tmp_path):
    script = ROOT / "experiments" / "mismatched_radii.py"
    command = [sys.executable, script, "--side=nan"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr == "mismatched_radii: side = nan: must be finite\n"
    assert os.listdir(tmp_path) == []
