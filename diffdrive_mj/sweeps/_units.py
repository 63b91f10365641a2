"""How figures of trials, and what varies in them, are called in print, and in which unit."""

from __future__ import annotations

import math

# Owners of what varies that go without saying.
_OF_THE_DRIVE = ("robot", "world", "maneuver")


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


def varied_in_words(name: str) -> str:
    """What varies as text says it: "robot.radius_ratio" is the radius ratio, "encoder.latency" the encoder latency."""
    owner, _, field = name.partition(".")
    said = field if owner in _OF_THE_DRIVE else name
    return said.replace(".", " ").replace("_", " ")
