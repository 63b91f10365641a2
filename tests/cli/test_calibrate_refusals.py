"""`diffdrive calibrate` refuses what is mixed up, names the option that cures it, and writes nothing then."""

import numpy as np
import pytest
from test_cli import NOMINAL, TRUE, drive, refused

import diffdrive_mj as dd
from diffdrive_mj import cli, logs

HEADER = "stamp,enc_l,enc_r,x,y,yaw"
READ = ["--robot", "nominal.toml", "--time", "stamp", "--left", "enc_l", "--right", "enc_r", "--theta", "yaw"]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A log with names of its own, its twin, and the nominal robot, in the working directory."""
    monkeypatch.chdir(tmp_path)
    for name, radius in (("lab", 1.0), ("other", -0.6)):
        logs.write_csv("plain.csv", drive(dd.maneuvers.arc(TRUE, radius=radius, distance=4.0, speed=0.5)))
        _, *rows = (tmp_path / "plain.csv").read_text().splitlines()
        (tmp_path / f"{name}.csv").write_text("\n".join([HEADER, *rows, ""]))
    (tmp_path / "plain.csv").unlink()
    NOMINAL.save("nominal.toml")
    return tmp_path


def changed(folder, name, **factors):
    """The log with some of its columns multiplied, under another name."""
    rows = np.genfromtxt(folder / "lab.csv", delimiter=",", names=True)
    for column, factor in factors.items():
        rows[column] *= factor
    lines = [",".join(map(repr, map(float, row))) for row in rows]
    (folder / name).write_text("\n".join([HEADER, *lines, ""]))


@pytest.mark.parametrize(
    ("options", "cure"),
    [
        (["--left", "enc_r", "--right", "enc_l"], "use --left enc_l --right enc_r"),
        (["--left", "3", "--right", "2"], "use --left 2 --right 3"),
        (["--reverse-left"], "try --no-reverse-left"),
        (["--reverse-right"], "try --no-reverse-right"),
        (["--position-unit", "mm"], "(--position-unit)"),
        (["--time-unit", "ms"], "(--time-unit)"),
        (["--angle-unit", "deg"], "try --angle-unit rad"),
    ],
)
def test_what_is_mixed_up_is_refused_with_the_option_that_cures(folder, capsys, options, cure):
    before = sorted(folder.iterdir())
    error = refused(
        capsys, "calibrate", "other.csv", "lab.csv", *READ, *options, "--export", "ros2", "--output", "new.toml"
    )
    assert error.startswith("diffdrive: other.csv: ")
    assert cure in error
    assert error.endswith("; --anyway accepts it\n")
    assert sorted(folder.iterdir()) == before


def test_faults_of_the_log_itself(folder, capsys):
    changed(folder, "left.csv", enc_l=-1)
    changed(folder, "degrees.csv", yaw=180 / np.pi)
    changed(folder, "motor.csv", enc_l=1.7, enc_r=1.7)
    for name, cure in (("left", "try --reverse-left"), ("degrees", "try --angle-unit deg"), ("motor", "--wheel-unit")):
        assert cure in refused(capsys, "calibrate", f"{name}.csv", *READ, "--output", "new.toml")
    assert not (folder / "new.toml").exists()


def test_the_same_log_twice(folder, capsys):
    (folder / "copy.csv").write_text((folder / "lab.csv").read_text())
    assert "lab.csv is given twice" in refused(capsys, "calibrate", "lab.csv", "other.csv", "lab.csv", *READ)
    assert "lab.csv and copy.csv are the same log" in refused(capsys, "calibrate", "lab.csv", "copy.csv", *READ)


def test_anyway_proceeds_with_a_warning(folder, capsys):
    swapped = ["--left", "enc_r", "--right", "enc_l"]
    cli.main(["calibrate", "lab.csv", *READ, *swapped, "--anyway", "--output", "new.toml"])
    printed = capsys.readouterr().out
    assert printed.startswith("calibration by")
    assert "  warning: lab.csv: left and right look swapped" in printed
    assert "use --left enc_l --right enc_r" in printed
    assert (folder / "new.toml").exists()


def test_a_start_is_advised_by_its_option(folder, capsys):
    rows = (folder / "lab.csv").read_text().splitlines()
    (folder / "late.csv").write_text("\n".join([HEADER, *rows[200:], ""]))
    cli.main(["calibrate", "late.csv", *READ, "--start", "truth"])
    assert "begins while the robot drives at 0.5" in (printed := capsys.readouterr().out)
    assert "(--start position)" in printed


def test_headings_that_are_not_read_are_said_to_look_wrong_and_do_not_matter(folder, capsys):
    changed(folder, "degrees.csv", yaw=180 / np.pi)
    cli.main(["calibrate", "lab.csv", *READ, "--no-headings"])
    right = capsys.readouterr().out.splitlines()
    cli.main(["calibrate", "degrees.csv", *READ, "--no-headings"])
    first, *printed = capsys.readouterr().out.splitlines()
    assert first.startswith("degrees.csv: ")
    assert "try --angle-unit deg" in first
    assert printed[:4] == right[:4]


def test_what_is_exported_follows_after_an_empty_line(folder, capsys):
    cli.main(["calibrate", "lab.csv", "other.csv", *READ, "--export", "wpilib"])
    printed = capsys.readouterr().out
    calibration, exported = printed.split("\n\n")
    assert calibration.startswith("calibration by")
    assert exported.startswith("public static final double kTrackWidth")
    assert exported.endswith("\n")


def test_what_a_logs_clock_shows_is_said(folder, capsys):
    lines = (folder / "lab.csv").read_text().splitlines()
    (folder / "twice.csv").write_text("\n".join([*lines[:9], lines[8], *lines[9:], ""]))
    cli.main(["calibrate", "twice.csv", "other.csv", *READ])
    said = capsys.readouterr().out.splitlines()
    assert said[:2] == [f"twice.csv: {what}: 1 repeated sample dropped" for what in ("wheels", "poses")]
    assert not any(line.startswith("other.csv") for line in said)


def test_a_tape_is_enough_and_anyway_is_offered_only_where_it_helps(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    NOMINAL.save("nominal.toml")
    true = NOMINAL.replace(left_radius=0.0515, track_width=0.31)
    for way in ("left", "right"):
        square = dd.simulate(true, dd.maneuvers.square(NOMINAL, side=2.0, clockwise=way == "right"), sample_rate=50.0)
        ends = [(0, 0, 0), (*square.truth[-1, :2], 0)]
        logs.write_csv(f"{way}.csv", dd.Drive(square.t, square.wheel_angles, ends, square.t[[0, -1]]))
    taped = ("calibrate", "left.csv", "right.csv", "--robot", "nominal.toml", "--method", "umbmark", "--side", "2")
    # Nothing accepts what these headings of zero say.
    assert "drive a shorter side, or check the drives\n" in refused(capsys, *taped)
    assert "drive a shorter side, or check the drives\n" in refused(capsys, *taped, "--anyway")
    cli.main([*taped, "--no-headings"])
    ratio = float(capsys.readouterr().out.split("radius_ratio")[1].split()[0])
    assert abs(ratio - true.radius_ratio) < 1e-3
