"""Tables of numbers in text files; every error names the line and the column."""

from __future__ import annotations

import itertools
import math
from array import array
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from diffdrive_mj._checks import Array
from diffdrive_mj._text import shown
from diffdrive_mj.errors import InvalidValue, UnknownName
from diffdrive_mj.logs._rows import Rows, open_rows

Mask = NDArray[np.bool_]


class Table:
    """The table in a text file, whose head has been read and whose rows are read once.

    Args:
        rows: of the file, the head among them.
        delimiter: one character; a blank stands for any white space. By default the first of tab, semicolon and comma
            that the first row has, or else white space.
        header: whether the first row names the columns; by default it does where none of its cells is a number.
            A comment right before the first row, with as many cells, names them too.

    Attributes:
        path: of the file.
        names: of the columns, if a header names them.
        width: how many columns there are.

    Raises:
        InvalidValue: no rows.
    """

    def __init__(self, rows: Rows, delimiter: str | None, header: bool | None) -> None:
        self.path, self._rows, blocks = rows.path, rows, rows.blocks()
        first = next(blocks, [])
        if not first:
            raise InvalidValue(f"{self.path}: the file is empty")
        self._mark = next((d for d in "\t;," if d in first[0]), " ") if delimiter is None else delimiter
        self._separator = None if self._mark == " " else self._mark
        head = self._cells(first[0])
        self.width = len(head)
        self.names: tuple[str, ...] | None = None
        self._above = 0  # rows above the first one with numbers
        if header if header is not None else all(number_in(cell) is None for cell in head):
            self.names, self._above = tuple(head), 1
        elif header is None and rows.comment:
            names = self._cells(rows.comment)
            self.names = tuple(names) if len(names) == self.width else None
        body = first[self._above :] or next(blocks, [])
        if not body:
            raise InvalidValue(f"{self.path}: there is a header and nothing below it")
        self._blocks = itertools.chain([body], blocks)

    def index(self, what: str, column: int | str) -> int:
        """The index of a column.

        Args:
            what: the column holds, for the message.
            column: its name, or its number from 1.

        Raises:
            UnknownName: no column of the name.
            InvalidValue: no column of the number, a name that occurs twice, or a file without a header.
        """
        if isinstance(column, int):
            if not 1 <= column <= self.width:
                raise InvalidValue(f"{self.path}: {what} in column {column}: there are columns 1 to {self.width}")
            return column - 1
        if self.names is None:
            raise InvalidValue(
                f"{self.path}: {what} in column {column!r}: no header names the columns; give a number, 1 to "
                f"{self.width}"
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
        return f"{self.row(row)}, {self.label(index)}"

    def row(self, row: int) -> str:
        """How messages call a row."""
        return f"{self.path}, line {self._rows.line(self._above + row)}"

    def texts(self) -> list[list[str]]:
        """The cells of all the rows, as text."""
        return [[_bare(cell) for cell in row] for _, columns in self._parsed() for row in zip(*columns, strict=True)]

    def read(self, *groups: Sequence[int]) -> list[tuple[Array, Mask]]:
        """The numbers of columns that belong together, for each of several groups of columns.

        Args:
            groups: the indices of K columns each; a row has numbers in all of them or is empty in all of them.

        Returns:
            For each group the M rows that have them (M, K), and which of all N rows these are, a mask (N,).

        Raises:
            InvalidValue: a cell that is not a finite number, a row that has only some of a group, or rows of different
                lengths.
        """
        numbers, masks = [array("d") for _ in groups], [bytearray() for _ in groups]
        for row, columns in self._parsed():
            for group, kept, mask in zip(groups, numbers, masks, strict=True):
                values, there = self._group(row, [columns[index] for index in group], group)
                kept.frombytes(values.tobytes())
                mask.extend(there.tobytes())
        return [
            (np.frombuffer(kept).reshape(-1, len(group)), np.frombuffer(mask, dtype=np.bool_))
            for group, kept, mask in zip(groups, numbers, masks, strict=True)
        ]

    def _parsed(self) -> Iterator[tuple[int, list[list[str]]]]:
        """Block by block, the number of its first row and the cells of each column; read only once."""
        row = 0
        for block in self._blocks:
            widths = self._widths(block)
            if widths.count(self.width) != len(block):
                k = next(k for k, width in enumerate(widths) if width != self.width)
                raise InvalidValue(
                    f"{self.row(row + k)}: {widths[k]} cells where line {self._rows.line(0)} has {self.width}"
                )
            cells = self._mark.join(block).split(self._separator)
            yield row, [cells[k :: self.width] for k in range(self.width)]
            row += len(block)

    def _widths(self, block: list[str]) -> list[int]:
        """How many cells each row has."""
        if self._separator is None:
            return [len(row.split()) for row in block]
        return [row.count(self._separator) + 1 for row in block]

    def _cells(self, row: str) -> list[str]:
        return _all_bare(row.split(self._separator))

    def _group(self, first: int, columns: list[list[str]], group: Sequence[int]) -> tuple[Array, Mask]:
        """The numbers of a block's rows that have them, and which rows these are; the block begins at row `first`."""
        parsed = [_numbers(cells) for cells in columns]
        values, there = (np.stack(parts, axis=-1) for parts in zip(*parsed, strict=True))
        mask: Mask = np.asarray(there.all(axis=-1))
        torn = there.any(axis=-1) & ~mask
        if torn.any():
            row = int(np.argmax(torn))
            raise InvalidValue(
                f"{self.at(first + row, group[int(np.argmin(there[row]))])}: the cell is empty, "
                f"{self.label(group[int(np.argmax(there[row]))])} is not"
            )
        bad = ~np.isfinite(values) & there
        if bad.any():
            row, k = np.argwhere(bad)[0].tolist()
            self.number(_bare(columns[k][row]), first + row, group[k])
        return values[mask], mask

    def number(self, cell: str, row: int, index: int) -> float:
        """The number in a cell.

        Raises:
            InvalidValue: not a number, or not finite.
        """
        value = number_in(cell)
        if value is None:
            comma = ": decimal commas must be points" if number_in(cell.replace(",", ".", 1)) is not None else ""
            raise InvalidValue(f"{self.at(row, index)}: {shown(cell)} is not a number{comma}")
        if not math.isfinite(value):
            raise InvalidValue(
                f"{self.at(row, index)}: {shown(cell)}: must be finite; leave cells without a value empty"
            )
        return value


@contextmanager
def open_table(path: str | Path, delimiter: str | None = None, header: bool | None = None) -> Iterator[Table]:
    """Open the table in a text file. Blank lines and comments, which start with #, are skipped.

    Args:
        path: of the file.
        delimiter: as for `Table`.
        header: as for `Table`.

    Raises:
        InvalidType: not a path.
        MissingFile: no such file.
        InvalidValue: it cannot be read, or has no rows.
    """
    with open_rows(path) as rows:
        yield Table(rows, delimiter, header)


def _numbers(cells: list[str]) -> tuple[Array, Mask]:
    """The numbers in cells (N,), NaN where a cell is not one, and which cells are not empty (N,)."""
    text = "".join(cells)
    if text.isascii() and "_" not in text:
        # Most are numbers as they stand; others are padded with blanks, or in quotes.
        for prepare in (list, _all_bare):
            with suppress(ValueError):
                return _all_numbers(prepare(cells))
    bare = _all_bare(cells)
    found = [number_in(cell) for cell in bare]
    return np.array([math.nan if value is None else value for value in found]), np.array(bare, dtype=np.bool_)


def _all_numbers(cells: list[str]) -> tuple[Array, Mask]:
    """The same for cells each of which is a number or empty; a ValueError for others."""
    if "" not in cells:
        return np.fromiter(map(float, cells), np.float64), np.ones(len(cells), dtype=np.bool_)
    there = np.fromiter(map(bool, cells), np.bool_)
    values = np.full(len(cells), math.nan)
    values[there] = np.fromiter(map(float, filter(None, cells)), np.float64)
    return values, there


def _all_bare(cells: list[str]) -> list[str]:
    return [_bare(cell) for cell in cells]


def _bare(cell: str) -> str:
    """A cell without blanks and quotes around it."""
    return cell.strip().strip('"').strip()


def number_in(cell: str) -> float | None:
    """The number in a cell, finite or not; None if there is none."""
    # Python's own numbers may have underscores and the digits of any script.
    if "_" in cell or not cell.isascii():
        return None
    try:
        return float(cell)
    except ValueError:
        return None
