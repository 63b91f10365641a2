"""How much of a page each of its parts may take, so that the whole stays small whatever there is to show."""

from __future__ import annotations

import html
from dataclasses import dataclass


@dataclass
class Room:
    """Bytes that some parts share: each may take an even share of what is left, but never less than is worth showing.

    Attributes:
        left: bytes that nobody has taken.
        parts: that have not had their turn.
        least: so much is worth showing; what is left may end before the parts do.
        most: so much is always enough.
    """

    left: int
    parts: int
    least: int
    most: int

    def share(self) -> int:
        """What the next part may take; 0 where nothing worth showing is left."""
        even = self.left // max(self.parts, 1)
        self.parts -= 1
        share = min(self.most, max(even, self.least))
        return share if share <= self.left else 0

    def take(self, size: int) -> None:
        """Note what a part has taken."""
        self.left -= size


def escaped(text: str, most: int) -> str:
    """A text for HTML, of so many bytes at most; of a longer one the beginning, and that there is more."""
    if len(text) <= most and len((whole := html.escape(text)).encode()) <= most:
        return whole
    text = text[:most]
    while len((whole := f"{html.escape(text)} … (cut short)").encode()) > most and text:
        text = text[: int(0.8 * len(text))]
    return whole
