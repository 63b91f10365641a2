"""What is written beside the pictures."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from diffdrive_mj._text import quantity
from diffdrive_mj.report.filming._ground import ground
from diffdrive_mj.report.filming._scene import GHOSTS, TRUE, Rgb, square_side
from diffdrive_mj.report.filming._take import Take

# Smaller distances are nobody's business [m].
_LEAST = 1e-6


@dataclass(frozen=True)
class Entry:
    """A piece of a caption, behind a spot of the colour that it explains if there is one."""

    text: str
    colour: Rgb | None = None


def caption(whole: Take, seen: Take, frame: int, speed: float = 1.0) -> list[Entry]:
    """What is written below a frame of a film: time, k, who is who, and how far each ghost is from the robot."""
    end = float(np.abs(whole.t).max())
    entries = [Entry(f"t = {seen.t[frame]:.{2 if end < 100 else 1}f} s")]
    if speed != 1:
        entries.append(Entry(f"speed x {speed:g}"))
    entries += [*_ratio(whole), Entry("robot", TRUE)]
    apart = seen.apart
    for (name, distances), colour in zip(whole.apart.items(), GHOSTS, strict=False):
        entries.append(Entry(f"{name}: {_fixed(float(apart[name][frame]), float(distances.max()))} off", colour))
    return [*entries, *_floor(whole)]


def legend(whole: Take, seen: Take) -> list[Entry]:
    """What is written below a strobe picture: who is who, k, and the times at which they are seen."""
    entries = [Entry("robot", TRUE)]
    entries += [Entry(name, colour) for name, colour in zip(whole.ghosts, GHOSTS, strict=False)]
    times = ", ".join(f"{t:.1f}" for t in seen.t)
    return [*entries, *_ratio(whole), Entry(f"at {times} s"), *_floor(whole)]


def finding(whole: Take, name: str = "") -> str:
    """What a drive has shown, with its numbers."""
    driven = float(whole.travelled[-1])
    after = quantity(driven, "m") if driven > whole.size else quantity(float(whole.t[-1] - whole.t[0]), "s")
    ends = {ghost: distance(float(distances[-1])) for ghost, distances in whole.apart.items()}
    if len(ends) > 1:
        off = ", ".join(f"{ghost} {end} off" for ghost, end in ends.items())
        return f"{name}, after {after}: {off}" if name else f"After {after}: {off}"
    (end,) = ends.values()
    return f"{name}: odometry {end} off after {after}" if name else f"After {after} odometry is {end} off"


def distance(value: float) -> str:
    """A distance [m], to no more digits than anybody needs."""
    return quantity(value, "m") if value >= _LEAST else "less than 1 µm"


def _ratio(whole: Take) -> list[Entry]:
    ratio = whole.speed_ratio
    return [] if ratio is None else [Entry(f"k = {ratio:.3f}")]


def _floor(whole: Take) -> list[Entry]:
    labels: dict[Rgb, list[str]] = {}
    for shape in ground(whole.world, whole.size):
        labels.setdefault(shape.colour[:3], []).append(shape.label)
    kinds = [Entry(f"{said[0]}{', ...' * (len(set(said)) > 1)}", colour) for colour, said in labels.items()]
    # A rough floor hides the squares of the level one.
    squares = [] if whole.world.rough else [Entry(f"squares of {square_side(whole.size):g} m")]
    return [*kinds, *_slope(whole), *squares]


def _slope(whole: Take) -> list[Entry]:
    """The floor is drawn level whatever its slope, along which the world's axes lie."""
    slope = whole.world.slope
    if slope is None or not slope.angle:
        return []
    return [Entry(f"slope of {100 * math.tan(slope.angle):.3g} %, up towards {math.degrees(slope.direction):.0f}°")]


def _fixed(value: float, largest: float) -> str:
    """A distance in the unit and with the decimals of the largest, so that the text does not jump."""
    if largest < _LEAST:
        return "less than 1 µm"
    scale, unit = next((s, u) for s, u in ((1.0, "m"), (1e-3, "mm"), (1e-6, "µm")) if largest >= s)
    decimals = 2 if largest / scale < 10 else 1 if largest / scale < 100 else 0
    return f"{value / scale:.{decimals}f} {unit}"
