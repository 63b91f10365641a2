"""Robots at rest stay at rest, and robots that are dropped come to it."""

import itertools
import math
import warnings

import mujoco
import numpy as np
import pytest
from random_robots import random_robots

import diffdrive_mj as dd
from diffdrive_mj.physics.model import compile_model
from diffdrive_mj.robot import presets

PRESETS = tuple(dd.Robot.load(name) for name in presets())
SETTINGS = {"default": dd.Physics(), "fast": dd.Physics.fast(), "sliding": dd.Physics.sliding()}
DROP = 0.020
# Heights around it, from which the landing falls into every part of a step: at 0.63 m/s a step of 2 ms is 1.3 mm.
HEIGHTS = DROP + np.linspace(-0.0007, 0.0007, 11)


RANDOM = random_robots(100, seed=5, ratios=(0.75, 1.33), axles=("independent", "rigid"))


def quiet_after(model, disturb, seconds):
    """When the robot moves by less than 0.1 mm/s for good [s]."""
    data = mujoco.MjData(model)
    disturb(data)
    speeds = np.empty(round(seconds / model.opt.timestep))
    for step in range(len(speeds)):
        mujoco.mj_step(model, data)
        speeds[step] = np.abs(data.qvel[:3]).max()
    moving = np.flatnonzero(speeds > 1e-4)
    return float(moving[-1] + 1) * model.opt.timestep if moving.size else 0.0


def dropped(height):
    def disturb(data):
        data.qpos[2] += height

    return disturb


def hopping(data):
    """Upward, as high as the drop."""
    data.qvel[2] = math.sqrt(2 * 9.81 * DROP)


def tilted(data):
    """Nose up by 0.1 rad, and dropped."""
    turned = np.empty(4)
    mujoco.mju_mulQuat(turned, [math.cos(0.05), 0, -math.sin(0.05), 0], data.qpos[3:7])
    data.qpos[3:7] = turned
    data.qpos[2] += DROP


@pytest.mark.parametrize("physics", SETTINGS.values(), ids=SETTINGS)
def test_a_level_drop_is_over_after_two_tenths_of_a_second(physics):
    """Whatever part of a step the landing falls into, which decides how much of it rebounds."""
    times = [quiet_after(compile_model(robot, physics), dropped(h), 0.4) for robot in PRESETS for h in HEIGHTS]
    assert 0.06 < min(times) <= max(times) < 0.2


def test_a_level_drop_of_any_robot_is_over_as_soon():
    heights = itertools.cycle(HEIGHTS)
    times = [quiet_after(compile_model(robot), dropped(next(heights)), 0.4) for robot in RANDOM]
    assert max(times) < 0.2


def test_a_landing_rebounds_by_at_most_a_quarter_of_the_height():
    """The stiffness gives back half of the landing speed at most: 0.5^2 of the height."""
    model = compile_model(dd.Robot.load("mismatched"))
    rebounds = []
    for height in HEIGHTS:
        data = mujoco.MjData(model)
        dropped(height)(data)
        heights = []
        for _ in range(100):
            mujoco.mj_step(model, data)
            heights.append(data.qpos[2] - model.qpos0[2])
        landed = int(np.argmax(np.array(heights) <= 0))
        rebounds.append(max(heights[landed:]))
    assert 0.1 * DROP < max(rebounds) < 0.25 * max(HEIGHTS)
    assert min(rebounds) < 0.01 * DROP


@pytest.mark.parametrize("disturb", [hopping, tilted])
@pytest.mark.parametrize("physics", SETTINGS.values(), ids=SETTINGS)
def test_a_preset_is_quiet_a_second_after_a_hop_or_a_tilt(physics, disturb):
    assert max(quiet_after(compile_model(robot, physics), disturb, 2.0) for robot in PRESETS) < 1.0


@pytest.mark.parametrize(
    ("robots", "physics", "seconds"),
    [*((PRESETS, physics, 10.0) for physics in SETTINGS.values()), (RANDOM, dd.Physics(), 2.0)],
    ids=[*SETTINGS, "random"],
)
def test_a_robot_at_rest_creeps_by_less_than_a_hundredth_of_a_micrometre_in_ten_seconds(robots, physics, seconds):
    """The presets, and a hundred robots that nobody chose, for a fifth of the time."""
    standing = dd.Commands(1.0, np.zeros((round(seconds), 2)))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        recording = dd.simulate(robots, standing, physics=physics, sample_rate=10.0)
    crept = np.linalg.norm(recording.truth[..., :2], axis=-1)
    assert crept.max() < 0.01e-6 * seconds / 10
    assert np.abs(recording.truth[..., 2]).max() < 1e-10 * seconds
    assert np.abs(recording.wheel_angles).max() < 1e-10 * seconds
    assert not recording.lift.any()
