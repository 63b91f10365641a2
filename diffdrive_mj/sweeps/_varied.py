"""What can vary from trial to trial, by name, and how a value of it is put in its place.

A name is that of the owner, then that of the field: "robot.tyres.width" is the width of the true robot's tyres. An
owner that has something beside its fields to vary, or is changed in a way of its own, has its line in `_CHANGE`.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from numpy.typing import NDArray

from diffdrive_mj._described import given, parts
from diffdrive_mj.errors import DiffdriveError, InvalidValue
from diffdrive_mj.robot import Robot
from diffdrive_mj.sensors.encoder import Encoder
from diffdrive_mj.sensors.gyro import Gyro
from diffdrive_mj.sweeps.named_maneuvers import Maneuver
from diffdrive_mj.world import World

Drawn = Mapping[str, NDArray[Any]]
Changes = dict[str, Any]

# What odometry and the commands read of a robot; the first two with the second two.
RADII, CAUSES = ("left_radius", "right_radius"), ("mean_radius", "radius_ratio")
_BELIEVED = (*RADII, *CAUSES, "track_width", "turning_gain")
# A robot's fields that no drive reads: the encoder of a study is its own.
_UNREAD = ("tolerances", "encoder")


def names(owners: Mapping[str, Any]) -> tuple[str, ...]:
    """The names of all that can vary of some owners, those left out that are None."""
    found: list[str] = []
    for owner, base in owners.items():
        if base is None:
            continue
        if owner == "believed":
            fields = iter(_BELIEVED)
        elif isinstance(base, Maneuver):
            fields = iter(base.known)
        else:
            fields = _leaves(type(base))
        found += [f"{owner}.{name}" for name in fields]
    return tuple(found)


def _leaves(kind: type) -> Iterator[str]:
    """The numbers, words and switches of a description and of its parts."""
    nested = parts(kind)
    if kind is Robot:
        yield from CAUSES
    for field in dataclasses.fields(kind):
        if field.name in nested:
            if field.default != () and not (kind is Robot and field.name in _UNREAD):
                yield from (f"{field.name}.{leaf}" for leaf in _leaves(nested[field.name]))
        elif field.name != "name" and not str(field.type).startswith("tuple"):
            yield field.name


def variations(owner: str, base: Any, drawn: Drawn, trials: int) -> list[Any]:
    """An owner as it is in each of some trials, or the error that says why it cannot be; equal ones are one object."""
    columns = {tuple(name.split(".")[1:]): of.tolist() for name, of in drawn.items() if name.split(".")[0] == owner}
    if not columns:
        return [base] * trials
    made: dict[Any, Any] = {}
    change = _CHANGE.get(owner, _replaced)
    for row in zip(*columns.values(), strict=True):
        if row not in made:
            try:
                made[row] = change(base, _nested(zip(columns, row, strict=True)))
            except DiffdriveError as error:
                made[row] = error
    return [made[row] for row in zip(*columns.values(), strict=True)]


def _nested(values: Iterator[tuple[tuple[str, ...], Any]]) -> Changes:
    """Values by their paths as mappings in mappings."""
    result: Changes = {}
    for path, value in values:
        place = result
        for part in path[:-1]:
            place = place.setdefault(part, {})
        place[path[-1]] = value
    return result


def _robot(base: Robot, changes: Changes) -> Robot:
    """A robot with other radii left and right, or with another mean and another ratio of them."""
    mean, ratio = changes.pop("mean_radius", base.mean_radius), changes.pop("radius_ratio", base.radius_ratio)
    if (mean, ratio) != (base.mean_radius, base.radius_ratio):
        if not ratio > 0:
            raise InvalidValue(f"radius_ratio = {ratio:g}: must be positive")
        left = 2 * mean / (1 + ratio)
        changes.update(left_radius=left, right_radius=ratio * left)
    return base.replace(**changes)


def _world(base: World, changes: Changes) -> World:
    """A world, of whose slope and rough floor what does not vary stays."""
    before = given(base)
    merged = {
        name: {**given(before.get(name)), **value} if isinstance(value, Mapping) else value
        for name, value in changes.items()
    }
    return base.replace(**merged)


def _maneuver(base: Maneuver, changes: Changes) -> Maneuver:
    return Maneuver(base.name, {**base.options, **changes})


def _replaced(base: Encoder | Gyro, changes: Changes) -> Encoder | Gyro:
    return dataclasses.replace(base, **changes)


_CHANGE: dict[str, Callable[[Any, Changes], Any]] = {
    "robot": _robot,
    "believed": _robot,
    "world": _world,
    "maneuver": _maneuver,
}
