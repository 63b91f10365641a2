"""Studies: what varies ends where its name says, nothing else does, and a wrong belief always shows."""

import dataclasses
import pickle

import numpy as np
import pytest
from helpers import refused
from hypothesis import given
from hypothesis import strategies as st
from strategies import numbers, robots

import diffdrive_mj as dd
from diffdrive_mj.maneuvers import BY_NAME
from diffdrive_mj.sweeps import Choice, Grid, Maneuver, Normal, Study, Uniform, _varied

ROBOT = dd.Robot.load("turtlebot3_burger").replace(right_radius=0.0331)
SPIN = Maneuver("spin", {"turns": 1.0})
WORLD = dd.World(
    slope={"angle": 0.01, "direction": 0.5}, rough={"x": (-1, 3), "y": (-1, 1), "rms": 2e-3, "wavelength": 0.4}
)


def study(vary=None, **fields):
    return Study(
        **{"robot": ROBOT, "maneuver": SPIN, "vary": vary or {}, "trials": 12, "truth": "kinematics", **fields}
    )


FULL = study(world=WORLD, encoder={"latency": 0.001}, gyro={"bias": 0.001}, maneuver={"name": "square", "side": 1.0})


def reached(trial, path):
    """What stands in a trial under a name."""
    value = trial
    for part in path.split("."):
        value = getattr(value, part)
    return value


def numbers_that_vary():
    """The names of numbers, beside their values as designed."""
    for name in _varied.names(FULL._owners):
        # A wheelbase makes another kind of robot, without a caster.
        if not name.startswith(("maneuver", "robot.skid_steer")):
            value = reached(FULL.trial(0), name)
            if isinstance(value, float):
                yield pytest.param(name, value, id=name)


@pytest.mark.parametrize(("name", "value"), list(numbers_that_vary()))
def test_a_number_varies_where_its_name_says_and_nowhere_else(name, value):
    other = value * 1.01 if value else 0.001
    first, second = FULL.replace(vary={name: Grid(values=(value, other))}).trials_between(0, 2)[0]
    assert reached(second, name) == pytest.approx(other, rel=1e-15)
    assert reached(first, name) == pytest.approx(value, rel=1e-15)
    owner = name.split(".")[0]
    for part in ("robot", "believed", "world", "encoder", "gyro"):
        assert (getattr(first, part) != getattr(second, part)) == (part == owner)
    assert (first.commands is second.commands) == (owner != "believed")


def test_what_stays_of_a_slope_is_what_it_was():
    slope = FULL.replace(vary={"world.slope.angle": Uniform(low=0.02, high=0.03)}).trial(3).world.slope
    assert 0.02 < slope.angle < 0.03
    assert slope.direction == 0.5
    level = study({"world.slope.angle": Uniform(low=0.02, high=0.03)}).trial(3).world
    assert 0.02 < level.slope.angle < 0.03


@given(robots, numbers(0.9, 1.1), numbers(0.9, 1.1), st.sampled_from(["robot", "believed"]))
def test_mean_and_ratio_of_the_radii_are_causes_apart(robot, mean, ratio, owner):
    base = study(robot=robot)

    def radii(**factors):
        vary = {f"{owner}.{name}": Grid(values=(getattr(robot, name) * by,)) for name, by in factors.items()}
        return getattr(base.replace(vary=vary).trial(0), owner)

    for factors in ({"mean_radius": mean}, {"radius_ratio": ratio}, {"mean_radius": mean, "radius_ratio": ratio}):
        found = radii(**factors)
        for name in ("mean_radius", "radius_ratio"):
            assert getattr(found, name) == pytest.approx(getattr(robot, name) * factors.get(name, 1.0), rel=1e-14)


@pytest.mark.parametrize("name", BY_NAME)
def test_a_maneuver_varies_in_its_own_options(name):
    speed = "yaw_rate" if name == "spin" else "speed"
    drives = study({f"maneuver.{speed}": Grid(values=(0.2, 0.4))}, maneuver=Maneuver(name))
    slow, fast = (trial.commands for trial in drives.trials_between(0, 2)[0])
    assert np.abs(fast.wheel_rates).max() == pytest.approx(2 * np.abs(slow.wheel_rates).max(), rel=0.05)
    expected = BY_NAME[name](ROBOT, **{speed: 0.4})
    assert (fast.wheel_rates == expected.wheel_rates).all()


def ends(vary, **fields):
    """By how far the heading of the first trial is off at the end [rad], which a full turn of the belief is to end."""
    return dd.sweep(study(vary, trials=1, **fields)).figures["final_heading"][0]


@given(numbers(-0.05, 0.05))
def test_a_wrong_track_shows_by_the_closed_form(part):
    # The wheels roll T b' / 2 each, which turns a robot of track b by T b' / b.
    wrong, turn = Grid(values=(ROBOT.track_width * (1 + part),)), 2 * np.pi
    even = ROBOT.replace(right_radius=ROBOT.left_radius)
    assert ends({"believed.track_width": wrong}, robot=even) == pytest.approx(-turn * part, abs=1e-9)
    assert ends({"robot.track_width": wrong}, robot=even) == pytest.approx(turn - turn / (1 + part), abs=1e-9)
    assert ends({"robot.track_width": wrong, "believed.track_width": wrong}, robot=even) == pytest.approx(0, abs=1e-9)


