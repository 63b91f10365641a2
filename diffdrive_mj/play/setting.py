"""A setting of the page: which robot drives what, what its odometry believes, how its wheels are read."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

from diffdrive_mj import _checks as checks
from diffdrive_mj._text import shown
from diffdrive_mj.errors import InvalidType, InvalidValue, UnknownName
from diffdrive_mj.kinematics import compensated_right_radius
from diffdrive_mj.robot import Robot

SPEED_RATIO = 0.91  # of [Behnke]'s example
RIGHT_RATE = 15.0  # [rad/s]: 1.5 m/s of a wheel of 0.1 m
# The longest text of a name or a number.
_LONGEST = 200


@dataclass(frozen=True)
class Knob:
    """A number of a setting: the range and the unit that it must be in.

    Attributes:
        least, most: both allowed.
        unit: SI.

    Example:
        >>> KNOBS["k"].most
        5.0
    """

    least: float
    most: float
    unit: str

    def checked(self, name: str, value: object) -> float:
        """Return the number, if it is one and within the range.

        Args:
            name: as the message calls it.
            value: a number.

        Raises:
            InvalidType: not a number.
            InvalidValue: not finite, or out of the range.
        """
        number = checks.number(name, value)
        if not self.least <= number <= self.most:
            unit = f" {self.unit}" if self.unit else ""
            raise InvalidValue(f"{name} = {number:g}{unit}: must lie between {self.least:g} and {self.most:g}{unit}")
        return number


_RADIUS, _TRACK = Knob(0.005, 0.5, "m"), Knob(0.02, 2.0, "m")
KNOBS: dict[str, Knob] = {
    "k": Knob(0.2, 5.0, ""),
    "right_rate": Knob(0.1, 100.0, "rad/s"),
    "speed": Knob(0.01, 3.0, "m/s"),
    "seconds": Knob(1.0, 60.0, "s"),
    "left_radius": _RADIUS,
    "right_radius": _RADIUS,
    "track_width": _TRACK,
    "believed_left_radius": _RADIUS,
    "believed_right_radius": _RADIUS,
    "believed_track_width": _TRACK,
    "friction": Knob(0.02, 2.0, ""),
    "ticks": Knob(0.0, 1e6, ""),
    "rate": Knob(1.0, 500.0, "Hz"),
}


@dataclass(frozen=True, kw_only=True)
class Setting:
    """Hold what the sliders say.

    Args:
        robot: the name of the robot that has the sizes and masses for which there is no slider.
        maneuver: one of `diffdrive_mj.play.drives.MANEUVERS`.
        k: left rate / right rate, of the maneuver "k" alone.
        right_rate: of the right wheel [rad/s], of the maneuver "k" alone.
        speed: of the other maneuvers [m/s]; on the spot that of the wheels' rims.
        seconds: at full speed [s].
        left_radius, right_radius, track_width: of the true robot [m].
        believed_left_radius, believed_right_radius, believed_track_width: of odometry, and of the driver, who computes
            the commands of all the maneuvers but "k" for it [m].
        friction: of the floor.
        ticks: of the encoders, per turn of a wheel; 0 for encoders without ticks.
        rate: at which odometry reads the wheels [Hz].

    Raises:
        InvalidValue, InvalidType: a field is out of its range or of another type; the message names it.

    Example:
        >>> Setting.of(Robot.load("matched")).believed_right_radius
        0.091
    """

    robot: str
    maneuver: str
    k: float
    right_rate: float
    speed: float
    seconds: float
    left_radius: float
    right_radius: float
    track_width: float
    believed_left_radius: float
    believed_right_radius: float
    believed_track_width: float
    friction: float
    ticks: float
    rate: float

    def __post_init__(self) -> None:
        for name in ("robot", "maneuver"):
            checks.string(name, getattr(self, name))
        for name, knob in KNOBS.items():
            object.__setattr__(self, name, knob.checked(name, getattr(self, name)))
        if 0 < self.ticks < 1:
            raise InvalidValue(f"ticks = {self.ticks:g}: must be 0, for none, or at least 1")

    @classmethod
    def of(cls, robot: Robot) -> Setting:
        """Return the setting with which the page opens: a left wheel 9 % slow, and a belief that has r_r = k r_l.

        A robot that is made so is believed to have equal wheels.

        Args:
            robot: the true one.
        """
        k = SPEED_RATIO
        believed = compensated_right_radius(robot.left_radius, k)
        if math.isclose(believed, robot.right_radius, rel_tol=1e-3):
            believed = robot.left_radius
        return cls(
            robot=robot.name,
            maneuver="k",
            k=k,
            right_rate=RIGHT_RATE,
            speed=min(float(f"{RIGHT_RATE * robot.mean_radius:.2g}"), KNOBS["speed"].most),
            seconds=10.0,
            left_radius=robot.left_radius,
            right_radius=robot.right_radius,
            track_width=robot.track_width,
            believed_left_radius=robot.left_radius,
            believed_right_radius=float(f"{believed:.12g}"),
            believed_track_width=robot.track_width,
            friction=1.0,
            ticks=0.0,
            rate=50.0,
        )

    @classmethod
    def parsed(cls, given: Mapping[str, Any]) -> Setting:
        """Return the setting whose fields are given as text.

        Args:
            given: each field once.

        Raises:
            InvalidValue: a field that is missing or out of its range.
            InvalidType: what is not a number.
            UnknownName: what is not a field.

        Example:
            >>> Setting.parsed({"robot": "matched"})
            Traceback (most recent call last):
            ...
            diffdrive_mj.errors.InvalidValue: maneuver: is missing
        """
        names = [field.name for field in fields(cls)]
        for name in given:
            if name not in names:
                raise UnknownName("setting", name[:_LONGEST], names)
        for name in names:
            if name not in given:
                raise InvalidValue(f"{name}: is missing")
        values: dict[str, Any] = {name: _number(name, text) if name in KNOBS else text for name, text in given.items()}
        return cls(**values)


def _number(name: str, text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise InvalidType(f"{name} = {shown(text[:_LONGEST])}: must be a number") from None
