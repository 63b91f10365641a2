"""What is kept of the messages of a topic."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from helpers import refused

from diffdrive_mj.logs._bag import Stamped


def stamp(nanoseconds):
    return SimpleNamespace(sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9)


@pytest.mark.parametrize(
    ("stamps", "headers", "times", "said"),
    [
        ("header", (0, 1_000_000_002, 3_000_000_000), (0.0, 1.000000002, 3.0), False),
        ("header", (0, 0, 0), (1e-8, 2e-8, 3e-8), True),
        ("bag", (5, 6, 7), (1e-8, 2e-8, 3e-8), False),
        ("bag", (0, 0, 0), (1e-8, 2e-8, 3e-8), False),
    ],
)
def test_times_of_the_headers_or_of_the_bag(stamps, headers, times, said):
    seen = Stamped(Path("log"), "/p", 2, stamps)
    for k, header in enumerate(headers, 1):
        seen.add(stamp(header), 10 * k, k, (k, -k))
    found, known = seen.times()
    np.testing.assert_array_equal(found, times)
    assert known == (("/p: the headers' stamps are all zero, those of the bag were taken",) if said else ())
    np.testing.assert_array_equal(seen.values(), [(1, -1), (2, -2), (3, -3)])


def test_the_last_message_alone():
    seen = Stamped(Path("log"), "/tf", 2)
    for k in (1, 2, 4, 7):
        seen.add(stamp(0), k, k, (k, 10 * k))
    last = seen.last()
    assert (len(last), last.at(0), last.times()[1]) == (1, "log, /tf, message 7", ())
    np.testing.assert_array_equal(last.values(), [(7, 70)])
    assert seen.at(2) == "log, /tf, message 4"


def test_warnings_name_the_topic_and_refusals_the_bag_too():
    seen = Stamped(Path("log"), "/p", 7)
    seen.add(stamp(10**9), 0, 1, (1, 2, 0, 0, 0, 0, 1))
    with refused(ValueError, "log, /p: 1 samples: must be at least two"):
        seen.poses()
    seen = Stamped(Path("log"), "/p", 7)
    for number in (1, 2, 3):
        seen.add(stamp(10**9 * min(number, 2)), 0, number, (min(number, 2), 2, 0, 0, 0, 0, 1))
    t, poses, said = seen.poses()
    assert (t.tolist(), poses.tolist()) == ([1, 2], [[1, 2, 0], [2, 2, 0]])
    assert said == ("/p: 1 repeated sample dropped",)
