"""The parts of a robot: tyres, caster, motors, servos, wheel encoders, payload, skid steer.

What a part leaves out of sizes and masses scales with the robot that gets the part (`Robot`), and is None until then.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass, field
from typing import Literal

from diffdrive_mj import _checks as checks
from diffdrive_mj._described import SCALES, checked, described
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.tolerances import Tolerances

# What is larger is in another unit, or breaks the physics.
LARGEST_LENGTH, LARGEST_MASS, LARGEST_INERTIA = 10.0, 1e6, 1e6

_POSITIVE = checked(checks.positive)
_PLACE = checked(checks.limited(checks.number, LARGEST_LENGTH, "m"))
_SIZE = checked(checks.limited(checks.positive, LARGEST_LENGTH, "m"))
# A force over the load that causes it.
RESISTANCE = checks.limited(checks.not_negative, 1.0, "of the load")
_HEIGHT = checked(checks.limited(checks.not_negative, LARGEST_LENGTH, "m"))


@described()
@dataclass(frozen=True, kw_only=True)
class Tyres:
    """Describe the wheels apart from their radii.

    Args:
        width: of a wheel [m]; scales with the mean radius.
        mass: of one wheel with its tyre [kg]; scales with the mean radius squared and the track width.
        rolling_resistance: force that rolling costs over the load, to which the floor adds its own
            (`World.rolling_resistance`).
        shape: "crowned", an ellipsoid that touches the floor in one point, so that the track is what the robot says, or
            "cylinder", whose contact jumps between its edges: it turns as if its track were 0.4 to 5 % off.
        stiffness: load over what a tyre gives way by [N/m]; the wheel rolls on a radius that is smaller by half of
            that. None is rigid.

    Raises:
        InvalidValue: a number that is not positive, not finite, or too large (10 m, 1000 t), or a rolling resistance
            that is not from 0 to 1.
        InvalidType: not a number.
        UnknownName: a shape or a field that tyres do not have.

    Example:
        >>> Tyres(width=0.026, mass=0.04).mass
        0.04
    """

    width: float = field(default=SCALES, metadata=_SIZE)
    mass: float = field(default=SCALES, metadata=checked(checks.limited(checks.positive, LARGEST_MASS, "kg")))
    rolling_resistance: float = field(default=0.0, metadata=checked(RESISTANCE))
    shape: Literal["crowned", "cylinder"] = field(
        default="crowned", metadata=checked(functools.partial(checks.member, valid=("crowned", "cylinder")))
    )
    stiffness: float | None = field(default=None, metadata=_POSITIVE)


@described()
@dataclass(frozen=True, kw_only=True)
class Caster:
    """Describe what carries what the wheels do not.

    Args:
        x: where it touches the floor, forward of the axle [m]; negative behind it. Scales with the track width. Of a
            swivel caster the axis of its fork.
        radius: [m]; scales with the wheels' mean radius.
        kind: "ball", or "swivel", a wheel in a fork that turns freely about the vertical.
        friction: coefficient with which a ball slides over the floor; 0 is a ball that rolls without resistance.
        trail: how far behind the fork's axis a swivel caster touches the floor [m]; None is 0.8 of its radius.
        angle: where its wheel is at the start, counter-clockwise [rad]: 0 behind the axis, as it trails a robot that
            drives forward. A robot that starts backward from 0 leaves it to rounding which way the fork flips.

    Raises:
        InvalidValue: a number that is not finite or above 10 m, a radius or a trail that is not positive, a negative
            friction, or a swivel caster with friction.
        InvalidType: not a number.
        UnknownName: a kind or a field that a caster does not have.

    Example:
        >>> Caster(x=-0.09)
        Caster(x=-0.09)
    """

    x: float = field(default=SCALES, metadata=_PLACE)
    radius: float = field(default=SCALES, metadata=_SIZE)
    kind: Literal["ball", "swivel"] = field(
        default="ball", metadata=checked(functools.partial(checks.member, valid=("ball", "swivel")))
    )
    friction: float = field(default=0.0, metadata=checked(checks.not_negative))
    trail: float | None = field(default=None, metadata=_SIZE)
    angle: float = field(default=0.0, metadata=checked(checks.number))

    def __post_init__(self) -> None:
        if self.kind == "swivel" and self.friction:
            raise InvalidValue(f"Caster.friction = {self.friction:g}: must be 0 for a swivel caster, whose wheel rolls")


@described()
@dataclass(frozen=True, kw_only=True)
class Motor:
    """Describe the motors, one a wheel.

    Args:
        rotor_inertia: inertia of a rotor, seen from a wheel of the mean radius: times the gear ratio squared [kg m^2];
            scales with the robot's mass and the mean radius squared.
        stall_torque: the largest torque, at rest, at the wheel: times the gear ratio [N m]; None is as much as asked.
        no_load_speed: the largest speed, without load, at the wheel: over the gear ratio [rad/s]; the torque falls
            evenly to zero there, by back-EMF. None is no back-EMF; it needs a stall torque.
        gain_ratio: what the right motor makes of the voltage that it is asked for, over what the left one makes.

    Raises:
        InvalidValue: a negative inertia, a torque, speed or ratio that is not positive, a number that is not finite or
            too large, or a no-load speed without a stall torque.
        InvalidType: not a number.
        UnknownName: a field that a motor does not have.

    Example:
        >>> Motor(rotor_inertia=70e-7 * 33**2)  # 70 g cm^2 behind a gear of 33:1
        Motor(rotor_inertia=0.007623)
        >>> Motor(stall_torque=1.77, no_load_speed=26.3).no_load_speed  # 18 kg cm, 251 turns a minute
        26.3
    """

    rotor_inertia: float = field(
        default=SCALES, metadata=checked(checks.limited(checks.not_negative, LARGEST_INERTIA, "kg m^2"))
    )
    stall_torque: float | None = field(default=None, metadata=_POSITIVE)
    no_load_speed: float | None = field(default=None, metadata=_POSITIVE)
    gain_ratio: float = field(default=1.0, metadata=_POSITIVE)

    def __post_init__(self) -> None:
        if self.no_load_speed is not None and self.stall_torque is None:
            raise InvalidValue(
                f"Motor.no_load_speed = {self.no_load_speed:g} rad/s: needs a stall_torque, from which the torque falls"
            )


@described()
@dataclass(frozen=True, kw_only=True)
class Servo:
    """Describe the speed controllers, one a wheel.

    Args:
        law: "PI" reaches the commanded rate under load, "P" falls short in proportion to the load, "voltage" is none:
            the motor gets the voltage at which it would turn as commanded without load (`Motor.no_load_speed`).
        bandwidth: its stiffness, as the natural frequency of the robot's speed [rad/s]; a time step too coarse for a
            light wheel lowers it (`Physics.servo_stiffness`).
        gains: "matched", gains and rotor inertia in proportion to the wheel's radius squared, which gives both wheels
            one time constant, or "equal", which makes unequal wheels lag unequally.

    Raises:
        InvalidValue: a bandwidth that is not positive and finite.
        InvalidType: not a number.
        UnknownName: a law, gains or a field that a servo does not have.

    Example:
        >>> Servo(law="P").bandwidth
        30.0
    """

    law: Literal["PI", "P", "voltage"] = field(
        default="PI", metadata=checked(functools.partial(checks.member, valid=("PI", "P", "voltage")))
    )
    bandwidth: float = field(default=30.0, metadata=_POSITIVE)
    gains: Literal["matched", "equal"] = field(
        default="matched", metadata=checked(functools.partial(checks.member, valid=("matched", "equal")))
    )


@described()
@dataclass(frozen=True, kw_only=True)
class WheelEncoder:
    """Describe the encoders, one a wheel.

    Args:
        ticks_per_revolution: ticks per turn of the encoder's shaft, all edges counted.
        gear: turns of that shaft per turn of the wheel; 1 on the wheel itself.

    Raises:
        InvalidValue: a number that is not positive and finite.
        InvalidType: not a number.
        UnknownName: a field that an encoder does not have.

    Example:
        >>> WheelEncoder(ticks_per_revolution=64, gear=43.7).ticks_per_wheel_turn
        2796.8
    """

    ticks_per_revolution: float = field(default=4096.0, metadata=_POSITIVE)
    gear: float = field(default=1.0, metadata=_POSITIVE)

    @property
    def ticks_per_wheel_turn(self) -> float:
        """Ticks per turn of the wheel, the gear included."""
        return self.ticks_per_revolution * self.gear


@described()
@dataclass(frozen=True, kw_only=True)
class Payload:
    """Describe a point mass that the body carries; no mass is no payload.

    Args:
        mass: [kg].
        x: forward of the axle [m].
        y: left of the middle of the wheels' contacts [m].
        height: of its centre above the floor [m].

    Raises:
        InvalidValue: a negative mass or height, or a number that is not finite or too large (10 m, 1000 t).
        InvalidType: not a number.
        UnknownName: a field that a payload does not have.

    Example:
        >>> Payload(mass=2, x=-0.05, height=0.15).y
        0.0
    """

    mass: float = field(default=0.0, metadata=checked(checks.limited(checks.not_negative, LARGEST_MASS, "kg")))
    x: float = field(default=0.0, metadata=_PLACE)
    y: float = field(default=0.0, metadata=_PLACE)
    height: float = field(default=0.0, metadata=_HEIGHT)


@described()
@dataclass(frozen=True, kw_only=True)
class SkidSteer:
    """Describe skid steer: four driven wheels, two a side that turn as one, and no caster.

    Args:
        wheelbase: from the front wheels' axle to the rear wheels' [m]; the robot's frame is midway between them. 0 is
            no skid steer: two wheels and a caster.

    Raises:
        InvalidValue: a wheelbase that is negative, not finite or above 10 m.
        InvalidType: not a number.
        UnknownName: a field that skid steer does not have.

    Example:
        >>> SkidSteer(wheelbase=0.512)
        SkidSteer(wheelbase=0.512)
    """

    wheelbase: float = field(default=0.0, metadata=_HEIGHT)


# Under which name a robot has each part, in Python and as a table in TOML.
PARTS: dict[str, type] = {
    "tyres": Tyres,
    "caster": Caster,
    "motor": Motor,
    "servo": Servo,
    "encoder": WheelEncoder,
    "payload": Payload,
    "tolerances": Tolerances,
    "skid_steer": SkidSteer,
}
