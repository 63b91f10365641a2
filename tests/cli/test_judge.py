"""`diffdrive judge`: programs judged on simulated drives, what is said of them, and the exit status."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from helpers import ROOT

from diffdrive_mj import cli
from diffdrive_mj.judging.by_name import MANEUVERS
from diffdrive_mj.judging.suite import cases
from diffdrive_mj.judging.verdict import Verdict
from diffdrive_mj.world import World

RIGHT = ROOT / "examples" / "odometry.py"
# Says what it reads second of all readings.
SECOND = """
import sys
next(sys.stdin)
next(sys.stdin)
print("0,0,0", flush=True)
sys.exit(next(sys.stdin))
"""


@pytest.fixture(autouse=True)
def elsewhere(tmp_path, monkeypatch):
    """A folder of its own, in which pictures are drawn."""
    monkeypatch.chdir(tmp_path)


def judged(capsys, *arguments, pictures=False):
    """Exit status and what is printed."""
    with pytest.raises(SystemExit) as ended:
        cli.main(["judge", *([] if pictures else ["--no-pictures"]), *map(str, arguments)])
    return ended.value.code, *capsys.readouterr()


@pytest.mark.parametrize("unit", ["rad", "ticks"])
def test_right_odometry_passes_without_bounds(capsys, unit):
    status, out, err = judged(capsys, "--robot", "ct_bot", "--unit", unit, "--drives", "square", "spin", "--",
                              sys.executable, RIGHT)  # fmt: skip
    assert (status, err) == (0, "")
    assert "holds on 2 of 2 drives" in out
    assert {line.split()[0] for line in out.splitlines()[3:]} == {"square", "spin"}


def test_sixty_ticks_a_turn_break_a_bound_on_the_drift_however_right_the_arithmetic_is(capsys):
    options = ("--robot", "ct_bot", "--drives", "straight", "--json")
    status, out, _ = judged(capsys, *options, "--position", 0.001, "--", sys.executable, RIGHT)
    (drive,) = json.loads(out)["drives"]
    assert status == 1
    assert drive["arithmetic_m"] < 1e-9
    assert drive["position_error_m"] > 0.001
    assert drive["heading_error_rad"] > 1e-4
    assert drive["distance_m"] == pytest.approx(15.0, rel=1e-3)
    assert out == json.dumps(json.loads(out), indent=1) + "\n"
    assert drive["broken"] == [f"position off by {1e3 * drive['position_error_m']:.3g} mm, more than 1.00 mm"]
    for option, error in (
        ("--position", drive["position_error_m"]),
        ("--position-per-metre", drive["position_error_m"] / drive["distance_m"]),
        ("--heading", drive["heading_error_rad"]),
    ):
        for factor, status in ((1.01, 0), (0.99, 1)):
            assert judged(capsys, *options, option, factor * error, "--", sys.executable, RIGHT)[0] == status


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler (cc)")
@pytest.mark.parametrize("unit", ["rad", "ticks"])
def test_the_example_in_c_is_right(capsys, tmp_path, unit):
    source = ROOT / "examples" / "odometry.c"
    assert len(source.read_text().splitlines()) <= 40
    strict = ("-O2", "-std=c99", "-Wall", "-Wextra", "-Werror")
    subprocess.run(["cc", *strict, "-o", tmp_path / "odometry", source, "-lm"], check=True)
    status, out, _ = judged(capsys, "--robot", "mismatched", "--unit", unit, "--json", "--", tmp_path / "odometry")
    found = json.loads(out)
    assert status == 0
    assert [drive["drive"] for drive in found["drives"]] == list(MANEUVERS)
    assert max(drive["arithmetic_m"] for drive in found["drives"]) < 1e-12
    wrong = source.read_text().replace("half == 0 ? 1 : sin(half) / half", "1")
    (tmp_path / "wrong.c").write_text(wrong)
    subprocess.run(["cc", *strict, "-o", tmp_path / "wrong", tmp_path / "wrong.c", "-lm"], check=True)
    slalom = ("--robot", "mismatched", "--unit", unit, "--drives", "slalom")
    status, out, _ = judged(capsys, *slalom, "--", tmp_path / "wrong")
    assert status == 1
    assert "steps are chords as long as their arcs (midpoint): use the exact arc" in out


@pytest.fixture
def no_binary(tmp_path):
    """What may be executed and is no program."""
    (tmp_path / "mine").write_text("0,0,0")
    (tmp_path / "mine").chmod(0o755)
    return "./mine"


def test_a_program_that_fails_breaks_its_bounds_and_is_named(capsys, no_binary):
    status, out, err = judged(capsys, "--robot", "ct_bot", "--drives", "spin", "--", no_binary)
    assert (status, err) == (1, "")
    assert "spin: cannot be started (Exec format error)" in out


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--", "true"), "a robot is missing: --robot names a preset or a TOML file; --suite needs none"),
        (("--robot", "ct_bot"), "a program is missing: diffdrive judge --robot ROBOT -- PROGRAM"),
        (("--robot", "ct_bot", "--", "./nowhere"), "./nowhere: no such program"),
        (("--robot", "ct_bot", "--", ""), "'': no such program"),
        (("--robot", "ct_bot", "--", "./nowhere.so"), "./nowhere.so: no such library"),
        (("--robot", "ct_bot", "--", ROOT / "README.md"), "README.md: may not be executed; chmod +x cures it"),
        (("--suite", "--robot", "ct_bot", "--", "true"), "--robot beside --suite"),
        (("--suite", "--position", "0.1", "--", "true"), "--position beside --suite"),
        (("--suite", "--drives", "spin", "--", "true"), "--drives beside --suite"),
        (("--suite", "--rate", "10", "--", "true"), "--rate beside --suite"),
        (("--suite", "--world", "office", "--", "true"), "--world beside --suite"),
        (("--robot", "ct_bot", "--logs", "a.csv", "--world", "office", "--", "true"), "--world office beside --logs"),
        (("--robot", "ct_bot", "--world", "offic", "--", "true"), "did you mean 'office'"),
        (("--suite", "--unit", "ticks", "--", "true"), "--unit beside --suite"),
        (("--suite", "--seed", "1", "--", "true"), "--seed beside --suite"),
        (("--robot", "ct_bot", "--json", "--markdown", "--", "true"), "--json and --markdown: must be one of them"),
        (("--robot", "mached", "--", "true"), "unknown preset 'mached'"),
        (("--robot", "ct_bot", "--drives", "sqare", "--", "true"), "unknown drive 'sqare'"),
        (("--robot", "ct_bot", "--position", "-1", "--", "true"), "position = -1.0: must be positive"),
        (("--robot", "ct_bot", "--seconds", "0", "--", "true"), "seconds = 0.0: must be positive"),
        (("--robot", "ct_bot", "--unit", "degrees", "--", "true"), "invalid choice 'degrees'"),
        (("--robot", "ct_bot", "--rate", "0", "--", "true"), "rate = 0.0: must be positive"),
    ],
)
def test_bad_input_is_one_line(capsys, arguments, said):
    status, out, err = judged(capsys, *arguments)
    assert (status, out) == (2, "")
    assert said in err
    assert err.count("\n") == 1


def test_pictures_are_drawn_and_take_the_place_of_earlier_ones(capsys, tmp_path):
    options = ("--robot", "ct_bot", "--drives", "straight", "spin", "--position", 1e-6)
    status, out, _ = judged(capsys, *options, "--", sys.executable, RIGHT, pictures=True)
    assert status == 1
    assert out.splitlines()[-1] == "written: results/judge/straight.png results/judge/spin.png"
    _, out, _ = judged(capsys, *options[:-2], "--json", "--", sys.executable, RIGHT, pictures=True)
    (picture,) = json.loads(out)["pictures"]  # of the worst one
    recorded = json.loads((tmp_path / "results" / "judge" / "metrics.json").read_text())["provenance"]["command"]
    assert recorded.startswith("diffdrive judge --robot ct_bot --drives straight spin --json -- ")
    assert sorted(path.name for path in (tmp_path / "results" / "judge").iterdir()) == [
        "metrics.json", picture.rpartition("/")[2],
    ]  # fmt: skip


def test_the_suite_needs_no_robot(capsys, tmp_path):
    """A runner that knows its law passes; one that does not fails on the readings that do not count."""
    status, out, _ = judged(capsys, "--suite", "--", sys.executable, RIGHT)
    assert status == 1
    assert f"of {len(cases())} drives" in out
    assert "straight: " not in out


def test_a_program_is_judged_on_logs(capsys):
    cli.main(["simulate", "square", "lab.csv", "--robot", "ct_bot"])
    cli.main(["simulate", "spin", "hall.mcap", "--robot", "ct_bot"])
    capsys.readouterr()
    options = ("--robot", "ct_bot", "--logs", "lab.csv", "hall.mcap", "--json")
    status, out, _ = judged(capsys, *options, "--", sys.executable, RIGHT)
    drives = json.loads(out)["drives"]
    assert status == 0
    assert [drive["drive"] for drive in drives] == ["lab.csv", "hall.mcap"]
    assert drives[0]["distance_m"] == pytest.approx(16.0, rel=1e-3)
    assert judged(capsys, *options, "--position", 0.01, "--", sys.executable, RIGHT)[0] == 1
    for wrong, said in (
        (("--robot", "ct_bot", "--logs", "nowhere.csv"), "nowhere.csv: no such file"),
        (("--suite", "--logs", "lab.csv"), "--logs beside --suite"),
    ):
        status, out, err = judged(capsys, *wrong, "--", sys.executable, RIGHT)
        assert (status, out) == (2, "")
        assert said in err


def test_markdown_is_a_table_for_a_comment(capsys):
    options = ("--robot", "ct_bot", "--drives", "spin", "--markdown")
    status, out, _ = judged(capsys, *options, "--position", 1e-6, "--", sys.executable, RIGHT)
    title, empty, header, rule, row = out.splitlines()
    assert (status, empty, rule) == (1, "", "| --- | --- | --- | --- | --- |")
    assert title.startswith("### ")
    assert title.endswith(": holds on 0 of 1 drives")
    assert header == "| drive | arithmetic | drift | heading | broken |"
    assert row.startswith("| spin | exact | ")
    assert "more than 1.00 µm |" in row


def test_what_fails_has_no_figures(capsys, no_binary):
    _, out, _ = judged(capsys, "--robot", "ct_bot", "--drives", "spin", "--json", "--", no_binary)
    (drive,) = json.loads(out)["drives"]
    figures = ("arithmetic_m", "position_error_m", "heading_error_rad", "distance_m")
    assert [drive[name] for name in figures] == [None] * 4
    assert (drive["holds"], drive["broken"]) == (False, ["cannot be started (Exec format error)"])


def test_readings_come_fifty_times_a_second_unless_told_otherwise(capsys):
    for options, t in (((), 0.02), (("--rate", 10), 0.1)):
        arguments = ("--robot", "ct_bot", "--drives", "spin", "--seconds", 5, *options)
        _, out, _ = judged(capsys, *arguments, "--", sys.executable, "-c", SECOND)
        assert float(out.split("it said: ")[1].split(",")[0]) == pytest.approx(t)
    assert "(default: 10.0)" in judged(capsys, "--help")[1]  # seconds that a drive may take


def test_drives_do_not_start_at_the_origin_and_the_seed_shifts_the_counters(capsys):
    """The answers of a program that copies its input say what it was told."""
    echo = "import sys; sys.exit(next(sys.stdin))"  # says it on stderr
    _, out, _ = judged(capsys, "--robot", "ct_bot", "--drives", "spin", "--", sys.executable, "-c", echo)
    header = out.split("it said: ")[1].split()
    assert header[:4] == ["#", "diffdrive", "1", "unit=rad"]
    start = {name: float(value) for name, value in (pair.split("=") for pair in header[4:])}
    assert start["x"] ** 2 + start["y"] ** 2 > 1
    assert start["theta"] != 0
    offs = []
    for seed in (0, 1):
        _, out, _ = judged(capsys, "--robot", "ct_bot", "--drives", "spin", "--seed", seed, "--json", "--",
                           sys.executable, RIGHT)  # fmt: skip
        offs.append(json.loads(out)["drives"][0]["position_error_m"])
    assert not np.isclose(*offs, rtol=1e-6)


@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="no such signals")
@pytest.mark.parametrize(("number", "status"), [("SIGTERM", 143), ("SIGHUP", 129), ("SIGINT", 130)])
def test_a_judge_that_is_stopped_stops_what_it_judges(tmp_path, number, status):
    """A build that is cancelled leaves no program behind."""
    hangs = "import os, pathlib, time; pathlib.Path('pid').write_text(str(os.getpid())); time.sleep(300)"
    program = ["--seconds", "250", "--", sys.executable, "-c", hangs]
    arguments = ["judge", "--robot", "ct_bot", "--drives", "spin", *program]
    code = f"from diffdrive_mj import cli; cli.main({arguments})"
    judge = subprocess.Popen([sys.executable, "-c", code], cwd=tmp_path, stderr=subprocess.DEVNULL)
    for _ in range(3000):
        if (tmp_path / "pid").exists() and (tmp_path / "pid").read_text():
            break
        time.sleep(0.02)
    pid = int((tmp_path / "pid").read_text())
    judge.send_signal(getattr(signal, number))
    assert judge.wait(60) == status
    assert_gone(pid)


def assert_gone(pid):
    """Nothing runs under a process number; an orphan that has ended may wait for the system to clear it away."""
    entry = Path(f"/proc/{pid}/stat")
    for _ in range(1500):
        try:
            os.kill(pid, 0)
            if entry.exists() and entry.read_text().rpartition(")")[2].split()[0] == "Z":
                return
        except (ProcessLookupError, FileNotFoundError):  # gone now, or between looking and reading
            return
        time.sleep(0.02)
    pytest.fail(f"process {pid} is still there")


@pytest.fixture
def asked(monkeypatch):
    """What the judge and the drives are asked for."""
    found = {"drives": []}

    def simulated(name, robot, **options):
        found["drives"].append((name, robot.name, options))
        return name

    def judge(candidate, tasks, **options):
        found.update(candidate=candidate, tasks=tasks, options=options)
        return Verdict("mine", ())

    # The package has a function of the module's name.
    module = sys.modules["diffdrive_mj.cli.judge"]
    monkeypatch.setattr(module, "simulated", simulated)
    monkeypatch.setattr(module, "judge", judge)
    return found


def test_options_reach_the_judge(capsys, asked):
    bounds = ("--position", 1, "--heading", 2, "--position-per-metre", 3)
    more = ("--unit", "ticks", "--seconds", 4, "--seed", 5, "--rate", 6, "--drives", "spin", "--world", "garden")
    assert judged(capsys, "--robot", "ct_bot", *bounds, *more, "--", sys.executable, "x")[0] == 0
    assert asked["candidate"] == [sys.executable, "x"]
    assert asked["options"] == {
        "position": 1.0, "heading": 2.0, "position_per_metre": 3.0, "unit": "ticks", "seconds": 4.0
    }  # fmt: skip
    assert asked["tasks"] == ["spin"]
    assert asked["drives"] == [("spin", "ct_bot", {"world": World.load("garden"), "rate": 6.0, "seed": 5})]


def test_what_is_left_out_is_not_bounded(capsys, asked):
    assert judged(capsys, "--robot", "ct_bot", "--", sys.executable)[0] == 0
    assert asked["options"] == {
        "position": None, "heading": None, "position_per_metre": None, "unit": "rad", "seconds": 10.0
    }  # fmt: skip
    assert asked["drives"] == [(name, "ct_bot", {"world": World(), "rate": 50.0, "seed": 0}) for name in MANEUVERS]
