"""`diffdrive explain` prints the error budget of the robot that it is given."""

import json
import math
import time

import pytest
from PIL import Image

import diffdrive_mj as dd
from diffdrive_mj import cli
from diffdrive_mj.estimation.sensitivities import error_budget
from diffdrive_mj.judging.by_name import MANEUVERS
from diffdrive_mj.physics import simulation
from diffdrive_mj.robot import presets

OWN = dd.Robot(left_radius=0.0325, right_radius=0.0325, track_width=0.132, name="own")


def test_it_prints_the_budget_of_a_preset_or_a_file(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    OWN.save("own.toml")
    cli.main(["explain", "own.toml"])
    assert capsys.readouterr().out == f"{error_budget(OWN)}\n"
    cli.main(["explain", "ct_bot", "--tolerance", "0.02", "--rate", "20", "--latency", "0.1", "--speed", "0.2",
              "--yaw-rate", "2"])  # fmt: skip
    options = {"tolerance": 0.02, "rate": 20, "latency": 0.1, "speed": 0.2, "yaw_rate": 2}
    assert capsys.readouterr().out == f"{error_budget(dd.Robot.load('ct_bot'), **options)}\n"


def test_json_has_every_figure(capsys):
    cli.main(["explain", "matched", "--json"])
    read = json.loads(capsys.readouterr().out)
    assert read["robot"] == "matched"
    assert list(read["drives"]) == ["straight", "square", "spin", "arc"]
    figures = {(e["cause"], e["drive"]): (e["position_error_m"], e["heading_error_rad"]) for e in read["errors"]}
    assert len(figures) == 8 * 4
    assert figures["wheel radii, 1 %", "straight"] == pytest.approx((0.1, 0))
    assert figures["wheel radii, 1 %", "spin"] == pytest.approx((0, 0.06 * math.pi), abs=1e-12)
    assert read["errors"][0]["cause"] == "radius ratio, 1 %"


@pytest.fixture(autouse=True)
def somewhere_else(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def test_a_maneuver_is_driven_and_its_error_split(capsys):
    cli.main(["explain", "matched", "--maneuver", "spin", "--rate", "20", "--json", "--no-pictures"])
    read = json.loads(capsys.readouterr().out)
    parts = {row["cause"]: row["part"] for row in read["causes"]}
    # On the spot, 1 % of the radii turns by 1 % too much, and 1 % of the track by as much too little.
    assert parts["wheel radii"]["heading_rad"] == pytest.approx(0.06 * math.pi, rel=0.01)
    assert parts["track width"]["heading_rad"] == pytest.approx(-0.06 * math.pi, rel=0.02)
    assert sum(part["heading_rad"] for part in parts.values()) == pytest.approx(read["error"]["heading_rad"], abs=1e-9)


def test_a_maneuver_is_driven_in_the_world_that_is_asked_for(capsys, monkeypatch):
    asked = []
    simulate = simulation.simulate
    monkeypatch.setattr(
        simulation, "simulate", lambda *given, **named: asked.append(named["world"]) or simulate(*given, **named)
    )
    for options in ([], ["--world", "ideal"]):
        cli.main(["explain", "ct_bot", "--maneuver", "spin", "--no-pictures", *options])
    assert asked == [dd.World(), dd.World.load("ideal")]


def test_a_maneuver_prints_a_table_with_bars_the_largest_first(capsys):
    cli.main(["explain", "turtlebot3_burger", "--maneuver", "straight", "--speed", "0.2"])
    title, _, header, _, *rows = capsys.readouterr().out.splitlines()
    assert title.startswith("turtlebot3_burger: ")
    assert title.endswith("largest part: radius ratio")
    assert header.split()[0] == "cause"
    assert rows[0].startswith("radius ratio")
    assert rows[0].endswith(20 * "#")
    assert [row.split("  ")[0] for row in rows[-3:]] == [
        "all", "slip at the contacts", "written: results/explain/attribution.png"
    ]  # fmt: skip
    with Image.open("results/explain/attribution.png") as picture:
        assert picture.width >= 800


def test_the_picture_goes_where_it_is_told_to_or_nowhere(tmp_path, capsys):
    cli.main(["explain", "matched", "--maneuver", "spin", "--output", "elsewhere", "--json"])
    written = json.loads(capsys.readouterr().out)["pictures"]
    assert written == ["elsewhere/explain/attribution.png"]
    assert (tmp_path / written[0]).is_file()
    cli.main(["explain", "matched", "--maneuver", "spin", "--no-pictures"])
    assert "written" not in capsys.readouterr().out
    assert not (tmp_path / "results").exists()


def test_a_robots_own_tolerances_and_encoder_are_explained(tmp_path, capsys):
    """Of a spin, half a per cent of the radii and 2 % of the track turn the robot by as much; no ratio is wrong."""
    tolerances = {"radius": 0.005, "radius_ratio": 0.0, "track_width": 0.02}
    OWN.replace(tolerances=tolerances, encoder={"ticks_per_revolution": 20}).save("own.toml")
    arguments = ["explain", "own.toml", "--maneuver", "spin", "--json", "--no-pictures"]
    cli.main(arguments)
    parts = {row["cause"]: row["alone"]["heading_rad"] for row in json.loads(capsys.readouterr().out)["causes"]}
    turned = 6 * math.pi
    assert parts["wheel radii"] == pytest.approx(0.005 * turned, rel=1e-3)
    assert parts["track width"] == pytest.approx(turned / 1.02 - turned, rel=1e-3)
    assert "radius ratio" not in parts
    assert 0 < abs(parts["encoder ticks"]) <= 2 * OWN.left_radius / OWN.track_width * 2 * math.pi / 20
    cli.main([*arguments, "--tolerance", "0.01"])
    given = {row["cause"]: row["alone"]["heading_rad"] for row in json.loads(capsys.readouterr().out)["causes"]}
    assert given["wheel radii"] == pytest.approx(0.01 * turned, rel=1e-3)
    assert "radius ratio" in given
    cli.main(["explain", "own.toml"])
    budget = capsys.readouterr().out
    assert all(name in budget for name in ("wheel radii, 0.5 %", "radius ratio, 0 %", "track width, 2 %"))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["matched", "--maneuver", "squar"], "unknown maneuver 'squar'"),
        (["matched", "--maneuver", "spin", "--speed", "1"], "--speed: the maneuver spin has none"),
        (["matched", "--maneuver", "spin", "--tolerance", "-0.1"], "tolerance = -0.1: must be positive"),
        (["matched", "--maneuver", "square", "--rate", "0"], "rate = 0.0: must be positive"),
        (["matched", "--maneuver", "square", "--latency", "-1"], "latency = -1.0: must not be negative"),
        (["matched", "--world", "garden"], "--world garden: is driven in with --maneuver"),
        (["matched", "--maneuver", "square", "--world", "gardn"], "did you mean 'garden'"),
        (["nowhere"], "unknown preset 'nowhere'"),
        (["nowhere.toml"], "nowhere.toml: no such robot file"),
        ([], "ROBOT; see diffdrive explain --help"),
        (["matched", "ct_bot"], "ct_bot"),
        (["matched", "--tolerance", "0"], "tolerance = 0.0: must be positive"),
        (["matched", "--tolerance", "1%"], "'1%'"),
        (["matched", "--rate", "nan"], "rate = nan: must be finite"),
        (["matched", "--speed", "-1"], "speed = -1.0: must be positive"),
        (["matched", "--turns", "2"], "--turns"),
    ],
)
def test_bad_input_is_one_line(arguments, words, capsys):
    with pytest.raises(SystemExit) as raised:
        cli.main(["explain", *arguments])
    assert raised.value.code == 2
    streams = capsys.readouterr()
    assert streams.out == ""
    assert streams.err.startswith("diffdrive: ")
    assert streams.err.count("\n") == 1
    assert words in streams.err


def test_the_help_starts_with_an_example_that_runs(capsys):
    with pytest.raises(SystemExit):
        cli.main(["explain", "--help"])
    example = capsys.readouterr().out.split("\n\n")[2]
    assert example.startswith("diffdrive explain ")
    cli.main(example.split()[1:])
    assert "turtlebot3_burger" in capsys.readouterr().out


def test_json_has_a_line_for_each_figure(capsys):
    cli.main(["explain", "ct_bot", "--json"])
    lines = capsys.readouterr().out.splitlines()
    assert lines[:2] == ["{", ' "robot": "ct_bot",']
    assert lines[-1] == "}"


@pytest.mark.slow
@pytest.mark.parametrize("maneuver", MANEUVERS)
@pytest.mark.parametrize("preset", presets())
def test_any_preset_and_maneuver_is_explained_in_ten_seconds(preset, maneuver, capsys):
    begin = time.process_time()
    cli.main(["explain", preset, "--maneuver", maneuver])
    assert time.process_time() - begin < 10
    assert "written: results/explain/attribution.png" in capsys.readouterr().out
