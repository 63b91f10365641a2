"""Stages: one of them is done in another way, and the others rightly."""

import numpy as np

import diffdrive_mj as dd
from diffdrive_mj.judging.stages import Stages
from diffdrive_mj.judging.tasks import Task

ROBOT = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
TASK = Task("any", ROBOT, [0.0, 1.0, 2.0], [(0, 0), (10, 10), (20, 30)])


def test_a_motion_that_is_not_finite_answers_no_numbers_in_the_shape_of_poses():
    answer = Stages(motion=lambda ds, turn, dt: (ds / 0.0, turn), answer=lambda poses: 0 * poses).solve(TASK)
    assert answer.shape == (3, 3)
    assert np.isnan(answer).all()


def test_motions_that_are_changed_twice_are_changed_one_after_the_other():
    later = Stages(motion=lambda ds, turn, dt: (ds + dt, turn))
    twice = Stages(motion=lambda ds, turn, dt: (2 * ds, -turn))
    assert twice.and_(later).moved(TASK).tolist() == [[3.0, 0.0], [4.0, -2.5]]
    assert later.and_(twice).moved(TASK).tolist() == [[4.0, 0.0], [5.0, -2.5]]
    assert Stages(radii=(1.0, 1.0)).and_(Stages(radii=(2.0, 2.0))) is None
