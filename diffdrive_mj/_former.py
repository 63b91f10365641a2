"""Names that a robot's fields had before its parts were nested, each refused with the new one."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from diffdrive_mj._text import shown
from diffdrive_mj.errors import InvalidType, InvalidValue
from diffdrive_mj.parts import PARTS

_NOW_IN_A_PART = {
    "wheel_width": ("tyres", "width"),
    "wheel_mass": ("tyres", "mass"),
    "caster_x": ("caster", "x"),
    "caster_radius": ("caster", "radius"),
    "rotor_inertia": ("motor", "rotor_inertia"),
    "servo_bandwidth": ("servo", "bandwidth"),
    "servo_gains": ("servo", "gains"),
    "ticks_per_revolution": ("encoder", "ticks_per_revolution"),
}
_AXLES = {"level": "independent", "coaxial": "rigid"}


def refuse_keywords(arguments: Mapping[str, Any]) -> None:
    """Refuse former names among the keyword arguments of a robot.

    Raises:
        InvalidType: there is one.
    """
    for name, value in arguments.items():
        if name == "hanging":
            raise InvalidType(f"Robot(hanging={shown(value)}) is now axle={_axle(value)}")
        if name == "servo" and isinstance(value, str):
            raise InvalidType(f"Robot(servo={shown(value)}) is now servo=Servo(law={value!r})")
        if name in _NOW_IN_A_PART:
            part, field = _NOW_IN_A_PART[name]
            raise InvalidType(f"Robot({name}=...) is now {part}={PARTS[part].__name__}({field}=...)")


def refuse_keys(path: Path, values: Mapping[str, Any]) -> None:
    """Refuse former names among the keys of a robot's file.

    Raises:
        InvalidValue: there is one.
    """
    for key, value in values.items():
        if key == "hanging":
            raise InvalidValue(f'{path}: hanging = "{value}" is now axle = {_axle(value)}')
        part, field = _NOW_IN_A_PART.get(key, ("servo", "law"))
        if key in _NOW_IN_A_PART or (key == "servo" and isinstance(value, str)):
            raise InvalidValue(f"{path}: key {key!r} is now {field!r} in the table [{part}]")


def _axle(hanging: object) -> str:
    now = _AXLES.get(str(hanging))
    return " or ".join(f'"{axle}"' for axle in ([now] if now else _AXLES.values()))
