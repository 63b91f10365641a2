"""First guesses: of headings where these show a robot near the believed one, of the belief where they do not."""

import numpy as np
import pytest
from planted import BELIEVED, ideal, mixed

import diffdrive_mj as dd
from diffdrive_mj.calibration._first_guess import continued, linear_fit
from diffdrive_mj.estimation.derivatives import parameters_of

BELIEF = parameters_of(BELIEVED)


def driven(robot):
    return ideal(robot, mixed(period=0.05))


@pytest.mark.parametrize(("factor", "near"), [(0.41, True), (0.39, False), (1.59, True), (1.61, False)])
@pytest.mark.parametrize("name", ["left_radius", "right_radius", "track_width"])
def test_a_robot_more_than_three_fifths_off_is_not_believed(name, factor, near):
    robot = BELIEVED.replace(**{name: factor * getattr(BELIEVED, name)}, caster={"x": -0.2})
    assert linear_fit([driven(robot)], BELIEVED) == pytest.approx(parameters_of(robot) if near else BELIEF, rel=1e-6)


@pytest.mark.parametrize("flip", [(1, -1), (-1, 1), (-1, -1)])
def test_wheels_that_turn_the_wrong_way_show_no_robot(flip):
    """Reversed encoders: the left wheel would need a negative radius, or the right one, or both."""
    drive = driven(BELIEVED)
    reversed_ = dd.Drive(drive.t, drive.wheel_angles * flip, drive.truth, drive.clock)
    assert linear_fit([reversed_], BELIEVED) == pytest.approx(BELIEF)


@pytest.mark.parametrize("angles", ["alike", "one wheel"])
def test_wheels_that_always_turn_alike_show_no_robot(angles):
    t = np.arange(0.0, 10.0, 0.1)
    wheels = np.stack([5 * t, (5 if angles == "alike" else 0) * t], axis=-1)
    drive = dd.Drive(t, wheels, dd.odometry.integrate(wheels, BELIEVED))
    assert linear_fit([drive], BELIEVED) == pytest.approx(BELIEF)


def test_positions_that_go_the_other_way_show_no_track():
    """A path laid over its mirror image in the origin."""
    drive = driven(BELIEVED)
    mirrored = dd.Drive(drive.t, drive.wheel_angles, drive.truth * (-1, -1, 1), drive.clock)
    assert linear_fit([mirrored], BELIEVED) == pytest.approx(BELIEF)


def test_positions_that_stay_show_no_track():
    drive = driven(BELIEVED)
    assert linear_fit([dd.Drive(drive.t, drive.wheel_angles, drive.truth * (0, 0, 1))], BELIEVED) == pytest.approx(
        BELIEF
    )


@pytest.mark.parametrize("start", ["estimated", "position", "truth"])
def test_longer_and_longer_beginnings_lead_to_a_robot_far_off(start):
    """From positions alone: whole paths of a robot a third off would first have to unwind."""
    robot = BELIEVED.replace(left_radius=0.12, right_radius=0.09, track_width=0.45)
    guess = continued([driven(robot)], BELIEVED, start)
    assert guess == pytest.approx(parameters_of(robot), rel=2e-3)
