"""The robot: geometry, masses and parts, as one frozen description."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from dataclasses import InitVar, dataclass, field
from pathlib import Path
from typing import Any, Literal

from diffdrive_mj import _checks as checks
from diffdrive_mj import _described_file, _scaling
from diffdrive_mj._described import SCALES, checked, described, given, one
from diffdrive_mj._former import refuse_keys, refuse_keywords
from diffdrive_mj._standing import refuse_beside_triangle, refuse_on_three_wheels
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.parts import (
    LARGEST_LENGTH,
    LARGEST_MASS,
    PARTS,
    Caster,
    Motor,
    Payload,
    Servo,
    SkidSteer,
    Tyres,
    WheelEncoder,
)
from diffdrive_mj.tolerances import Tolerances


def _length(below: float, millimetres_from: float) -> Callable[[str, Any], float]:
    """A length [m] below some size; a larger one is in another unit, in millimetres from some number on."""

    def check(name: str, value: object) -> float:
        length = checks.positive(name, value)
        if length >= below:
            unit, scale = ("millimetres", 1000) if length >= millimetres_from else ("centimetres", 100)
            hint = f"; in {unit}? then {length / scale:g}" if length / scale < below else ""
            raise InvalidValue(f"{name} = {length:g} m: must be below {below:g} m{hint}")
        return length

    return check


def _turning_gain(name: str, value: object) -> float:
    gain = checks.number(name, value)
    if abs(gain) >= 0.5:
        raise InvalidValue(f"{name} = {gain:g}: must lie between -0.5 and 0.5")
    return gain


def _prepared(arguments: dict[str, Any]) -> dict[str, Any]:
    """The arguments of a robot without former names; of `dataclasses.replace`, only what it was given or changes."""
    refuse_keywords(arguments)
    before = arguments.pop("_given", None)
    if before is None:
        return arguments
    robot = vars(Robot(**before))
    same = [name for name, value in arguments.items() if type(value) is type(robot.get(name)) and value == robot[name]]
    return {**before, **{name: value for name, value in arguments.items() if name not in same}}


@described(_prepared)
@dataclass(frozen=True, kw_only=True)
class Robot:
    """Describe a differential-drive robot: two driven wheels on one axle and a caster, or four wheels that skid.

    Odometry reads the two radii and the track width alone; the physics reads all of it. Sizes and masses that are not
    given scale from a reference robot of 4.6 kg with radii of 0.100 and 0.091 m and a track width of 0.400 m
    (`models/README.md` gives the laws, and the source of every number): lengths with the mean radius R or the track
    width b, masses with R^2 b.

    Args:
        left_radius: rolling radius of the left wheel [m].
        right_radius: rolling radius of the right wheel [m].
        track_width: distance between the wheels' contact points [m]; the whole of it, not the half that [ct-Sim],
            [Behnke] and [Odometrie wiki 2016] write as d or l.
        name: what messages call it.
        axle: "independent", each hub at its own radius above the floor, or "rigid", both hubs on one straight axle,
            which tilts a robot with unequal wheels.
        body_mass: mass of all but the wheels and the payload [kg].
        center_of_mass_x: of the body, forward of the axle [m]; between the axle and the caster.
        center_of_mass_height: of the body, above the floor [m].
        turning_gain: how much more the robot turns on the spot than its track says, relative (`kinematics.body_twist`);
            a belief of odometry, which a calibration may find; the physics makes its own and takes none.
        tyres: `Tyres`, or a mapping of its fields, as all the parts.
        caster: `Caster`.
        motor: `Motor`, one a wheel.
        servo: `Servo`, the speed controller of each wheel.
        encoder: `WheelEncoder`, one a wheel.
        payload: `Payload`, which the body carries.
        tolerances: `Tolerances`, how well radii and track are known; nothing but an error budget reads them.
        skid_steer: `SkidSteer`, four driven wheels in the place of two and a caster.

    Raises:
        InvalidValue: a field out of its range, or a robot that would tip over; the message names the field.
        InvalidType: a field of the wrong kind or under a former name, or a radius or the track width is missing.
        UnknownName: a field that a robot does not have, or a word that is not among the valid ones.

    Example:
        >>> robot = Robot(left_radius=0.100, right_radius=0.091, track_width=0.400)
        >>> robot.caster
        Caster(x=-0.2, radius=0.025)
        >>> robot.replace(track_width=0.800).caster
        Caster(x=-0.4, radius=0.025)
    """

    left_radius: float = field(metadata=checked(_length(2.0, 15.0)))
    right_radius: float = field(metadata=checked(_length(2.0, 15.0)))
    track_width: float = field(metadata=checked(_length(10.0, 60.0)))
    name: str = field(default="robot", metadata=checked(checks.string))
    axle: Literal["independent", "rigid"] = field(
        default="independent", metadata=checked(functools.partial(checks.member, valid=("independent", "rigid")))
    )
    body_mass: float = field(default=SCALES, metadata=checked(checks.limited(checks.positive, LARGEST_MASS, "kg")))
    center_of_mass_x: float = field(
        default=SCALES, metadata=checked(checks.limited(checks.number, LARGEST_LENGTH, "m"))
    )
    center_of_mass_height: float = field(
        default=SCALES, metadata=checked(checks.limited(checks.positive, LARGEST_LENGTH, "m"))
    )
    turning_gain: float = field(default=0.0, metadata=checked(_turning_gain))
    tyres: Tyres = field(default=Tyres(), metadata=one(PARTS["tyres"]))
    caster: Caster = field(default=Caster(), metadata=one(PARTS["caster"]))
    motor: Motor = field(default=Motor(), metadata=one(PARTS["motor"]))
    servo: Servo = field(default=Servo(), metadata=one(PARTS["servo"]))
    encoder: WheelEncoder = field(default=WheelEncoder(), metadata=one(PARTS["encoder"]))
    payload: Payload = field(default=Payload(), metadata=one(PARTS["payload"]))
    tolerances: Tolerances = field(default=Tolerances(), metadata=one(PARTS["tolerances"]))
    skid_steer: SkidSteer = field(default=SkidSteer(), metadata=one(PARTS["skid_steer"]))
    _given: InitVar[Any] = None  # so that dataclasses.replace passes it on

    def __post_init__(self, _given: None) -> None:
        for name, value in _scaling.completed(self.mean_radius, self.track_width, given(self)).items():
            object.__setattr__(self, name, value)
        if self.axle == "rigid" and abs(self.left_radius - self.right_radius) >= self.track_width:
            raise InvalidValue(
                f"Robot.track_width = {self.track_width:g} m: on a rigid axle it must exceed the "
                f"difference of the radii, {abs(self.left_radius - self.right_radius):g} m"
            )
        if self.servo.law == "voltage" and self.motor.no_load_speed is None:
            raise InvalidValue('Robot.servo.law = "voltage": needs a motor with stall_torque and no_load_speed')
        own, (x, y, _) = self.center_of_mass_x, self.loaded_center_of_mass
        if not self.skids:
            refuse_beside_triangle(own, x, y, self.payload, self.track_width, self.caster.x)
            return
        refuse_on_three_wheels(own, x, y, self.payload, self.track_width, self.skid_steer.wheelbase)
        if given(given(self).get("caster")):
            raise InvalidValue(
                "Robot.caster: with skid steer a robot stands on four wheels alone; caster=Caster() has none"
            )
        if self.axle == "rigid":
            raise InvalidValue("Robot.axle = 'rigid': with skid steer the wheels have independent axles")

    @property
    def radius_ratio(self) -> float:
        """Right radius / left radius."""
        return self.right_radius / self.left_radius

    @property
    def mean_radius(self) -> float:
        """Half the sum of the radii [m]."""
        return (self.left_radius + self.right_radius) / 2

    @property
    def skids(self) -> bool:
        """Whether it has skid steer."""
        return self.skid_steer.wheelbase > 0

    @property
    def effective_track(self) -> float:
        """The track that odometry of the robot needs, with its weight in the middle [m]; with skid steer it is wider.

        It is b (1 + (wheelbase / b)^2) of the track width b, on any floor and at any low speed: all four wheels slide
        equally fast then, by omega wheelbase / 2 to the side and omega wheelbase^2 / (2 b) along.
        """
        return self.track_width * (1 + (self.skid_steer.wheelbase / self.track_width) ** 2)

    @property
    def mass(self) -> float:
        """Mass of the body, the driven wheels and the payload [kg]."""
        wheels = 4 if self.skids else 2
        return self.body_mass + wheels * self.tyres.mass + self.payload.mass

    @property
    def loaded_center_of_mass(self) -> tuple[float, float, float]:
        """Where the centre of mass of the body with its payload lies: forward, left, above the floor [m]."""
        load = self.payload
        share = load.mass / (self.body_mass + load.mass)
        x, height = self.center_of_mass_x, self.center_of_mass_height
        return x + share * (load.x - x), share * load.y, height + share * (load.height - height)

    def replace(self, **changes: Any) -> Robot:
        """Return the robot with some fields changed; what was not given before scales with the new robot.

        Args:
            changes: fields of a robot. A mapping changes the named fields of a part, a part replaces the whole part;
                None lets a size or mass scale again.

        Raises:
            InvalidValue, InvalidType, UnknownName: as for a new robot.

        Example:
            >>> robot = Robot(left_radius=0.05, right_radius=0.05, track_width=0.3, caster={"x": -0.1})
            >>> robot.replace(caster={"radius": 0.01}).caster
            Caster(x=-0.1, radius=0.01)
        """
        before = given(self)
        for name, change in changes.items():
            if isinstance(change, Mapping):
                changes[name] = {**given(before.get(name)), **change}
        return type(self)(**{**before, **changes})

    __replace__ = replace  # for copy.replace

    @classmethod
    def load(cls, name_or_path: str | Path) -> Robot:
        """Read the robot of a preset's name, or of a path to a TOML file.

        The file's keys are the fields of a robot, and each part is a table.

        Args:
            name_or_path: one of `presets()`, or a path that ends on .toml or has a folder.

        Raises:
            UnknownName: no such preset, or a key that is not a field.
            MissingFile: no file at the path.
            InvalidValue: not a TOML file, or a field that is missing, out of range or under a former name.
            InvalidType: neither a name nor a path, or a field of the wrong kind.

        Example:
            >>> Robot.load("turtlebot3_burger").track_width
            0.16
        """
        return _described_file.load(cls, name_or_path, refuse_keys)

    def save(self, path: str | Path) -> None:
        """Write the robot's TOML file, whole or not at all; `Robot.load` reads it back equal.

        Args:
            path: must end on .toml.

        Raises:
            InvalidType: not a path.
            InvalidValue: the file is not named .toml, or cannot be written.

        Example:
            >>> Robot.load("ct_bot").save("/no/such/folder/mine.toml")
            Traceback (most recent call last):
            diffdrive_mj.errors.InvalidValue: /no/such/folder/mine.toml: cannot be written (No such file or directory)
        """
        _described_file.save(self, path)

    def to_toml(self) -> str:
        """Return the robot as TOML: its name and what it was given, so that the rest scales when it is read back.

        Example:
            >>> print(Robot(left_radius=0.1, right_radius=0.1, track_width=0.4, caster={"x": -0.3}).to_toml())
            name = "robot"
            left_radius = 0.1
            right_radius = 0.1
            track_width = 0.4
            <BLANKLINE>
            [caster]
            x = -0.3
            <BLANKLINE>
        """
        return _described_file.text(self)


def presets() -> tuple[str, ...]:
    """Return the names that `Robot.load` knows.

    Example:
        >>> "ct_bot" in presets()
        True
    """
    return _described_file.presets(Robot)
