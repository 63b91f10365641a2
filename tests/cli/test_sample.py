"""`diffdrive sample` writes logs that calibrate, and overwrites nothing."""

import shlex

import numpy as np
import pytest

import diffdrive_mj as dd
from diffdrive_mj import cli, logs
from diffdrive_mj.cli.sample import NOMINAL, TRUE

FILES = ("left.csv", "right.csv", "nominal.toml")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def refused(capsys, *arguments):
    with pytest.raises(SystemExit) as raised:
        cli.main(["sample", *map(str, arguments)])
    assert raised.value.code == 2
    streams = capsys.readouterr()
    assert streams.out == ""
    assert streams.err.count("\n") == 1
    return streams.err


@pytest.mark.parametrize("name", ["lab", "deep/in/my lab"])
def test_the_command_that_it_prints_finds_the_true_robot(folder, name, capsys):
    cli.main(["sample", name])
    assert sorted(path.name for path in (folder / name).iterdir()) == sorted(FILES)
    written, command = capsys.readouterr().out.split("\n\n")
    assert written.startswith("written: ")
    cli.main([*shlex.split(command.replace("\\\n", ""))[1:], "--output", "found.toml"])
    # Nothing looks wrong with the logs.
    assert capsys.readouterr().out.startswith("calibration by")
    found = dd.Robot.load("found.toml")
    for field in ("left_radius", "right_radius", "track_width"):
        assert getattr(found, field) == pytest.approx(getattr(TRUE, field), rel=1e-4)
        assert abs(getattr(NOMINAL, field) / getattr(TRUE, field) - 1) > 3e-3


def test_the_logs_are_like_a_real_robots(folder):
    cli.main(["sample", "lab"])
    columns = logs.Columns(time="stamp", time_unit="ms", left="enc_l", right="enc_r", wheel_unit="ticks",
                           counter_bits=16, theta="yaw", angle_unit="deg")  # fmt: skip
    nominal = dd.Robot.load("lab/nominal.toml")
    for name, sense in (("left", 1), ("right", -1)):
        counts = np.array([line.split(",")[1:3] for line in (folder / "lab" / f"{name}.csv").read_text().split()[1:]])
        assert (np.abs(np.diff(counts.astype(int), axis=0)) > 30000).any(axis=0).all()  # both counters wrap
        drive = logs.read_csv(f"lab/{name}.csv", columns, nominal)
        assert np.diff(drive.t) == pytest.approx(0.02)
        assert np.diff(drive.clock) == pytest.approx(0.1)
        # Along sides of a metre, at 20 cm a second at most.
        assert np.ptp(drive.truth[:, :2], axis=0) == pytest.approx((1.0, 1.0), abs=0.01)
        speed = np.linalg.norm(np.diff(drive.truth[:, :2], axis=0), axis=1) / 0.1
        assert np.median(speed[speed > 0.1]) == pytest.approx(0.2, abs=0.01)
        # Back to where it started, once around, but for the noise and a fraction of a tick.
        assert np.hypot(*(drive.truth[-1] - drive.truth[0])[:2]) < 0.005
        assert np.unwrap(drive.truth[:, 2])[-1] - drive.truth[0, 2] == pytest.approx(2 * np.pi * sense, abs=0.01)
        residual = drive.odometry(TRUE) - drive.truth
        assert 0.0003 < residual[:, :2].std() < 0.002
        assert dd.se2.wrap_angle(np.diff(residual[:, 2])).std() == pytest.approx(np.radians(0.1) * np.sqrt(2), rel=0.2)
    assert nominal.name == "nominal"


def test_the_seed_decides_the_noise_and_nothing_else(folder):
    for name, options in (("one", ()), ("two", ("--seed", "0")), ("three", ("--seed", "1"))):
        cli.main(["sample", name, *options])
    texts = [[(folder / name / file).read_text() for file in FILES] for name in ("one", "two", "three")]
    assert texts[0] == texts[1]
    assert texts[2][:2] != texts[0][:2]
    assert texts[2][2] == texts[0][2]


@pytest.mark.parametrize("name", FILES)
def test_nothing_is_overwritten(folder, name, capsys):
    (folder / name).write_text("mine")
    assert refused(capsys, ".") == f"diffdrive: {name}: is there already and is not overwritten; name another folder\n"
    assert [path.name for path in folder.iterdir()] == [name]
    assert (folder / name).read_text() == "mine"


def test_a_folder_that_cannot_be_made(folder, capsys):
    (folder / "file").write_text("")
    assert "file/lab: cannot be made" in refused(capsys, "file/lab")
    assert "file: cannot be made" in refused(capsys, "file")
    assert "seed = -1: must not be negative" in refused(capsys, "lab", "--seed", "-1")
    assert "must name a file or a folder" in refused(capsys, "lab\0x")
    assert "FOLDER" in refused(capsys)
    assert [path.name for path in folder.iterdir()] == ["file"]
