"""Wheels that slide, against mechanics in closed form: when they begin to, and where they stop."""

import mujoco
import numpy as np
import pytest
from locked import deceleration, locked, slope, tilt_the_floor

import diffdrive_mj as dd
from diffdrive_mj import se2
from diffdrive_mj.errors import PhysicsWarning
from diffdrive_mj.robot import presets

SPEED = 1.5


@pytest.mark.parametrize("friction", [0.3, 0.5, 0.8])
@pytest.mark.parametrize(
    ("name", "physics"),
    [(name, dd.Physics()) for name in ("matched", "mismatched")] + [(name, dd.Physics.sliding()) for name in presets()],
)
def test_a_braked_robot_begins_to_slide_on_the_slope_that_statics_says(name, physics, friction):
    """Facing uphill; downhill at 0.8 it tips over its wheels first. The default throws up a wheel that slides a little,
    which then slides on; it is that much less sharp."""
    robot = dd.Robot.load(name)
    off = 1e-3 if physics == dd.Physics() else 5e-5
    for share, slides in ((1 - off, False), (1 + off, True)):
        model = locked(robot, friction, physics)
        data = tilt_the_floor(model, share * slope(robot, friction), 1.0)
        before = data.qpos[0]
        mujoco.mj_step(model, data, nstep=500)
        moved = before - data.qpos[0]
        # What does not slide creeps, by the part of the slip that friction damping leaves.
        assert moved > 1e-4 if slides else abs(moved) < 2e-5


def stop(robot, friction, physics):
    """Where a robot that slides at 1.5 m/s with locked wheels stops, and how high its axle hops [m]."""
    model = locked(robot, friction, physics)
    data = mujoco.MjData(model)
    data.qvel[0] = SPEED
    highest = 0.0
    for _ in range(round(1.5 / model.opt.timestep)):
        mujoco.mj_step(model, data)
        highest = max(highest, data.qpos[2] - model.qpos0[2])
    assert abs(data.qvel[0]) < 1e-3
    return float(data.qpos[0]), highest


@pytest.mark.parametrize(
    ("name", "friction"),
    [("matched", 0.3), ("matched", 0.5), ("optiodom", 0.3), ("optiodom", 0.5), ("mismatched", 0.3)],
)
def test_a_sliding_robot_stops_where_friction_stops_it(name, friction):
    robot = dd.Robot.load(name)
    distance, hop = stop(robot, friction, dd.Physics.sliding())
    assert distance == pytest.approx(SPEED**2 / (2 * deceleration(robot, friction)), rel=0.01)
    assert hop < 0.5e-3


def test_the_default_throws_a_sliding_robot_up_which_is_what_the_sliding_setting_is_for():
    assert stop(dd.Robot.load("matched"), 0.5, dd.Physics())[1] > 5e-3


@pytest.mark.parametrize("physics", [dd.Physics.sliding(), dd.Physics(truth="engine"), dd.Physics()])
def test_its_price_is_creep_in_turns(physics):
    """A turn creeps outward by 1 / friction_damping - 1/2 of its angle a step: 9.5 at 0.1, 0.5 at 1, 0 corrected."""
    robot = dd.Robot.load("mismatched")
    commands = dd.maneuvers.arc(robot, radius=1.0, distance=1.5, speed=0.5, ramp=0.5)
    recording = dd.simulate(robot, commands, physics=physics, sample_rate=1 / physics.timestep)
    cruising = recording.during(1.5, 2.5).truth
    step = np.diff(cruising, axis=0).mean(axis=0)[2]
    forward, left, _ = se2.log(se2.between(cruising[:-1], cruising[1:])).mean(axis=0)
    assert step == pytest.approx(0.5 * physics.timestep, rel=1e-3)
    parts = 0.0 if physics.truth == "midpoint" else 1 / physics.friction_damping - 0.5
    assert left / forward == pytest.approx(-parts * step, rel=0.01, abs=1e-4 * step)


def test_in_the_air_the_true_pose_is_off_by_half_a_steps_turn():
    """Nothing holds a flying robot's displacement to its heading: the engine's own pose is exact there."""
    robot = dd.Robot.load("matched")
    commands = dd.maneuvers.arc(robot, radius=1.0, distance=2.0, speed=1.0, ramp=0.5)
    world = dd.World(pushes=(dd.Push(start=1.0, duration=0.02, acceleration=(0.0, 0.0, 60.0)),))
    recordings = []
    for truth in ("midpoint", "engine"):
        with pytest.warns(PhysicsWarning):
            recordings.append(dd.simulate(robot, commands, world=world, physics=dd.Physics(truth=truth)))
        assert recordings[-1].lift
    middle, engine = (recording.truth[104:116] for recording in recordings)  # it flies from 1.02 to 1.2 s
    assert np.array_equal(middle[:, 2], engine[:, 2])
    directions = [np.arctan2(*np.diff(poses[:, 1::-1], axis=0).T) for poses in (middle, engine)]
    half_a_step = np.diff(engine[:, 2]) / 0.01 * 0.002 / 2
    assert (half_a_step > 0.9e-3).all()
    assert directions[0] - directions[1] == pytest.approx(half_a_step, rel=1e-6)
