"""What cannot be used is refused in one line by an error of the package's family, whatever function it is given to."""

import warnings
from pathlib import Path

import numpy as np
import pytest
from bad_calls import CALLS
from bad_files import COMMANDS, LOGS, RECORDINGS, ROBOTS, SIZES
from helpers import refused

import diffdrive_mj as dd
from diffdrive_mj import cli, maneuvers, metrics
from diffdrive_mj.errors import DiffdriveError


def driven():
    """Wheel angles and true poses of a robot that turns both ways and drives straight."""
    rates = np.repeat([(5.0, 5.0), (3.0, 5.0), (5.0, 5.0), (6.0, 4.0)], 40, axis=0)
    angles = np.vstack([(0.0, 0.0), np.cumsum(0.1 * rates, axis=0)])
    return angles, dd.odometry.integrate(angles, dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4))


LAB = "t,left,right,x,y,theta\n" + "".join(
    f"{0.1 * k},{a},{b},{x},{y},{theta}\n" for k, ((a, b), (x, y, theta)) in enumerate(zip(*driven(), strict=True))
)


def run(arguments):
    """A kind of bad command line."""
    return lambda: cli.main(arguments.split())


def read(function, name, content):
    """A kind of bad file, or of a folder of files."""

    def write_and_read():
        for path, text in content.items() if isinstance(content, dict) else [(name, content)]:
            file = Path(path if "." in path else f"{name}/{path}.csv")
            file.write_bytes(text if isinstance(text, bytes) else text.encode())
        function(name)

    return write_and_read


KINDS = {
    **{f"call: {kind}": row for kind, row in CALLS.items()},
    **{
        f"{what}: {kind}": (read(function, name, content), (ValueError, TypeError, OSError), words)
        for what, function, name, kinds in (
            ("log", dd.logs.read_csv, "log.csv", LOGS),
            ("robot", dd.Robot.load, "r.toml", ROBOTS),
            ("recording", dd.logs.read_optiodom, "folder", RECORDINGS),
        )
        for kind, (content, words) in kinds.items()
    },
    **{f"command: {kind}": (run(arguments), SystemExit, words) for kind, (arguments, words) in COMMANDS.items()},
}

ROBOT = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
HUGE = 10**400
ANGLES = np.zeros((3, 2))
POSES = np.zeros((3, 3))
DRIVE = dd.Drive([0.0, 1.0, 2.0], ANGLES, POSES)
RECORDING = dd.Recording(
    np.arange(3.0), ANGLES, POSES, ROBOT, dd.Commands(1.0, ANGLES), dd.World(), dd.Physics(), flow=ANGLES
)
SENSOR = dd.FlowSensor(x=0.1)
ENCODER = dd.Encoder(ticks_per_revolution=100, sample_rate=1.0)

OF_A_ROBOT = {
    "body_twist": lambda robot: dd.kinematics.body_twist((1.0, 2.0), robot),
    "wheel_rates": lambda robot: dd.kinematics.wheel_rates((1.0, 2.0), robot),
    "constraint_residuals": lambda robot: dd.kinematics.constraint_residuals((1.0, 0.0, 0.0), (1.0, 2.0), robot),
    "belief_matrix": lambda robot: dd.kinematics.belief_matrix(robot, ROBOT),
    "belief_matrix of the true": lambda robot: dd.kinematics.belief_matrix(ROBOT, robot),
    "integrate": lambda robot: dd.odometry.integrate(ANGLES, robot),
    "Odometer": dd.odometry.Odometer,
    "subdivide": lambda robot: dd.odometry.subdivide(ANGLES, robot),
    "straight": maneuvers.straight,
    "arc": maneuvers.arc,
    "spin": maneuvers.spin,
    "square": maneuvers.square,
    "figure_eight": maneuvers.figure_eight,
    "slalom": maneuvers.slalom,
    "sequence": lambda robot: maneuvers.sequence(robot, [[maneuvers.Segment(1.0, 0.0, 1.0)]]),
    "GoToPose": lambda robot: dd.GoToPose(robot, goal=(1.0, 0.0, 0.0)),
    "heading_per_tick": ENCODER.heading_per_tick,
    "distance_per_tick": ENCODER.distance_per_tick,
    "Recording.odometry": RECORDING.odometry,
    "Recording.drift": RECORDING.drift,
    "Drive.odometry": DRIVE.odometry,
    "Drive.drift": DRIVE.drift,
}


