"""Steering by one's own odometry: it gets where it believes to go, smoothly, and knows nothing else."""

import math

import numpy as np
import pytest
from helpers import refused

import diffdrive_mj as dd
from diffdrive_mj.controller import GoToPose
from diffdrive_mj.kinematics import body_twist

TRUE = dd.Robot.load("mismatched")
WRONG = TRUE.replace(right_radius=TRUE.left_radius)


def ideal_drive(driver, robot, start=(0.0, 0.0, 0.0), seconds=20.0, period=0.05):
    """Kinematics instead of physics: wheels that do what they are told at once."""
    angles, poses, twists = np.zeros((*np.shape(start)[:-1], 2)), [np.asarray(start, float)], []
    for k in range(round(seconds / period)):
        rates = driver(k * period, angles)
        angles = angles + period * rates
        twist = body_twist(rates, robot)
        twists.append(twist)
        poses.append(dd.se2.compose(poses[-1], dd.se2.exp(np.insert(period * twist, 1, 0.0, axis=-1))))
    return np.stack(poses, axis=-2), np.stack(twists, axis=-2)


GRID = np.array([(x, y, h) for x in (-2.0, 0.0, 1.0) for y in (-1.0, 0.0, 2.0) for h in (-3.0, 0.0, 1.5)])


def test_it_reaches_the_goal_from_any_start():
    poses, _ = ideal_drive(GoToPose(TRUE, goal=(0.0, 0.0, 0.5), start=GRID), TRUE, GRID)
    assert np.hypot(*poses[:, -1, :2].T).max() < 5e-3
    assert np.abs(dd.se2.wrap_angle(poses[:, -1, 2] - 0.5)).max() < math.radians(0.5)


def test_speeds_and_their_changes_keep_their_limits():
    driver = GoToPose(TRUE, goal=(3.0, 1.0, -2.0), speed=0.4, yaw_rate=1.0, acceleration=0.3, yaw_acceleration=2.0)
    _, twists = ideal_drive(driver, TRUE)
    assert np.abs(twists).max(axis=0) == pytest.approx((0.4, 1.0), rel=1e-9)
    assert (np.abs(np.diff(twists, axis=0)).max(axis=0) <= np.array([0.3, 2.0]) * 0.05 + 1e-9).all()


def test_it_ends_at_rest():
    _, twists = ideal_drive(GoToPose(TRUE, goal=(1.0, 1.0, 1.0)), TRUE)
    assert np.abs(twists[-20:]).max() < 1e-4


def test_it_brakes_at_half_of_what_it_may():
    """v^2 = a d leads to rest at d = 0 at a / 2, and leaves as much for what the heading costs."""
    driver = GoToPose(TRUE, goal=(20.0, 0.0, 0.0), speed=2.0, acceleration=0.3)
    poses, twists = ideal_drive(driver, TRUE, seconds=30.0)
    away, speed = 20.0 - poses[1:, 0], twists[:, 0]
    braking = (np.diff(speed, prepend=0.0) < -1e-9) & (away > 1.0)
    assert np.count_nonzero(braking) > 20
    assert -np.diff(speed)[braking[1:]] / 0.05 == pytest.approx(0.15, rel=0.1)
    assert away.min() > -1e-3


def test_close_to_the_goal_it_backs_up_and_does_not_turn():
    _, twists = ideal_drive(GoToPose(TRUE, goal=(-0.02, 0.01, 0.0)), TRUE, seconds=0.3)
    assert twists[-1, 0] < 0
    assert np.abs(twists[:, 1]).max() < 1e-15


