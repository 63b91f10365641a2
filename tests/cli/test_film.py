"""`diffdrive film`: what is filmed if nobody says, what is said of it, where it goes, and what is refused."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from PIL import Image

import diffdrive_mj as dd
from diffdrive_mj import cli
from diffdrive_mj.report import filming
from diffdrive_mj.report.filming import _choices
from diffdrive_mj.report.filming.films import Film

EQUAL, UNEQUAL = dd.Robot.load("ct_bot"), dd.Robot.load("mismatched")


@pytest.fixture
def asked(monkeypatch, tmp_path):
    """What is asked of `film` and `strobe`, which draw nothing."""
    monkeypatch.chdir(tmp_path)
    found = []

    def drawing(what):
        def draw(recording, believed, path, **options):
            found.append((what, recording, believed, Path(path), options))
            return Film(Path(path), 2, (640, 480), 1.0)

        return draw

    for what in ("film", "strobe"):
        monkeypatch.setattr(filming, what, drawing(what))
    return found


def test_unequal_wheels_are_taken_for_equal(asked, capsys):
    cli.main(["film", "mismatched"])
    ((what, recording, believed, path, options),) = asked
    ((name, belief),) = believed.items()
    assert (what, path, options) == ("film", Path("results/film/film.webp"), {})
    assert recording.robot == UNEQUAL
    assert belief.left_radius == belief.right_radius == UNEQUAL.mean_radius
    printed = capsys.readouterr().out
    assert "takes both wheels for 0.0955 m, their mean radius" in printed
    assert f"{name} is " in printed
    assert printed.endswith("written: results/film/film.webp (2 frames of 640 x 480, 1 s)\n")


def test_of_equal_wheels_one_is_smaller_than_believed(asked, capsys):
    cli.main(["film", "ct_bot"])
    ((_, recording, believed, _, _),) = asked
    assert recording.robot.right_radius == pytest.approx(0.99 * EQUAL.right_radius)
    assert list(believed.values()) == [EQUAL]
    assert "1 % smaller" in capsys.readouterr().out


def test_the_commands_are_those_of_the_believed_robot(asked):
    cli.main(["film", "ct_bot", "--maneuver", "straight"])
    ((_, recording, _, _, _),) = asked
    assert (recording.commands.wheel_rates[:, 0] == recording.commands.wheel_rates[:, 1]).all()
    assert recording.truth[-1, 2] < -0.1  # and it turns to its smaller wheel


def test_what_is_said(asked):
    cli.main(
        [
            "film",
            "ct_bot",
            "--output",
            "a.mp4",
            "--believed",
            "mismatched",
            "matched",
            "--camera",
            "both",
            "--size",
            "320",
            "200",
            "--fps",
            "10",
            "--speed",
            "2",
        ]
    )
    cli.main(["film", "ct_bot", "--output", "b.png", "--strobe", "--times", "4", "--camera", "above"])
    cli.main(["film", "ct_bot", "--still", "1.5"])
    (_, recording, believed, path, options), strobe, still = asked
    assert recording.robot == EQUAL
    assert believed == {"mismatched": UNEQUAL, "matched": dd.Robot.load("matched")}
    assert (path, options) == (Path("a.mp4"), {"camera": "both", "size": (320, 200), "fps": 10.0, "speed": 2.0})
    assert (strobe[0], strobe[3], strobe[4]) == ("strobe", Path("b.png"), {"times": 4, "camera": "above"})
    assert (still[0], still[3], still[4]) == ("film", Path("results/film/still.png"), {"time": 1.5})


@pytest.mark.parametrize("maneuver", _choices.DRIVES)
@pytest.mark.parametrize("robot", ["ct_bot", "turtlebot3_burger", "mismatched", "optiodom"])
def test_every_maneuver_suits_every_robot(maneuver, robot):
    true, beliefs, _ = _choices.usual_belief(dd.Robot.load(robot))
    recording = dd.simulate(true, _choices.DRIVES[maneuver](next(iter(beliefs.values()))))
    assert recording.events == ()
    assert 5 < recording.t[-1] < 30


@pytest.mark.parametrize("maneuver", _choices.DRIVES)
def test_a_robot_as_large_as_a_truck_stays_on_its_wheels(maneuver):
    huge = dd.Robot(left_radius=1.5, right_radius=1.5, track_width=9.9)
    true, beliefs, _ = _choices.usual_belief(huge)
    (name,) = _choices.usual_belief(huge.replace(left_radius=1.6))[1]
    assert name == "odometry (both wheels 1.55 m)"
    recording = dd.simulate(true, _choices.DRIVES[maneuver](next(iter(beliefs.values()))))
    assert recording.events == ()


REFUSED = {
    "maneuver": ("ct_bot --maneuver squar", "unknown maneuver 'squar'"),
    "robot": ("ct_bt", "unknown preset 'ct_bt'"),
    "belief": ("ct_bot --believed nobody", "unknown preset 'nobody'"),
    "friction": ("ct_bot --friction 0", "friction = 0"),
    "world": ("ct_bot --world offic", "did you mean 'office'"),
    "two kinds": ("ct_bot --strobe --still 1", "--strobe and --still: must be one of them"),
    "times of a film": ("ct_bot --times 3", "--times: is not read here"),
    "rate of a strobe": ("ct_bot --strobe --fps 3", "--fps: is not read here"),
    "speed of a still": ("ct_bot --still 1 --speed 3", "--speed: is not read here"),
    "still that moves": ("ct_bot --still 1 --output a.webp", "--output a.webp: must end on .png"),
    "camera": ("ct_bot --camera aboev", "unknown camera 'aboev'"),
    "ending": ("ct_bot --output a.gif", "unknown ending"),
    "size": ("ct_bot --size 0 480", "size[0] = 0"),
    "time": ("ct_bot --still 1000", "time = 1000 s: must be on the drive"),
    "folder": ("ct_bot --output nowhere/a.webp", "nowhere/a.webp: cannot be written"),
}


@pytest.mark.parametrize(("arguments", "said"), REFUSED.values(), ids=REFUSED)
def test_what_is_refused_leaves_nothing(arguments, said, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as end:
        cli.main(["film", *arguments.split()])
    assert end.value.code == 2
    streams = capsys.readouterr()
    assert streams.err.startswith("diffdrive: ")
    assert said in streams.err
    assert streams.err.count("\n") == 1
    assert streams.out == ""
    assert not list(tmp_path.rglob("*.*"))


def test_a_file_of_somebody_else_stays(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    mine = tmp_path / "results" / "film" / "film.webp"
    mine.parent.mkdir(parents=True)
    mine.write_text("mine")
    with pytest.raises(SystemExit):
        cli.main(["film", "ct_bot"])
    assert "was not written by this command" in capsys.readouterr().err
    assert mine.read_text() == "mine"


@pytest.mark.usefixtures("opengl")
def test_it_works_with_a_robot_alone_and_again(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    EQUAL.save(tmp_path / "my.toml")
    for _ in range(2):  # its own film is replaced
        cli.main(["film", "my.toml", "--fps", "1", "--size", "160", "120"])
    with Image.open(tmp_path / "results" / "film" / "film.webp") as film:
        assert (film.size, film.n_frames > 10) == ((160, 120), True)
    assert sorted(path.name for path in tmp_path.rglob("*.*")) == ["film.webp", "my.toml"]
    assert capsys.readouterr().err == ""


def test_an_opengl_that_cannot_be_used_is_one_line_and_the_physics_works(tmp_path):
    """MUJOCO_GL is read when MuJoCo is imported, here as a program's user has it in the environment."""
    environment = {**os.environ, "MUJOCO_GL": "rubbish"}
    command = [sys.executable, "-m", "diffdrive_mj", "film", "ct_bot", "--maneuver", "spin"]
    ran = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert (ran.returncode, len(ran.stderr.splitlines())) == (2, 1)
    assert "OpenGL cannot be used" in ran.stderr
    assert "MUJOCO_GL=rubbish" in ran.stderr
