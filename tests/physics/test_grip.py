"""What the physics says has happened: friction used, wheels off the floor, falls; coarse steps."""

import warnings

import numpy as np
import pytest

import diffdrive_mj as dd
from diffdrive_mj.errors import DiffdriveError, InvalidType, InvalidValue, PhysicsWarning, RobotFell
from diffdrive_mj.physics._probes import FallProbe, Steps
from diffdrive_mj.physics.mechanics import contact_forces
from diffdrive_mj.physics.model import compile_model

ROBOT = dd.Robot.load("matched")
BURGER = dd.Robot.load("turtlebot3_burger")
SHORT = dd.maneuvers.straight(ROBOT, speed=0.5, distance=0.3)


def test_friction_use_is_the_need_over_what_the_floor_gives():
    """A start at 1 m/s^2 needs what mechanics says, which is twice the share of half the friction."""
    drive = dd.maneuvers.straight(ROBOT, speed=1.0, distance=2.0, ramp=1.0)
    need = contact_forces(ROBOT, (0.5, 0.0), (1.0, 0.0)).friction_need
    for friction in (0.5, 1.0):
        recording = dd.simulate(ROBOT, drive, world=dd.World(friction=friction))
        # The commands rise in steps of 10 ms, which the servos round off: the largest use is a tenth above the mean.
        assert (recording.friction_use > need / friction).all()
        assert (recording.friction_use < 1.15 * need / friction).all()
        assert recording.events == ()
        assert not recording.lift
        assert recording.upright


def test_a_wheel_that_slips_is_named_with_its_share_and_time_and_in_the_drift():
    drive = dd.maneuvers.straight(ROBOT, speed=1.0, distance=2.0, ramp=0.2)
    words = r"robot matched: the left wheel used 1\d\d % of its friction at 0\.\d+ s"
    with pytest.warns(PhysicsWarning, match=words) as seen:
        recording = dd.simulate(ROBOT, drive, world=dd.World(friction=0.3))
    assert len(seen) == 1
    assert recording.friction_use.min() > 0.99
    assert "warning: robot matched: the left wheel used" in str(recording.drift(ROBOT))


def test_of_many_robots_those_that_slip_are_named_and_only_those():
    drives = [dd.maneuvers.straight(ROBOT, speed=1.0, distance=2.0, ramp=ramp).extended(5) for ramp in (1.0, 0.1, 1.0)]
    with pytest.warns(PhysicsWarning, match=r"robot 1 \(matched\)"):
        recording = dd.simulate(ROBOT, drives)
    assert (recording.friction_use.max(axis=-1) > 0.95).tolist() == [False, True, False]
    assert all(event.startswith("robot 1 (matched)") for event in recording.events)
    assert [run.events == () for run in recording.runs] == [True, False, True]


def test_recordings_of_other_places_know_nothing_of_grip():
    recording = dd.simulate(ROBOT, SHORT)
    bare = dd.Recording(recording.t, recording.wheel_angles, recording.truth, ROBOT, SHORT, dd.World(), dd.Physics())
    assert bare.events == ()
    with pytest.raises(InvalidValue, match=r"Recording\.grip is None"):
        bare.upright  # noqa: B018


@pytest.mark.parametrize(
    ("robot", "drive"),
    [
        (BURGER, lambda robot: dd.maneuvers.straight(robot, speed=1.0, distance=2.0, ramp=0.2)),
        (dd.Robot.load("ct_bot"), lambda robot: dd.maneuvers.straight(robot, speed=1.0, distance=2.0, ramp=0.2)),
        (ROBOT.replace(center_of_mass_height=0.6), lambda robot: dd.maneuvers.straight(robot, speed=1.5, distance=4.0)),
    ],
)
def test_a_robot_that_falls_ends_in_an_error_with_robot_and_time(robot, drive):
    with pytest.raises(
        RobotFell, match=rf"robot 0 \({robot.name}\) .* at t = \d+\.\d+ s: .*on_fall='record'"
    ) as raised:
        dd.simulate(robot, drive(robot))
    assert isinstance(raised.value, DiffdriveError)
    assert isinstance(raised.value, RuntimeError)
    with pytest.warns(PhysicsWarning, match=r"fell at \d+\.\d+ s"):
        recording = dd.simulate(robot, drive(robot), on_fall="record")
    assert not recording.upright
    assert recording.lift


