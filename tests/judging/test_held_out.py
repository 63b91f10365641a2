"""Leaving one recording out: what is fitted on what, and judged on what."""

import numpy as np
from helpers import refused

import diffdrive_mj as dd
from diffdrive_mj.judging.held_out import drift_on, fitted_on, unseen

ROBOT = dd.Robot.load("matched")


def drive(metres):
    """A straight metre by the wheels, so many by the truth."""
    turned = 1 / ROBOT.left_radius
    return dd.Drive([0.0, 1.0], [(0, 0), (turned, turned)], [(0, 0, 0), (metres, 0, 0)])


RECORDINGS = {"a": [drive(1.0)], "b": [drive(1.1), drive(1.2)], "c": [drive(1.3)]}


def mean_scale(drives):
    """A fit that anyone can check: the mean of what the drives say of the wheels' size."""
    scale = float(np.mean([one.truth[-1, 0] for one in drives]))
    return ROBOT.replace(left_radius=scale * ROBOT.left_radius, right_radius=scale * ROBOT.right_radius)


def test_each_recording_is_judged_by_a_fit_on_the_others():
    found = unseen(RECORDINGS, mean_scale)
    np.testing.assert_allclose(found["a"].final_position, [1.2 - 1.0])
    np.testing.assert_allclose(found["b"].final_position, [1.15 - 1.1, 1.2 - 1.15])
    np.testing.assert_allclose(found["c"].final_position, [1.3 - 1.1])


def test_a_fit_on_some_recordings():
    np.testing.assert_allclose(fitted_on(RECORDINGS, mean_scale, "a", "c").left_radius, 1.15 * ROBOT.left_radius)
    np.testing.assert_allclose(drift_on(RECORDINGS["b"], ROBOT).final_position, [0.1, 0.2])


def test_a_single_recording_cannot_be_left_out():
    with refused(ValueError, "at least two"):
        unseen({"a": [drive(1.0)]}, mean_scale)
