"""What surrounds the robot: the floor and its disturbances."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from diffdrive_mj import _checks as checks
from diffdrive_mj import _described_file
from diffdrive_mj._checks import Array
from diffdrive_mj._described import checked, described, given, one, several, span
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.parts import RESISTANCE
from diffdrive_mj.terrain import Cable, RoughFloor, Slope

# Standard gravity to three digits [m/s^2].
GRAVITY = 9.81
# The smallest friction that MuJoCo has (mjMINMU); it takes a smaller one for it.
_LEAST_FRICTION = 1e-5


def _friction(name: str, value: Any) -> float:
    result = checks.positive(name, value)
    if result < _LEAST_FRICTION:
        raise InvalidValue(f"{name} = {result:g}: must be at least {_LEAST_FRICTION:g}, the least that the engine has")
    return result


def _acceleration(name: str, value: Any) -> tuple[float, float, float]:
    x, y, z = checks.vector(name, value, 3).tolist()
    return x, y, z


@described()
@dataclass(frozen=True, kw_only=True)
class Push:
    """A force on the body's centre of mass for some time, as an acceleration of the whole robot.

    Args:
        start: [s].
        duration: [s].
        acceleration: (x, y, z) in the world's axes [m/s^2], times the robot's mass.

    Raises:
        InvalidValue: a field is out of its range; the message names it.
        InvalidType: a field is missing or not a number; the message names it.
        UnknownName: a field that a push does not have.

    Example:
        A tenth of its weight pushes the robot to the left for half a second:

        >>> dd.World(pushes=(dd.Push(start=1.0, duration=0.5, acceleration=(0.0, 0.981, 0.0)),)).pushes[0].start
        1.0
    """

    start: float = field(metadata=checked(checks.not_negative))
    duration: float = field(metadata=checked(checks.positive))
    acceleration: tuple[float, float, float] = field(metadata=checked(_acceleration))


@described()
@dataclass(frozen=True, kw_only=True)
class Patch:
    """A rectangle of floor with a friction of its own.

    Args:
        x: from and to [m].
        y: from and to [m].
        friction: coefficient of sliding friction.

    Raises:
        InvalidValue: a field is out of its range; the message names it.
        InvalidType: a field is missing or not a number; the message names it.
        UnknownName: a field that a patch does not have.

    Example:
        >>> ice = dd.Patch(x=(1.0, 2.0), y=(-0.5, 0.5), friction=0.05)
        >>> ice.contains(np.array([(0.0, 0.0), (1.5, 0.0)])).tolist()
        [False, True]
    """

    x: tuple[float, float] = field(metadata=checked(span))
    y: tuple[float, float] = field(metadata=checked(span))
    friction: float = field(metadata=checked(_friction))

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


@described()
@dataclass(frozen=True, kw_only=True)
class World:
    """The floor and what happens on it; the default is ideal.

    Args:
        name: what messages call it.
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

    name: str = field(default="world", metadata=checked(checks.string))
    friction: float = field(default=1.0, metadata=checked(_friction))
    patches: tuple[Patch, ...] = field(default=(), metadata=several(Patch))
    pushes: tuple[Push, ...] = field(default=(), metadata=several(Push))
    gravity: float = field(default=GRAVITY, metadata=checked(checks.positive))
    slope: Slope | None = field(default=None, metadata=one(Slope, or_none=True))
    cables: tuple[Cable, ...] = field(default=(), metadata=several(Cable))
    rough: RoughFloor | None = field(default=None, metadata=one(RoughFloor, or_none=True))
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

    @classmethod
    def load(cls, name_or_path: str | Path) -> World:
        """Read the world of a preset's name, or of a path to a TOML file.

        The file's keys are the fields of a world; a slope and a rough floor are tables, and arrays of tables are
        patches, pushes and cables.

        Args:
            name_or_path: one of `presets()`, or a path that ends on .toml or has a folder.

        Raises:
            UnknownName: no such preset, or a key that is not a field.
            MissingFile: no file at the path.
            InvalidValue: not a TOML file, or a field that is missing or out of range.
            InvalidType: neither a name nor a path, or a field of the wrong kind.

        Example:
            >>> dd.World.load("workshop").friction
            0.6
        """
        return _described_file.load(cls, name_or_path)

    def save(self, path: str | Path) -> None:
        """Write the world's TOML file, whole or not at all; `World.load` reads it back equal.

        Args:
            path: must end on .toml.

        Raises:
            InvalidType: not a path.
            InvalidValue: the file is not named .toml, or cannot be written.

        Example:
            >>> dd.World.load("office").save("/no/such/folder/mine.toml")
            Traceback (most recent call last):
            diffdrive_mj.errors.InvalidValue: /no/such/folder/mine.toml: cannot be written (No such file or directory)
        """
        _described_file.save(self, path)

    def to_toml(self) -> str:
        """Return the world as TOML: its name and what it was given.

        Example:
            >>> print(dd.World(friction=0.8, slope={"angle": 0.02}).to_toml())
            name = "world"
            friction = 0.8
            <BLANKLINE>
            [slope]
            angle = 0.02
            <BLANKLINE>
        """
        return _described_file.text(self)

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


def presets() -> tuple[str, ...]:
    """Return the names that `World.load` knows.

    Example:
        >>> presets()
        ('garden', 'ideal', 'office', 'workshop')
    """
    return _described_file.presets(World)
