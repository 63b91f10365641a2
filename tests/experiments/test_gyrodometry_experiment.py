"""The experiment on gyros: what its bounds catch, and what it drives."""

import dataclasses

import numpy as np
import pytest
from experiment_runs import answer, broken, each_robot, even, right_or_refused, whole
from helpers import experiment

import diffdrive_mj as dd
from diffdrive_mj.estimation import heading

SCRIPT = experiment("gyrodometry")
SHORT = {"rounds": 1, "units": 20}


@each_robot
def test_any_options_have_the_right_answer(robot):
    right_or_refused(
        SCRIPT,
        robot,
        side=even(1.0, 3.0),
        rounds=whole(1, 3),
        stop=even(1.0, 3.0),
        units=whole(2, 20),
        seed=whole(0, 99),
    )


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"units": 1}, "units = 1: must be at least 2"),
        ({"rounds": 0}, "rounds = 0"),
        ({"side": 0.5}, "side = 0.5 m: must be at least 1 m"),
        ({"stop": 0.2}, "stop = 0.2 s: must be at least 1 s"),
        ({"robot": "nobody.toml"}, "nobody.toml: no such robot file"),
    ],
)
def test_what_has_no_answer_is_said_in_one_line(options, said):
    assert said in answer(SCRIPT, **options)


def test_a_filter_that_takes_a_robot_at_its_last_tick_for_standing_breaks_a_bound(monkeypatch):
    """What the robot turns after the tick goes into the bias."""
    hasty = heading.standing
    monkeypatch.setattr(heading, "standing", lambda t, wheels, **usual: hasty(t, wheels, settle=0.0, lead=0.0))
    assert any("filter" in name for name in map(str, broken(SCRIPT.run(robot="ct_bot", units=20))))


def test_a_filter_that_trusts_its_gyro_too_much_breaks_a_bound(monkeypatch):
    honest = heading.filtered

    def sure(turns, dt, still, gyro, **options):
        return honest(
            turns, dt, still, dataclasses.replace(gyro, angle_random_walk=gyro.angle_random_walk / 2), **options
        )

    monkeypatch.setattr(heading, "filtered", sure)
    assert any("filter" in name for name in map(str, broken(SCRIPT.run(**SHORT))))


def test_the_robot_stands_before_and_after_every_turn():
    robot = dd.Robot.load("matched")
    commands = SCRIPT.tour(robot, 2.0, 1, 1.5)
    moving = np.abs(commands.wheel_rates).max(axis=1) > 0
    starts = np.flatnonzero(np.diff(moving.astype(int)) == 1)
    ends = np.flatnonzero(np.diff(moving.astype(int)) == -1)
    assert len(starts) == 8
    assert (starts[0] + 1) * commands.period == pytest.approx(3.0)
    assert ((starts[1:] - ends[:-1]) * commands.period >= 1.5 - 1e-9).all()
    angles = np.vstack([(0, 0), np.cumsum(commands.wheel_rates * commands.period, axis=0)])
    assert dd.odometry.integrate(angles, robot)[-1] == pytest.approx([0, 0, 2 * np.pi], abs=1e-9)
