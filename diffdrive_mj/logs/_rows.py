"""The rows of a text file, read in blocks so that memory does not grow with it, and the number of each one's line."""

from __future__ import annotations

import bisect
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TextIO

import numpy as np

from diffdrive_mj._files import as_path
from diffdrive_mj._progress import Advance, progress
from diffdrive_mj.errors import DiffdriveError, InvalidValue, MissingFile

# Characters: of a block, and of the longest line.
_BLOCK, _LONGEST = 1 << 18, 1 << 24


class Rows:
    """The lines of a text file that are neither blank nor a comment, which starts with #.

    Attributes:
        path: of the file.
        comment: the last comment before the first row, without its mark; empty if there is none.
    """

    def __init__(self, path: Path, file: TextIO, advance: Advance) -> None:
        self.path = path
        self.comment = ""
        self._file, self._advance = file, advance
        # Where the numbers of rows and lines part anew: rows, ascending from 0, and their lines, from 1.
        self._rows: list[int] = []
        self._lines: list[int] = []

    def line(self, row: int) -> int:
        """The number of a row's line in the file, from 1."""
        k = bisect.bisect(self._rows, row) - 1
        return self._lines[k] + row - self._rows[k]

    def blocks(self) -> Iterator[list[str]]:
        """The rows, some thousand at a time; none of the blocks is empty."""
        row, line = 0, 1
        while block := self._file.read(_BLOCK):
            block += self._file.readline(_LONGEST)
            if not block.endswith("\n") and len(block) >= _LONGEST:
                raise InvalidValue(f"{self.path}: cannot be read (a line of more than {_LONGEST} characters)")
            lines = block.split("\n")
            found = [k for k, text in enumerate(lines) if (start := text.lstrip()) and start[0] != "#"]
            if not row:
                self._keep_comment(lines[: found[0] if found else None])
            if found:
                self._count(row, line, found)
                yield lines if len(found) == len(lines) else [lines[k] for k in found]
            row += len(found)
            line += len(lines) - 1
            self._advance(len(block))

    def _keep_comment(self, lines: list[str]) -> None:
        for text in lines:
            if text.strip():
                self.comment = text.lstrip("# \t")

    def _count(self, row: int, line: int, found: list[int]) -> None:
        """Remember the lines of rows that were found at some indices from a line on."""
        at = np.array(found)
        for k in np.concatenate([[0], np.flatnonzero(np.diff(at) > 1) + 1]).tolist():
            if not row + k or self.line(row + k) != line + found[k]:
                self._rows.append(row + k)
                self._lines.append(line + found[k])


@contextmanager
def open_rows(path: str | Path) -> Iterator[Rows]:
    """Open a text file, to be read once.

    Raises:
        InvalidType: not a path.
        MissingFile: no such file.
        InvalidValue: it cannot be read, or a line is too long.
    """
    path = as_path("path", path)
    try:
        with path.open(encoding="utf-8-sig") as file:
            size = os.fstat(file.fileno()).st_size or None
            with progress(f"reading {path.name}", size, "B") as advance:
                yield Rows(path, file, advance)
    except DiffdriveError:
        raise
    except FileNotFoundError:
        raise MissingFile(f"{path}: no such file") from None
    except OSError as error:
        raise InvalidValue(f"{path}: cannot be read ({error.strerror})") from None
    except UnicodeError:
        raise InvalidValue(f"{path}: cannot be read (not a text file in UTF-8)") from None


def is_text(head: bytes) -> bool:
    """Whether a file that begins so may be a text in UTF-8."""
    try:
        return "\0" not in head.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        # The beginning may end within a character.
        return error.start > 0 and error.start >= len(head) - 3 and b"\0" not in head
