"""Packages that only some of the work needs: imported where it is done, under a name that pip knows."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from diffdrive_mj.errors import MissingExtra


@contextmanager
def extra(name: str, package: str, what: str) -> Iterator[None]:
    """Import what is imported in the block, or say which command installs it.

    Args:
        name: of the extra.
        package: that is imported, as Python calls it.
        what: needs it, for the message.

    Raises:
        MissingExtra: it is not installed.
    """
    try:
        yield
    except ImportError as error:
        if (error.name or "").split(".")[0] != package:
            raise
        raise MissingExtra(what, package, name) from None
