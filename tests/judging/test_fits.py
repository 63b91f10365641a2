"""Fits: how many digits the answers have, and how few answers say nothing about it."""

import numpy as np
import pytest

from diffdrive_mj.judging import _fits as fits

SINGLE = np.random.default_rng(7).normal(size=(5, 3)).astype(np.float32).astype(np.float64)


@pytest.mark.parametrize(
    ("size", "words"), [(1.0, "whole metres"), (0.01, "whole centimetres"), (1e-3, "whole millimetres")]
)
def test_five_answers_show_their_digits_and_four_do_not(size, words):
    whole = np.column_stack([np.arange(5) * size, 3 * np.arange(5) * size, np.sqrt(np.arange(5))])
    assert words in fits.digits(whole)
    assert fits.digits(whole[:4]) == ""
    assert fits.digits(whole[[0, 1, 2, 3, 3]]) == ""


def test_single_precision_is_seen_in_five_answers_and_not_in_the_numbers_of_fewer():
    assert fits.digits(SINGLE) == "the answers are in single precision: add up in double precision"
    assert fits.digits(SINGLE[:4]) == ""
    assert fits.digits(SINGLE[[0, 1, 2, 3] * 3]) == ""
    assert fits.digits(SINGLE + 1e-12) == ""
