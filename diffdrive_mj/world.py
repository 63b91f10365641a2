"""What surrounds the robot: the floor and its disturbances."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj._described import checked, described, described_as, given
from diffdrive_mj._text import shown
from diffdrive_mj.errors import InvalidType, InvalidValue
from diffdrive_mj.parts import RESISTANCE
from diffdrive_mj.terrain import Cable, RoughFloor, Slope


@dataclass(frozen=True, kw_only=True)
class Push:
    """A force on the body's centre of mass for some time, as an acceleration of the whole robot.

    Args:
        start: [s].
        duration: [s].
        acceleration: (x, y, z) in the world's axes [m/s^2], times the robot's mass.

    Raises:
        InvalidValue: a field is out of its range; the message names it.
        InvalidType: a field is not a number; the message names it.

    Example:
        A tenth of its weight pushes the robot to the left for half a second:

        >>> dd.World(pushes=(dd.Push(start=1.0, duration=0.5, acceleration=(0.0, 0.981, 0.0)),)).pushes[0].start
        1.0
    """

    start: float
    duration: float
    acceleration: tuple[float, float, float]

    def __post_init__(self) -> None:
        object.__setattr__(self, "start", checks.not_negative("Push.start", self.start))
        object.__setattr__(self, "duration", checks.positive("Push.duration", self.duration))
        x, y, z = checks.vector("Push.acceleration", self.acceleration, 3).tolist()
        object.__setattr__(self, "acceleration", (x, y, z))


@dataclass(frozen=True, kw_only=True)
class Patch:
    """A rectangle of floor with a friction of its own.

    Args:
        x: from and to [m].
        y: from and to [m].
        friction: coefficient of sliding friction.

    Raises:
        InvalidValue: a field is out of its range; the message names it.
        InvalidType: a field is not a number; the message names it.

    Example:
        >>> ice = dd.Patch(x=(1.0, 2.0), y=(-0.5, 0.5), friction=0.05)
        >>> ice.contains(np.array([(0.0, 0.0), (1.5, 0.0)])).tolist()
        [False, True]
    """

    x: tuple[float, float]
    y: tuple[float, float]
    friction: float

    def __post_init__(self) -> None:
        for axis in ("x", "y"):
            low, high = checks.vector(f"Patch.{axis}", getattr(self, axis), 2).tolist()
            if low >= high:
                raise InvalidValue(f"Patch.{axis} = ({low:g}, {high:g}): must go from a smaller to a larger number")
            object.__setattr__(self, axis, (low, high))
        object.__setattr__(self, "friction", checks.positive("Patch.friction", self.friction))

    def contains(self, points: Array) -> NDArray[np.bool_]:
        """Tell which of the points lie on it; its borders at the smaller x and y belong to it, the others do not.

        Args:
            points: (..., 2) [m].

        Returns:
            (...).
        """
        points = checks.array("points", points, 2)
        (left, right), (near, far) = self.x, self.y
        x, y = points[..., 0], points[..., 1]
        return (left <= x) & (x < right) & (near <= y) & (y < far)


def _one(kind: type) -> dict[str, Callable[[str, Any], Any]]:
    return checked(lambda name, value: None if value is None else described_as(kind, name, value))


def _several(kind: type) -> dict[str, Callable[[str, Any], Any]]:
    def check(name: str, value: object) -> tuple[Any, ...]:
        if not isinstance(value, (tuple, list)):
            raise InvalidType(f"{name} = {shown(value)}: must be a tuple of {kind.__name__}")
        return tuple(described_as(kind, f"{name}[{k}]", item) for k, item in enumerate(value))

    return checked(check)


@described()
@dataclass(frozen=True, kw_only=True)
class World:
    """The floor and what happens on it; the default is ideal.

    Args:
        friction: coefficient of sliding friction between wheels and floor.
        patches: where the floor has another friction; where two overlap, the later counts.
        pushes: on the robot.
        gravity: [m/s^2].
        slope: a floor that rises evenly; None is level.
        cables: that lie across the way.
        rough: a part of the floor that is uneven; None is smooth everywhere.
        rolling_resistance: what the floor adds to that of the tyres, force over load (`Tyres.rolling_resistance`).

    Raises:
        InvalidValue: a field is out of its range; the message names it.
        InvalidType: a field is of another type; the message names it.
        UnknownName: a field that a world does not have.

    Example:
        >>> ice = dd.Patch(x=(1.0, 2.0), y=(-0.5, 0.5), friction=0.05)
        >>> dd.World(friction=0.8, patches=(ice,)).friction_at(np.array([(0.0, 0.0), (1.5, 0.0)])).tolist()
        [0.8, 0.05]
    """

    friction: float = field(default=1.0, metadata=checked(checks.positive))
    patches: tuple[Patch, ...] = field(default=(), metadata=_several(Patch))
    pushes: tuple[Push, ...] = field(default=(), metadata=_several(Push))
    gravity: float = field(default=9.81, metadata=checked(checks.positive))
    slope: Slope | None = field(default=None, metadata=_one(Slope))
    cables: tuple[Cable, ...] = field(default=(), metadata=_several(Cable))
    rough: RoughFloor | None = field(default=None, metadata=_one(RoughFloor))
    rolling_resistance: float = field(default=0.0, metadata=checked(RESISTANCE))

    def replace(self, **changes: Any) -> World:
        """Return the world with some fields changed.

        Args:
            changes: fields of a world.

        Raises:
            InvalidValue, InvalidType, UnknownName: as for a new world.

        Example:
            >>> dd.World(gravity=1.62).replace(friction=0.5).gravity
            1.62
        """
        return type(self)(**{**given(self), **changes})

    def friction_at(self, points: Array) -> Array:
        """Find the coefficient of friction under each of the points.

        Args:
            points: (..., 2) [m].

        Returns:
            (...).
        """
        points = checks.array("points", points, 2)
        edges_x, edges_y, table = self._tiles
        return table[
            np.searchsorted(edges_x, points[..., 0], side="right"),
            np.searchsorted(edges_y, points[..., 1], side="right"),
        ]

    @cached_property
    def _tiles(self) -> tuple[Array, Array, Array]:
        """The floor cut along all the edges of its patches: the edges in x and y [m], and the friction of each tile."""
        edges = [np.unique([edge for patch in self.patches for edge in getattr(patch, axis)]) for axis in ("x", "y")]
        table = np.full([len(cuts) + 1 for cuts in edges], self.friction)
        for patch in self.patches:
            (left, right), (near, far) = (
                np.searchsorted(cuts, span) for cuts, span in zip(edges, (patch.x, patch.y), strict=True)
            )
            table[left + 1 : right + 1, near + 1 : far + 1] = patch.friction
        return edges[0], edges[1], table
