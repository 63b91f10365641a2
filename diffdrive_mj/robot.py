"""The robot: geometry, masses, servo and encoder, as one frozen description."""

from __future__ import annotations

import dataclasses
import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from diffdrive_mj import _checks as checks
from diffdrive_mj._files import write_whole
from diffdrive_mj._resources import MODELS
from diffdrive_mj.errors import InvalidType, InvalidValue, MissingFile, UnknownName

Hanging = Literal["level", "coaxial"]
Servo = Literal["PI", "P"]
ServoGains = Literal["matched", "equal"]

_POSITIVE = (
    "left_radius",
    "right_radius",
    "track_width",
    "wheel_width",
    "wheel_mass",
    "body_mass",
    "center_of_mass_height",
    "caster_radius",
    "servo_bandwidth",
    "ticks_per_revolution",
)


@dataclass(frozen=True, kw_only=True)
class Robot:
    """A differential-drive robot: two driven wheels on one axle and a frictionless caster.

    The odometry reads the two radii and the track width alone; the physics reads all of it. The defaults
    of the other fields are the reference robot's (`models/README.md` gives the source of every number).

    Args:
        left_radius: rolling radius of the left wheel [m].
        right_radius: rolling radius of the right wheel [m].
        track_width: distance between the wheels' contact points [m]; the whole of it, not the half
            that 000, 002 and 003 write as d or l.
        name: what messages call it.
        hanging: "level", each hub at its own radius above the floor, or "coaxial", both hubs on one
            straight axle, which tilts a robot with unequal wheels.
        wheel_width: [m].
        wheel_mass: mass of each wheel [kg].
        body_mass: mass of all but the wheels [kg].
        center_of_mass_x: of the body, forward of the axle [m]; between the axle and the caster.
        center_of_mass_height: of the body, above the floor [m].
        caster_x: where the caster touches the floor, forward of the axle [m].
        caster_radius: [m].
        rotor_inertia: inertia of a motor's rotor, reflected to a wheel of the mean radius [kg m^2].
        servo: the law of a wheel's speed controller: "PI" ends up at the rate that it is told, "P" falls behind
            in proportion to the load.
        servo_bandwidth: how stiff it is, as the natural frequency of the robot's speed [rad/s]; a time step too
            coarse for a light wheel lowers it (`Physics.servo_stiffness`).
        servo_gains: "matched", gains and rotor inertia in proportion to the wheel's radius squared,
            which gives both wheels one time constant, or "equal", which makes unequal wheels lag unequally.
        ticks_per_revolution: encoder ticks per turn of a wheel.
        turning_gain: how much more the robot turns on the spot than its track says, relative (`kinematics.body_twist`);
            a belief of odometry, which a calibration may find; the physics makes its own and takes none.

    Raises:
        InvalidValue, InvalidType, UnknownName: a field is out of its range; the message names it.
    """

    left_radius: float
    right_radius: float
    track_width: float
    name: str = "robot"
    hanging: Hanging = "level"
    wheel_width: float = 0.04
    wheel_mass: float = 0.3
    body_mass: float = 4.0
    center_of_mass_x: float = -0.06
    center_of_mass_height: float = 0.08
    caster_x: float = -0.2
    caster_radius: float = 0.025
    rotor_inertia: float = 0.01
    servo: Servo = "PI"
    servo_bandwidth: float = 30.0
    servo_gains: ServoGains = "matched"
    ticks_per_revolution: float = 4096.0
    turning_gain: float = 0.0

    def __post_init__(self) -> None:
        for field in _POSITIVE:
            self._set(field, checks.positive(f"Robot.{field}", getattr(self, field)))
        for field in ("center_of_mass_x", "caster_x"):
            self._set(field, checks.number(f"Robot.{field}", getattr(self, field)))
        self._set("rotor_inertia", checks.not_negative("Robot.rotor_inertia", self.rotor_inertia))
        if abs(checks.number("Robot.turning_gain", self.turning_gain)) >= 0.5:
            raise InvalidValue(f"Robot.turning_gain = {self.turning_gain:g}: must lie between -0.5 and 0.5")
        checks.member("Robot.hanging", self.hanging, ("level", "coaxial"))
        checks.member("Robot.servo", self.servo, ("PI", "P"))
        checks.member("Robot.servo_gains", self.servo_gains, ("matched", "equal"))
        if not isinstance(self.name, str):
            raise InvalidType(f"Robot.name = {self.name!r}: must be a text")
        if not 0 < self.center_of_mass_x / (self.caster_x or math.inf) < 1:
            raise InvalidValue(
                f"Robot.center_of_mass_x = {self.center_of_mass_x:g} m: must lie between the axle (0) and "
                f"caster_x = {self.caster_x:g} m, or the robot tips over"
            )
        if self.hanging == "coaxial" and abs(self.left_radius - self.right_radius) >= self.track_width:
            raise InvalidValue(
                f"Robot.track_width = {self.track_width:g} m: on one straight axle it must exceed the "
                f"difference of the radii, {abs(self.left_radius - self.right_radius):g} m"
            )

    def _set(self, field: str, value: float) -> None:
        object.__setattr__(self, field, value)

    @property
    def radius_ratio(self) -> float:
        """Right radius / left radius."""
        return self.right_radius / self.left_radius

    @property
    def mean_radius(self) -> float:
        """Half the sum of the radii [m]."""
        return (self.left_radius + self.right_radius) / 2

    @property
    def mass(self) -> float:
        """Mass of the body and both wheels [kg]."""
        return self.body_mass + 2 * self.wheel_mass

    def replace(self, **changes: Any) -> Robot:
        """The same robot with some fields changed.

        Raises:
            UnknownName: a field that a robot does not have.
        """
        _known_fields("Robot field", changes)
        return dataclasses.replace(self, **changes)

    @classmethod
    def load(cls, name_or_path: str | Path) -> Robot:
        """The robot of a preset's name, or of a path to a TOML file whose keys are the fields' names.

        Raises:
            UnknownName: no such preset, or a key that is not a field.
            MissingFile: no file at the path.
            InvalidValue: not a TOML file, or a field that is missing or out of range.
        """
        if not isinstance(name_or_path, str | Path):
            raise InvalidType(f"robot {name_or_path!r}: must be a preset's name or a path")
        path = Path(name_or_path)
        if path.suffix != ".toml" and len(path.parts) == 1:
            path = MODELS / "robots" / f"{name_or_path}.toml"
            if not path.is_file():
                raise UnknownName("preset", str(name_or_path), presets())
        return _read(path)


