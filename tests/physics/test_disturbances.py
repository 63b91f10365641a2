"""Pushes act during their steps and patches under the wheels that stand on them."""

import math
import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import diffdrive_mj as dd
from diffdrive_mj.errors import PhysicsWarning
from diffdrive_mj.physics._disturbances import Floor, Pushes
from diffdrive_mj.physics.tilt import resting_tilt

STEP = 0.002


def test_a_push_acts_from_its_first_step_to_its_last():
    pushes = Pushes([dd.Push(acceleration=(1.0, 2.0, 3.0), start=2 * STEP, duration=STEP)], STEP)
    assert [pushes.acceleration(step).tolist() for step in range(4)] == [[0, 0, 0], [0, 0, 0], [1, 2, 3], [0, 0, 0]]
    assert [pushes.steps_to_change(step) for step in range(4)] == [2, 1, 1, None]


@pytest.mark.parametrize("first", range(1, 400, 7))
def test_a_push_that_begins_and_ends_with_a_step_acts_in_no_other(first):
    """However its times are rounded."""
    pushes = Pushes([dd.Push(acceleration=(1.0, 0.0, 0.0), start=round(first * STEP, 3), duration=0.014)], STEP)
    shares = [pushes.acceleration(first + k)[0] for k in range(-1, 8)]
    assert shares == [0, 1, 1, 1, 1, 1, 1, 1, 0]
    assert pushes.steps_to_change(0) == first


def test_pushes_at_the_same_time_add_up():
    pushes = Pushes(
        [
            dd.Push(acceleration=(1.0, 0.0, 0.0), start=0.0, duration=4 * STEP),
            dd.Push(acceleration=(0, 0.5, 0), start=2 * STEP, duration=6 * STEP),
        ],
        STEP,
    )
    assert pushes.acceleration(1).tolist() == [1, 0, 0]
    assert pushes.acceleration(3).tolist() == [1, 0.5, 0]
    assert pushes.acceleration(7).tolist() == [0, 0.5, 0]
    assert [pushes.steps_to_change(step) for step in (0, 2, 4, 8)] == [2, 2, 4, None]


@pytest.mark.parametrize("heading", [0.0, 0.7, -2.5])
def test_each_wheel_of_each_robot_feels_the_patch_under_itself(heading):
    """Patches of 2 cm where the wheels stand: half a track to both sides of the axle's midpoint."""
    robots = [dd.Robot.load("mismatched"), dd.Robot.load("ct_bot")]
    start = np.array([(3.0, -2.0, 0.4), (-1.0, 5.0, 1.0)])
    poses = np.array([(0.5, 0.25, heading), (-0.5, 0.75, heading + 1)])
    patches, expected = [], np.zeros((2, 1, 2))
    for k, robot in enumerate(robots):
        half = resting_tilt(robot).track_width / 2
        for side, sign in enumerate((1, -1)):
            x = start[k, 0] + poses[k, 0] - sign * half * math.sin(poses[k, 2])
            y = start[k, 1] + poses[k, 1] + sign * half * math.cos(poses[k, 2])
            expected[k, 0, side] = 0.1 + 0.2 * k + 0.1 * side
            patches.append(dd.Patch(x=(x - 0.01, x + 0.01), y=(y - 0.01, y + 0.01), friction=expected[k, 0, side]))
    floor = Floor(dd.World(patches=tuple(patches)), robots, start)
    assert floor.friction(poses[:, None], np.arange(2)) == pytest.approx(expected)
    assert floor.friction(poses[1:, None], np.array([1])) == pytest.approx(expected[1:])
    assert floor.friction(poses[:, None] + (0.1, 0.1, 0), np.arange(2)) == pytest.approx(np.ones((2, 1, 2)))


@given(start=st.floats(0, 0.1), duration=st.floats(1e-6, 0.05), other=st.floats(0, 0.1))
def test_a_push_gives_its_whole_impulse_however_short_it_is(start, duration, other):
    pushes = Pushes(
        [
            dd.Push(start=start, duration=duration, acceleration=(3.0, 0.0, -1.0)),
            dd.Push(start=other, duration=STEP, acceleration=(0.0, 2.0, 0.0)),
        ],
        STEP,
    )
    step, impulse = 0, np.zeros(3)
    while steps := pushes.steps_to_change(step):
        impulse += pushes.acceleration(step) * steps * STEP
        step += steps
    assert not pushes.acceleration(step).any()
    # A thousandth of a thousandth of a step is rounding.
    np.testing.assert_allclose(impulse, [3 * duration, 2 * STEP, -duration], rtol=0, atol=1e-5 * STEP)


def test_a_push_shorter_than_a_step_moves_the_robot_as_a_longer_one_does():
    robot = dd.Robot.load("matched")
    still = dd.Commands(0.01, np.zeros((60, 2)))

    def pushed(start, duration):
        push = dd.Push(start=start, duration=duration, acceleration=(0.2 / duration, 0.0, 0.0))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", PhysicsWarning)
            return float(dd.simulate(robot, still, world=dd.World(friction=1e-3, pushes=(push,))).truth[-1, 0])

    whole = pushed(0.1, 0.002)
    assert whole > 0.05
    assert [pushed(0.1, 1e-4), pushed(0.1005, 1e-3)] == pytest.approx([whole] * 2, rel=1e-9)
    # Across the border of two steps: half of it 2 ms later.
    assert pushed(0.1015, 1e-3) == pytest.approx(whole, rel=0.01)


def test_a_push_that_never_comes():
    pushes = Pushes([dd.Push(start=1e90, duration=1e90, acceleration=(1.0, 0.0, 0.0))], STEP)
    assert not pushes.acceleration(0).any()
    assert pushes.steps_to_change(0) > 1e15
