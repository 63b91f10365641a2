"""Driving in physics: the ideal world's bounds, disturbances, determinism, recording, errors."""

import math
import os
import warnings

import mujoco
import numpy as np
import pytest

import diffdrive_mj as dd
from diffdrive_mj.errors import DiffdriveError, InvalidType, InvalidValue, PhysicsWarning, SimulationDiverged
from diffdrive_mj.judging.standards import HEADING_FLOOR, POSITION_FLOOR, PRESETS, STANDARD_MANEUVERS, residual
from diffdrive_mj.physics import _engine, _runs
from diffdrive_mj.physics._engine import Engine
from diffdrive_mj.physics.model import compile_model

G = 9.81
ROBOT = dd.Robot(left_radius=0.1, right_radius=0.091, track_width=0.4)
SHORT = dd.maneuvers.straight(ROBOT, speed=0.5, distance=0.3)


@pytest.mark.parametrize("maneuver", STANDARD_MANEUVERS)
def test_odometry_with_the_true_parameters_agrees_with_the_ideal_physics(maneuver):
    robots = [dd.Robot.load(name) for name in PRESETS]
    drives = [STANDARD_MANEUVERS[maneuver](robot) for robot in robots]
    longest = max(drive.duration for drive in drives)
    recording = dd.simulate(robots, [drive.extended(longest) for drive in drives])
    for run, robot in zip(recording.runs, robots, strict=True):
        left = residual(run, robot)
        assert left.within(POSITION_FLOOR, HEADING_FLOOR), (robot.name, left)


def test_a_compensated_robot_keeps_its_line():
    robot = dd.Robot.load("mismatched")
    recording = dd.simulate(robot, dd.maneuvers.straight(robot, speed=1.5, distance=15))
    assert np.abs(recording.truth[:, 1]).max() <= 1e-4
    assert recording.truth[-1, 0] == pytest.approx(15, abs=1e-4)


@pytest.mark.parametrize("law", ["PI", "P"])
def test_equal_servo_gains_let_unequal_wheels_leave_the_line(law):
    def off_line(gains, bandwidth):
        robot = dd.Robot.load("mismatched").replace(servo={"law": law, "gains": gains, "bandwidth": bandwidth})
        recording = dd.simulate(robot, dd.maneuvers.straight(robot, speed=1.5, distance=13.5))
        return np.abs(recording.truth[:, 1]).max()

    soft, stiff = off_line("equal", 5.0), off_line("equal", 20.0)
    assert soft > 2 * stiff > 2e-3
    assert off_line("matched", 5.0) < 1e-5


@pytest.mark.parametrize("wrong", [{"right_radius": 0.1}, {"left_radius": 0.0955, "right_radius": 0.0955}])
def test_a_wrong_belief_breaks_the_bound(wrong):
    robot = dd.Robot.load("mismatched")
    recording = dd.simulate(robot, dd.maneuvers.straight(robot, speed=1.5, distance=5))
    assert recording.drift(robot).max_position_per_metre < 1e-6
    assert recording.drift(robot.replace(**wrong)).max_position_per_metre > 0.1


@pytest.mark.parametrize("wrong", [{"track_width": 0.4004}, {"left_radius": 0.1001}])
def test_a_belief_wrong_by_a_per_mille_breaks_the_bound(wrong):
    robot = dd.Robot.load("mismatched")
    recording = dd.simulate(robot, dd.maneuvers.square(robot, side=1.0))
    assert recording.drift(robot).max_position_per_metre < 1e-6
    assert recording.drift(robot.replace(**wrong)).max_position_per_metre > 1e-4


