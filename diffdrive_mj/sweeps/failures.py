"""What ends a sweep, and what it warns of."""

from __future__ import annotations

from diffdrive_mj.errors import DiffdriveError


class SweepFailed(DiffdriveError, RuntimeError):
    """A sweep that cannot go on: processes that die again and again, a scheduler that does not answer.

    Chunks that were done are kept in the sweep's folder.

    Example:
        >>> issubclass(SweepFailed, dd.DiffdriveError)
        True
    """


class SweepWarning(UserWarning):
    """A chunk of a sweep that is run again or left out, since its file is not whole.

    Example:
        A test that must not find any makes errors of them:

        >>> import warnings
        >>> with warnings.catch_warnings():
        ...     warnings.simplefilter("error", SweepWarning)
    """
