"""What is kept of the messages of a topic."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

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