@pytest.mark.parametrize("direction", [(0.3, 0, 0), (-0.3, 0, 0), (0, 0.3, 0), (0, -0.3, 0)])
@pytest.mark.parametrize("maneuver", [dd.maneuvers.straight, dd.maneuvers.arc])
def test_a_push_that_friction_holds_leaves_the_odometry_alone(direction, maneuver):
    push = dd.Push(start=2.0, duration=0.1, acceleration=tuple(G * np.array(direction)))
    robots = [dd.Robot.load(name) for name in ("matched", "mismatched")]
    recording = dd.simulate(robots, [maneuver(robot, distance=6.0) for robot in robots], world=dd.World(pushes=(push,)))
    for run, robot in zip(recording.runs, robots, strict=True):
        assert run.drift(robot).max_position <= 5e-5


@pytest.mark.parametrize("direction", [(0, 1.5, 0), (0, 0, 1.3)])
def test_wheels_that_slide_or_leave_the_floor_show_and_are_named(direction):
    push = dd.Push(start=1.0, duration=0.1, acceleration=tuple(G * np.array(direction)))
    robots = [dd.Robot.load(name) for name in ("matched", "mismatched")]
    drives = [dd.maneuvers.straight(robot, distance=6.0) for robot in robots]
    with pytest.warns(PhysicsWarning, match=r"robot 0 \(matched\): .* at 1\.0\d* s"):
        recording = dd.simulate(robots, drives, world=dd.World(pushes=(push,)))
    drift = recording.drift(robots[0])
    assert drift.max_position.min() > 1e-3
    assert drift.warnings == recording.events
    assert (recording.lift if direction[2] else recording.friction_use.max(axis=-1) > 0.95).all()
    assert recording.upright.all()


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("side", [-1, 1])
def test_a_push_moves_the_robot_as_newton_says(axis, side):
    """On a floor nearly without friction: a t^2 / 2 while it is pushed, then on with a t, in the world's axes."""
    acceleration = [0.0, 0.0, 0.0]
    acceleration[axis] = side * 0.5
    push = dd.Push(start=0.2, duration=0.4, acceleration=tuple(acceleration))
    still = dd.Commands(0.1, np.zeros((10, 2)))
    world = dd.World(friction=1e-5, pushes=(push,))
    # Whatever way it heads: it slides sideways too.
    with pytest.warns(PhysicsWarning):
        recording = dd.simulate(ROBOT, still, world=world, start=(0, 0, 0.7), physics=dd.Physics(truth="engine"))
    t = recording.t
    way = np.where(t < 0.6, (t - 0.2).clip(0) ** 2 / 2, 0.08 + 0.4 * (t - 0.6)) * side * 0.5
    # The push acts on the centre of mass, about which the robot turns a little: the axle is 0.05 m from it.
    assert recording.truth[:, axis] == pytest.approx(way, abs=2e-3)
    assert np.abs(recording.truth[:, 1 - axis]).max() < 2e-3
    assert abs(recording.truth[-1, axis]) > 0.1


def test_the_same_bits_alone_in_a_batch_and_on_any_threads():
    robots = [dd.Robot.load(name) for name in PRESETS]
    drives = [dd.maneuvers.arc(robot, distance=1.0, radius=0.7, speed=0.3) for robot in robots]
    together = dd.simulate(robots, drives, threads=2)
    assert np.array_equal(together.truth, dd.simulate(robots, drives, threads=1).truth)
    for i, (robot, drive) in enumerate(zip(robots, drives, strict=True)):
        alone = dd.simulate(robot, drive)
        assert np.array_equal(together.truth[i], alone.truth)
        assert np.array_equal(together.wheel_angles[i], alone.wheel_angles)


def test_a_closed_loop_that_repeats_commands_drives_the_same_bits():
    calls = []

    def repeat(t, wheel_angles):
        calls.append((t, wheel_angles.shape))
        return SHORT.wheel_rates[round(t / SHORT.period)]

    loop = dd.ClosedLoop(repeat, SHORT.period, SHORT.duration)
    closed, opened = dd.simulate(ROBOT, loop), dd.simulate(ROBOT, SHORT)
    assert np.array_equal(closed.truth, opened.truth)
    assert np.array_equal(closed.commands.wheel_rates, SHORT.wheel_rates)
    assert len(calls) == len(SHORT.wheel_rates)
    assert calls[0] == (0.0, (2,))


