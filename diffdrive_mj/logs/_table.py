"""Tables of numbers in text files; every error names the line and the column."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from diffdrive_mj._checks import Array
from diffdrive_mj._files import as_path
from diffdrive_mj.errors import InvalidValue, MissingFile, UnknownName


@dataclass(frozen=True, eq=False)
class Table:
    """The cells of a text file.

    Attributes:
        path: of the file.
        names: of the columns, if a header names them.
        rows: the cells, as text.
        lines: the number of each row's line in the file, from 1.
    """

    path: Path
    names: tuple[str, ...] | None
    rows: list[list[str]]
    lines: list[int]

    def index(self, what: str, column: int | str) -> int:
        """The index of a column.

        Args:
            what: the column holds, for the message.
            column: its name, or its number from 1.

        Raises:
            UnknownName: no column of the name.
            InvalidValue: no column of the number, a name that occurs twice, or a file without a header.
        """
        width = len(self.rows[0])
        if isinstance(column, int):
            if not 1 <= column <= width:
                raise InvalidValue(f"{self.path}: {what} in column {column}: there are columns 1 to {width}")
            return column - 1
        if self.names is None:
            raise InvalidValue(
                f"{self.path}: {what} in column {column!r}: no header names the columns; give a number, 1 to {width}"
            )
        if column not in self.names:
            raise UnknownName(f"column of {self.path}", column, filter(None, self.names))
        if self.names.count(column) > 1:
            raise InvalidValue(f"{self.path}: {what} in column {column!r}: {self.names.count(column)} columns have it")
        return self.names.index(column)

    def label(self, index: int) -> str:
        """How messages call a column."""
        return f"column {index + 1}" + (f" ({self.names[index]})" if self.names else "")

    def at(self, row: int, index: int) -> str:
        """How messages call a cell."""
        return f"{self.path}, line {self.lines[row]}, {self.label(index)}"

    def column(self, index: int) -> Array:
        """The numbers of a column without empty cells."""
        values, there = self.columns([index])
        if not there.all():
            raise InvalidValue(f"{self.at(int(np.argmin(there)), index)}: the cell is empty")
        return values[:, 0]

    def columns(self, indices: Sequence[int]) -> tuple[Array, NDArray[np.bool_]]:
        """The numbers of K columns that belong together.

        Returns:
            The N rows that have them (N, K), and which of all rows these are, a mask.

        Raises:
            InvalidValue: a cell that is not a finite number, or a row that has only some of them.
        """
        there = np.array([[bool(row[index]) for index in indices] for row in self.rows])
        torn = there.any(axis=1) & ~there.all(axis=1)
        if torn.any():
            row = int(np.argmax(torn))
            raise InvalidValue(
                f"{self.at(row, indices[int(np.argmin(there[row]))])}: the cell is empty, "
                f"{self.label(indices[int(np.argmax(there[row]))])} is not"
            )
        mask = np.asarray(there.all(axis=1))
        values = [[self.number(int(row), index) for index in indices] for row in np.flatnonzero(mask)]
        return np.array(values, dtype=np.float64).reshape(-1, len(indices)), mask

    def number(self, row: int, index: int) -> float:
        """The number in a cell."""
        cell = self.rows[row][index]
        value = _number(cell)
        if value is None:
            raise InvalidValue(f"{self.at(row, index)}: {cell!r} is not a number")
        if not math.isfinite(value):
            raise InvalidValue(f"{self.at(row, index)}: {cell!r}: must be finite; leave cells without a value empty")
        return value


def read_table(path: str | Path, delimiter: str | None = None, header: bool | None = None) -> Table:
    """Read the table in a text file. Blank lines and comments, which start with #, are skipped.

    Args:
        path: of the file.
        delimiter: one character; a blank stands for any white space. By default the first of tab, semicolon and comma
            that the first line has, or else white space.
        header: whether the first line names the columns; by default it does where none of its cells is a number.
            A comment right before the first row, with as many cells, names them too.

    Raises:
        InvalidType: not a path.
        MissingFile: no such file.
        InvalidValue: it cannot be read, has no rows, or rows of different lengths.
    """
    path = as_path("path", path)
    try:
        text = path.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise MissingFile(f"{path}: no such file") from None
    except OSError as error:
        raise InvalidValue(f"{path}: cannot be read ({error.strerror})") from None
    except UnicodeError:
        raise InvalidValue(f"{path}: cannot be read (not a text file in UTF-8)") from None
    numbered = [(k, line) for k, line in enumerate(text.split("\n"), 1) if line.strip()]
    given = [(k, line) for k, line in numbered if not line.lstrip().startswith("#")]
    if not given:
        raise InvalidValue(f"{path}: the file is empty")
    mark = next((d for d in "\t;," if d in given[0][1]), " ") if delimiter is None else delimiter
    rows, lines = [_cells(line, mark) for _, line in given], [k for k, _ in given]
    for row, k in zip(rows, lines, strict=True):
        if len(row) != len(rows[0]):
            raise InvalidValue(f"{path}, line {k}: {len(row)} cells where line {lines[0]} has {len(rows[0])}")
    names: tuple[str, ...] | None = None
    if header if header is not None else all(_number(cell) is None for cell in rows[0]):
        names, rows, lines = tuple(rows[0]), rows[1:], lines[1:]
    elif header is None:
        comment = [line.lstrip("# \t") for k, line in numbered if k < lines[0]][-1:]
        cells = _cells(comment[0], mark) if comment else []
        names = tuple(cells) if len(cells) == len(rows[0]) else None
    if not rows:
        raise InvalidValue(f"{path}: there is a header and nothing below it")
    return Table(path, names, rows, lines)


def _cells(line: str, delimiter: str) -> list[str]:
    cells = line.split() if delimiter == " " else line.split(delimiter)
    return [cell.strip().strip('"').strip() for cell in cells]


def _number(cell: str) -> float | None:
    # Python's own numbers may have underscores and the digits of any script.
    if "_" in cell or not cell.isascii():
        return None
    try:
        return float(cell)
    except ValueError:
        return None