def presets() -> tuple[str, ...]:
    """The names that `Robot.load` knows."""
    return tuple(sorted(path.stem for path in (MODELS / "robots").glob("*.toml")))


def _known_fields(kind: str, keys: dict[str, Any]) -> None:
    valid = [field.name for field in dataclasses.fields(Robot)]
    for key in keys:
        if key not in valid:
            raise UnknownName(kind, key, valid)


def _read(path: Path) -> Robot:
    import tomllib

    try:
        with path.open("rb") as file:
            values = tomllib.load(file)
    except FileNotFoundError:
        raise MissingFile(f"{path}: no such robot file") from None
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise InvalidValue(f"{path}: not a robot's TOML file ({error})") from None
    _known_fields(f"key in {path.name}", values)
    missing = [key for key in ("left_radius", "right_radius", "track_width") if key not in values]
    if missing:
        raise InvalidValue(f"{path}: {', '.join(missing)} missing; a robot needs its radii and track width")
    return Robot(**{"name": path.stem, **values})


def to_toml(robot: Robot) -> str:
    """A robot as the TOML that `Robot.load` reads back equal."""
    rows = ((field.name, getattr(robot, field.name)) for field in dataclasses.fields(robot))
    return "".join(f"{name} = {_quoted(value) if isinstance(value, str) else repr(value)}\n" for name, value in rows)


def save(path: str | Path, robot: Robot) -> None:
    """Write a robot's TOML file, whole or not at all.

    Raises:
        InvalidValue: the file is not named .toml, or cannot be written.
    """
    if Path(path).suffix != ".toml":
        raise InvalidValue(f"{path}: a robot's file is named .toml")
    write_whole(path, to_toml(robot))


def _quoted(value: str) -> str:
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