@pytest.mark.parametrize(
    "world",
    [
        dd.World(pushes=(dd.Push(start=0.1, duration=0.2, acceleration=(0.5, 1.0, 0.0)),)),
        dd.World(patches=(dd.Patch(x=(0.05, 0.3), y=(0.0, 1.0), friction=0.01),)),
    ],
    ids=["a push", "a patch"],
)
def test_a_closed_loop_drives_the_same_bits_through_disturbances(world):
    loop = dd.ClosedLoop(lambda t, angles: SHORT.wheel_rates[round(t / SHORT.period)], SHORT.period, SHORT.duration)
    with warnings.catch_warnings(action="ignore", category=PhysicsWarning):
        closed, opened = (dd.simulate(ROBOT, commands, world=world) for commands in (loop, SHORT))
    assert np.array_equal(closed.truth, opened.truth)
    assert not np.array_equal(closed.truth, dd.simulate(ROBOT, SHORT).truth)


def test_how_far_the_engine_runs_ahead_over_patches_does_not_matter(monkeypatch):
    patches = tuple(dd.Patch(x=(x, x + 0.01), y=(-1.0, 1.0), friction=0.2) for x in np.arange(0.0, 0.5, 0.03))
    world = dd.World(patches=patches)
    with warnings.catch_warnings(action="ignore", category=PhysicsWarning):
        ahead = dd.simulate(ROBOT, SHORT, world=world)
        monkeypatch.setattr(_engine, "_NEAREST", 2)
        monkeypatch.setattr(_engine, "_FARTHEST", 16)
        stepwise = dd.simulate(ROBOT, SHORT, world=world)
    assert np.array_equal(ahead.truth, stepwise.truth)
    assert np.array_equal(ahead.wheel_angles, stepwise.wheel_angles)


def test_a_closed_loop_is_not_asked_about_angles_that_are_not_finite():
    """Its push ends the physics between two periods; the driver never sees it."""
    seen = []

    def drive(t, wheel_angles):
        seen.append(np.isfinite(wheel_angles).all())
        return (5.0, 5.0)

    push = dd.Push(start=0.25, duration=0.1, acceleration=(0.0, 0.0, 1e13))
    with pytest.raises(SimulationDiverged):
        dd.simulate(ROBOT, dd.ClosedLoop(drive, 0.05, 1.0), world=dd.World(pushes=(push,)))
    assert all(seen)


def test_a_closed_loop_sees_the_angles_of_all_the_runs():
    seen = []

    def drive(t, wheel_angles):
        seen.append(wheel_angles.copy())
        return np.full((3, 2), 5.0 * t)

    recording = dd.simulate([ROBOT] * 3, dd.ClosedLoop(drive, 0.05, 0.5), sample_rate=20)
    assert recording.wheel_angles.shape == (3, 11, 2)
    assert len(recording.commands) == 3
    assert np.array_equal(np.stack(seen, axis=1), recording.wheel_angles[:, :-1])


def test_the_engine_stepped_by_hand_says_the_same():
    """An independent loop over mj_step, reading the model's own sensors, sees what the recording holds."""
    model = compile_model(ROBOT)
    data = mujoco.MjData(model)
    seen = []
    for rates in SHORT.wheel_rates:
        mujoco.mj_forward(model, data)
        w, _, _, z = data.sensor("axle_orientation").data
        angles = (data.sensor("left_angle").data[0], data.sensor("right_angle").data[0])
        seen.append((*angles, *data.sensor("axle_position").data[:2], 2 * math.atan2(z, w)))
        data.ctrl[:] = np.tile(rates, 2)
        mujoco.mj_step(model, data, nstep=5)
    seen = np.array(seen)
    recording = dd.simulate(ROBOT, SHORT, sample_rate=100)
    count = len(seen)
    assert seen[:, :2] == pytest.approx(recording.wheel_angles[:count], abs=1e-9)
    assert dd.se2.between(seen[0, 2:], seen[:, 2:]) == pytest.approx(recording.truth[:count], abs=1e-9)
    assert recording.truth[count - 1, 0] > 0.29


