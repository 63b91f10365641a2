"""Studies as TOML files: read back equal, names looked up beside the file, each error one line that names the file."""

import tomllib

import numpy as np
import pytest
from helpers import refused
from hypothesis import given
from hypothesis import strategies as st
from strategies import laden_robots, numbers, sizes
from test_world_file import worlds

import diffdrive_mj as dd
from diffdrive_mj.sweeps import Study
from diffdrive_mj.sweeps.studies import presets

spreads = st.fixed_dictionaries(
    {},
    optional={
        "believed.track_width": st.fixed_dictionaries(
            {"distribution": st.just("normal"), "mean": numbers(0.2, 0.3), "sigma": sizes(1e-6, 1e-3)}
        ),
        "world.friction": st.fixed_dictionaries(
            {"distribution": st.just("lognormal"), "median": sizes(0.01, 1.0), "sigma": sizes(1e-3, 1.0)}
        ),
        "maneuver.speed": st.fixed_dictionaries(
            {"distribution": st.just("uniform"), "low": numbers(0.1, 0.2), "high": numbers(0.3, 0.4)}
        ),
        "robot.servo.gains": st.just({"distribution": "choice", "values": ["matched", "equal"], "weights": [1, 2.5]}),
        "encoder.swapped": st.just({"distribution": "grid", "values": [False, True]}),
    },
)
physics = st.sampled_from(["fast", "default", "sliding", "skidding", "mujoco_defaults"]) | st.builds(
    dd.Physics, timestep=sizes(1e-4, 1e-2), truth=st.just("engine"), friction_damping=st.none() | sizes(0.1, 1.0)
)
studies = st.fixed_dictionaries(
    {
        "robot": laden_robots,
        "maneuver": st.fixed_dictionaries({"name": st.just("square"), "side": sizes(0.5, 2.0)}),
        "vary": spreads,
        "trials": st.integers(1, 100).map(lambda half: 2 * half),
        "encoder": st.fixed_dictionaries(
            {}, optional={"latency": numbers(0.0, 0.01), "counter_bits": st.sampled_from([16, 32])}
        ),
    },
    optional={
        "name": st.text(max_size=20),
        "seed": st.integers(0, 2**63 - 1),
        "design": st.sampled_from(["random", "sobol"]),
        "figures": st.lists(st.sampled_from(["final_heading", "distance"]), max_size=2),
        "world": worlds,
        "physics": physics,
        "truth": st.sampled_from(["physics", "kinematics"]),
        "gyro": st.none() | st.fixed_dictionaries({}, optional={"bias": numbers(-0.1, 0.1), "range": sizes(1.0, 10.0)}),
        "sample_rate": sizes(1.0, 1e3),
    },
).map(lambda fields: Study(**fields))


@given(studies)
def test_a_study_is_read_back_as_it_was(tmp_path_factory, study):
    path = tmp_path_factory.mktemp("studies") / "mine.toml"
    study.save(path)
    again = Study.load(path)
    assert again.to_toml() == study.to_toml() == path.read_text(encoding="utf-8")
    for name in Study.__dataclass_fields__:
        assert getattr(again, name) == getattr(study, name)
    assert again.trial(1).robot == study.trial(1).robot
    assert again.replace(seed=study.seed + 1) != study


@pytest.mark.parametrize("name", presets())
def test_a_preset_is_what_its_file_says_and_nothing_is_left_out(name):
    study = Study.load(name)
    assert study.name == name
    written = tomllib.loads(study.to_toml())
    assert set(Study.__dataclass_fields__) - set(written) <= {"gyro", "encoder"}
    assert not study.trials_between(0, study.trials)[1]


HEAD = 'trials = 4\nrobot = "ct_bot"\n[maneuver]\nname = "spin"\n'


def load(tmp_path, text):
    (tmp_path / "mine.toml").write_text(text)
    return Study.load(tmp_path / "mine.toml")


def test_names_may_be_quoted_dotted_or_tables(tmp_path):
    spread = 'distribution = "normal"\nmean = 0.1\nsigma = 0.001\n'
    inline = spread.strip().replace("\n", ", ")
    quoted = load(tmp_path, f'{HEAD}[vary]\n"robot.track_width" = {{ {inline} }}\n')
    assert quoted == load(tmp_path, f"{HEAD}[vary]\nrobot.track_width = {{ {inline} }}\n")
    assert quoted == load(tmp_path, f"{HEAD}[vary.robot.track_width]\n{spread}")


