"""How values and results read in print."""

from __future__ import annotations

import html
import re
from collections.abc import Iterable, Sequence
from numbers import Integral, Real
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # errors, and with them the program's help, do without numpy
    from numpy.typing import ArrayLike

# A longer repr is not shown in a message.
_LONGEST = 60


def shown(value: object) -> str:
    """A value in a message of one line: its repr if that is short, else the beginning of a string, or what it is."""
    try:
        text = repr(value)
    except Exception:  # an integer of thousands of digits, an object that is half made
        text = "\n"
    if len(text) <= _LONGEST and text.isprintable():
        return text
    if isinstance(value, str):
        return f"{value[: _LONGEST // 2]!r}..."
    return a(type(value).__name__) + (f" of shape {value.shape}" if hasattr(value, "shape") else "")


def one_line(text: str) -> str:
    """A text with line breaks, control characters and whatever else cannot be printed shown by their numbers."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def listed(names: Sequence[str], most: int = 20) -> str:
    """Names in a message, and how many more there are."""
    more = [f"and {len(names) - most} more"] if len(names) > most else []
    return ", ".join([*names[:most], *more])


def a(noun: str) -> str:
    """A noun with its article."""
    return f"{'an' if noun[0] in 'aeiouAEIOU' else 'a'} {noun}"


def span(value: ArrayLike, unit: str, scale: float = 1.0, digits: int = 4) -> str:
    """One number to some digits, or the range of many."""
    import numpy as np

    low, high = (f"{scale * extreme:.{digits}g}" for extreme in (np.min(value), np.max(value)))
    return f"{low} {unit}" if low == high else f"{low} to {high} {unit}"


def quantity(value: float, unit: str, digits: int = 3) -> str:
    """A number with the prefix of its unit that reads best, such as 0.0123 m as 12.3 mm."""
    prefixes = {1e3: "k", 1.0: "", 1e-3: "m", 1e-6: "µ", 1e-9: "n", 1e-12: "p"}
    size = abs(value)
    scale = next((scale for scale in prefixes if size >= scale * (1 - 0.5 * 10**-digits)), 1.0 if size == 0 else 1e-12)
    return f"{value / scale:#.{digits}g}".rstrip(".") + f" {prefixes[scale]}{unit}"


def yaml_number(value: float) -> str:
    """A number that YAML 1.1 reads as one: its floats have a point, also before an exponent."""
    digits = repr(value)
    return digits if "." in digits else digits.replace("e", ".0e")


def table(header: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """A table in plain text: the first column to the left, the others to the right, numbers to four digits."""
    cells = [list(header), *([_cell(value) for value in row] for row in rows)]
    widths = [max(len(row[i]) for row in cells) for i in range(len(header))]
    lines = [
        "  ".join([row[0].ljust(widths[0]), *(c.rjust(w) for c, w in zip(row[1:], widths[1:], strict=True))]).rstrip()
        for row in cells
    ]
    return "\n".join([lines[0], "-" * len(lines[0]), *lines[1:]])


def markdown_table(header: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A table in Markdown: whatever the cells hold is shown as it is."""
    lines = [[_in_markdown(_cell(value)) for value in row] for row in (header, ["---"] * len(header), *rows)]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines)


def _in_markdown(text: str) -> str:
    return re.sub(r"([|`*<\[\]\\])", r"\\\1", text).replace("\n", " ")


def html_table(rows: Iterable[Sequence[object]], header: Sequence[str] = (), caption: str = "") -> str:
    """A table for notebooks: whatever the cells hold is shown as it is, and none of it is read as HTML."""
    parts = [f"<caption>{html.escape(caption)}</caption>"] if caption else []
    parts += [_html_row(header, "th")] if header else []
    return "\n".join(["<table>", *parts, *(_html_row(row, "td") for row in rows), "</table>"])


def _html_row(cells: Sequence[object], tag: str) -> str:
    return "<tr>" + "".join(f"<{tag}>{html.escape(_cell(cell))}</{tag}>" for cell in cells) + "</tr>"


def _cell(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, Real) and not isinstance(value, Integral) else str(value)
