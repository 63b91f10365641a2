"""Turns of wheels: what a log counted as angles, and by how much an angle within one turn may be off it."""

from pathlib import Path

import numpy as np
import pytest
from helpers import refused

import diffdrive_mj as dd
from diffdrive_mj.logs import Columns
from diffdrive_mj.logs._wheels import wheel_angles, wrapped

ROBOT = dd.Robot(left_radius=0.05, right_radius=0.04, track_width=0.3, encoder={"ticks_per_revolution": 1000})
TURNED = np.array([[0.0, 0.0], [3.0, 5.0]])


@pytest.mark.parametrize(
    ("options", "factors"),
    [
        ({}, (1, 1)),
        ({"gear": 4}, (0.25, 0.25)),
        ({"reverse_left": True}, (-1, 1)),
        ({"reverse_right": True}, (1, -1)),
        ({"wheel_unit": "ticks"}, (np.pi / 500, np.pi / 500)),
        ({"wheel_unit": "ticks", "ticks_per_revolution": 8}, (np.pi / 4, np.pi / 4)),
        ({"wheel_unit": "metres"}, (20, 25)),
    ],
)
def test_angles_of_what_was_counted(options, factors):
    found = wheel_angles(TURNED, Columns(**options), ROBOT, Path("log"))
    np.testing.assert_allclose(found, TURNED * factors, rtol=1e-15)


def test_ticks_without_a_robot_need_their_number():
    columns = Columns(wheel_unit="ticks", ticks_per_revolution=8)
    np.testing.assert_allclose(wheel_angles(TURNED, columns, None, Path("log")), TURNED * np.pi / 4, rtol=1e-15)
    with refused(ValueError, "log: wheels in ticks need Columns.ticks_per_revolution or a robot"):
        wheel_angles(TURNED, Columns(wheel_unit="ticks"), None, Path("log"))


@pytest.mark.parametrize(
    ("count", "span", "said"), [(10, 1.0, 1), (9, 1.0, 0), (10, 1 + 0.9e-6, 1), (10, 1 + 1.1e-6, 0), (10, 0.49, 0)]
)
def test_ten_samples_within_a_turn_that_jump_by_half_of_it_are_wrapped(count, span, said):
    jumping = np.where(np.arange(count) % 2, span, 0.0)
    assert len(wrapped((jumping, np.arange(count)), "rotations")) == said


def test_numbers_beyond_all_sizes_are_no_turn():
    """Whose angles have no span, and which a drive refuses later."""
    beyond = np.full(10, 1e308)
    assert wrapped((beyond, -beyond), "rotations") == ()