def test_robots_and_worlds_are_presets_tables_or_files_beside_the_study(tmp_path, monkeypatch):
    folder = tmp_path / "floors"
    folder.mkdir()
    robot, world = dd.Robot.load("ct_bot").replace(name="own"), dd.World(name="own", friction=0.5)
    robot.save(tmp_path / "own.toml")
    world.save(folder / "own.toml")
    monkeypatch.chdir(folder)  # a path is relative to the study's file, wherever one is
    vary = "\n[vary]\n"
    study = load(
        tmp_path, HEAD.replace("ct_bot", "own.toml").replace("trials", 'world = "floors/own.toml"\ntrials') + vary
    )
    assert (study.robot, study.world) == (robot, world)
    tables = HEAD.replace('robot = "ct_bot"\n', "") + vary + "[robot]\nleft_radius = 0.1\nright_radius = 0.1\n"
    study = load(tmp_path, tables + "track_width = 0.4\n[robot.tyres]\nwidth = 0.01\n[world.slope]\nangle = 0.01\n")
    assert study.robot.tyres.width == 0.01
    assert study.world.slope.angle == 0.01
    # An encoder is the robot's own where nothing else is said.
    assert load(tmp_path, HEAD + "[encoder]\n[vary]\n").encoder == dd.Encoder(dd.Robot.load("ct_bot"))


VARY = "[vary]\n"
BAD = {
    "no study": ("", ValueError, "maneuver, vary, robot missing"),
    "no TOML": ("trials = = 4", ValueError, "not a study's TOML file"),
    "unknown key": (
        "trial = 4\n" + HEAD + VARY,
        KeyError,
        "unknown key in mine.toml 'trial'",
        "did you mean 'trials'?",
    ),
    "unknown key of the robot": (
        HEAD.replace('robot = "ct_bot"\n', "") + VARY + "[robot]\nradius = 0.1\n",
        KeyError,
        "unknown key in mine.toml [robot] 'radius'",
    ),
    "unknown preset": (HEAD.replace("ct_bot", "ct_bott") + VARY, KeyError, "unknown preset in mine.toml 'ct_bott'"),
    "unknown maneuver": (HEAD.replace("spin", "spinn") + VARY, KeyError, "unknown maneuver in mine.toml 'spinn'"),
    "unknown name": (
        HEAD + VARY + 'robot.track = { distribution = "normal", mean = 0.1, sigma = 0.01 }',
        KeyError,
        "unknown name of what varies in mine.toml 'robot.track'",
    ),
    "unknown distribution": (
        HEAD + VARY + 'robot.track_width = { distribution = "gauss" }',
        KeyError,
        "in mine.toml 'gauss'",
    ),
    "no distribution": (
        HEAD + VARY + "robot.track_width = 0.1",
        TypeError,
        "mine.toml: Study.vary['robot.track_width'] = 0.1",
    ),
    "a field missing": (
        HEAD + VARY + 'robot.track_width = { distribution = "normal", mean = 0.1 }',
        TypeError,
        "mine.toml: ",
        "sigma missing",
    ),
    "out of range": (
        HEAD + VARY + 'robot.track_width = { distribution = "normal", mean = 0.1, sigma = -1 }',
        ValueError,
        "mine.toml: Normal.sigma = -1: must be positive",
    ),
    "no such robot": (
        HEAD.replace("ct_bot", "ct_bot.toml") + VARY,
        FileNotFoundError,
        "ct_bot.toml: no such robot file",
    ),
    "a word for a number": (
        "trials = 'many'\n" + HEAD.replace("trials = 4\n", "") + VARY,
        TypeError,
        "mine.toml: Study.trials",
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_what_is_wrong_with_a_file_names_the_file(tmp_path, name):
    text, kind, *words = BAD[name]
    with refused(kind, *words):
        load(tmp_path, text)


def test_what_is_no_file_of_a_study(tmp_path):
    with refused(KeyError, "unknown preset 'sqares'", "did you mean 'squares'?"):
        Study.load("sqares")
    with refused(FileNotFoundError, "nowhere.toml: no such study file"):
        Study.load(tmp_path / "nowhere.toml")
    with refused(TypeError, "study = 3: must be a preset's name or a path"):
        Study.load(3)
    with refused(ValueError, "a study's file is named .toml"):
        Study.load("squares").save(tmp_path / "study.txt")


def test_a_distribution_of_ones_own_is_driven_but_has_no_file():
    class Measured:
        def at(self, share):
            return np.quantile([0.0329, 0.0330, 0.0332], share)

    study = Study.load("squares").replace(vary={"robot.mean_radius": Measured()}, trials=50)
    radii = [trial.robot.mean_radius for trial in study.trials_between(0, 50)[0]]
    assert 0.0329 <= min(radii) < max(radii) <= 0.0332
    with refused(TypeError, "a Measured has no name in a file"):
        study.to_toml()


@pytest.mark.parametrize("damping", [None, 0.9])
def test_a_physics_of_ones_own_is_a_table(tmp_path, damping):
    own = dd.Physics(timestep=0.001, truth="engine", friction_damping=damping)
    study = Study.load("squares").replace(physics=own)
    study.save(tmp_path / "mine.toml")
    assert "\n[physics]\ntimestep = 0.001\n" in study.to_toml()
    assert Study.load(tmp_path / "mine.toml").physics == own
