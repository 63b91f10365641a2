"""Files: names that can be one, and text written whole or not at all."""

from __future__ import annotations

import secrets
import stat
from pathlib import Path

from diffdrive_mj.errors import InvalidType, InvalidValue


def checked_path(name: str, value: object) -> Path:
    """A string or a path that can name a file."""
    if not isinstance(value, (str, Path)):
        raise InvalidType(f"{name} = {value!r}: must be a string or a Path")
    if not str(value) or "\0" in str(value):
        raise InvalidValue(f"{name} = {str(value)!r}: must be the name of a file")
    return Path(value)


def write_whole(path: str | Path, text: str) -> None:
    """Write a text file whole or not at all; an earlier one stays until the new one is complete.

    A link is followed, and an earlier file's permissions are kept.

    Args:
        path: of the file.
        text: in UTF-8.

    Raises:
        InvalidType: a path of another type.
        InvalidValue: it cannot be written.
    """
    path = checked_path("path", path)
    try:
        target = path.resolve()
        new = target.with_name(f".{target.name[:100]}-{secrets.token_hex(8)}")
        try:
            # "x": nothing that is there already, not even a link, is written to.
            with new.open("x", encoding="utf-8", newline="\n") as file:
                file.write(text)
            if target.exists():
                new.chmod(stat.S_IMODE(target.stat().st_mode))
            new.replace(target)
        finally:
            new.unlink(missing_ok=True)
    except (OSError, ValueError, RuntimeError) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        raise InvalidValue(f"{path}: cannot be written ({reason})") from None
