"""Passive wheels: one linear law there and back, what it cannot see, ticks, and what the physics makes of them."""

import math
import warnings

import numpy as np
import pytest
from helpers import refused
from hypothesis import assume, given
from hypothesis import strategies as st
from strategies import numbers, robots

import diffdrive_mj as dd
from diffdrive_mj import PassiveWheel, PassiveWheels
from diffdrive_mj.errors import PhysicsWarning
from diffdrive_mj.judging.random_drives import random_cases
from diffdrive_mj.judging.standards import STANDARD_MANEUVERS
from diffdrive_mj.physics import _runs

places = numbers(-0.3, 0.3)
wheels = st.builds(PassiveWheel, x=places, y=places, angle=numbers(-4.0, 4.0), radius=numbers(0.01, 0.05))
motions = st.tuples(numbers(-2.0, 2.0), numbers(-1.0, 1.0), numbers(-3.0, 3.0))
ROBOT = dd.Robot.load("mismatched")
LEFT, RIGHT = PassiveWheel(y=0.08), PassiveWheel(y=-0.07)
ACROSS = PassiveWheel(x=-0.05, y=0.02, angle=math.pi / 2)
PODS = PassiveWheels(wheels=(LEFT, RIGHT, ACROSS))


def pods(*some):
    return PassiveWheels(wheels=some)


@given(wheels, motions)
def test_a_wheel_rolls_what_its_place_moves_along_its_direction(wheel, motion):
    """Small chords of its place, seen in the mean heading of each, add up to what the law says at once."""
    steps, mount = 2000, np.array([wheel.x, wheel.y, wheel.angle])
    robot_after = dd.se2.exp(np.array(motion) / steps)
    x, y, turn = dd.se2.between(mount, dd.se2.compose(robot_after, mount))
    forward = x * math.cos(turn / 2) + y * math.sin(turn / 2)
    assert pods(wheel).displacement(motion) == pytest.approx([forward * steps], abs=1e-5)


@given(st.lists(wheels, min_size=3, max_size=5), motions)
def test_the_motion_comes_back(some, motion):
    several = PassiveWheels(wheels=tuple(some))
    assume(not several.unseen())
    assume(np.linalg.cond(several.matrix) < 1e4)
    assert several.motion(several.displacement(motion)) == pytest.approx(motion, abs=1e-9)
    ahead, _, turn = motion
    if np.linalg.cond(several.matrix[:, [0, 2]]) < 1e4 and not several.unseen(slides=False):
        assert several.motion(several.displacement((ahead, 0.0, turn)), slides=False) == pytest.approx(
            (ahead, 0.0, turn), abs=1e-9
        )


@given(wheels, wheels, motions)
def test_two_wheels_and_a_gyro_see_all(a, b, motion):
    both = pods(a, b)
    assume(abs(math.sin(a.angle - b.angle)) > 0.01)
    turn = motion[2]
    assert both.motion(both.displacement(motion), turn=turn) == pytest.approx(motion, abs=1e-9)


@given(robots, numbers(-3.0, 3.0), numbers(-5.0, 5.0))
def test_wheels_at_the_drive_wheels_places_are_wheel_odometry(robot, left, right):
    half = robot.track_width / 2
    driven = pods(PassiveWheel(y=half, radius=robot.left_radius), PassiveWheel(y=-half, radius=robot.right_radius))
    ahead, slide, turn = driven.from_angles([(0.0, 0.0), (left, right)], slides=False)[0]
    assert (ahead, turn) == pytest.approx(tuple(dd.kinematics.body_twist((left, right), robot)), abs=1e-9)
    assert slide == 0


def test_the_formulas_of_three_pods():
    """Road Runner's: two parallel wheels give turn and distance, the third the slide less its share of the turn."""
    motion = np.array([0.4, -0.1, 0.3])
    left, right, across = PODS.displacement(motion)
    turn = (right - left) / (LEFT.y - RIGHT.y)
    ahead = (LEFT.y * right - RIGHT.y * left) / (LEFT.y - RIGHT.y)
    slide = across - ACROSS.x * turn
    assert (ahead, slide, turn) == pytest.approx(tuple(motion))
    assert PODS.motion((left, right, across)) == pytest.approx(motion)


@given(wheels, numbers(-0.2, 0.2), motions)
def test_a_place_along_the_rolling_direction_changes_nothing(wheel, by, motion):
    along = PassiveWheel(
        x=wheel.x + by * math.cos(wheel.angle), y=wheel.y + by * math.sin(wheel.angle), angle=wheel.angle
    )
    assert pods(along).displacement(motion) == pytest.approx(pods(wheel).displacement(motion), abs=1e-9)
    assert wheel.moved(along.lever_arm + by).lever_arm == pytest.approx(wheel.lever_arm + by, abs=1e-9)