@pytest.mark.parametrize("function", OF_A_ROBOT.values(), ids=OF_A_ROBOT)
def test_anything_but_a_robot_is_refused(function):
    with refused(TypeError, "'matched': must be a Robot; Robot.load('matched') gives that preset"):
        function("matched")
    for value, shown in ((None, "None"), (0.1, "0.1"), ([ROBOT], "a list"), (DRIVE, "a Drive"), (dd.Robot, "a type")):
        with refused(TypeError, f" = {shown}: must be a Robot"):
            function(value)


OF_AN_ARRAY = {
    "wrap_angle": dd.se2.wrap_angle,
    "rotate": lambda value: dd.se2.rotate(value, 0.0),
    "compose": lambda value: dd.se2.compose(value, (0.0, 0.0, 0.0)),
    "exp": dd.se2.exp,
    "log": dd.se2.log,
    "body_twist": lambda value: dd.kinematics.body_twist(value, ROBOT),
    "turning_share": lambda value: dd.kinematics.turning_share(value, 0.4),
    "integrate": lambda value: dd.odometry.integrate(value, ROBOT),
    "accumulate": dd.odometry.accumulate,
    "start": lambda value: dd.odometry.integrate(ANGLES, ROBOT, start=value),
    "drift": lambda value: metrics.drift(POSES, value),
    "ate": lambda value: metrics.ate(value, POSES),
    "rpe": lambda value: metrics.rpe(POSES, POSES, duration=1.0, t=value),
    "Commands": lambda value: dd.Commands(0.1, value),
    "constant_rates": lambda value: maneuvers.constant_rates(value, 1.0),
    "Drive": lambda value: dd.Drive([0.0, 1.0, 2.0], ANGLES, value),
    "angles_at": DRIVE.angles_at,
    "Patch": lambda value: dd.Patch(x=value, y=(0.0, 1.0), friction=0.1),
    "Push": lambda value: dd.Push(start=0.0, duration=1.0, acceleration=value),
    "displacement": SENSOR.displacement,
    "motion": SENSOR.motion,
    "counts": SENSOR.counts,
    "lever_arm": lambda value: dd.optical_flow.lever_arm(value, 1.0),
    "to_angles": ENCODER.to_angles,
    "Encoder.read": lambda value: ENCODER.read([0.0, 1.0, 2.0], value),
    "Tracker.read": lambda value: dd.Tracker().read([0.0, 1.0, 2.0], value),
    "Tracker.gaps": lambda value: dd.Tracker(gaps=[value]),
    "goal": lambda value: dd.GoToPose(ROBOT, goal=value),
}


@pytest.mark.parametrize("function", OF_AN_ARRAY.values(), ids=OF_AN_ARRAY)
def test_arrays_of_anything_but_finite_numbers_are_refused(function):
    struct = np.zeros(3, dtype=[("x", float)])
    for value in ("abc", ["1", "2", "3"], [1j, 2j, 3j], [True, False, True], struct, object(), [[1, 2], [3]]):
        with refused(TypeError, "must be an array of real numbers"):
            function(value)
    # A huge integer has no type of numpy's.
    for value in ([HUGE] * 3, HUGE):
        with refused((TypeError, ValueError)):
            function(value)


@pytest.mark.parametrize(
    "function",
    [function for name, function in OF_AN_ARRAY.items() if name not in ("wrap_angle", "angles_at", "Tracker.gaps")],
)
def test_masked_values_are_refused_wherever_they_are(function):
    masked = np.ma.masked_equal([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]], 5.0)
    for value in (masked, list(masked), masked[1], [[*row] for row in masked], [[list(masked)]]):
        with refused(ValueError, "has masked values: must have none"):
            function(value)


@pytest.mark.parametrize("flow", [[[0, 0], [1e16, 0]], [[0, 0], [1e99, 0]], [[-1e99, 0], [1e99, 0]]])
def test_flow_that_no_counter_holds_is_refused_without_a_warning(flow):
    with warnings.catch_warnings(), refused(ValueError, "more counts than a number holds, 2^53"):
        warnings.simplefilter("error")
        SENSOR.counts(flow)


