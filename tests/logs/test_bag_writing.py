"""Times as stamps of bags."""

from pathlib import Path

import numpy as np
from helpers import refused

from diffdrive_mj.logs._bag_writing import _stamps


def test_stamps_are_whole_nanoseconds_to_the_last_that_31_bits_hold():
    t = np.array([0.0, 0.1, 1.0000000014, 2.0**31 - 1])
    assert _stamps(t, Path("log")).tolist() == [0, 100_000_000, 1_000_000_001, (2**31 - 1) * 10**9]
    with refused(ValueError, "log: times from 0 to 2147483648 s: a bag's stamps are from 0 to 2^31 s"):
        _stamps(np.array([0.0, 2.0**31]), Path("log"))


def test_the_first_two_times_of_one_stamp_are_named():
    t = np.array([0.0, 1.0, 1.0 + 2e-10, 2.0, 2.0 + 4e-10])
    with refused(ValueError, f"log: 1 and {t[2]:.17g} s are one stamp in whole nanoseconds"):
        _stamps(t, Path("log"))