@pytest.mark.parametrize("start", [(3.0, -2.0, 1.0), (0.0, 0.0, 40.0)])
def test_the_start_pose_moves_the_drive_and_nothing_else(start):
    drive = dd.maneuvers.arc(ROBOT, distance=1.0)
    moved, origin = dd.simulate(ROBOT, drive, start=start), dd.simulate(ROBOT, drive)
    assert np.array_equal(moved.truth[0], start)
    assert np.array_equal(moved.wheel_angles[0], (0, 0))
    assert moved.truth == pytest.approx(dd.se2.compose(start, origin.truth), abs=1e-6)


def test_the_heading_is_followed_through_many_turns_whatever_the_sample_rate():
    drive = dd.maneuvers.spin(ROBOT, turns=3, yaw_rate=6.0).extended(6.0)
    recording = dd.simulate(ROBOT, drive, sample_rate=1.0)
    assert recording.truth[-1, 2] == pytest.approx(6 * math.pi, rel=1e-3)
    assert np.array_equal(recording.truth, dd.simulate(ROBOT, drive).truth[::100][: len(recording.t)])


def test_the_recording_holds_the_samples_asked_for():
    drive = SHORT.extended(2.4)
    recording = dd.simulate(ROBOT, drive, sample_rate=50)
    assert np.allclose(np.diff(recording.t), 0.02)
    assert recording.t[-1] == pytest.approx(2.4)
    assert recording.wheel_angles.shape == (len(recording.t), 2)
    assert recording.robot is ROBOT
    assert recording.commands is drive
    slower = recording.at_rate(10)
    assert np.array_equal(slower.truth, recording.truth[::5])
    assert "samples" in repr(recording)


def test_long_drives_go_through_many_calls_of_the_engine(monkeypatch):
    whole = dd.simulate(ROBOT, SHORT)
    monkeypatch.setattr(_runs, "STEPS_PER_CALL", 7)
    assert np.array_equal(whole.truth, dd.simulate(ROBOT, SHORT).truth)


def test_a_divergence_names_robot_time_and_warning_and_leaves_no_log(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    push = dd.Push(start=0.25, duration=0.1, acceleration=(0.0, 0.0, 1e13))
    robots = [dd.Robot.load("matched"), dd.Robot.load("mismatched")]
    with pytest.raises(SimulationDiverged, match=r"robot 0 \(matched\) diverged at t = 0\.2\d* s: .*"):
        dd.simulate(robots, SHORT, world=dd.World(pushes=(push,)))
    # Of several the one that did, and its time after settling.
    at_once = dd.Commands(SHORT.period, np.where(np.arange(30)[:, None] < 20, SHORT.wheel_rates[:30], 1e9))
    with pytest.raises(SimulationDiverged, match=r"robot 1 \(mismatched\) diverged at t = 0\.202 s: an acceleration"):
        dd.simulate(robots, [SHORT, at_once.extended(SHORT.duration)], physics=dd.Physics(settle_time=0.1))
    with pytest.raises(RuntimeError):
        dd.simulate(robots[0], SHORT, world=dd.World(pushes=(push,)))
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"sample_rate": 0}, InvalidValue, "sample_rate = 0"),
        ({"sample_rate": 300}, InvalidValue, "sampling interval = 0.00333333 s.*whole multiple.*0.002 or 0.004"),
        ({"start": (0, 0)}, InvalidValue, "start has shape"),
        ({"start": (0, math.nan, 0)}, InvalidValue, r"start\[1\] = nan"),
        ({"start": np.zeros((2, 3))}, InvalidValue, "start has shape"),
        ({"physics": dd.Physics(timestep=0.003)}, InvalidValue, "command period = 0.01 s"),
    ],
)
def test_bad_options_are_named(options, error, message):
    with pytest.raises(error, match=message) as raised:
        dd.simulate(ROBOT, SHORT, **options)
    assert isinstance(raised.value, DiffdriveError)


