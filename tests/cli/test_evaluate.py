"""`diffdrive simulate` writes logs, and `diffdrive evaluate` compares them: figures, bounds, exit status, refusals."""

import json
import sys
import warnings

import numpy as np
import pytest
from figure_checks import problems

import diffdrive_mj as dd
from diffdrive_mj import cli, logs
from diffdrive_mj.errors import PhysicsWarning
from diffdrive_mj.report.verdicts import evaluated


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A drive, and what a robot with too wide a track believes of it."""
    made = tmp_path_factory.mktemp("logs")
    true = dd.Robot.load("ct_bot")
    true.replace(track_width=1.02 * true.track_width).save(made / "believed.toml")
    cli.main(
        ["simulate", "square", str(made / "drive.csv"), "--robot", "ct_bot", "--tracker-rate", "10", "--odometry",
         str(made / "odom.tum"), "--believed", str(made / "believed.toml")]
    )  # fmt: skip
    return made


@pytest.fixture(autouse=True)
def there(folder, monkeypatch):
    monkeypatch.chdir(folder)


def ran(capsys, *arguments):
    """Exit status and what is printed."""
    with pytest.raises(SystemExit) as ended:
        cli.main([*map(str, arguments)])
    return ended.value.code, *capsys.readouterr()


def test_the_logs_are_those_of_the_drive(folder):
    robot = dd.Robot.load("ct_bot")
    drive = logs.read("drive.csv")
    assert np.diff(drive.t) == pytest.approx(0.02)
    assert np.diff(drive.clock) == pytest.approx(0.1)
    assert float(dd.metrics.drift(drive.truth, drive.truth).distance) == pytest.approx(16.0, rel=1e-3)
    ticks = drive.wheel_angles * robot.encoder.ticks_per_wheel_turn / (2 * np.pi)
    assert np.abs(ticks - np.round(ticks)).max() < 1e-6
    believed = logs.read_poses("odom.tum")
    assert believed.poses == pytest.approx(drive.odometry(dd.Robot.load("believed.toml")), abs=1e-6)


def test_noise_friction_and_seed_reach_the_drive(folder):
    options = ["simulate", "spin", "one.csv", "--robot", "ct_bot"]
    found = {}
    for name, more in (
        ("plain", ()), ("again", ()), ("seed", ("--seed", "1")), ("headings", ("--heading-noise", "0.05")),
        ("positions", ("--position-noise", "0.05")), ("slippery", ("--friction", "1e-4")), ("rate", ("--rate", "20")),
    ):  # fmt: skip
        with warnings.catch_warnings(action="ignore", category=PhysicsWarning):
            cli.main([*options, *more])
        found[name] = logs.read("one.csv")
    plain = found["plain"]
    assert np.array_equal(found["again"].wheel_angles, plain.wheel_angles)
    assert not np.array_equal(found["seed"].wheel_angles, plain.wheel_angles)
    off = {name: (found[name].truth - plain.truth).std(axis=0) for name in ("headings", "positions")}
    assert off["headings"] == pytest.approx([0, 0, 0.05], abs=0.003)
    assert off["positions"] == pytest.approx([0.05, 0.05, 0], abs=0.003)
    assert np.abs(found["slippery"].truth[-1, 2] - plain.truth[-1, 2]) > 0.1
    assert np.diff(found["rate"].t) == pytest.approx(0.05)


def test_the_figures_are_those_of_the_library(capsys):
    status, out, _ = ran(capsys, "evaluate", "odom.tum", "--truth", "drive.csv", "--json")
    assert status == 0
    found = json.loads(out)
    same = dd.evaluate(logs.read_poses("drive.csv"), logs.read_poses("odom.tum"))
    assert found["max_position_error_m"] == pytest.approx(float(same.drift.max_position))
    assert found["ate_rmse_m"] == pytest.approx(float(same.ate.rmse))
    assert found["rpe_rmse_m"] == pytest.approx(float(same.rpe.rmse))
    assert found["max_position_error_m"] > 0.2  # 2 % of a track are 1.8 degrees at each corner
    assert found["pictures"] == ["results/evaluate/path.png"]


def test_in_words_the_figures_come_first_then_what_is_broken_then_the_picture(capsys, folder):
    arguments = ("evaluate", "odom.tum", "--truth", "drive.csv", "--position", "0.001")
    status, out, err = ran(capsys, *arguments)
    same = dd.evaluate(logs.read_poses("drive.csv"), logs.read_poses("odom.tum"))
    assert (status, err) == (1, "")
    *figures, broken, written = out.splitlines()
    assert "\n".join(figures) == str(same)
    assert broken.startswith("position off by ")
    assert written == "written: results/evaluate/path.png"
    assert (folder / "results" / "evaluate" / "path.png").read_bytes().startswith(b"\x89PNG")
    assert ran(capsys, *arguments, "--no-pictures")[1] == "\n".join([*figures, broken, ""])


@pytest.mark.parametrize(("option", "figure"), [
    ("--position", "max_position_error_m"), ("--heading", "max_heading_error_rad"),
    ("--position-per-metre", "max_position_error_per_metre"),
])  # fmt: skip
def test_a_bound_holds_or_is_broken(capsys, option, figure):
    arguments = ("evaluate", "odom.tum", "--truth", "drive.csv", "--no-pictures", "--json")
    value = abs(json.loads(ran(capsys, *arguments)[1])[figure])
    for factor, status in ((1.01, 0), (0.99, 1)):
        found = ran(capsys, *arguments, option, factor * value)
        assert found[0] == status
        assert json.loads(found[1])["holds"] == (status == 0)


def test_markdown_is_a_table_for_a_comment(capsys):
    arguments = ("evaluate", "odom.tum", "--truth", "drive.csv", "--no-pictures", "--markdown", "--position", "0.001")
    status, out, _ = ran(capsys, *arguments)
    assert status == 1
    assert out.startswith("### odom.tum: ")
    assert "| --- | --- |" in out
    assert out.splitlines()[-1].endswith("more than 1.00 mm")


def test_the_picture_is_legible():
    found = dd.evaluate(logs.read_poses("drive.csv"), logs.read_poses("odom.tum"))
    (picture,) = evaluated(found).pictures.values()
    assert problems(picture) == []
    assert "mm off in 16" in picture.get_suptitle()


def test_the_results_say_what_was_typed_and_which_bound_is_broken(capsys, folder, monkeypatch):
    monkeypatch.setattr("sys.argv", ["somebody's own program", "with its own options"])
    status, _, _ = ran(capsys, "evaluate", "odom.tum", "--truth", "drive.csv", "--position", "0.001")
    content = json.loads((folder / "results" / "evaluate" / "metrics.json").read_text())
    assert content["provenance"]["command"] == "diffdrive evaluate odom.tum --truth drive.csv --position 0.001"
    assert (status, [(bound["name"], bound["holds"]) for bound in content["bounds"]]) == (
        1,
        [("position off by", False)],
    )
    assert sys.argv == ["somebody's own program", "with its own options"]


def test_columns_of_other_names_and_topics(capsys):
    drive = logs.read("drive.csv")
    rows = np.column_stack([drive.clock, drive.odometry(dd.Robot.load("ct_bot"))])
    text = "stamp,px,py,yaw\n" + "".join(",".join(map(repr, row)) + "\n" for row in rows.tolist())
    with open("own.csv", "w") as file:
        file.write(text)
    logs.write("own.mcap", dd.PoseLog(rows[:, 0], rows[:, 1:]), logs.Topics(poses="/odom"))
    found = [
        json.loads(ran(capsys, "evaluate", log, "--truth", "drive.csv", "--no-pictures", "--json", *options)[1])
        for log, *options in (
            ("own.csv", "--columns", "stamp,px,py,yaw"), ("own.csv", "--columns", "1,2,3,4"),
            ("own.mcap", "--topic", "/odom"),
        )
    ]  # fmt: skip
    assert found[0]["max_position_error_m"] == found[1]["max_position_error_m"]
    assert found[2]["max_position_error_m"] == pytest.approx(found[0]["max_position_error_m"], rel=1e-9)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("evaluate", "odom.tum"), "--truth"),
        (("evaluate", "nowhere.tum", "--truth", "drive.csv"), "nowhere.tum: no such file"),
        (("evaluate", "odom.tum", "--truth", "drive.csv", "--position", "-1"), "position = -1.0: must be positive"),
        (("evaluate", "odom.tum", "--truth", "drive.csv", "--stretch", "0"), "stretch = 0.0"),
        (
            ("evaluate", "odom.tum", "--truth", "drive.csv", "--truth-columns", "a,b"),
            "--truth-columns a,b: must be four",
        ),
        (
            ("evaluate", "odom.tum", "--truth", "drive.csv", "--topic", "/a", "--columns", "1,2,3,4"),
            "must be one of them",
        ),
        (("evaluate", "odom.tum", "--truth", "drive.csv", "--offset", "1e6"), "spans"),
        (("evaluate", "odom.tum", "--truth", "drive.csv", "--align", "sim3"), "sim3"),
        (("evaluate", "odom.tum", "--truth", "drive.csv", "--json", "--markdown"), "must be one of them"),
        (("simulate", "squar", "new.csv", "--robot", "ct_bot"), "unknown maneuver 'squar'"),
        (("simulate", "square", "new.csv", "--robot", "ct_bolt"), "unknown preset 'ct_bolt'"),
        (("simulate", "square", "new.csv", "--robot", "ct_bot", "--rate", "0"), "rate = 0.0: must be positive"),
        (("simulate", "square", "new.csv", "--robot", "ct_bot", "--position-noise", "-1"), "position_noise"),
        (("simulate", "square", "new.csv", "--robot", "ct_bot", "--friction", "-1"), "friction"),
        (("simulate", "square", "new.csv", "--robot", "ct_bot", "--seed", "-1"), "seed = -1"),
        (("simulate", "square", "new.csv", "--robot", "ct_bot", "--believed", "ct_bot"), "--odometry must say where"),
        (("simulate", "square", "new.xls", "--robot", "ct_bot"), "new.xls"),
        (("simulate", "square", "new.csv", "--robot", "ct_bot", "--tracker-rate", "0"), "sample_rate = 0.0"),
        (("simulate", "square", "new.csv", "--robot", "ct_bot", "--odometry", "./new.csv"), "must be another file"),
        (("simulate", "square", "new.csv", "--robot", "ct_bot", "--odometry", "new.xls"), "unknown ending '.xls'"),
        (("simulate", "square", "new.csv", "--robot", "ct_bot", "--odometry", "no/such/new.tum"), "cannot be written"),
        (("simulate", "square", "no/such/new.csv", "--robot", "ct_bot"), "cannot be written"),
    ],
)
def test_bad_input_is_one_line(capsys, folder, arguments, said):
    before = sorted(folder.iterdir())
    status, out, err = ran(capsys, *arguments)
    assert (status, out) == (2, "")
    assert said in err
    assert err.count("\n") == 1
    assert sorted(folder.iterdir()) == before


def test_json_is_indented_by_one(capsys):
    out = ran(capsys, "evaluate", "odom.tum", "--truth", "drive.csv", "--json", "--no-pictures")[1]
    assert out == json.dumps(json.loads(out), indent=1) + "\n"