@pytest.mark.parametrize("name", STANDARD_MANEUVERS)
@pytest.mark.parametrize("robot", ["mismatched", "turtlebot3_burger"])
def test_a_millionth_in_the_ideal_world(name, robot):
    """Three wheels, two with a slide taken for none, and two with the turn of an ideal gyro."""
    true = dd.Robot.load(robot)
    recording = dd.simulate(true, STANDARD_MANEUVERS[name](true), passive_wheels=PODS, start=(1.0, -2.0, 0.5))
    for steps in readings(recording):
        position, heading = off(recording, steps)
        assert position < 1
        assert heading < 1


@pytest.mark.parametrize("seed", range(3))
def test_a_millionth_for_robots_drives_and_mountings_that_nobody_chose(seed):
    """Whether the drive wheels slip or not; at every step of the physics, inside which the twist does not vary."""
    rng = np.random.default_rng(seed)
    for case in random_cases(4, seed=100 + seed):
        some = random_pods(rng, case.robot.track_width)
        with warnings.catch_warnings(action="ignore", category=PhysicsWarning):
            recording = dd.simulate(case.robot, case.commands, passive_wheels=some, sample_rate=500.0, on_fall="record")
        position, heading = off(recording, some.from_angles(recording.passive_angles))
        assert position < 1
        assert heading < 1


def random_pods(rng, size):
    """Three or four wheels in random places and directions that see everything well."""
    while True:
        mounted = [
            PassiveWheel(x=x, y=y, angle=angle)
            for x, y, angle in rng.uniform(-1, 1, (rng.integers(3, 5), 3)) * (size, size, math.pi)
        ]
        some = PassiveWheels(wheels=tuple(mounted))
        if np.linalg.cond(some.matrix / (1.0, 1.0, size)) < 20:
            return some


def test_what_slipping_wheels_do_not_see():
    """Full power from rest: the drive wheels spin, the passive ones do not."""
    robot = dd.Robot.load("matched")
    start = dd.maneuvers.straight(robot, distance=1.0, speed=1.0, ramp=0.05)
    with pytest.warns(PhysicsWarning, match="100 % of its friction"):
        slid = dd.simulate(
            robot, start, world=dd.World(friction=0.2), physics=dd.Physics.sliding(), passive_wheels=PODS
        )
    assert float(slid.drift(robot).max_position) > 0.05
    for steps in readings(slid):
        drift = dd.metrics.drift(slid.truth, dd.odometry.accumulate(steps, start=slid.truth[0]))
        assert float(drift.max_position) < 1e-6


def test_readings_do_not_depend_on_the_sample_rate_or_the_batch():
    drive = dd.maneuvers.arc(ROBOT, distance=1.0)
    fine = dd.simulate([ROBOT] * 2, drive, passive_wheels=PODS, sample_rate=500)
    coarse = dd.simulate(ROBOT, drive, passive_wheels=PODS, sample_rate=10)
    assert fine.passive_angles.shape == (2, len(fine.t), 3)
    assert fine.passive_angles[1, ::50][: len(coarse.t)] == pytest.approx(coarse.passive_angles, abs=1e-12)
    assert np.array_equal(fine.at_rate(10).passive_angles[0], fine.passive_angles[0, ::50])
    assert np.array_equal(fine.runs[1].during(0.5, 1.0).passive_angles, fine.passive_angles[1, 250:501])
    plain = dd.simulate(ROBOT, drive, sample_rate=10)
    assert plain.passive_angles is None
    assert np.array_equal(plain.truth, coarse.truth)


def test_readings_do_not_depend_on_how_the_drive_is_cut(monkeypatch):
    drive = dd.maneuvers.arc(ROBOT, distance=1.0)
    at_once = dd.simulate(ROBOT, drive, passive_wheels=PODS, sample_rate=50).passive_angles
    monkeypatch.setattr(_runs, "STEPS_PER_CALL", 70)
    assert np.array_equal(dd.simulate(ROBOT, drive, passive_wheels=PODS, sample_rate=50).passive_angles, at_once)


def test_a_flow_sensor_beside_them_sees_the_same_motion():
    flow = dd.FlowSensor(x=0.05)
    recording = dd.simulate(ROBOT, dd.maneuvers.arc(ROBOT, distance=1.0), flow_sensor=flow, passive_wheels=PODS)
    ahead, slide, turn = np.moveaxis(PODS.from_angles(recording.passive_angles), -1, 0)
    seen = flow.displacement(np.stack([ahead, slide, turn], axis=-1))
    assert np.cumsum(seen, axis=0) == pytest.approx(recording.flow[1:], abs=1e-9)


