"""`diffdrive sweep`: a study's file becomes a table of trials, what is done stays, and bad input is one line."""

import csv
import json
import re
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import diffdrive_mj as dd
from diffdrive_mj import cli

STUDY = """\
trials = 12
truth = "kinematics"
robot = "ct_bot"

[maneuver]
name = "square"
side = 0.5

[vary]
robot.track_width = { distribution = "normal", mean = 0.0972, sigma = 0.0005 }
"""


@pytest.fixture
def study(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(STUDY)
    return path


def printed(capsys, *arguments):
    cli.main(["sweep", *map(str, arguments)])
    return capsys.readouterr().out


def refusal(capsys, *arguments):
    with pytest.raises(SystemExit) as ended:
        cli.main(["sweep", *map(str, arguments)])
    assert ended.value.code == 2
    streams = capsys.readouterr()
    assert streams.out == ""
    assert streams.err.count("\n") == 1
    return streams.err


def test_a_study_becomes_a_table_of_trials(capsys, study, tmp_path):
    out = printed(capsys, study, "--output", tmp_path / "out", "--chunk", 5)
    expected = dd.sweep(dd.sweeps.Study.load(study))
    assert out == f"{expected}\n\nwritten: {tmp_path / 'out' / 'trials.csv'}\n"
    with (tmp_path / "out" / "trials.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [int(row["index"]) for row in rows] == list(range(12))
    for name, values in {**expected.drawn, **expected.figures}.items():
        assert [float(row[name]) for row in rows] == values.tolist()


def test_what_is_done_is_not_done_again(capsys, study, tmp_path, monkeypatch):
    first = printed(capsys, study, "--output", tmp_path / "out")
    monkeypatch.setattr("diffdrive_mj.sweeps._chunk.run", lambda *_: pytest.fail("it was driven again"))
    assert printed(capsys, study, "--output", tmp_path / "out") == first


def test_a_chunk_that_is_not_whole_is_driven_again_and_said_in_a_line(study, tmp_path):
    command = [
        sys.executable,
        "-m",
        "diffdrive_mj",
        "sweep",
        str(study),
        "--output",
        str(tmp_path / "out"),
        "--workers",
        "1",
    ]
    first = subprocess.run(command, capture_output=True, text=True, check=True)
    (chunk,) = tmp_path.glob("out/chunks/*.npz")
    chunk.write_bytes(chunk.read_bytes()[:100])
    again = subprocess.run(command, capture_output=True, text=True, check=True)
    assert again.stdout == first.stdout
    assert again.stderr.startswith(f"diffdrive: {chunk}: is not whole")
    assert again.stderr.count("\n") == 1


def test_as_json_it_can_be_read_by_programs(capsys, study, tmp_path):
    found = json.loads(printed(capsys, study, "--output", tmp_path / "out", "--trials", 6, "--json"))
    assert found["study"] == "mine"
    assert found["outcomes"] == {"ok": 6}
    sizes = np.abs(dd.sweep(dd.sweeps.Study.load(study).replace(trials=6)).figures["final_heading"])
    percents = found["figures"]["final_heading"]
    assert list(percents) == ["50 %", "90 %", "95 %", "99 %"]
    assert percents["99 %"] == pytest.approx(sizes.max())


def test_a_robot_and_its_tolerances_are_a_study(capsys, tmp_path):
    robot = dd.Robot.load("ct_bot").replace(name="mine", tolerances=dd.Tolerances(radius=0, radius_ratio=0.001))
    robot.save(tmp_path / "mine.toml")
    command = ("--robot", tmp_path / "mine.toml", "--maneuver", "spin", "--output", tmp_path / "out", "--trials", 4)
    found = json.loads(printed(capsys, *command, "--json"))
    assert (found["study"], found["outcomes"]) == ("mine", {"ok": 4})
    of = dd.sweeps.Study.of_tolerances(robot, dd.sweeps.Maneuver("spin"), trials=4, name="mine", truth="kinematics")
    kept = dd.sweeps.load(tmp_path / "out")
    assert kept.figures["final_heading"].tolist() == dd.sweep(of, workers=1).figures["final_heading"].tolist()
    assert "the 99th percentile takes 500" in refusal(capsys, *command, "--prices")
    printed(capsys, *command[:-1], 1, "--truth", "physics", "--output", tmp_path / "driven")
    assert dd.sweeps.Study.load(tmp_path / "driven" / "study.toml") == of.replace(trials=1, truth="physics")


def test_prices_follow_the_trials(capsys, study, tmp_path):
    out = printed(capsys, study, "--output", tmp_path / "out", "--trials", 1000, "--prices")
    assert re.search(r"\nHalve the spread of the track width, and the 99th .* falls by 5\d % \(", out)
    found = json.loads(printed(capsys, study, "--output", tmp_path / "out", "--trials", 1000, "--prices", "--json"))
    assert found["budget"]["tolerances"]["robot.track_width"]["fall"][0] == pytest.approx(0.5, abs=0.1)


def test_each_value_of_a_grid_has_a_table_of_its_own(capsys, study, tmp_path):
    study.write_text(STUDY + 'maneuver.side = { distribution = "grid", values = [0.5, 2.0] }\n')
    out = printed(capsys, study, "--output", tmp_path / "out")
    parts = dd.sweeps.load(tmp_path / "out").by("maneuver.side")
    texts = [f"maneuver.side = {side}\n\n{part}\n\n" for (side,), part in parts.items()]
    assert out == f"{''.join(texts)}written: {tmp_path / 'out' / 'trials.csv'}\n"
    found = json.loads(printed(capsys, study, "--output", tmp_path / "out", "--json"))
    assert [each["of"] for each in found["grid"]] == [{"maneuver.side": 0.5}, {"maneuver.side": 2.0}]
    short, long = (each["figures"]["final_position"]["50 %"] for each in found["grid"])
    assert long == pytest.approx(4 * short, rel=0.05)


def test_bad_input_is_one_line(capsys, study, tmp_path):
    out = ("--output", tmp_path / "out")
    assert "did you mean 'squares'?" in refusal(capsys, "sqares", *out)
    assert "no such study file" in refusal(capsys, tmp_path / "nowhere.toml", *out)
    assert "Study.trials = 0: must be at least 1" in refusal(capsys, study, *out, "--trials", 0)
    assert "chunk = 0: must be at least 1" in refusal(capsys, study, *out, "--chunk", 0)
    assert "output" in refusal(capsys, study)
    assert "STUDY is missing" in refusal(capsys, *out)
    assert "only one of them" in refusal(capsys, study, "--robot", "ct_bot", *out)
    assert "goes with --robot" in refusal(capsys, study, "--maneuver", "square", *out)
    assert "did you mean 'square'?" in refusal(capsys, "--robot", "ct_bot", "--maneuver", "sqare", *out)
    study.write_text(STUDY.replace("track_width", "track"))
    assert "in mine.toml 'robot.track': " in refusal(capsys, study, *out)
    assert not (tmp_path / "out").exists()
    study.write_text(STUDY)
    assert "out = " in refusal(capsys, study, "--output", study)


def test_an_interrupted_sweep_keeps_what_is_done_and_goes_on(study, tmp_path):
    out = tmp_path / "out"
    study.write_text(STUDY.replace("trials = 12", "trials = 600"))
    command = [sys.executable, "-m", "diffdrive_mj", "sweep", str(study), "--output", str(out), "--chunk", "3"]
    running = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    until = time.monotonic() + 60
    while len(list(out.glob("chunks/*.npz"))) < 2 and time.monotonic() < until:
        time.sleep(0.01)
    running.send_signal(signal.SIGINT)
    said, complained = running.communicate(timeout=60)
    assert (running.returncode, said, complained) == (130, "", "diffdrive: interrupted\n")
    there = {path: path.stat().st_mtime_ns for path in out.glob("chunks/*.npz")}
    assert 2 <= len(there) < 200
    assert not list(out.glob("**/.*"))
    assert not (out / "trials.csv").exists()
    done = dd.sweep(dd.sweeps.Study.load(study), out, chunk=3)
    assert (done.index == np.arange(600)).all()
    assert {path: path.stat().st_mtime_ns for path in there} == there
