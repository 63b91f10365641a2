"""The published figures of the real robot's squares, as printed, and found again from its recordings."""

import math
from dataclasses import astuple

import pytest
from real_data import optiodom_folder

from diffdrive_mj.judging.optiodom import LARGE, SQUARE_A, SQUARE_B
from diffdrive_mj.judging.published_squares import PUBLISHED, SquareFigures, umbmark_figures

# Sousa et al. 2022: track width, right and left diameter, largest final error before and after [mm]; side [m].
PRINTED = {
    SQUARE_A: (201.46, 83.95, 84.05, 33.26, 7.16, 0.75),
    SQUARE_B: (201.22, 83.95, 84.05, 33.46, 7.43, 0.75),
    LARGE: (201.70, 83.98, 84.02, 113.89, 37.81, 1.70),
}


def test_the_table_is_the_printed_one():
    assert {name: (*astuple(figures), side) for name, (figures, side) in PUBLISHED.items()} == PRINTED


@pytest.mark.parametrize("field", range(5))
@pytest.mark.parametrize("off", [-0.03, 0.03])
def test_digits_are_counted_in_hundredths_of_a_millimetre_either_way(field, off):
    printed = list(PRINTED[LARGE][:5])
    changed = [value + off * (k == field) for k, value in enumerate(printed)]
    assert SquareFigures(*changed).digits_off(SquareFigures(*printed)) == 3.0
    assert math.isclose(SquareFigures(*printed).digits_off(SquareFigures(*printed)), 0.0)


@pytest.mark.parametrize("recording", PRINTED)
def test_the_printed_figures_come_out_of_the_recordings(recording):
    assert umbmark_figures(optiodom_folder(), recording).digits_off(PUBLISHED[recording][0]) < 0.5