def test_the_robots_beside_one_that_falls_are_recorded_as_if_they_were_alone():
    calm = dd.maneuvers.straight(BURGER, speed=0.2, distance=0.5).extended(4.0)
    wild = dd.maneuvers.straight(BURGER, speed=1.0, distance=2.0, ramp=0.2).extended(4.0)
    with pytest.warns(PhysicsWarning, match="robot 1"):
        both = dd.simulate(BURGER, [calm, wild], on_fall="record")
    assert both.upright.tolist() == [True, False]
    assert np.array_equal(both.truth[0], dd.simulate(BURGER, calm).truth)


@pytest.mark.parametrize("acceleration", [(0.0, 0.0, 30.0), (0.0, 0.0, 1000.0), (0.0, 20.0, 0.0)])
def test_a_robot_that_is_thrown_away_is_not_recorded_as_a_drive(acceleration):
    push = dd.Push(start=0.2, duration=0.5, acceleration=acceleration)
    with pytest.raises(RobotFell):
        dd.simulate(ROBOT, SHORT.extended(3.0), world=dd.World(pushes=(push,)))


def test_a_hop_is_named_and_is_no_fall():
    push = dd.Push(start=0.2, duration=0.05, acceleration=(0.0, 0.0, 15.0))
    with pytest.warns(PhysicsWarning):
        recording = dd.simulate(ROBOT, SHORT, world=dd.World(pushes=(push,)))
    assert "off the floor at 0.2" in " ".join(recording.events)
    assert recording.lift
    assert recording.upright


def test_coarse_steps_warn_of_the_floor_to_expect_and_nonsense_steps_are_refused():
    with pytest.warns(PhysicsWarning, match=r"Physics.timestep = 0.01 s is coarse: expect 2 ppm"):
        dd.simulate(ROBOT, SHORT, physics=dd.Physics(timestep=0.01))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        dd.simulate(ROBOT, SHORT, physics=dd.Physics.fast())
    with pytest.raises(InvalidValue, match=r"Physics\.timestep = 0\.2 s: must be at most 0.05 s"):
        dd.Physics(timestep=0.2)


@pytest.mark.parametrize("timestep", [0.005, 0.01, 0.02])
def test_the_floor_at_coarse_steps_is_what_the_warning_says(timestep):
    robot = dd.Robot.load("ct_bot")
    physics = dd.Physics(timestep=timestep)
    drive = dd.maneuvers.figure_eight(robot, period=timestep)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PhysicsWarning)
        recording = dd.simulate(robot, drive, physics=physics, sample_rate=1 / timestep)
    expected = 0.5 * (timestep / 0.005) ** 2
    assert expected / 4 < 1e6 * float(recording.drift(robot).max_position_per_metre) < 1.2 * expected


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"threads": -1}, InvalidValue, "threads = -1: must be at least 0"),
        ({"threads": True}, InvalidType, "threads = True: must be a whole number"),
        ({"threads": 0.5}, InvalidType, "threads = 0.5: must be a whole number"),
        ({"threads": None}, InvalidType, "threads = None: must be a whole number"),
        ({"physics": "fast"}, InvalidType, "physics = 'fast': must be a Physics"),
        ({"world": "ice"}, InvalidType, "world = 'ice': must be a World"),
        ({"flow_sensor": 0.1}, InvalidType, "flow_sensor = 0.1: must be a FlowSensor"),
        ({"on_fall": "ignore"}, ValueError, "unknown on_fall 'ignore': choose from raise, record"),
        ({"start": (1e10, 0, 0)}, InvalidValue, "start = 1e\\+10 m: must be within 1e\\+09 m of zero"),
        ({"start": (0, 0, 1e7)}, InvalidValue, "start = 1e\\+07 rad"),
    ],
)
def test_bad_options_are_one_line(options, error, words):
    with pytest.raises(error, match=words) as raised:
        dd.simulate(ROBOT, SHORT, **options)
    assert isinstance(raised.value, DiffdriveError)
    assert "\n" not in str(raised.value)


