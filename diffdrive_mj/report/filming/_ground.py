"""What lies on the floor of a world, as flat shapes: a new kind of world adds a function to `GROUNDS`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

from diffdrive_mj.world import World

Colour = tuple[float, float, float, float]
SLIPPERY: Colour = (0.66, 0.84, 0.97, 1.0)
GRIPPY: Colour = (0.88, 0.80, 0.66, 1.0)


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


def patches(world: World, unit: float) -> Iterator[Flat]:
    """Patches of another friction, the later ones above the earlier ones; `unit` is the size of the robot [m]."""
    for k, patch in enumerate(world.patches):
        (left, right), (near, far) = patch.x, patch.y
        height = unit * (0.002 + 0.006 * k / len(world.patches))  # below the trails
        colour = SLIPPERY if patch.friction < world.friction else GRIPPY
        yield Flat(
            ((left + right) / 2, (near + far) / 2, 0.0),
            ((right - left) / 2, (far - near) / 2, height),
            colour,
            f"friction {patch.friction:g}",
        )


GROUNDS: tuple[Callable[[World, float], Iterator[Flat]], ...] = (patches,)


def ground(world: World, unit: float) -> list[Flat]:
    """Everything that lies on the floor."""
    return [flat for kind in GROUNDS for flat in kind(world, unit)]
