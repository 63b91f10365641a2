"""The standard maneuvers by name, as a study and its file describe what is driven."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from diffdrive_mj import _checks as checks
from diffdrive_mj._text import shown
from diffdrive_mj.commands import Commands
from diffdrive_mj.errors import InvalidType, UnknownName
from diffdrive_mj.maneuvers import BY_NAME
from diffdrive_mj.robot import Robot


@dataclass(frozen=True)
class Maneuver:
    """Name a standard maneuver, with its options.

    Args:
        name: "straight", "arc", "spin", "square", "figure_eight" or "slalom".
        options: of that maneuver (`dd.maneuvers`), by name.

    Raises:
        UnknownName: another name, or an option that the maneuver does not have.
        InvalidType: options that are no mapping.

    Example:
        >>> dd.sweeps.Maneuver("square", {"side": 1.0}).commands(dd.Robot.load("matched")).period
        0.01
    """

    name: str
    options: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        checks.one_of("maneuver", self.name, BY_NAME)
        if not isinstance(self.options, Mapping):
            raise InvalidType(f"Maneuver.options = {shown(self.options)}: must be a mapping, such as {{'speed': 0.3}}")
        for option in self.options:
            if option not in self.known:
                raise UnknownName(f"option of {self.name}", option, self.known)
        # In the maneuver's order, whole numbers as the floats that they stand for: equal maneuvers read alike.
        options = {
            key: _plain(self.options[key], default) for key, default in self.known.items() if key in self.options
        }
        object.__setattr__(self, "options", options)

    @property
    def known(self) -> dict[str, Any]:
        """The options that the maneuver has, with what they are if they are not given."""
        parameters = list(inspect.signature(BY_NAME[self.name]).parameters.values())[1:]
        return {parameter.name: parameter.default for parameter in parameters}

    def commands(self, robot: Robot) -> Commands:
        """Compute the wheel rates for a robot."""
        return BY_NAME[self.name](robot, **self.options)


def _plain(value: Any, default: Any) -> Any:
    value = value.item() if isinstance(value, np.generic) else value
    return float(value) if type(value) is int and isinstance(default, float) else value


def maneuver(name: str, value: object) -> Maneuver:
    """Return a maneuver as it is, or that of its name, or of a mapping of its name and its options.

    Args:
        name: how the message calls it.
        value: a maneuver, its name, or a mapping with `name` beside its options.

    Raises:
        InvalidType: none of the three.
        UnknownName: another maneuver, or an option that it does not have.

    Example:
        >>> maneuver("maneuver", {"name": "square", "side": 1.0})
        Maneuver(name='square', options={'side': 1.0})
    """
    if isinstance(value, str):
        return Maneuver(value)
    if isinstance(value, Mapping):
        if "name" not in value:
            raise InvalidType(f"{name}: name missing, such as name = 'square'")
        return Maneuver(value["name"], {key: item for key, item in value.items() if key != "name"})
    return checks.instance(name, value, Maneuver)
