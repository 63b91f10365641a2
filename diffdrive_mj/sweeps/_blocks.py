"""The blocks of a design for Sobol' indices, known by what was drawn.

The trials are n (D + 2): A, B, and for each of the D numbers that vary a block that is A with that number out of B.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

Drawn = Mapping[str, NDArray[Any]]


def rows_a_block(drawn: Drawn, trials: int) -> int | None:
    """The number n of trials in each block; None if the trials are not of such a design."""
    blocks = len(drawn) + 2
    rows = trials // blocks
    if not drawn or rows < 2 or trials != rows * blocks:
        return None
    columns = [np.reshape(values, (blocks, rows)) for values in drawn.values()]
    # Words and whole numbers repeat by chance, in which case nothing is proven.
    if not any(len(np.unique(column[:2])) == 2 * rows for column in columns):
        return None
    for k, column in enumerate(columns):
        expected = np.repeat(column[:1], len(drawn), axis=0)
        expected[k] = column[1]
        if not np.array_equal(column[2:], expected):
            return None
    return rows


def independent(drawn: Drawn, trials: int) -> NDArray[np.bool_]:
    """Which trials are independent of each other (N,): all, or A and B."""
    rows = rows_a_block(drawn, trials)
    return np.arange(trials) < (trials if rows is None else 2 * rows)


def groups(drawn: Drawn, trials: int) -> NDArray[np.int64]:
    """For each trial the number of the row that it shares with others (N,): its own if it is independent."""
    rows = rows_a_block(drawn, trials)
    return np.arange(trials) % (trials if rows is None else rows)