@given(st.lists(st.tuples(*[numbers(-2.0, 2.0)] * 3), min_size=2, max_size=20), numbers(0.0, 0.999))
def test_ticks_are_within_one_of_the_truth(steps, phase):
    angles = np.cumsum(steps, axis=0)
    ticks = PODS.ticks(angles, phase=phase)
    assert np.array_equal(ticks[0], (0, 0, 0))
    back = PODS.from_ticks(ticks)
    assert (np.abs(back - (angles - angles[0])) <= 2 * math.pi / 2000 * (1 + 1e-9)).all()


def test_the_law_of_wheels_cannot_be_changed():
    for values in (PODS.matrix, PODS.radii, PODS.tick_angles):
        with pytest.raises(ValueError, match="read-only"):
            values[0] = 1.0
    assert PassiveWheels(wheels=[LEFT, RIGHT, ACROSS]) == PODS
    assert hash(PODS) == hash(PassiveWheels(wheels=[LEFT, RIGHT, ACROSS]))


def test_each_wheel_has_its_own_ticks():
    coarse = PassiveWheel(ticks_per_revolution=100)
    assert pods(coarse, LEFT).ticks([(0.0, 0.0), (math.pi, math.pi)]).tolist() == [[0, 0], [50, 1000]]


def test_runs_are_leading_dimensions():
    rng = np.random.default_rng(0)
    angles, phase, turn = (
        rng.normal(size=(3, 4, 10, 3)).cumsum(axis=-2),
        rng.random((3, 4, 3)),
        rng.normal(size=(3, 4, 9)),
    )
    ticks = PODS.ticks(angles, phase=phase)
    assert np.array_equal(ticks[2, 1], PODS.ticks(angles[2, 1], phase=phase[2, 1]))
    steps = PODS.from_angles(angles, turn=turn)
    assert steps.shape == (3, 4, 9, 3)
    assert steps[2, 1] == pytest.approx(PODS.from_angles(angles[2, 1], turn=turn[2, 1]))
    assert PODS.from_angles(angles[0, 0], turn=turn).shape == (3, 4, 9, 3)


IN_LINE = pods(PassiveWheel(x=0.1), PassiveWheel(x=-0.1))
BESIDE = pods(PassiveWheel(x=0.1, y=0.05), PassiveWheel(x=-0.1, y=0.05))
DIAGONAL = pods(PassiveWheel(angle=math.radians(30)), PassiveWheel(y=0.1, angle=math.radians(210)))
# They roll along lines that meet in one point, about which they do not see a turn.
MEETING = pods(*(PassiveWheel(x=0.1 * math.cos(a) + 0.05, y=0.1 * math.sin(a), angle=a) for a in (0.0, 2.0, 4.0)))
SIDE, AHEAD = "a slide to the side", "a move straight ahead"


@pytest.mark.parametrize(
    ("some", "known", "words"),
    [
        (pods(LEFT, RIGHT), {}, [SIDE]),
        (pods(LEFT, RIGHT), {"slides": False}, []),
        (pods(LEFT, RIGHT), {"turn_known": True}, [SIDE]),
        (pods(LEFT, ACROSS), {}, ["a turn about (-0.05, 0.08) m"]),
        (pods(LEFT, ACROSS), {"turn_known": True}, []),
        (pods(LEFT, ACROSS), {"slides": False}, []),
        (IN_LINE, {}, [SIDE, "a turn about (0, 0) m"]),
        (IN_LINE, {"slides": False}, ["a turn about (0, 0) m"]),
        (IN_LINE, {"turn_known": True, "slides": False}, []),
        (BESIDE, {"slides": False}, ["a turn about (0, 0.05) m"]),
        (DIAGONAL, {"turn_known": True}, ["a slide along 120 degrees to the left of ahead"]),
        (MEETING, {}, ["a turn about (0.05, 0) m"]),
        (pods(ACROSS), {"turn_known": True, "slides": False}, [AHEAD]),
        (pods(ACROSS), {"turn_known": True}, [AHEAD]),
        (PODS, {}, []),
    ],
)
def test_what_wheels_cannot_see(some, known, words):
    assert list(some.unseen(**known)) == words


@pytest.mark.parametrize("some", [pods(LEFT, ACROSS), IN_LINE, BESIDE, MEETING])
def test_the_turn_that_is_named_is_the_one_that_leaves_the_wheels_still(some):
    *_, named = some.unseen()
    x, y = map(float, named.removeprefix("a turn about (").removesuffix(") m").split(", "))
    assert some.displacement((y, -x, 1.0)) == pytest.approx(0, abs=1e-9)


def test_a_law_that_is_nearly_singular_is_singular():
    almost = pods(PassiveWheel(y=1e-5, x=0.1), PassiveWheel(x=-0.1))
    with refused(ValueError, "cannot see", "a turn about"):
        almost.motion((0.1, 0.1), slides=False)