def test_waypoints_are_passed_by_in_their_order():
    points = np.array([(1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
    poses, _ = ideal_drive(GoToPose(TRUE, goal=(0.0, 0.0, 0.0), waypoints=points), TRUE, seconds=30)
    near = [np.argmin(np.hypot(*(poses[:, :2] - point).T)) for point in points]
    assert near == sorted(near)
    assert [np.hypot(*(poses[k, :2] - point)) < 0.2 for k, point in zip(near, points, strict=True)] == [True] * 3
    assert np.hypot(*poses[-1, :2]) < 5e-3


def test_each_robot_of_many_has_its_own_goal():
    goals = np.array([(1.0, 0.0, 0.0), (0.0, 1.0, 3.0), (-1.0, -1.0, -1.0)])
    starts = np.zeros((3, 3))
    together, _ = ideal_drive(GoToPose(TRUE, goal=goals, start=starts), TRUE, starts)
    assert np.abs(together[:, -1, :2] - goals[:, :2]).max() < 5e-3
    alone, _ = ideal_drive(GoToPose(TRUE, goal=goals[1]), TRUE)
    assert together[1] == pytest.approx(alone, abs=1e-12)


def test_an_instance_is_for_one_drive():
    driver = GoToPose(TRUE, goal=(1.0, 0.0, 0.0))
    ideal_drive(driver, TRUE, seconds=1.0)
    with refused(ValueError, "GoToPose at t = 0 s, after 0.95 s", "make another"):
        ideal_drive(driver, TRUE, seconds=1.0)
    short = GoToPose(TRUE, goal=(1.0, 0.0, 0.0))
    short(0.0, (0.0, 0.0))
    with refused(ValueError, "GoToPose at t = 0 s, after 0 s", "make another"):
        short(0.0, (0.0, 0.0))


def test_in_physics_a_wrong_belief_ends_elsewhere_and_does_not_know():
    starts = np.array([(-1.5, 1.0, 2.0), (1.0, 1.0, -2.5)])
    ends = {}
    for belief in (TRUE, WRONG):
        driver = GoToPose(belief, goal=(0.0, 0.0, 0.0), start=starts)
        recording = dd.simulate([TRUE] * 2, dd.ClosedLoop(driver, 0.05, 14.0), start=starts, sample_rate=20)
        assert np.hypot(*driver.pose[:, :2].T).max() < 5e-3
        ends[belief] = np.hypot(*recording.truth[:, -1, :2].T)
    assert ends[TRUE].max() < 5e-3
    assert ends[WRONG].min() > 0.05


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"goal": (0.0, math.inf, 0.0)}, r"goal\[1\] = inf"),
        ({"goal": (0.0, 0.0)}, "goal has shape"),
        ({"goal": (0, 0, 0), "waypoints": [(0.0, math.nan)]}, "waypoints"),
        ({"goal": np.zeros((2, 3)), "waypoints": np.zeros((3, 1, 2))}, "must be for the same robots"),
        ({"goal": (0, 0, 0), "start": (0, 0)}, "start has shape"),
        ({"goal": (0, 0, 0), "speed": 0}, "speed = 0: must be positive"),
        ({"goal": (0, 0, 0), "acceleration": math.nan}, "acceleration"),
        ({"goal": (0, 0, 0), "method": "exact"}, "unknown odometry method 'exact'"),
    ],
)
def test_bad_input_is_named(options, words):
    with pytest.raises(dd.DiffdriveError, match=words):
        GoToPose(TRUE, **options)


def test_robots_with_waypoints_and_goals_of_their_own_drive_as_each_would_alone():
    """Three robots at once, in the shapes that broadcast: starts (3, 3), waypoints (3, 2, 2), one goal for all."""
    starts = np.array([(0.0, 0.0, 0.0), (1.0, -1.0, 2.0), (0.0, 2.0, -1.0)])
    ways = np.array([[(1.0, 0.0), (1.0, 1.0)], [(2.0, 0.0), (0.5, 0.5)], [(-1.0, 2.0), (0.0, 0.0)]])
    goal = (2.0, 2.0, 1.0)
    together, _ = ideal_drive(GoToPose(TRUE, goal=goal, waypoints=ways, start=starts), TRUE, starts)
    for k in range(3):
        alone, _ = ideal_drive(GoToPose(TRUE, goal=goal, waypoints=ways[k], start=starts[k]), TRUE, starts[k])
        assert together[k] == pytest.approx(alone, abs=1e-9)
    # And one way for all of them.
    shared, _ = ideal_drive(GoToPose(TRUE, goal=goal, waypoints=ways[0], start=starts), TRUE, starts)
    assert shared[0] == pytest.approx(together[0], abs=1e-9)


@pytest.mark.parametrize("side", [1, -1])
def test_what_is_off_to_the_side_of_the_goal_is_left_and_the_heading_turned(side):
    """5 mm beside it nothing is left ahead: it turns on the spot, and stands when it has turned."""
    start = (0.0, 0.005 * side, 0.0)
    poses, twists = ideal_drive(GoToPose(TRUE, goal=(0.0, 0.0, 1.0), start=start), TRUE, start, seconds=10.0)
    assert np.abs(twists[:, 0]).max() < 1e-9
    assert poses[-1, 2] == pytest.approx(1.0, abs=1e-3)


def test_what_is_left_ahead_close_by_is_taken_out_as_a_first_order_lag():
    """v in proportion to what is left along the heading, forwards and backwards."""
    found = []
    for ahead in (0.02, -0.02):
        start = (-ahead, 0.01, 0.0)
        _, twists = ideal_drive(GoToPose(TRUE, goal=(0.0, 0.0, 0.0), start=start), TRUE, start, seconds=6.0)
        found.append(twists[:, 0].sum() * 0.05)
    assert found == pytest.approx([0.02, -0.02], rel=0.3)
