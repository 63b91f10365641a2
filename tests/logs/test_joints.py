"""The wheels among joints: by their names, by what was said, and wherever a message has them."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from helpers import refused

from diffdrive_mj.logs._joints import Joints


def message(names, position):
    stamp = SimpleNamespace(sec=1, nanosec=0)
    return SimpleNamespace(name=list(names), position=position, header=SimpleNamespace(stamp=stamp))


def joints(left=None, right=None):
    return Joints(Path("log"), "/j", left, right, "header")


def test_a_message_may_have_more_positions_or_just_enough():
    kept = joints()
    kept.add(message(("right", "left", "arm"), [2.0, 1.0]), 0, 1)
    kept.add(message(("right", "left", "arm"), [4.0, 3.0, 9.0]), 0, 2)
    np.testing.assert_array_equal(kept.seen().values(), [[1, 2], [3, 4]])
    with refused(ValueError, "log, /j, message 3: 1 positions for 2 joints: the wheels' angles are needed"):
        kept.add(message(("right", "left"), [4.0]), 0, 3)


@pytest.mark.parametrize("other", [("left",), ("right",), ("arm",)])
def test_messages_without_both_are_passed_over(other):
    kept = joints()
    kept.add(message(other, [7.0]), 0, 1)
    kept.add(message(("left", "right"), [1.0, 2.0]), 0, 2)
    np.testing.assert_array_equal(kept.seen().values(), [[1, 2]])
    assert kept.seen().at(0) == "log, /j, message 2"


def test_what_there_is_instead_is_listed_once():
    kept = joints(left="l")
    for number, names in enumerate((("arm", "right"), ("hand",), ("arm", "right")), 1):
        kept.add(message(names, [0.0, 0.0]), 0, number)
    with refused(ValueError, "log, /j: no message has the joints 'l' and 'right': choose", "from arm, right, hand"):
        kept.seen()


def test_several_of_one_side():
    """Two are as many as may not be told apart, whether or not they say that they are wheels."""
    for names in (("left_a", "left_b", "right"), ("left_wheel_a", "left_wheel_b", "left_arm", "right")):
        with refused(
            ValueError, f"log, /j: {names[0]}, {names[1]} may be the left wheel: name one, as in Topics(left="
        ):
            joints().add(message(names, [0.0] * 4), 0, 1)
    kept = joints()
    kept.add(message(("left_arm", "left_wheel", "right"), [9.0, 1.0, 2.0]), 0, 1)
    np.testing.assert_array_equal(kept.seen().values(), [[1, 2]])
