"""`diffdrive robots`: what it prints is what the robots are, and its file is one that MuJoCo opens."""

import math
import re
import subprocess
import sys

import mujoco
import pytest

import diffdrive_mj as dd
from diffdrive_mj import cli
from diffdrive_mj.robot import presets


def printed(capsys, *arguments):
    cli.main(["robots", *map(str, arguments)])
    return capsys.readouterr().out


def test_every_preset_has_a_line_with_its_geometry(capsys):
    header, *lines = printed(capsys, "list").splitlines()
    assert header.split() == ["preset", "left", "[m]", "right", "[m]", "track", "[m]", "robot"]
    assert [line.split()[0] for line in lines] == list(presets())
    for line in lines:
        name, *numbers = line.split()[:4]
        robot = dd.Robot.load(name)
        assert [float(number) for number in numbers] == [robot.left_radius, robot.right_radius, robot.track_width]
        assert len(line.split("  ")[-1]) > 10
    said = {line.split()[0]: line.split("  ")[-1] for line in lines}
    # What the first sentence of the file's comment says, without its mark.
    assert said["ct_bot"].startswith("c't-Bot")
    assert not any(set("#:;") & set(words) or words != words.strip() for words in said.values())


def test_a_robot_is_shown_with_what_it_leaves_out(capsys, tmp_path):
    small = dd.Robot(left_radius=0.03, right_radius=0.031, track_width=0.15, name="small")
    small.save(tmp_path / "small.toml")
    text = printed(capsys, "show", tmp_path / "small.toml")
    for table, field in (("tyres", "mass"), ("caster", "x"), ("servo", "bandwidth"), ("encoder", "gear")):
        (value,) = re.findall(rf"^\[{table}\]\n(?:\w+ = .*\n)*?{field} = (.*)$", text, re.MULTILINE)
        assert float(value) == getattr(getattr(small, table), field)
    assert text.startswith(f"# {small.mass:.4g} kg; radius ratio 1.03333, right / left\n")
    assert text.endswith("\n")
    assert not text.endswith("\n\n")
    (tmp_path / "again.toml").write_text(text)
    again = dd.Robot.load(tmp_path / "again.toml")
    assert again == small
    assert again.replace(track_width=0.3).caster == small.caster  # it scales no more


def test_a_robot_with_skid_steer_is_shown_without_a_caster(capsys, tmp_path):
    robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4, skid_steer={"wheelbase": 0.3}, name="rover")
    robot.save(tmp_path / "rover.toml")
    text = printed(capsys, "show", tmp_path / "rover.toml")
    assert "[caster]" not in text
    (tmp_path / "again.toml").write_text(text)
    assert dd.Robot.load(tmp_path / "again.toml") == robot


@pytest.mark.parametrize("name", presets())
def test_the_model_drives(capsys, tmp_path, name):
    assert printed(capsys, "mjcf", name, tmp_path / "robot.xml") == f"written: {tmp_path / 'robot.xml'}\n"
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "robot.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("straight").id)
    mujoco.mj_step(model, data, nstep=2000)
    assert data.qpos[0] > 5 * dd.Robot.load(name).track_width
    assert abs(data.qpos[1]) < 1e-4 * data.qpos[0]


def test_the_model_has_the_world_that_is_asked_for(capsys, tmp_path):
    printed(capsys, "mjcf", "ct_bot", tmp_path / "robot.xml", "--world", "garden")
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "robot.xml"))
    world = dd.World.load("garden")
    assert model.opt.gravity[2] == pytest.approx(-9.81 * math.cos(world.slope.angle), rel=1e-5)
    assert model.pair("left_floor").friction[0] == world.friction


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["mjcf", "matchd", "a.xml"], "did you mean 'matched'"),
        (["mjcf", "matched", "a.xml", "--world", "gardn"], "did you mean 'garden'"),
        (["mjcf", "nowhere.toml", "a.xml"], "nowhere.toml: no such robot file"),
        (["mjcf", "matched", "nowhere/a.xml"], "nowhere/a.xml: cannot be written"),
        (["mjcf", "matched", "a.toml"], "a.toml: a MuJoCo model is named .xml"),
        (["mjcf", "light.toml", "a.xml"], "MuJoCo cannot build it"),
        (["mjcf", "gain.toml", "a.xml"], "Robot.turning_gain = 0.1"),
        (["show", "bad.toml"], "bad.toml: not a robot's TOML file"),
    ],
)
def test_bad_input_is_one_line(capsys, tmp_path, monkeypatch, arguments, words):
    monkeypatch.chdir(tmp_path)
    dd.Robot.load("matched").replace(tyres={"mass": 1e-20}).save("light.toml")
    dd.Robot.load("matched").replace(turning_gain=0.1).save("gain.toml")
    (tmp_path / "bad.toml").write_text("left_radius: 0.1")
    with pytest.raises(SystemExit) as raised:
        cli.main(["robots", *arguments])
    assert raised.value.code == 2
    streams = capsys.readouterr()
    assert streams.out == ""
    assert streams.err.startswith("diffdrive: ")
    assert streams.err.count("\n") == 1
    assert words in streams.err
    assert not list(tmp_path.glob("a.*"))


@pytest.mark.parametrize(
    ("arguments", "words"), [([], "list, show, new, mjcf"), (["mjcf"], "ROBOT"), (["sho"], "show")]
)
def test_a_command_line_that_makes_no_sense(capsys, arguments, words):
    with pytest.raises(SystemExit) as raised:
        cli.main(["robots", *arguments])
    assert raised.value.code == 2
    assert words in capsys.readouterr().err


def test_listing_needs_no_simulator():
    program = "import sys; from diffdrive_mj.cli import main; main(['robots', 'list']); print('mujoco' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "False"


@pytest.mark.parametrize("action", ["show", "mjcf"])
def test_the_help_says_which_arguments_must_be_given(capsys, action):
    with pytest.raises(SystemExit):
        cli.main(["robots", action, "--help"])
    words = " ".join(capsys.readouterr().out.split())
    assert re.search(r"ROBOT [^│]*\(required\)", words)


@pytest.mark.parametrize("verb", ["show", "mjcf"])
def test_the_help_says_that_a_robot_is_required(capsys, verb):
    with pytest.raises(SystemExit) as ended:
        printed(capsys, verb, "--help")
    assert ended.value.code == 0
    assert re.search(r"ROBOT\s.*\(required\)", capsys.readouterr().out)


def test_a_robot_of_ones_own_is_written_and_never_over_another_file(capsys, tmp_path):
    path = tmp_path / "mine.toml"
    options = (
        "--left-radius",
        0.033,
        "--track-width",
        0.16,
        "--ticks-per-revolution",
        600,
        "--gear",
        2,
        "--body-mass",
        3,
    )
    assert printed(capsys, "new", path, *options) == f"written: {path}\n"
    robot = dd.Robot.load(path)
    assert (robot.name, robot.left_radius, robot.right_radius, robot.track_width) == ("mine", 0.033, 0.033, 0.16)
    assert (robot.encoder.ticks_per_wheel_turn, robot.body_mass) == (1200, 3)
    with pytest.raises(SystemExit) as ended:
        printed(capsys, "new", path, "--left-radius", 0.05, "--track-width", 0.3)
    assert ended.value.code == 2
    assert "is there already and is not overwritten" in capsys.readouterr().err
    assert dd.Robot.load(path) == robot
    printed(capsys, "new", tmp_path / "plain.toml", "--left-radius", 0.05, "--right-radius", 0.04, "--track-width", 0.3)
    assert dd.Robot.load(tmp_path / "plain.toml").radius_ratio == pytest.approx(0.8)
