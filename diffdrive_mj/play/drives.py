"""From a setting to a drive: the true robot, the believed one, the commands, and all of it as JSON for the page."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from typing import Any

from diffdrive_mj import _checks as checks
from diffdrive_mj import maneuvers
from diffdrive_mj.commands import Commands
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.judging.rolling import gentle_ramp
from diffdrive_mj.physics._numbers import full_model
from diffdrive_mj.physics.limits import needed_grip
from diffdrive_mj.play.setting import Setting
from diffdrive_mj.robot import Robot
from diffdrive_mj.sensors import Encoder
from diffdrive_mj.solver import Physics
from diffdrive_mj.world import World

LONGEST = 120.0  # [s]
# Up to which share of the floor's friction a drive's need of it counts as rolling.
_SURE_GRIP = 0.9
_SIZES = ("left_radius", "right_radius", "track_width")
# Every size follows from how far the robot gets at full speed.
_Maneuver = Callable[[Setting, Robot, float], Commands]


def _constant(s: Setting, _: Robot, ramp: float) -> Commands:
    return maneuvers.constant_rates((s.k * s.right_rate, s.right_rate), s.seconds, ramp=ramp)


def _straight(s: Setting, robot: Robot, ramp: float) -> Commands:
    return maneuvers.straight(robot, speed=s.speed, distance=s.speed * s.seconds, ramp=ramp)


def _circle(s: Setting, robot: Robot, ramp: float) -> Commands:
    around = s.speed * s.seconds
    return maneuvers.arc(robot, speed=s.speed, distance=around, radius=around / (2 * math.pi), ramp=ramp)


def _square(s: Setting, robot: Robot, ramp: float) -> Commands:
    yaw_rate = min(1.0, 2 * s.speed / robot.track_width)
    return maneuvers.square(robot, speed=s.speed, side=s.speed * s.seconds / 4, yaw_rate=yaw_rate, ramp=ramp)


def _figure_eight(s: Setting, robot: Robot, ramp: float) -> Commands:
    return maneuvers.figure_eight(robot, speed=s.speed, radius=s.speed * s.seconds / (4 * math.pi), ramp=ramp)


def _slalom(s: Setting, robot: Robot, ramp: float) -> Commands:
    return maneuvers.slalom(robot, speed=s.speed, wavelength=s.speed * s.seconds / 3, waves=3.0, ramp=ramp)


def _spin(s: Setting, robot: Robot, ramp: float) -> Commands:
    yaw_rate = 2 * s.speed / robot.track_width
    return maneuvers.spin(robot, yaw_rate=yaw_rate, turns=yaw_rate * s.seconds / (2 * math.pi), ramp=ramp)


MANEUVERS: dict[str, _Maneuver] = {
    "k": _constant,
    "straight": _straight,
    "circle": _circle,
    "square": _square,
    "figure_eight": _figure_eight,
    "slalom": _slalom,
    "spin": _spin,
}


@dataclass(frozen=True, eq=False)
class Planned:
    """A drive that can be stepped, here by `simulate` or on the page.

    Attributes:
        setting: what it follows from.
        true: the robot in the physics.
        believed: the robot of odometry, of which radii and track alone count.
        commands: wheel rates.
        world: the floor.
        physics: how it is solved; for wheels that slide where the floor holds less than the drive needs.

    Example:
        >>> matched = Robot.load("matched")
        >>> plan(Setting.of(matched), {"matched": matched}).commands
        Commands(1150 periods of 0.01 s, 11.5 s)
    """

    setting: Setting
    true: Robot
    believed: Robot
    commands: Commands
    world: World
    physics: Physics

    @property
    def encoder(self) -> Encoder | None:
        """The wheels' encoders; None for those without ticks."""
        if not self.setting.ticks:
            return None
        return Encoder(ticks_per_revolution=self.setting.ticks, sample_rate=self.setting.rate)

    def as_json(self) -> dict[str, Any]:
        """Return the drive as JSON, whose numbers have all their digits.

        Raises:
            InvalidValue: a robot that cannot stand or be built; the message says why.
        """
        friction, damping = self.world.friction, self.physics.friction_damping
        return {
            "setting": asdict(self.setting),
            "model": full_model(self.true, self.physics, self.world),
            "timestep": self.physics.timestep,
            # What part of a step's turn the true pose's displacement is turned by (`physics._motion`).
            "turned_on": 1 / damping - 0.5 if damping and self.physics.truth == "midpoint" else 0.0,
            "friction": friction,
            "rates": self.commands.wheel_rates.ravel().tolist(),
            "steps_per_period": round(self.commands.period / self.physics.timestep),
            "true": {name: getattr(self.true, name) for name in _SIZES},
            "believed": {name: getattr(self.believed, name) for name in _SIZES},
            "ticks": self.setting.ticks,
            "rate": self.setting.rate,
        }


def plan(setting: Setting, robots: Mapping[str, Robot]) -> Planned:
    """Plan the drive of a setting.

    Args:
        setting: what the sliders say.
        robots: by name.

    Returns:
        The drive; commands speed up gently, unless the floor is slippery.

    Raises:
        UnknownName: a robot or a maneuver that there is not.
        InvalidValue: sizes that no robot has, a rate whose interval is not a whole number of time steps, or a drive
            that takes too long.

    Example:
        >>> matched = Robot.load("matched")
        >>> plan(Setting.of(matched), {"matched": matched}).believed.radius_ratio
        0.9099999999999999
    """
    base = checks.one_of("robot", setting.robot, robots)
    maneuver = checks.one_of("maneuver", setting.maneuver, MANEUVERS)
    true = base.replace(**{name: getattr(setting, name) for name in _SIZES})
    believed = Robot(name="believed", **{name: getattr(setting, f"believed_{name}") for name in _SIZES})
    by_rates = max(1.0, setting.k) * setting.right_rate * max(true.left_radius, true.right_radius)
    checks.multiple("the interval 1 / rate", 1 / setting.rate, "the time step", Physics().timestep)
    ramp = gentle_ramp(true, by_rates if setting.maneuver == "k" else setting.speed)
    if setting.seconds + ramp > LONGEST:
        raise InvalidValue(f"the robot needs {ramp:.3g} s to speed up: too long, drive more slowly")
    commands = maneuver(setting, believed, ramp)
    if commands.duration > LONGEST:
        raise InvalidValue(f"the drive takes {commands.duration:.3g} s: must be at most {LONGEST:g} s, lower seconds")
    # Where wheels slide, contacts that roll best throw them up, and the least rounding decides where they land.
    need, _ = needed_grip(true, commands)
    slides = need.max() > _SURE_GRIP * setting.friction
    physics = Physics.sliding() if slides else Physics()
    return Planned(setting, true, believed, commands, World(friction=setting.friction), physics)