@pytest.mark.parametrize(
    ("call", "builtin", "words"),
    [
        (lambda: pods(LEFT, RIGHT).motion((1, 1)), ValueError, [SIDE, "slides=False", "shows it"]),
        (
            lambda: pods(LEFT, ACROSS).motion((1, 1)),
            ValueError,
            ["a turn about (-0.05, 0.08) m", "gyro", "slides=False"],
        ),
        (lambda: IN_LINE.motion((1, 1)), ValueError, [SIDE, "a turn about (0, 0) m", "gyro (turn=...) with slides"]),
        (lambda: IN_LINE.motion((1, 1), slides=False), ValueError, ["cannot see a turn about (0, 0) m", "gyro"]),
        (lambda: MEETING.motion((1, 1, 1)), ValueError, ["a turn about (0.05, 0) m"]),
        (lambda: pods(ACROSS).motion((1,), turn=0.0), ValueError, [AHEAD, "a wheel mounted otherwise"]),
        (lambda: PODS.motion((1, 1)), ValueError, ["displacement has shape (2,): must be (..., 3)"]),
        (lambda: PODS.motion((1, 1, math.nan)), ValueError, ["displacement[2] = nan: must be finite"]),
        (lambda: PODS.motion((1, 1, 1), slides=None), TypeError, ["slides = None: must be True or False"]),
        (lambda: PODS.motion((1, 1, 1), turn="left"), TypeError, ["turn"]),
        (lambda: PODS.motion(np.zeros((4, 3)), turn=np.zeros(5)), ValueError, ["displacement (4,), turn (5,)"]),
        (lambda: PODS.displacement((1, 1)), ValueError, ["motion has shape (2,): must be (..., 3)"]),
        (lambda: PODS.from_angles(np.zeros((4, 3)), turn=[0.1]), ValueError, ["turn has shape (1,): must be (..., 3)"]),
        (lambda: PODS.from_angles(np.zeros((4, 3)), turn=0.1), ValueError, ["turn has shape (): must be (..., 3)"]),
        (lambda: PODS.from_angles([(0, 0, 0)]), ValueError, ["at least two to move between"]),
        (lambda: PODS.ticks([(0, 0, 0)], phase=1.0), ValueError, ["phase: must be at least 0 and below 1 tick"]),
        (lambda: PODS.ticks([(0, 0, 0)], phase=(0, 0)), ValueError, ["phase has shape (2,)"]),
        (lambda: PODS.ticks([(0, 0, 0), (1e15, 0, 0)]), ValueError, ["2^53"]),
        (lambda: PassiveWheels(wheels=()), ValueError, ["PassiveWheels.wheels: must hold at least one"]),
        (lambda: PassiveWheels(wheels=(LEFT, "right")), TypeError, ["PassiveWheels.wheels[1] = 'right'"]),
        (lambda: PassiveWheels(LEFT, RIGHT), TypeError, ["takes its fields by name"]),
        (lambda: PassiveWheel(radius=0), ValueError, ["PassiveWheel.radius = 0: must be positive"]),
        (lambda: PassiveWheel(x=80), ValueError, ["PassiveWheel.x = 80 m: must be at most 10 m"]),
        (lambda: PassiveWheel(ticks_per_revolution=-1), ValueError, ["PassiveWheel.ticks_per_revolution"]),
        (lambda: PassiveWheel(bearing=0.0), KeyError, ["unknown PassiveWheel field 'bearing'"]),
        (lambda: LEFT.moved("far"), TypeError, ["lever_arm = 'far': must be a number"]),
        (
            lambda: dd.simulate(ROBOT, dd.maneuvers.spin(ROBOT), passive_wheels=LEFT),
            TypeError,
            ["passive_wheels = a PassiveWheel: must be a PassiveWheels"],
        ),
    ],
)
def test_bad_input_is_named(call, builtin, words):
    with refused(builtin, *words):
        call()


def readings(recording):
    angles, turn = recording.passive_angles, np.diff(recording.truth[:, 2])
    yield PODS.from_angles(angles)
    yield pods(LEFT, RIGHT).from_angles(angles[:, :2], slides=False)
    yield pods(RIGHT, ACROSS).from_angles(angles[:, 1:], turn=turn)


def off(recording, steps):
    """Largest errors, of the way and of the turns [ppm]."""
    drift = dd.metrics.drift(recording.truth, dd.odometry.accumulate(steps, start=recording.truth[0]))
    turned = float(np.abs(np.diff(recording.truth[:, 2])).sum())
    way = max(float(drift.distance), turned * recording.robot.track_width / 2)
    return 1e6 * float(drift.max_position) / way, 1e6 * float(drift.max_heading) / max(turned, 1.0)
