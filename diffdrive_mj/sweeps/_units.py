"""In which unit figures of trials are printed."""

from __future__ import annotations

import math


def unit_of(figure: str) -> tuple[str, float]:
    """The unit of a figure by its name, and the factor from SI to it."""
    over = "/m" if figure.endswith("_per_metre") else ""
    if "position" in figure:
        return f"mm{over}", 1e3
    if "heading" in figure:
        return f"deg{over}", 180 / math.pi
    return ("m", 1.0) if figure == "distance" else ("", 1.0)


def in_words(figure: str) -> str:
    """A figure as text says it."""
    return figure.replace("_", " ").replace("position", "position error").replace("heading", "heading error")