def test_a_start_far_away_costs_no_precision():
    drive = dd.maneuvers.arc(ROBOT, distance=1.0)
    near = dd.simulate(ROBOT, drive)
    far = dd.simulate(ROBOT, drive, start=(1e9, -1e9, 0.0))
    assert far.truth[:, :2] - (1e9, -1e9) == pytest.approx(near.truth[:, :2], abs=2.5e-7)  # 1e9 m resolves 1.2e-7 m
    assert np.array_equal(far.wheel_angles, near.wheel_angles)


@pytest.mark.parametrize("robot", [ROBOT.replace(body_mass=1e-20), ROBOT.replace(left_radius=1e-9, right_radius=1e-9)])
def test_what_the_engine_cannot_build_is_one_line(robot):
    with pytest.raises(InvalidValue, match="robot matched: MuJoCo cannot build it") as raised:
        dd.simulate(robot, SHORT)
    assert "\n" not in str(raised.value)


def test_how_far_a_wheel_slid_is_how_much_further_it_rolled_than_it_went():
    drive = dd.maneuvers.constant_rates((60.0, 60.0), 2.0, ramp=1.0)
    with pytest.warns(PhysicsWarning, match=r"of its friction at \d\.\d+ s, and slid \d+\.\d* m"):
        recording = dd.simulate(ROBOT, drive, world=dd.World(friction=0.1), physics=dd.Physics.sliding())
    rolled = recording.wheel_angles * (ROBOT.left_radius, ROBOT.right_radius)
    further = np.diff(rolled - recording.truth[:, :1], axis=0)  # less far while it brakes
    assert recording.grip.slide == pytest.approx(np.abs(further).sum(axis=0), rel=0.01)
    assert recording.grip.slide.min() > 9.0


def test_wheels_that_hold_slide_nowhere():
    recording = dd.simulate([ROBOT, ROBOT], SHORT)
    assert recording.grip.slide.tolist() == [[0.0, 0.0], [0.0, 0.0]]
    assert recording.runs[1].grip.slide.tolist() == [0.0, 0.0]


@pytest.mark.parametrize("leaning", [0.0, 0.2], ids=["level", "leaning"])
def test_a_fall_is_seen_at_the_step_at_which_the_robot_has_tilted_by_thirty_degrees_from_its_rest(leaning):
    """Rotations about axes through the floor, whose tilt from the rest is known as they are made."""
    model, rng = compile_model(ROBOT), np.random.default_rng(0)

    def turned(axis, angle):
        return np.array([np.cos(angle / 2), *(np.sin(angle / 2) * axis)])

    def after(a, b):
        (w, *v), (s, *u) = a, b
        return np.array([w * s - np.dot(v, u), *(w * np.array(u) + s * np.array(v) + np.cross(v, u))])

    for _ in range(50):
        direction = rng.uniform(-np.pi, np.pi)
        axis = np.array([np.cos(direction), np.sin(direction), 0.0])
        rest = np.zeros((1, model.nq))
        rest[0, 3:7] = after(turned(np.array([0.0, 0.0, 1.0]), rng.uniform(-3, 3)), turned(axis, leaning))
        tilts = np.radians(np.sort(rng.uniform(0, rng.choice([20, 40]), 20)))
        states = rest[:, None].repeat(20, axis=1)
        # The tilt goes on about the same axis or back about it.
        way = rng.choice([-1, 1])
        states[0, :, 3:7] = [after(rest[0, 3:7], turned(axis, way * tilt)) for tilt in tilts]
        time = 0.01 * np.arange(1, 21)
        probe = FallProbe(model, rest)
        probe.read(Steps(time, states, np.zeros((1, 20, model.nsensordata)), np.ones((1, 20, 2)), np.zeros((1, 21, 3))))
        fallen = np.flatnonzero(tilts > np.radians(30))
        assert probe.time[0] == (time[fallen[0]] if fallen.size else pytest.approx(np.nan, nan_ok=True))
