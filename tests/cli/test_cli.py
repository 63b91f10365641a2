"""The program: it reads logs, says what looks wrong, calibrates, exports; bad input is one line and status 2."""

import dataclasses
import subprocess
import sys
import types

import numpy as np
import pytest

import diffdrive_mj as dd
from diffdrive_mj import cli, logs
from diffdrive_mj.calibration.result import Calibration
from diffdrive_mj.drive import Drive
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.metrics import stacked

TRUE = dd.Robot(
    left_radius=0.05, right_radius=0.0485, track_width=0.31, encoder={"ticks_per_revolution": 1000}, name="mine"
)
NOMINAL = TRUE.replace(right_radius=0.05, track_width=0.3)


def drive(commands):
    angles = np.concatenate([[[0, 0]], np.cumsum(commands.wheel_rates * commands.period, axis=0)])
    return Drive(np.arange(len(angles)) * commands.period, angles, dd.odometry.integrate(angles, TRUE))


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Two logs and the nominal robot, as files, in the working directory."""
    monkeypatch.chdir(tmp_path)
    for k, radius in enumerate((1.0, -0.6)):
        logs.write_csv(f"log{k}.csv", drive(dd.maneuvers.arc(TRUE, radius=radius, distance=4.0, speed=0.5)))
    NOMINAL.save("nominal.toml")
    return tmp_path


@pytest.fixture
def method(monkeypatch):
    """A method that knows the answer, in place of `least_squares`; the calls it got."""
    calls = []

    def least_squares(drives, believed, *, start, headings, turning_gain=None, anyway=False):
        calls.append((drives, believed, turning_gain))
        calibrated = believed.replace(right_radius=TRUE.right_radius, track_width=TRUE.track_width)
        return Calibration(
            "a planted method", believed, calibrated, ("track_width",), np.array([0.31]), np.eye(1) * 1e-8, np.zeros(3),
            *(stacked(drive.drift(robot) for drive in drives) for robot in (believed, calibrated)),
            warnings=("a planted warning",),
        )  # fmt: skip

    module = types.ModuleType("diffdrive_mj.calibration.paths")
    module.least_squares = least_squares
    monkeypatch.setitem(sys.modules, "diffdrive_mj.calibration.paths", module)
    return calls


def refused(capsys, *arguments):
    """The one line on stderr of a call that ends with status 2 and prints and writes nothing."""
    with pytest.raises(SystemExit) as raised:
        cli.main([str(argument) for argument in arguments])
    assert raised.value.code == 2
    streams = capsys.readouterr()
    assert streams.err.startswith("diffdrive: ")
    assert streams.err.count("\n") == 1
    return streams.err


def test_a_calibration_is_printed(folder, method, capsys):
    cli.main(["calibrate", "log0.csv", "log1.csv", "--robot", "nominal.toml"])
    printed = capsys.readouterr().out
    for words in ("a planted method", "track_width    0.31 +- 0.0001", "before", "after", "warning: a planted warning"):
        assert words in printed
    ((drives, believed, gain),) = method
    assert [d.name for d in drives] == ["log0.csv", "log1.csv"]
    assert believed == NOMINAL
    assert gain is None
    assert sorted(path.name for path in folder.iterdir()) == ["log0.csv", "log1.csv", "nominal.toml"]


@pytest.mark.parametrize(
    ("target", "words"),
    [
        ("ros2", "right_wheel_radius_multiplier: 0.97\n"),
        ("wpilib", "kTrackWidth = 0.31;"),
        ("duckietown", "baseline: 0.31\n"),
        ("toml", "track_width = 0.31\n"),
    ],
)
def test_the_configuration_of_other_stacks(folder, method, capsys, target, words):
    cli.main(["calibrate", "log0.csv", "--robot", "nominal.toml", "--export", target])
    assert words in capsys.readouterr().out
    assert method[0][2] is (None if target == "toml" else False)


def test_the_robot_is_written(folder, method, capsys):
    cli.main(["calibrate", "log0.csv", "--robot", "nominal.toml", "--output", "mine.toml"])
    assert "written: mine.toml" in capsys.readouterr().out
    assert dd.Robot.load("mine.toml") == TRUE


def test_presets_and_columns_of_any_name(folder, method, capsys):
    lines = (folder / "log0.csv").read_text().splitlines()[1:]
    rows = [[float(cell) for cell in line.split(",")] for line in lines]
    ticks = [
        ";".join(map(repr, [1e3 * t, round(right * 500 / np.pi) % 2**16, -round(left * 500 / np.pi) % 2**16,
                            1e3 * x, 1e3 * y, float(np.degrees(theta))]))
        for t, left, right, x, y, theta in rows
    ]  # fmt: skip
    (folder / "own.csv").write_text("\n".join(["ms;enc r;enc l;px;py;yaw", *ticks]))
    cli.main(
        ["calibrate", "own.csv", "--robot", "nominal.toml", "--time", "ms", "--left", "enc l", "--right", "2",
         "--x", "px", "--y", "py", "--theta", "yaw", "--wheel-unit", "ticks", "--counter-bits", "16", "--time-unit",
         "ms", "--position-unit", "mm", "--angle-unit", "deg", "--reverse-left", "--ticks-per-revolution", "1000"]
    )  # fmt: skip
    assert ": " not in capsys.readouterr().out.split("calibration by")[0]
    read, written = method[0][0][0], logs.read_csv("log0.csv")
    np.testing.assert_allclose(read.wheel_angles, written.wheel_angles, atol=0.0032)
    np.testing.assert_allclose(read.truth, written.truth, atol=1e-12)
    np.testing.assert_allclose(read.t, written.t, atol=1e-12)
    cli.main(["calibrate", "log0.csv", "--robot", "matched"])
    assert method[1][1] == dd.Robot.load("matched")


def pushed(drive):
    """The same drive, displaced at its middle."""
    truth = drive.truth.copy()
    truth[len(truth) // 2 :, :2] += (0.2, 0.1)
    return dataclasses.replace(drive, truth=truth)


def test_suspicions_come_first(folder, method, capsys):
    logs.write_csv("pushed.csv", pushed(logs.read_csv("log0.csv")))
    cli.main(["calibrate", "log1.csv", "pushed.csv", "--robot", "nominal.toml"])
    printed = capsys.readouterr().out
    assert printed.startswith("pushed.csv: at about ")
    assert printed.index("was the robot pushed") < printed.index("calibration by")


def test_suspicions_are_said_even_if_the_calibration_fails(folder, method, capsys, monkeypatch):
    def least_squares(drives, believed, *, start, headings, turning_gain=None, anyway=False):
        raise InvalidValue("nothing to be learnt from it")

    monkeypatch.setattr(sys.modules["diffdrive_mj.calibration.paths"], "least_squares", least_squares)
    error = refused(capsys, "calibrate", "log0.csv", "--robot", "nominal.toml", "--output", "mine.toml")
    assert error == "diffdrive: nothing to be learnt from it\n"
    assert not (folder / "mine.toml").exists()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["nowhere.csv", "--robot", "nominal.toml"], "nowhere.csv: no such file"),
        (["log0.csv", "nowhere.csv", "--robot", "nominal.toml"], "nowhere.csv: no such file"),
        (["log0.csv", "--robot", "nowhere.toml"], "nowhere.toml: no such robot file"),
        (["log0.csv", "--robot", "optidom"], "did you mean 'optiodom'"),
        (["--robot", "nominal.toml"], "no logs"),
        (["log0.csv", "--robot", "nominal.toml", "--x", "xx"], "unknown column of log0.csv 'xx'"),
        (["log0.csv", "--robot", "nominal.toml", "--x", "9"], "columns 1 to 6"),
        (["bad.csv", "--robot", "nominal.toml"], "bad.csv, line 3, column 2 (left): 'one' is not a number"),
        (["empty.csv", "--robot", "nominal.toml"], "empty.csv: the file is empty"),
        (["log0.csv", "--robot", "bad.toml"], "not a robot's TOML file"),
        (["log0.csv", "--robot", "nominal.toml", "--output", "mine.yaml"], "named .toml"),
        (["log0.csv", "--robot", "nominal.toml", "--output", "nowhere/mine.toml"], "cannot be written"),
    ],
)
def test_bad_input_is_one_line(folder, method, capsys, arguments, words):
    (folder / "bad.csv").write_text("t,left,right,x,y,theta\n0,0,0,0,0,0\n1,one,1,1,1,0\n")
    (folder / "empty.csv").write_text("")
    (folder / "bad.toml").write_text("left_radius: 0.1")
    before = sorted(folder.iterdir())
    assert words in refused(capsys, "calibrate", *arguments)
    assert sorted(folder.iterdir()) == before


def test_a_robot_with_a_gain_is_not_exported_without_it(folder, method, capsys):
    nominal = NOMINAL.replace(turning_gain=0.02)
    nominal.save("gain.toml")
    assert "ros2 has none" in refused(
        capsys, "calibrate", "log0.csv", "--robot", "gain.toml", "--export", "ros2", "--output", "mine.toml"
    )
    assert not (folder / "mine.toml").exists()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "--robot"),
        (["a.csv", "--robot"], "--robot"),
        (["a.csv", "--robot", "matched", "--export", "ros1"], "ros2"),
        (["a.csv", "--robot", "matched", "--x", "0"], "columns count from 1"),
        (["a.csv", "--robot", "matched", "--counter-bits", "16"], "only counters of ticks"),
        (["a.csv", "--robot", "matched", "--delimiter", "::"], "must be one character"),
    ],
)
def test_options_that_make_no_sense_are_refused_in_one_line(arguments, words, capsys):
    error = refused(capsys, "calibrate", *arguments)
    assert words in error
    assert error.endswith("; see diffdrive calibrate --help\n")


def test_help_says_what_every_option_means(capsys):
    with pytest.raises(SystemExit) as raised:
        cli.main(["calibrate", "--help"])
    assert raised.value.code == 0
    text = " ".join(capsys.readouterr().out.replace("│", " ").split())
    for field in dataclasses.fields(logs.Columns):
        assert f"--{field.name.replace('_', '-')}" in text
    for words in (
        "Exit status",
        "LOG.csv [LOG.csv ...]",
        "--robot ROBOT",
        "ros2 (diff_drive_controller)",
        "uncertainty",
    ):
        assert words in text


@pytest.mark.parametrize("command", [["-m", "diffdrive_mj"], ["-c", "from diffdrive_mj.cli import main; main()"]])
def test_it_runs_as_a_program(folder, command):
    program = [sys.executable, "-W", "error", *command]
    done = subprocess.run([*program, "calibrate", "nowhere.csv", "--robot", "nominal.toml"],
                          capture_output=True, text=True, check=False)  # fmt: skip
    assert (done.returncode, done.stdout, done.stderr) == (2, "", "diffdrive: nowhere.csv: no such file\n")


def test_with_the_method_itself(folder, capsys):
    pytest.importorskip("diffdrive_mj.calibration.paths")
    cli.main(["calibrate", "log0.csv", "log1.csv", "--robot", "nominal.toml", "--export", "ros2", "--output", "m.toml"])
    found = dd.Robot.load("m.toml")
    for field in ("left_radius", "right_radius", "track_width"):
        assert getattr(found, field) == pytest.approx(getattr(TRUE, field), rel=1e-3)
    assert "left_wheel_radius_multiplier" in capsys.readouterr().out


def test_how_the_truth_is_to_be_taken_reaches_the_method(folder, monkeypatch):
    seen = []

    def least_squares(drives, believed, *, start, headings, turning_gain, anyway):
        seen.append({"start": start, "headings": headings, "turning_gain": turning_gain, "anyway": anyway})
        raise InvalidValue("enough")

    module = types.ModuleType("diffdrive_mj.calibration.paths")
    module.least_squares = least_squares
    monkeypatch.setitem(sys.modules, "diffdrive_mj.calibration.paths", module)
    for arguments in ([], ["--start", "position", "--no-headings", "--anyway", "--export", "ros2"]):
        with pytest.raises(SystemExit):
            cli.main(["calibrate", "log0.csv", "--robot", "nominal.toml", *arguments])
    assert seen == [
        {"start": "estimated", "headings": True, "turning_gain": None, "anyway": False},
        {"start": "position", "headings": False, "turning_gain": False, "anyway": True},
    ]


@pytest.mark.parametrize(
    ("method", "options", "parameters"),
    [
        ("from_fixes", (), ("left_radius", "right_radius", "track_width")),
        ("umbmark", ("--side", "2"), ("radius_ratio", "track_width")),
        ("jung_chung", ("--side", "2"), ("radius_ratio", "track_width")),
    ],
)
def test_every_method_is_there(tmp_path, monkeypatch, capsys, method, options, parameters):
    """On squares in both directions, which all of them take."""
    monkeypatch.chdir(tmp_path)
    nominal = TRUE.replace(right_radius=0.0488, track_width=0.305)
    nominal.save("nominal.toml")
    drives = [drive(dd.maneuvers.square(nominal, side=2.0, clockwise=clockwise)) for clockwise in (False, True)]
    for name, each in zip(("left", "right"), drives, strict=True):
        logs.write_csv(f"{name}.csv", each)
    cli.main(["calibrate", "left.csv", "right.csv", "--robot", "nominal.toml", "--method", method, *options,
              "--output", "new.toml"])  # fmt: skip
    out = capsys.readouterr().out
    same = getattr(dd.calibration, method)(
        [logs.read_csv(f"{name}.csv") for name in ("left", "right")], nominal,
        **({"side": 2.0} if options else {}),
    )  # fmt: skip
    assert same.parameters == parameters
    assert dd.Robot.load("new.toml").replace(name="") == same.calibrated.replace(name="")
    for name in parameters:
        assert name in out


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--method", "umbmark"), "--method umbmark needs --side, that of the squares [m]"),
        (("--method", "umbmark", "--side", "2", "--start", "truth"), "--start says nothing to --method umbmark"),
        (
            ("--method", "jung_chung", "--side", "2", "--no-headings"),
            "--no-headings says nothing to --method jung_chung",
        ),
        (("--method", "speed_ratio", "--side", "2"), "--side says nothing to --method speed_ratio"),
        (("--side", "2"), "--side says nothing to --method least_squares"),
    ],
)
def test_options_that_a_method_does_not_take_are_refused(folder, capsys, options, said):
    assert said in refused(capsys, "calibrate", "log0.csv", "--robot", "nominal.toml", *options)


def test_a_bag_is_calibrated_as_its_table_is(tmp_path, monkeypatch, capsys):
    pytest.importorskip("rosbags")
    monkeypatch.chdir(tmp_path)
    NOMINAL.save("nominal.toml")
    for ending in ("csv", "mcap"):
        log = f"log.{ending}"
        logs.write(log, drive(dd.maneuvers.figure_eight(TRUE, radius=0.5)))
        cli.main(["calibrate", log, "--robot", "nominal.toml", "--output", f"{ending}.toml"])
    tables, bags = (dd.Robot.load(f"{ending}.toml") for ending in ("csv", "mcap"))
    assert bags.track_width == pytest.approx(tables.track_width, rel=1e-6)
    assert bags.track_width == pytest.approx(TRUE.track_width, rel=1e-4)
