"""Numbers in print."""

import pytest

from diffdrive_mj._text import quantity


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (18.97, "19.0 m"), (0.0123, "12.3 mm"), (1.6e-8, "16.0 nm"), (2.2e-6, "2.20 µm"), (-0.5, "-500 mm"),
        (0, "0.00 m"), (0.99999, "1.00 m"), (999.9, "1.00 km"), (3e-14, "0.0300 pm"),
    ],
)  # fmt: skip
def test_a_quantity_gets_the_prefix_that_reads_best(value, expected):
    assert quantity(value, "m") == expected
