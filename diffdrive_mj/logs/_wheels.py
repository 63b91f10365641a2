"""Wheels as logs count them, in radians."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Literal, Protocol

import numpy as np

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.robot import Robot

WheelUnit = Literal["radians", "degrees", "rotations", "ticks", "metres"]

# Radians of one.
_TURNS = {"radians": 1.0, "degrees": np.pi / 180, "rotations": 2 * np.pi}

# Fewer samples may differ by more than half a turn without having been wrapped.
_FEW = 10


class Counted(Protocol):
    """Options that say how a log counts its wheels."""

    @property
    def wheel_unit(self) -> WheelUnit: ...
    @property
    def ticks_per_revolution(self) -> float | None: ...
    @property
    def gear(self) -> float | None: ...
    @property
    def reverse_left(self) -> bool: ...
    @property
    def reverse_right(self) -> bool: ...


def check_gear(options: Counted) -> None:
    """Check the fields that count turns.

    Raises:
        InvalidType: not numbers.
        InvalidValue: out of range, or not of this unit.
    """
    name, unit = type(options).__name__, options.wheel_unit
    if options.ticks_per_revolution is not None:
        ticks = checks.positive(f"{name}.ticks_per_revolution", options.ticks_per_revolution)
        if unit != "ticks":
            raise InvalidValue(f"{name}.ticks_per_revolution = {ticks:g}: but wheel_unit is {unit!r}")
    if options.gear is not None:
        gear = checks.positive(f"{name}.gear", options.gear)
        if unit not in _TURNS:
            cure = "; ticks_per_revolution has the gear in it" if unit == "ticks" else ""
            raise InvalidValue(f"{name}.gear = {gear:g}: but wheel_unit is {unit!r}{cure}")
    for field in ("reverse_left", "reverse_right"):
        checks.boolean(f"{name}.{field}", getattr(options, field))


def wheel_angles(turned: Array, options: Counted, robot: Robot | None, path: Path) -> Array:
    """Wheel angles (T, 2) [rad] from what a log counted, left then right.

    Raises:
        InvalidValue: ticks or metres without the robot that they are of.
    """
    name = type(options).__name__
    radians: float | Array
    if options.wheel_unit == "ticks":
        ticks = options.ticks_per_revolution or (robot and robot.encoder.ticks_per_wheel_turn)
        if not ticks:
            raise InvalidValue(f"{path}: wheels in ticks need {name}.ticks_per_revolution or a robot")
        radians = 2 * np.pi / ticks
    elif options.wheel_unit == "metres":
        if robot is None:
            raise InvalidValue(f"{path}: wheels in metres need a robot, whose radii made metres of turns")
        radians = 1 / np.array([robot.left_radius, robot.right_radius])
    else:
        radians = _TURNS[options.wheel_unit] / (options.gear or 1.0)
    with np.errstate(over="ignore"):  # numbers beyond all sizes, which a drive refuses
        return turned * radians * np.where([options.reverse_left, options.reverse_right], -1.0, 1.0)


def wrapped(wheels: Iterable[Array], unit: WheelUnit) -> tuple[str, ...]:
    """What to know of wheels whose angle starts anew with every turn, as absolute encoders show it.

    Args:
        wheels: what a log counted of the left and of the right (N,).
        unit: of it; ticks and metres have no turns that could be seen.
    """
    found = []
    for side, turned in zip(("left", "right"), wheels, strict=True):
        with np.errstate(over="ignore", invalid="ignore"):  # numbers beyond all sizes, which a drive refuses
            angle = turned * _TURNS.get(unit, 0.0)
            within = len(angle) >= _FEW and np.ptp(angle) <= 2 * np.pi * (1 + 1e-6)
        if within and np.abs(np.diff(angle)).max() > np.pi:
            found.append(f"the {side} wheel looks wrapped: its angle must go on past a turn, and jumps within one")
    return tuple(found)