def test_more_threads_than_robots_have_nothing_to_do():
    many, one = (dd.simulate(ROBOT, SHORT, threads=threads) for threads in (10**30, 1))
    np.testing.assert_array_equal(many.truth, one.truth)


@pytest.mark.parametrize(
    ("robot", "commands", "error", "message"),
    [
        ([], SHORT, InvalidValue, "robot: must hold at least one"),
        (ROBOT, [], InvalidValue, "commands: must hold at least one"),
        ("matched", SHORT, InvalidType, "robot = 'matched': must be a Robot; Robot.load"),
        (None, SHORT, InvalidType, "robot = None: must be a Robot"),
        (ROBOT, np.ma.masked, InvalidType, "commands = a MaskedConstant: must be a Commands or a ClosedLoop"),
        ([ROBOT, 5], SHORT, InvalidType, r"robot\[1\] = 5: must be a Robot"),
        (ROBOT, 5, InvalidType, "commands = 5: must be a Commands or a ClosedLoop"),
        (ROBOT, np.zeros((5, 2)), InvalidType, r"commands\[0\] = a ndarray: must be a Commands or a ClosedLoop"),
        ([ROBOT] * 2, [SHORT] * 3, InvalidValue, "robot has 2 entries: must be 1 or 3"),
        (ROBOT, [SHORT, SHORT.extended(9)], InvalidValue, "one period and one duration"),
        (ROBOT, [dd.ClosedLoop(lambda t, a: a, 0.1, 1.0)] * 2, InvalidValue, "must hold one ClosedLoop"),
    ],
)
def test_robots_and_commands_that_do_not_fit_are_named(robot, commands, error, message):
    with pytest.raises(error, match=message):
        dd.simulate(robot, commands)


@pytest.mark.parametrize(
    ("decide", "message"),
    [
        (lambda t, a: np.zeros(3), "rates of the driver at 0 s has shape"),
        (lambda t, a: np.zeros((1, 2)), "rates of the driver at 0 s have shape"),
        (lambda t, a: (math.nan, 0.0), r"rates of the driver at 0 s\[0\] = nan"),
        (lambda t, a: None, "rates of the driver at 0 s"),
    ],
)
def test_a_driver_that_returns_nonsense_is_named(decide, message):
    with pytest.raises(DiffdriveError, match=message):
        dd.simulate(ROBOT, dd.ClosedLoop(decide, 0.1, 0.5))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: dd.Physics(timestep=0), "Physics.timestep = 0: must be positive"),
        (lambda: dd.Physics(timestep=math.inf), "must be finite"),
        (lambda: dd.Physics(friction_damping=2.0), "Physics.friction_damping = 2: must be below 2"),
        (lambda: dd.Physics(contact_stiffness=1.1), "Physics.contact_stiffness = 1.1: must be at most 1"),
        (lambda: dd.Physics(contact_damping=0), "Physics.contact_damping = 0: must be positive"),
        (lambda: dd.Physics(friction_damping=-1), "Physics.friction_damping = -1: must be positive"),
        (lambda: dd.Physics(settle_time=-1), "Physics.settle_time = -1: must not be negative"),
        (lambda: dd.Physics(contact_impedance=[0.9, 0.8]), "0 < touching <= deep < 1"),
        (lambda: dd.Physics(balanced_contacts="no"), "Physics.balanced_contacts = 'no': must be True or False"),
        (lambda: dd.Physics(timestep=0.1), "Physics.timestep = 0.1 s: must be at most 0.05 s"),
        (lambda: dd.Physics(integrator="RK4"), "Physics.truth = 'midpoint' with integrator = 'RK4'.*truth='engine'"),
        (lambda: dd.Physics(friction_damping=None), "Physics.truth = 'midpoint'.*needs 'Euler' and a number"),
        (lambda: dd.Physics(contact_impedance=(0.9, 1.0)), "Physics.contact_impedance"),
        (lambda: dd.Physics(servo_stiffness=1.6), "Physics.servo_stiffness = 1.6: must be at most 1.5"),
        (lambda: dd.Physics(integrator="euler"), "unknown Physics.integrator 'euler'.*did you mean 'Euler'"),
        (lambda: dd.World(friction=-1), "World.friction = -1: must be positive"),
        (lambda: dd.World(pushes=(1,)), "World.pushes"),
        (lambda: dd.Push(start=-1, duration=1, acceleration=(0, 0, 0)), "Push.start = -1"),
        (lambda: dd.Push(start=0, duration=0, acceleration=(0, 0, 0)), "Push.duration = 0"),
        (lambda: dd.Push(start=0, duration=1, acceleration=(0, 0)), "Push.acceleration"),
        (lambda: dd.ClosedLoop(lambda t, a: a, 0.0, 1.0), "ClosedLoop.period"),
        (lambda: dd.ClosedLoop(lambda t, a: a, 0.1, 0.0), "ClosedLoop.duration = 0.0: must be positive"),
    ],
)
def test_bad_worlds_are_named(make, message):
    with pytest.raises(DiffdriveError, match=message):
        make()