@given(numbers(-0.05, 0.05), numbers(-0.01, 0.01))
def test_odometry_believes_in_the_gyro_as_designed(scale, bias):
    vary = {"gyro.scale_error": Grid(values=(scale,)), "gyro.bias": Grid(values=(bias + 0.001,))}
    wrong_track = {"robot.track_width": Grid(values=(ROBOT.track_width * 1.02,))}
    fields = {"gyro": {"bias": 0.001}, "robot": ROBOT.replace(right_radius=ROBOT.left_radius)}
    duration = SPIN.commands(ROBOT).duration
    turn = 2 * np.pi / 1.02  # the gyro sees it, the wheels do not
    assert ends({**vary, **wrong_track}, **fields) == pytest.approx(turn * scale + bias * duration, abs=1e-3)
    assert ends(wrong_track, **fields) == pytest.approx(0, abs=1e-3)


def test_what_cannot_be_is_counted_and_never_clipped():
    masses = Normal(mean=1.0, sigma=1.0)
    trials = dd.sweep(study({"robot.body_mass": masses}, trials=200), chunk=64)
    drawn = trials.drawn["robot.body_mass"]
    assert (drawn <= 0).any()
    assert ((trials.outcome == "refused") == (drawn <= 0)).all()
    assert np.isnan(trials.figures["final_heading"][drawn <= 0]).all()
    assert all("Robot.body_mass = -" in why for why in trials.why[drawn <= 0])
    heavy = study({"robot.body_mass": masses}, trials=200)
    bad = int(np.flatnonzero(drawn <= 0)[0])
    with refused(ValueError, "Robot.body_mass = -"):
        heavy.trial(bad)


@given(st.sampled_from(["random", "sobol", "saltelli"]), st.integers(0, 23), st.integers(1, 24))
def test_a_trial_is_the_same_alone_and_among_others(design, first, count):
    vary = {"robot.mean_radius": Normal(mean=0.033, sigma=1e-4), "world.friction": Uniform(low=0.5, high=1.0)}
    several = study(vary, trials=24, design=design)
    last = min(first + count, 24)
    together, refusals = several.trials_between(first, last)
    assert not refusals
    alone = [several.trial(index) for index in range(first, last)]
    for one, other in zip(together, alone, strict=True):
        assert (one.commands.wheel_rates == other.commands.wheel_rates).all()
        assert dataclasses.replace(one, commands=None) == dataclasses.replace(other, commands=None)


def test_two_studies_are_equal_where_their_trials_are():
    spreads = {
        "robot.track_width": Normal(mean=0.16, sigma=0.001),
        "robot.axle": Choice(values=("independent", "rigid")),
    }
    one, other = study(spreads), study(dict(reversed(spreads.items())))
    assert one == other
    assert hash(one) == hash(other)
    assert pickle.loads(pickle.dumps(one)) == one
    assert one != one.replace(seed=1)
    # Of a robot whose mass was not given the mass scales with the radii.
    scaling = dd.Robot(left_radius=0.033, right_radius=0.033, track_width=0.16)
    fixed = dd.Robot(**{**dataclasses.asdict(scaling)})
    assert fixed == scaling
    assert study(spreads, robot=fixed) != study(spreads, robot=scaling)


def test_tolerances_become_spreads():
    robot = ROBOT.replace(tolerances={"radius": 0.002, "radius_ratio": 0.0, "track_width": 0.01})
    made = Study.of_tolerances(robot, SPIN, trials=10, truth="kinematics")
    assert made.vary == {
        "robot.mean_radius": Normal(mean=robot.mean_radius, sigma=0.002 * robot.mean_radius),
        "robot.track_width": Normal(mean=robot.track_width, sigma=0.01 * robot.track_width),
    }
    known = robot.replace(tolerances={"radius": 0, "radius_ratio": 0, "track_width": 0})
    with refused(ValueError, "Robot.tolerances: all are zero"):
        Study.of_tolerances(known, SPIN)


def test_a_longer_study_continues_a_shorter_one():
    spreads = {"robot.track_width": Normal(mean=0.16, sigma=0.001)}
    short = study(spreads)
    assert short.replace(trials=24).continues(short)
    assert short.continues(short)
    assert not short.continues(short.replace(trials=24))
    assert not short.replace(trials=24, seed=1).continues(short)
    blocks = short.replace(design="saltelli")
    assert blocks.continues(blocks)
    assert not blocks.replace(trials=24).continues(blocks)
    assert blocks.blocks.tolist() == np.arange(12).reshape(3, 4).tolist()
    with refused(ValueError, "must be 'saltelli'"):
        _ = short.blocks


