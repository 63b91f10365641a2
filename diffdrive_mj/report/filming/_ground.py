"""What lies on the floor of a world, as shapes: a new kind of world adds a function to `GROUNDS`."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from diffdrive_mj._checks import Array
from diffdrive_mj.terrain import RoughFloor
from diffdrive_mj.world import Patch, World

Colour = tuple[float, float, float, float]
Span = tuple[float, float]
SLIPPERY: Colour = (0.66, 0.84, 0.97, 1.0)
GRIPPY: Colour = (0.88, 0.80, 0.66, 1.0)
CABLE: Colour = (0.25, 0.25, 0.27, 1.0)
ROUGH: Colour = (0.80, 0.81, 0.78, 1.0)


@dataclass(frozen=True)
class Flat:
    """A box, most often flat, with its sides along x and y.

    Attributes:
        centre: (x, y, z) [m].
        half: half of its sides [m].
        colour: red, green, blue, alpha.
        label: what it is, for the caption.
    """

    centre: tuple[float, float, float]
    half: tuple[float, float, float]
    colour: Colour
    label: str

    def moved(self, x: float, y: float) -> Flat:
        """The same shape elsewhere on the floor."""
        return replace(self, centre=(self.centre[0] + x, self.centre[1] + y, self.centre[2]))


@dataclass(frozen=True)
class Bar:
    """A round bar.

    Attributes:
        ends: of its axis, (x, y, z) each [m].
        radius: [m].
        colour: red, green, blue, alpha.
        label: what it is, for the caption.
    """

    ends: tuple[tuple[float, float, float], tuple[float, float, float]]
    radius: float
    colour: Colour
    label: str

    def moved(self, x: float, y: float) -> Bar:
        """The same shape elsewhere on the floor."""
        (ax, ay, az), (bx, by, bz) = self.ends
        return replace(self, ends=((ax + x, ay + y, az), (bx + x, by + y, bz)))


@dataclass(frozen=True, eq=False)
class Field:
    """A rectangle of floor that is uneven.

    Attributes:
        centre: (x, y) [m].
        half: half of its sides [m].
        heights: (m, n) [m], evenly from corner to corner, rows along x.
        colour: red, green, blue, alpha.
        label: what it is, for the caption.
    """

    centre: tuple[float, float]
    half: tuple[float, float]
    heights: Array
    colour: Colour
    label: str

    def moved(self, x: float, y: float) -> Field:
        """The same shape elsewhere on the floor."""
        return replace(self, centre=(self.centre[0] + x, self.centre[1] + y))


Shape = Flat | Bar | Field


def patches(world: World, unit: float) -> Iterator[Flat | Field]:
    """Patches of another friction, the later ones above the earlier ones; `unit` is the size of the robot [m]."""
    rough = world.rough
    for k, patch in enumerate(world.patches):
        (left, right), (near, far) = patch.x, patch.y
        height = unit * (0.002 + 0.006 * k / len(world.patches))  # below the trails
        colour = SLIPPERY if patch.friction < world.friction else GRIPPY
        label = f"friction {patch.friction:g}"
        level = 0.0 if rough is None else -rough.depth
        middle = ((left + right) / 2, (near + far) / 2, level)
        yield Flat(middle, ((right - left) / 2, (far - near) / 2, height), colour, label)
        if rough is not None and (over := _overlap(patch, rough)):
            yield _uneven(rough, *over, height, colour, label)


def _overlap(patch: Patch, rough: RoughFloor) -> tuple[Span, Span] | None:
    """Which part of a patch is rough, along x and along y [m]; None if none is."""
    x, y = ((max(ours[0], its[0]), min(ours[1], its[1])) for ours, its in ((patch.x, rough.x), (patch.y, rough.y)))
    return (x, y) if x[0] < x[1] and y[0] < y[1] else None


def _uneven(rough: RoughFloor, x: Span, y: Span, above: float, colour: Colour, label: str) -> Field:
    """A rectangle of a rough floor, `above` it [m], with points as far apart as it has."""
    spacing = rough.grid[0][1] - rough.grid[0][0]
    columns, rows = (np.linspace(*span, math.ceil((span[1] - span[0]) / spacing) + 1) for span in (x, y))
    middle, half = ((x[0] + x[1]) / 2, (y[0] + y[1]) / 2), ((x[1] - x[0]) / 2, (y[1] - y[0]) / 2)
    heights = rough.height_at(np.stack(np.meshgrid(columns, rows), axis=-1)) + above
    return Field(middle, half, heights, colour, label)


def cables(world: World, unit: float) -> Iterator[Bar]:
    """Cables, as they are, in straight pieces."""
    for cable in world.cables:
        label = f"cable of {1e3 * cable.height:.3g} mm"
        for begin, end in itertools.pairwise(map(tuple, cable.course(world.rough).tolist())):
            yield Bar((begin, end), cable.radius, CABLE, label)


def rough_floor(world: World, unit: float) -> Iterator[Field]:
    """A rough floor, as it is."""
    if world.rough is not None:
        x, y, z = world.rough.grid
        middle, half = ((x[0] + x[-1]) / 2, (y[0] + y[-1]) / 2), ((x[-1] - x[0]) / 2, (y[-1] - y[0]) / 2)
        yield Field(middle, half, z, ROUGH, f"rough floor of {1e3 * world.rough.rms:.3g} mm RMS")


GROUNDS: tuple[Callable[[World, float], Iterator[Shape]], ...] = (patches, cables, rough_floor)


def ground(world: World, unit: float) -> list[Shape]:
    """Everything that lies on the floor."""
    return [shape for kind in GROUNDS for shape in kind(world, unit)]


def levels(shapes: list[Shape]) -> tuple[float, float]:
    """How deep its hollows and how high its crests are [m]; zero where all of the floor is level."""
    heights = [shape.heights for shape in shapes if isinstance(shape, Field)]
    return min((float(np.min(z)) for z in heights), default=0.0), max((float(np.max(z)) for z in heights), default=0.0)