HUGE_PARTS = {
    "Robot.body_mass = 1e+99 kg": {"body_mass": 1e99},
    "Robot.center_of_mass_x = -1000 m": {"center_of_mass_x": -1000},
    "Robot.center_of_mass_height = 500 m": {"center_of_mass_height": 500},
    "Tyres.width = 26 m": {"tyres": {"width": 26}},
    "Tyres.mass = 1e+07 kg": {"tyres": {"mass": 1e7}},
    "Caster.x = -90 m": {"caster": {"x": -90}},
    "Caster.radius = 1e+10 m": {"caster": {"radius": 1e10}},
    "Motor.rotor_inertia = 1e+99 kg m^2": {"motor": {"rotor_inertia": 1e99}},
    "Payload.mass = 2e+06 kg": {"payload": {"mass": 2e6}},
    "Payload.x = -50 m": {"payload": {"mass": 1, "x": -50}},
    "Payload.height = 150 m": {"payload": {"mass": 1, "height": 150}},
}


@pytest.mark.parametrize(("words", "fields"), HUGE_PARTS.items(), ids=HUGE_PARTS)
def test_sizes_and_masses_that_no_robot_has_are_refused(words, fields):
    with refused(ValueError, f"{words}: must be at most", "in size"):
        ROBOT.replace(**fields)


@pytest.mark.parametrize("path", [None, 5, b"robot.toml"])
def test_what_is_not_a_robots_path(path):
    with refused(TypeError, f"path = {path!r}: must be a path"):
        ROBOT.save(path)
    with refused(TypeError, f"robot = {path!r}: must be a preset's name or a path"):
        dd.Robot.load(path)


def test_a_robots_path_names_a_file():
    for call, name in ((dd.Robot.load, "robot"), (ROBOT.save, "path")):
        for path in ("", "a\0b.toml"):
            with refused(ValueError, f"{name} = {path!r}: must name a file"):
                call(path)


def test_an_array_whose_mask_hides_nothing_is_an_array():
    assert dd.se2.compose(np.ma.array([1.0, 2.0, 3.0]), (0.0, 0.0, 0.0)).tolist() == [1.0, 2.0, 3.0]


NUMBERS = {
    "Robot.left_radius": lambda value: dd.Robot(left_radius=value, right_radius=0.1, track_width=0.4),
    "Segment.distance": lambda value: maneuvers.Segment(value, 0.0, 1.0),
    "speed": lambda value: maneuvers.straight(ROBOT, speed=value),
    "radius": lambda value: maneuvers.arc(ROBOT, radius=value),
    "turns": lambda value: maneuvers.spin(ROBOT, turns=value),
    "ramp": lambda value: maneuvers.square(ROBOT, ramp=value),
    "rest": lambda value: maneuvers.square(ROBOT, rest=value),
    "period": lambda value: maneuvers.square(ROBOT, period=value),
    "waves": lambda value: maneuvers.slalom(ROBOT, waves=value),
    "duration": lambda value: dd.Commands(0.1, ANGLES).extended(value),
    "ClosedLoop.period": lambda value: dd.ClosedLoop(lambda t, angles: angles, value, 1.0),
    "max_turn": lambda value: dd.odometry.subdivide(ANGLES, ROBOT, value),
    "distance": lambda value: metrics.rpe(POSES, POSES, distance=value),
    "Encoder.gear": lambda value: dd.Encoder(ticks_per_revolution=1, sample_rate=1, gear=value),
    "Tracker.x": lambda value: dd.Tracker(x=value),
    "FlowSensor.y": lambda value: dd.FlowSensor(x=0.1, y=value),
    "World.friction": lambda value: dd.World(friction=value),
    "Push.start": lambda value: dd.Push(start=value, duration=1.0, acceleration=(0, 0, 0)),
    "sample_rate": RECORDING.at_rate,
    "start": lambda value: RECORDING.during(value, 1.0),
    "yaw_rate": lambda value: dd.GoToPose(ROBOT, goal=(0, 0, 0), yaw_rate=value),
    "max_rate": lambda value: ENCODER.to_angles(ANGLES, max_rate=value),
}


@pytest.mark.parametrize(("name", "function"), NUMBERS.items(), ids=NUMBERS)
def test_numbers_are_finite_numbers(name, function):
    for value in ("1", None, True, 1j, [1.0], np.timedelta64(1, "s")):
        # None leaves an option out.
        if not (value is None and name in ("distance", "max_rate", "Encoder.gear")):
            with refused(TypeError, f"{name} = {value!r}: must be a number"):
                function(value)
    for value in (HUGE, -HUGE):
        with refused(ValueError, f"{name}: must be finite, and an integer of 1329 bits is not"):
            function(value)
    for value in (np.nan, np.inf, -np.inf):
        with refused(ValueError, f"{name} = {value!r}: must be finite"):
            function(value)


