"""`realistic_worlds`: what its finding counts."""

from helpers import experiment

import diffdrive_mj as dd
from diffdrive_mj.judging.costs import Cost
from diffdrive_mj.judging.effects import Effect, Outcome

SCRIPT = experiment("realistic_worlds")


def outcome(name, ppm, recording):
    robot = dd.Robot.load("matched")
    return Outcome(Effect(name, robot, dd.World()), Cost(ppm, ppm, ()), Cost(ppm, ppm, ()), recording)


def test_the_ideal_drive_is_no_effect():
    robot = dd.Robot.load("matched")
    made = dd.simulate(robot, dd.maneuvers.straight(robot, distance=0.2))
    ranked = [outcome(name, ppm, made) for name, ppm in (("a", 20.0), ("nothing: ideal floor", 0.1), ("b", 0.01))]
    said = SCRIPT.finding(robot, ranked)
    assert said.startswith("What costs matched most: a, 0.02 mm a metre\n")
    assert "1 of 2 cost less than 10 ppm" in said