@pytest.mark.parametrize("heading", [0.7, 2.0, -2.5])
def test_a_robot_that_leans_leans_the_same_whatever_its_heading(heading):
    """Its axle is tilted by unequal wheels: turned as a whole, nothing of the drive changes."""
    robot = dd.Robot.load("mismatched").replace(axle="rigid", left_radius=0.08)
    drive = dd.maneuvers.arc(robot, radius=1.0, distance=0.5, speed=0.5)
    ahead, turned = (dd.simulate(robot, drive, start=(0.0, 0.0, theta)) for theta in (0.0, heading))
    seen = dd.se2.between(turned.truth[0], turned.truth)
    assert np.abs(seen - ahead.truth).max() < 1e-7
    assert turned.friction_use == pytest.approx(ahead.friction_use, rel=1e-3)


@pytest.mark.parametrize("states", ["nan", "inf"])
def test_a_state_that_is_not_finite_is_named_where_the_engine_gives_no_warning(states):
    engine = Engine([ROBOT, ROBOT], dd.World(), dd.Physics(), np.zeros((2, 3)), threads=1)
    rows = np.zeros((2, 3, engine.model.nq))
    engine.refuse_divergence(rows)
    rows[1, 2, 0] = float(states)
    with pytest.raises(dd.SimulationDiverged, match=r"robot 1 \(.*\) diverged at t = 0 s: the state is not finite"):
        engine.refuse_divergence(rows)


@pytest.mark.parametrize("most", [1, 10**6])
def test_steps_end_at_whole_steps_of_time_however_they_are_read(monkeypatch, most):
    read, times = _runs.GripProbe.read, []

    def kept(probe, steps):
        assert steps.time.shape == steps.states.shape[1:2]
        times.extend(steps.time)
        read(probe, steps)

    monkeypatch.setattr(_runs, "STEPS_PER_CALL", most)
    monkeypatch.setattr(_runs.GripProbe, "read", kept)
    dd.simulate(ROBOT, SHORT)
    assert times == pytest.approx(0.002 * np.arange(1, round(SHORT.duration / 0.002) + 1))


def test_samples_come_at_their_times_however_the_steps_are_read(monkeypatch):
    """Pieces of 35 steps and samples every 50: what is left of a piece counts for the next."""
    drive = dd.maneuvers.arc(ROBOT, radius=1.0, distance=0.5, speed=0.5, period=0.07)
    whole = dd.simulate(ROBOT, drive, sample_rate=10.0)
    monkeypatch.setattr(_runs, "STEPS_PER_CALL", 1)
    pieces = dd.simulate(ROBOT, drive, sample_rate=10.0)
    assert np.array_equal(pieces.truth, whole.truth)
    assert np.array_equal(pieces.wheel_angles, whole.wheel_angles)