FLAGS = {
    "clockwise": lambda value: maneuvers.square(ROBOT, clockwise=value),
    "Encoder.swapped": lambda value: dd.Encoder(ticks_per_revolution=1, sample_rate=1, swapped=value),
    "Encoder.reversed": lambda value: dd.Encoder(ticks_per_revolution=1, sample_rate=1, reversed=(value, False)),
}


@pytest.mark.parametrize(("name", "function"), FLAGS.items(), ids=FLAGS)
def test_words_are_no_flags(name, function):
    for value in ("no", "False", 0, 1, None, np.array([True, False])):
        with refused(TypeError, f"{name} = ", "must be True or False"):
            function(value)
    for value in (True, False, np.True_, np.False_):
        function(value)


def test_a_flag_of_numpy_is_kept_as_pythons():
    encoder = dd.Encoder(ticks_per_revolution=1, sample_rate=1, swapped=np.True_, reversed=(np.False_, np.True_))
    assert encoder.swapped is True
    assert encoder.reversed == (False, True)


TOO_LONG = {
    "way": lambda: maneuvers.straight(ROBOT, distance=1e99),
    "sum of ways": lambda: maneuvers.sequence(ROBOT, [[maneuvers.Segment(0.0, 0.0, 1e99)] * 9]),
    "ramp": lambda: maneuvers.straight(ROBOT, ramp=1e18, distance=1e20),
    "rest": lambda: maneuvers.straight(ROBOT, rest=1e99),
    "period": lambda: maneuvers.straight(ROBOT, period=1e-99),
    "smallest period": lambda: maneuvers.spin(ROBOT, period=1e-100),
    "rates": lambda: maneuvers.constant_rates((1.0, 1.0), 1e99),
    "turns": lambda: maneuvers.spin(ROBOT, turns=1e99),
    "circles": lambda: maneuvers.figure_eight(ROBOT, radius=1e98),
    "slalom": lambda: maneuvers.slalom(ROBOT, waves=1e18),
    "endless slalom": lambda: maneuvers.slalom(ROBOT, waves=1e99, wavelength=1e99),
    "extension": lambda: dd.Commands(0.01, ANGLES).extended(1e99),
    "closed loop": lambda: dd.ClosedLoop(lambda t, angles: angles, 1e-99, 1e99),
    "readings": lambda: dd.Encoder(ticks_per_revolution=1, sample_rate=1e99).read([0.0, 1.0, 2.0], ANGLES),
    "poses": lambda: dd.Tracker(sample_rate=1e99).read([0.0, 1.0, 2.0], POSES),
}


@pytest.mark.parametrize("function", TOO_LONG.values(), ids=TOO_LONG)
def test_what_does_not_fit_in_memory_is_refused_before_it_is_made(function):
    with refused(ValueError, "samples every", "must be at most 10000000"):
        function()


def test_more_segments_than_memory_holds():
    with refused(ValueError, "max_turn = 1e-99 rad", "segments, must be at most 10000000"):
        dd.odometry.subdivide([(0.0, 0.0), (-1.0, 1.0)], ROBOT, max_turn=1e-99)


def test_a_sensor_that_would_count_beyond_every_number():
    with refused(ValueError, "flow = 1e+12 m", "2^53"):
        SENSOR.counts([[0.0, 0.0], [1e12, 0.0]])
    assert SENSOR.counts([[0.0, 0.0], [1e6, 0.0]])[-1, 0] == round(1e6 * SENSOR.counts_per_metre)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: maneuvers.square(ROBOT, sides=2), "square() got an unexpected keyword argument 'sides'"),
        (lambda: maneuvers.spin(ROBOT, speed=2.0), "spin() got an unexpected keyword argument 'speed'"),
        (lambda: maneuvers.constant_rates((1, 1), 1.0, ramps=1), "constant_rates() got an unexpected keyword"),
    ],
)
def test_a_misspelt_option_is_named_with_its_maneuver(call, words):
    with pytest.raises(TypeError) as info:
        call()
    assert words in str(info.value)


