"""What real floors and real parts do to odometry, one at a time: each on an otherwise ideal robot in an ideal world."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from diffdrive_mj import _checks as checks
from diffdrive_mj import maneuvers
from diffdrive_mj.calibration.paths import least_squares
from diffdrive_mj.commands import Commands
from diffdrive_mj.errors import CalibrationRefused, DiffdriveError, InvalidValue
from diffdrive_mj.judging.costs import Cost, driven
from diffdrive_mj.parts import Payload
from diffdrive_mj.physics.mechanics import resting_loads
from diffdrive_mj.physics.tilt import level_twin, resting_tilt
from diffdrive_mj.recording import Recording
from diffdrive_mj.robot import Robot
from diffdrive_mj.sensors import measure
from diffdrive_mj.terrain import Cable, RoughFloor, Slope
from diffdrive_mj.world import Patch, World

# Paths are laid to 1:50 for drainage; a network cable; DIN 18202's 4 mm under a straightedge of a metre, as a root mean
# square; carpet for small hard wheels; rubber on a wet tile.
_FALL, _CABLE, _UNEVEN, _CARPET, _WET = 0.02, 0.005, 0.0014, 0.05, 0.3
# Of a robot: what a tyre gives way, in radii; a payload, in its own mass; a ball caster's friction; a motor's weakness.
_SINK, _LOAD, _DRAG, _WEAK = 0.01, 0.25, 0.2, 0.95


@dataclass(frozen=True)
class Effect:
    """Hold one thing that is not ideal.

    Attributes:
        name: in words, with its size.
        robot: with it, or the ideal one.
        world: with it, or the ideal one.

    Example:
        >>> Effect("a slope", Robot.load("matched"), World(slope=Slope(angle=0.02))).world.slope
        Slope(angle=0.02)
    """

    name: str
    robot: Robot
    world: World


@dataclass(frozen=True)
class Outcome:
    """Hold what an effect costs odometry on the standard drive.

    Attributes:
        effect: that it was.
        nominal: with the robot's own numbers.
        calibrated: with those that a calibration with the same effect, on the same drive the other way round, finds;
            None where it finds none.
        recording: of the drive; None where the robot could not be driven.

    Example:
        >>> found = Outcome(Effect("none", Robot.load("matched"), World()), Cost(0.1, 0.1, ()), None, None)
        >>> found.nominal.position
        0.1
    """

    effect: Effect
    nominal: Cost
    calibrated: Cost | None
    recording: Recording[Robot, Commands] | None


def without_parts(robot: Robot) -> Robot:
    """Return a robot of the same sizes and masses whose parts are ideal, and which carries nothing.

    Args:
        robot: whose soft tyres, weak motors, payload and the like are left away.

    Example:
        >>> robot = Robot.load("matched")
        >>> without_parts(robot.replace(tyres={"stiffness": 40_000}, payload={"mass": 1.0})) == robot
        True
    """
    law = checks.instance("robot", robot, Robot).servo.law
    return robot.replace(
        turning_gain=0.0,
        tyres={"stiffness": None, "shape": "crowned", "rolling_resistance": 0.0},
        caster={"kind": "ball", "friction": 0.0, "trail": None, "angle": 0.0},
        motor={"stall_torque": None, "no_load_speed": None, "gain_ratio": 1.0},
        servo={"law": "PI" if law == "voltage" else law},
        payload=Payload(),
    )


def usual_effects(robot: Robot) -> tuple[Effect, ...]:
    """Return what may be less than ideal about a robot and its floor, in sizes that are usual.

    Args:
        robot: whose sizes and masses decide how large "usual" is; parts of its own that are not ideal are left away
            (`without_parts`).

    Raises:
        InvalidValue: a robot with skid steer.

    Example:
        >>> [effect.name for effect in usual_effects(Robot.load("matched"))][:2]
        ['nothing: ideal floor and parts', 'slope of 1:50']
    """
    if checks.instance("robot", robot, Robot).skids:
        raise InvalidValue(f"robot {robot.name}: must have wheels that roll, not skid steer")
    robot = without_parts(robot)
    # A rigid axle on unequal wheels leans, and the fork with it: as that swivels, the robot pitches.
    leaning = "leaning " if resting_tilt(robot).roll else ""
    floors = {
        "nothing: ideal floor and parts": World(),
        f"slope of 1:{1 / _FALL:.0f}": World(slope=Slope(angle=_FALL, direction=0.5)),
        "floor uneven by 4 mm a metre": World(
            rough=RoughFloor(x=(-6.0, 8.0), y=(-6.0, 8.0), rms=_UNEVEN, wavelength=1.0, level=robot.track_width)
        ),
        "5 mm cable across two sides": World(cables=(Cable(x=(1.0, 1.0), y=(-3.0, 3.0), height=_CABLE),)),
        "5 mm cable under one wheel": World(cables=(Cable(x=(1.0, 1.0), y=(0.0, 1.0), height=_CABLE),)),
        "carpet, rolling resistance 0.05": World(rolling_resistance=_CARPET),
        "wet corner, friction 0.3": World(patches=(Patch(x=(1.5, 2.5), y=(-0.5, 0.5), friction=_WET),)),
    }
    load = {"mass": _LOAD * robot.mass, "height": robot.center_of_mass_height, "x": 0.3 * robot.caster.x}
    tyre = float(resting_loads(robot)[:2].mean()) / (_SINK * robot.mean_radius)
    stall = 4.0 * _CARPET * float(resting_loads(robot)[:2].max()) * robot.mean_radius
    fastest = 2.0 / robot.mean_radius
    parts: dict[str, dict[str, Any]] = {
        "payload of a quarter of its mass": {"payload": {**load, "y": 0.1 * robot.track_width}},
        "tyres that give way by 1 %": {"tyres": {"stiffness": tyre}},
        "cylinder wheels": {"tyres": {"shape": "cylinder"}},
        "ball caster that drags, 0.2": {"caster": {"friction": _DRAG}},
        f"{leaning}swivel caster": {"caster": {"kind": "swivel", "angle": 0.8}},
        "right motor 5 % weaker": {"motor": {"stall_torque": stall, "no_load_speed": fastest, "gain_ratio": _WEAK}},
    }
    return (
        *(Effect(name, robot, world) for name, world in floors.items()),
        *(Effect(name, robot.replace(**changes), World()) for name, changes in parts.items()),
    )


def outcome(effect: Effect, *, side: float = 2.0, speed: float = 0.2) -> Outcome:
    """Drive a square with an effect, and compare odometry with the physics, before and after a calibration.

    Args:
        effect: that is there, on the drive and on the calibration's.
        side: of the square [m].
        speed: along its sides [m/s].

    Returns:
        What it costs; what falls, slides or gets stuck says so.

    Raises:
        InvalidType: not an effect, not numbers.
        InvalidValue: a side or a speed out of its range.

    Example:
        >>> ideal = usual_effects(Robot.load("matched"))[0]
        >>> outcome(ideal, side=0.5).nominal.position < 1.0
        True
    """
    checks.instance("effect.world", checks.instance("effect", effect, Effect).world, World)
    level = level_twin(effect.robot)
    there, back = (
        maneuvers.square(level, side=side, speed=speed, yaw_rate=0.5, clockwise=way) for way in (False, True)
    )
    try:
        drive, other = (driven(effect.robot, effect.world, commands) for commands in (there, back))
    except DiffdriveError as error:
        return Outcome(effect, Cost.refused(error), None, None)
    found = _calibrated(other, level)
    return Outcome(effect, Cost.of(drive, level), None if found is None else Cost.of(drive, found), drive)


def _calibrated(recording: Recording[Robot, Commands], believed: Robot) -> Robot | None:
    """The robot that fits a drive, by an exact tracker; None where calibration refuses."""
    drive = measure(recording.at_rate(100.0))
    try:
        return least_squares([drive], believed, turning_gain=False).calibrated
    except CalibrationRefused:
        return None
