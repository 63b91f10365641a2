"""Drives by name: how they are read, and where they start; physics and sensors are told apart elsewhere."""

import inspect
import math

import numpy as np
import pytest

import diffdrive_mj as dd
from diffdrive_mj.judging import by_name
from diffdrive_mj.physics import simulation

ROBOT = dd.Robot.load("ct_bot")


@pytest.fixture
def asked(monkeypatch):
    """What physics and sensors are asked for; the drive starts at (1, 0) and faces left."""
    found = {}

    def simulate(robot, commands, *, world):
        found.update(robot=robot, commands=commands, world=world)
        return "recording"

    def measure(recording, *, encoder, tracker, seed):
        found.update(recording=recording, encoder=encoder, tracker=tracker, seed=seed)
        return dd.Drive([0.0, 1.0], [(0.0, 0.0), (5.0, 5.0)], [(1.0, 0.0, math.pi / 2), (1.0, 2.0, math.pi / 2)])

    monkeypatch.setattr(simulation, "simulate", simulate)
    monkeypatch.setattr(by_name, "measure", measure)
    return found


def test_the_encoder_and_the_tracker_run_at_the_rate_and_the_seed_is_passed_on(asked):
    by_name.simulated("square", ROBOT, rate=7.0, seed=3)
    assert asked["encoder"].sample_rate == asked["tracker"].sample_rate == 7.0
    assert (asked["recording"], asked["robot"], asked["seed"]) == ("recording", ROBOT, 3)
    by_name.simulated("square", "ct_bot")
    assert asked["encoder"].sample_rate == asked["tracker"].sample_rate == 50.0
    assert (asked["robot"], asked["seed"], asked["world"]) == (ROBOT, 0, dd.World())
    for garden in ("garden", dd.World.load("garden")):
        by_name.simulated("square", ROBOT, world=garden)
        assert asked["world"] == dd.World.load("garden")


def test_a_task_starts_away_from_the_origin_and_keeps_its_shape(asked):
    task = by_name.simulated("spin", ROBOT)
    c, s = math.cos(0.5), math.sin(0.5)
    first = np.array([2 + c, -1 + s, 0.5 + math.pi / 2])
    assert task.start == pytest.approx(first)
    assert task.truth == pytest.approx(np.array([first, np.add(first, (-2 * s, 2 * c, 0))]))
    assert (task.name, task.robot) == ("spin", ROBOT)
    assert task.wheel_angles.tolist() == [[0.0, 0.0], [5.0, 5.0]]


def test_each_name_is_a_maneuver_of_the_package():
    for name, maneuver in by_name.MANEUVERS.items():
        assert maneuver is getattr(dd.maneuvers, name)
        assert next(iter(inspect.signature(maneuver).parameters)) == "robot"