@pytest.mark.parametrize(
    ("call", "builtin", "words"),
    [
        (lambda: dd.ClosedLoop("x", 0.02, 1.0), TypeError, "ClosedLoop.function = 'x': must be a function"),
        (lambda: dd.Drive([0, 1], ANGLES[:2], POSES[:2], name=3), TypeError, "Drive.name = 3: must be a string"),
        (lambda: dd.Patch(x=[[0, 1], [2, 3]], y=(0, 1), friction=0.1), ValueError, "Patch.x has shape (2, 2)"),
        (lambda: dd.Patch(x=np.zeros((3, 2)), y=(0, 1), friction=0.1), ValueError, "Patch.x has shape (3, 2)"),
        (lambda: dd.World(patches=dd.World()), TypeError, "World.patches"),
        (lambda: maneuvers.sequence(ROBOT, [[(1.0, 0.0, 1.0)]]), TypeError, "legs[0][0] = a tuple: must be a Segment"),
        (lambda: maneuvers.sequence(ROBOT, []), ValueError, "at least one leg"),
        (lambda: maneuvers.sequence(ROBOT, [[], []]), ValueError, "at least one segment"),
        (lambda: dd.odometry.integrate(ANGLES, ROBOT, "Euler"), KeyError, "unknown odometry method 'Euler'"),
        (lambda: RECORDING.drift(ROBOT, "rk4"), KeyError, "unknown odometry method 'rk4'"),
        (lambda: DRIVE.drift(ROBOT, "rk4"), KeyError, "unknown odometry method 'rk4'"),
        (lambda: RECORDING.at_rate(1e-99), ValueError, "is too long"),
        (lambda: dd.odometry.Odometer(ROBOT, method=None), KeyError, "unknown odometry method None"),
    ],
)
def test_other_mistakes(call, builtin, words):
    with refused(builtin, words):
        call()


def everything():
    """What is in the working directory."""
    return {path: path.read_bytes() if path.is_file() else None for path in Path().rglob("*")}


def test_there_are_many_kinds():
    assert len(KINDS) >= 240


@pytest.mark.parametrize(("function", "builtin", "words"), KINDS.values(), ids=KINDS)
def test_every_kind_is_one_line_and_nothing_is_written(function, builtin, words, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("log.csv").write_text(LAB)
    Path("r.toml").write_text(SIZES)
    Path("light.toml").write_text(f"{SIZES}body_mass = 1e-20\n")
    for folder in ("folder", "taken"):
        Path(folder).mkdir()
    Path("taken", "left.csv").write_text("mine")
    before = everything()
    with pytest.raises(builtin) as info:
        function()
    said = capsys.readouterr()
    assert said.out == ""
    if builtin is SystemExit:
        assert info.value.code == 2
        message, end = said.err[:-1], said.err[-1:]
        assert (end, len(message.splitlines())) == ("\n", 1)
        assert before == everything()
    else:
        assert isinstance(info.value, DiffdriveError)
        message = str(info.value)
        assert said.err == ""
        assert set(before) >= {path for path in everything() if path.parent.name != "folder"}
    assert len(message.splitlines()) == 1
    assert message.isprintable()
    assert words in message
    assert len(message) < 600


def raised(function, value):
    """The exception that a call raises, if any."""
    try:
        function(value)
    except Exception as error:
        return error
    return None


@pytest.mark.parametrize("seed", range(20))
def test_random_rubbish_is_refused_or_used_but_never_lets_another_error_out(seed):
    rng = np.random.default_rng(seed)
    rubbish = (
        None, "", "x", b"x", 0, -1, 1.5, np.nan, np.inf, HUGE, 10**5000, 1e308, 5e-324, True, [], [[]], (1, 2),
        [1, 2, 3], {}, {"a": 1}, np.zeros((2, 2)), np.zeros((0, 3)), np.zeros((2, 3)), 1j, object, print, ROBOT, DRIVE,
        np.array("x"), range(3), "line\nbreak", "x" * 1000,
    )  # fmt: skip
    functions = [*OF_A_ROBOT.values(), *OF_AN_ARRAY.values(), *NUMBERS.values(), *FLAGS.values()]
    for _ in range(100):
        function, value = functions[rng.integers(len(functions))], rubbish[rng.integers(len(rubbish))]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            error = raised(function, value)
        assert error is None or (isinstance(error, DiffdriveError) and len(str(error).splitlines()) == 1), repr(error)
