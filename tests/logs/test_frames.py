"""Chains of transforms: which are meant, and the poses along them."""

from pathlib import Path

import numpy as np
import pytest
from helpers import refused

from diffdrive_mj.logs._frames import Edge, chain, composed

LOG = Path("log")
MOVING = {("map", "odom"): False, ("odom", "base"): False, ("base", "laser"): True}


@pytest.mark.parametrize(
    ("frame", "child", "way"),
    [
        ("map", "laser", [("map", "odom"), ("odom", "base"), ("base", "laser")]),
        ("odom", "base", [("odom", "base")]),
        ("map", None, [("map", "odom")]),
        (None, "base", [("odom", "base")]),
    ],
)
def test_the_way_between_frames(frame, child, way):
    assert chain(MOVING, frame, child, LOG) == way


@pytest.mark.parametrize(
    ("frame", "child", "words"),
    [
        (None, None, "log: several of the transforms map -> odom, odom -> base may be meant: name two frames"),
        ("base", None, "log: none of the transforms map -> odom, odom -> base, base -> laser may be meant"),
        (None, "laser", "log: none of the transforms"),
        ("laser", "map", "no transforms from 'laser' to 'map': there are map -> odom, odom -> base, base -> laser"),
    ],
)
def test_frames_that_leave_none_or_several(frame, child, words):
    with refused(ValueError, words):
        chain(MOVING, frame, child, LOG)
    with refused(ValueError, "log: its messages hold no transforms"):
        chain({}, "map", None, LOG)


def test_the_only_one_that_moves_needs_no_name():
    assert chain({("base", "laser"): True, ("odom", "base"): False}, None, None, LOG) == [("odom", "base")]


def test_a_way_through_a_circle_and_past_a_dead_end():
    """Of two parents of a frame the first leads round, the second up."""
    pairs = dict.fromkeys([("b", "a"), ("a", "b"), ("x", "b"), ("top", "b")], False)
    assert chain(pairs, "top", "a", LOG) == [("top", "b"), ("b", "a")]


def straight(*t):
    """Along x at 1 m/s, from zero at time zero."""
    return Edge(np.array(t, dtype=float), np.array([(at, 0.0, 0.0) for at in t]))


def test_poses_at_the_times_of_the_densest_that_all_know_ends_included():
    still = Edge(np.array([100.0]), np.array([(0.0, 2.0, np.pi / 2)]))
    t, poses = composed([still, straight(0, 1, 2, 3), straight(1, 3)], LOG)
    assert t.tolist() == [1, 2, 3]
    np.testing.assert_allclose(poses, [(0, 2 + 2 * at, np.pi / 2) for at in (1, 2, 3)], atol=1e-15)


def test_what_does_not_move_or_is_not_known_together():
    still = Edge(np.zeros(1), np.zeros((1, 3)))
    with refused(ValueError, "log: nothing between these frames moves"):
        composed([still, still], LOG)
    with refused(ValueError, "log: at 1 times all transforms between these frames are known: must be two"):
        composed([straight(0, 1, 2), straight(2, 3)], LOG)
    assert composed([straight(0, 1, 2), straight(1, 3)], LOG)[0].tolist() == [1, 2]
