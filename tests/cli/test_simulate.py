"""`diffdrive simulate`: what its options ask of physics and of the sensors, and what is written."""

import subprocess
import sys

import numpy as np
import pytest

import diffdrive_mj as dd
from diffdrive_mj import cli, logs, sensors
from diffdrive_mj.physics import simulation

ROBOT = dd.Robot.load("ct_bot")
DRIVE = dd.Drive([0.0, 1.0, 2.0], [(0, 0), (5, 5), (9, 10)], np.zeros((2, 3)), [0.0, 2.0])


@pytest.fixture
def asked(monkeypatch, tmp_path):
    """What is asked for, and what is written by its path."""
    monkeypatch.chdir(tmp_path)
    found = {"written": {}}

    def simulate(robot, commands, *, world):
        found.update(robot=robot, commands=commands, world=world)
        return "recording"

    def measure(recording, *, encoder, tracker, seed):
        found.update(recording=recording, encoder=encoder, tracker=tracker, seed=seed)
        return DRIVE

    monkeypatch.setattr(simulation, "simulate", simulate)
    monkeypatch.setattr(sensors, "measure", measure)
    monkeypatch.setattr(logs, "write", lambda path, log: found["written"].update({str(path): log}))
    return found


def test_what_is_not_given(asked, capsys):
    cli.main(["simulate", "spin", "drive.csv", "--robot", "ct_bot"])
    encoder, tracker = asked["encoder"], asked["tracker"]
    assert (asked["robot"], encoder.sample_rate, tracker.sample_rate) == (ROBOT, 50.0, 50.0)
    assert (tracker.position_noise, tracker.heading_noise) == (0.0, 0.0)
    assert (asked["world"], asked["seed"], asked["recording"]) == (dd.World(), 0, "recording")
    assert asked["written"] == {"drive.csv": DRIVE}
    assert capsys.readouterr().out == f"{DRIVE!r}\nwritten: drive.csv\n"


@pytest.mark.parametrize("more", [{}, {"friction": 0.4}])
def test_a_world_is_driven_in_with_its_own_friction_or_another(asked, capsys, more):
    options = [text for name, value in more.items() for text in (f"--{name}", str(value))]
    cli.main(["simulate", "spin", "drive.csv", "--robot", "ct_bot", "--world", "garden", *options])
    assert asked["world"] == dd.World.load("garden").replace(**more)


def test_what_is_given(asked, capsys):
    cli.main(
        ["simulate", "spin", "drive.csv", "--robot", "ct_bot", "--rate", "20", "--tracker-rate", "5", "--seed", "7",
         "--position-noise", "0.01", "--heading-noise", "0.02", "--friction", "0.3",
         "--odometry", "odom.tum", "--believed", "matched"]
    )  # fmt: skip
    encoder, tracker = asked["encoder"], asked["tracker"]
    assert (encoder.sample_rate, tracker.sample_rate) == (20.0, 5.0)
    assert (tracker.position_noise, tracker.heading_noise) == (0.01, 0.02)
    assert (asked["world"], asked["seed"]) == (dd.World(friction=0.3), 7)
    believed = dd.Robot.load("matched")
    log = asked["written"]["odom.tum"]
    assert (log.name, log.t.tolist()) == (believed.name, [0.0, 2.0])
    assert np.array_equal(log.poses, DRIVE.odometry(believed))
    assert capsys.readouterr().out.endswith("\nwritten: drive.csv odom.tum\n")


def test_a_tracker_that_stands_is_refused(asked, capsys):
    """Nought is a rate that is given, and a wrong one."""
    with pytest.raises(SystemExit) as ended:
        cli.main(["simulate", "spin", "drive.csv", "--robot", "ct_bot", "--tracker-rate", "0"])
    assert ended.value.code == 2
    assert "must be positive" in capsys.readouterr().err
    assert asked["written"] == {}


def test_what_happened_on_the_drive_is_said_in_a_line(tmp_path):
    program = "import sys; from diffdrive_mj.cli import main; main(sys.argv[1:])"
    options = ["simulate", "square", "a.csv", "--robot", "ct_bot", "--friction", "0.02"]
    done = subprocess.run(
        [sys.executable, "-c", program, *options], capture_output=True, text=True, check=True, cwd=tmp_path
    )
    assert done.stderr.startswith("diffdrive: robot ct_bot: the left wheel used ")
    assert done.stderr.count("\n") == 1