def test_equal_maneuvers_read_alike():
    spellings = [
        {"name": "square", "speed": 1, "side": 2.0},
        Maneuver("square", {"side": np.float64(2), "speed": np.int64(1)}),
        Maneuver("square", {"speed": 1.0, "side": 2}),
    ]
    assert len({study(maneuver=spelling) for spelling in spellings}) == 1
    assert study(maneuver="square") == study(maneuver=Maneuver("square"))


TRACK = Normal(mean=0.16, sigma=0.001)
BAD = {
    "unknown field": ({"vary": {"robot.track_widht": TRACK}}, KeyError, "did you mean 'robot.track_width'?"),
    "unknown owner": (
        {"vary": {"robt.track_width": TRACK}},
        KeyError,
        "did you mean 'robot'?",
    ),
    "owner that never varies": ({"vary": {"physics.timestep": TRACK}}, KeyError, "owner of what varies 'physics'"),
    "no owner": ({"vary": {"track_width": TRACK}}, KeyError, "choose from believed.track_width, robot.track_width"),
    "what odometry does not read": ({"vary": {"believed.tyres.width": TRACK}}, KeyError, "unknown name"),
    "no option of the maneuver": ({"vary": {"maneuver.side": TRACK}}, KeyError, "did you mean"),
    "no encoder": ({"vary": {"encoder.latency": TRACK}}, ValueError, "the study has no encoder"),
    "no gyro": ({"vary": {"gyro.bias": TRACK}}, ValueError, "the study has no gyro"),
    "a number for a word": ({"vary": {"robot.servo.law": TRACK}}, KeyError, "unknown Servo.law 0.16"),
    "a word for a number": (
        {"vary": {"robot.track_width": Choice(values=("wide",))}},
        TypeError,
        "Robot.track_width = 'wide': must be a number",
    ),
    "a word that is none": (
        {"vary": {"robot.servo.law": Choice(values=("PI", "PD"))}},
        KeyError,
        "unknown Servo.law 'PD'",
    ),
    "millimetres": (
        {"vary": {"robot.left_radius": Normal(mean=33.0, sigma=0.1)}},
        ValueError,
        "in millimetres? then 0.033",
    ),
    "radii twice": (
        {"vary": {"robot.left_radius": TRACK, "robot.mean_radius": TRACK}},
        ValueError,
        "the two radii, or their mean",
    ),
    "a listed value that cannot be": (
        {"vary": {"world.friction": Grid(values=(0.5, -0.5))}},
        ValueError,
        "World.friction = -0.5: must be positive",
    ),
    "no distribution": ({"vary": {"robot.track_width": 0.16}}, TypeError, "must be a distribution of dd.sweeps"),
    "no mapping": ({"vary": ["robot.track_width"]}, TypeError, "must be a mapping"),
    "half a grid": (
        {"vary": {"world.friction": Grid(values=(0.5, 0.6, 0.7, 0.8, 0.9))}},
        ValueError,
        "multiple of the 5",
        "10 or 15",
    ),
    "half a row": ({"vary": {"robot.track_width": TRACK}, "design": "saltelli", "trials": 2}, ValueError, "such as 3"),
    "a grid in blocks": (
        {"vary": {"world.friction": Grid(values=(0.5,))}, "design": "saltelli"},
        ValueError,
        "no Grid",
    ),
    "another design": ({"design": "lhs"}, KeyError, "unknown Study.design 'lhs'"),
    "another figure": ({"figures": ("final_postion",)}, KeyError, "did you mean 'final_position'?"),
    "a maneuver that cannot be": (
        {"maneuver": {"name": "spin", "yaw_rate": -1}},
        ValueError,
        "yaw_rate = -1.0: must be positive",
    ),
    "another maneuver": ({"maneuver": {"name": "circle"}}, KeyError, "unknown maneuver 'circle'"),
    "a maneuver without a name": ({"maneuver": {"side": 1.0}}, TypeError, "name missing"),
    "another option": ({"maneuver": {"name": "spin", "side": 1.0}}, KeyError, "unknown option of spin 'side'"),
    "another physics": ({"physics": "quick"}, KeyError, "unknown physics 'quick'"),
    "a field that physics does not have": ({"physics": {"step": 0.1}}, KeyError, "unknown Physics field 'step'"),
    "a field that an encoder does not have": ({"encoder": {"ticks": 1}}, KeyError, "unknown Encoder field 'ticks'"),
    "a gyro and Euler": ({"gyro": {}, "method": "euler"}, ValueError, "must be 'arc' with a gyro"),
}


@pytest.mark.parametrize("name", BAD)
def test_what_cannot_be_studied(name):
    fields, kind, *words = BAD[name]
    with refused(kind, *words):
        study(**fields)


def test_trials_are_those_of_the_study():
    with refused(ValueError, "first = -1: must be at least 0"):
        study().drawn(-1, 2)
    for first, last in ((3, 3), (5, 13)):
        with refused(ValueError, f"trials {first} to {last}: must be some of the 12"):
            study().drawn(first, last)
