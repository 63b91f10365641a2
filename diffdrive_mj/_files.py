"""Files written whole or not at all."""

from __future__ import annotations

import os
from pathlib import Path

from diffdrive_mj.errors import InvalidValue


def write_whole(path: str | Path, text: str) -> None:
    """Write a text file whole or not at all; an earlier one stays until the new one is complete.

    Raises:
        InvalidValue: it cannot be written.
    """
    path = Path(path)
    new = path.with_name(f".{path.name}-{os.getpid()}")
    try:
        try:
            new.write_text(text, encoding="utf-8", newline="\n")
            new.replace(path)
        finally:
            new.unlink(missing_ok=True)
    except (OSError, UnicodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        raise InvalidValue(f"{path}: cannot be written ({reason})") from None
