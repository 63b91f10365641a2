"""Progress of what takes longer than two seconds, on a terminal."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Protocol

# Work that is done sooner shows nothing [s].
DELAY = 2.0


class Advance(Protocol):
    """Says that some more of the work is done."""

    def __call__(self, amount: float, /) -> object: ...


@contextmanager
def progress(what: str, total: float | None, unit: str) -> Iterator[Advance]:
    """Show on stderr how far work has come, if it takes longer and a person is there to see it.

    Args:
        what: is done, for the line that is shown.
        total: how much there is to do; None if nobody knows.
        unit: of the total, such as "B" for bytes.
    """
    from tqdm import tqdm

    with tqdm(desc=what, total=total, unit=unit, unit_scale=True, delay=DELAY, disable=None, leave=False) as bar:
        yield bar.update
