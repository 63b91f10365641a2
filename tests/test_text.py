"""Numbers in print."""

import pytest

from diffdrive_mj._text import listed, quantity, shown


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (18.97, "19.0 m"), (0.0123, "12.3 mm"), (1.6e-8, "16.0 nm"), (2.2e-6, "2.20 µm"), (-0.5, "-500 mm"),
        (0, "0.00 m"), (0.9993, "999 mm"), (0.99999, "1.00 m"), (999.9, "1.00 km"), (3e-14, "0.0300 pm"),
    ],
)  # fmt: skip
def test_a_quantity_gets_the_prefix_that_reads_best(value, expected):
    assert quantity(value, "m") == expected


def test_a_long_or_unprintable_value_is_not_shown_in_full():
    assert shown("a" * 58) == repr("a" * 58)
    assert shown("a" * 59) == repr("a" * 30) + "..."
    assert shown(10**59) == str(10**59)
    assert shown(10**60) == "an int"
    assert shown([0.0] * 30) == "a list"


@pytest.mark.parametrize("name", ["b\x1b[31m", "two\nlines"])
def test_an_object_shows_no_control_characters(name):
    """A string's repr has none; that of somebody's class may."""
    odd = type("Odd", (), {"__repr__": lambda self: name})()
    assert shown(odd) == "an Odd"


def test_more_names_than_fit_are_counted():
    names = [f"n{k}" for k in range(22)]
    assert listed(names[:20]) == ", ".join(names[:20])
    assert listed(names[:21]) == ", ".join(names[:20]) + ", and 1 more"
    assert listed(names, most=2) == "n0, n1, and 20 more"
