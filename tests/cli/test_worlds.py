"""`diffdrive worlds`: what it prints is what the worlds are, and what it writes is one."""

import subprocess
import sys

import pytest

import diffdrive_mj as dd
from diffdrive_mj import cli
from diffdrive_mj.world import presets


def printed(capsys, *arguments):
    cli.main(["worlds", *map(str, arguments)])
    return capsys.readouterr().out


def refusal(capsys, *arguments):
    with pytest.raises(SystemExit) as ended:
        cli.main(["worlds", *map(str, arguments)])
    assert ended.value.code == 2
    streams = capsys.readouterr()
    assert streams.out == ""
    assert streams.err.count("\n") == 1
    return streams.err


def test_every_preset_has_a_line_with_its_numbers(capsys):
    header, *lines = printed(capsys, "list").splitlines()
    assert header.split() == ["preset", "friction", "slope", "[rad]", "world"]
    assert [line.split()[0] for line in lines] == list(presets())
    for line in lines:
        world = dd.World.load(line.split()[0])
        friction, angle = map(float, line.split()[1:3])
        assert friction == world.friction
        assert angle == (world.slope.angle if world.slope else 0.0)
        assert len(line.split("  ")[-1]) > 10


@pytest.mark.parametrize("name", presets())
def test_a_world_is_shown_with_what_it_leaves_out(capsys, tmp_path, name):
    text = printed(capsys, "show", name)
    assert "gravity = 9.81" in text
    (tmp_path / "again.toml").write_text(text)
    assert dd.World.load(tmp_path / "again.toml") == dd.World.load(name)


def test_a_world_of_ones_own_is_written_and_never_over_another_file(capsys, tmp_path):
    path = tmp_path / "mine.toml"
    options = ("--friction", 0.6, "--slope", 0.02, "--direction", 1.5, "--gravity", 9.8)
    assert printed(capsys, "new", path, *options) == f"written: {path}\n"
    slope = dd.Slope(angle=0.02, direction=1.5)
    assert dd.World.load(path) == dd.World(name="mine", friction=0.6, slope=slope, gravity=9.8)
    assert "is there already and is not overwritten" in refusal(capsys, "new", path, "--friction", 0.5)
    printed(capsys, "new", tmp_path / "plain.toml", "--friction", 0.5)
    assert dd.World.load(tmp_path / "plain.toml") == dd.World(name="plain", friction=0.5)


def test_it_says_what_each_world_costs(capsys, tmp_path):
    (tmp_path / "cliff.toml").write_text("[slope]\nangle = 1.2\n")
    ideal, cliff = printed(capsys, "cost", "ct_bot", "--worlds", "ideal", tmp_path / "cliff.toml").splitlines()
    name, position, unit = ideal.split()[:3]
    assert (name, unit) == ("ideal", "ppm,")
    assert 0 < float(position) < 1
    assert "not driven: World.slope.angle = 1.2 rad: robot ct_bot would" in cliff


def test_bad_input_is_one_line(capsys, tmp_path):
    path = tmp_path / "mine.toml"
    assert "did you mean 'garden'" in refusal(capsys, "show", "gardn")
    assert "--slope must say how steeply" in refusal(capsys, "new", path, "--friction", 0.5, "--direction", 1)
    assert "World.friction = 0" in refusal(capsys, "new", path, "--friction", 0)
    assert "in degrees?" in refusal(capsys, "new", path, "--friction", 0.5, "--slope", 10)
    assert not path.exists()


def test_listing_needs_no_simulator():
    program = "import sys; from diffdrive_mj.cli import main; main(['worlds', 'list']); print('mujoco' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "False"
