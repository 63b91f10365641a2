"""What a world costs odometry that knows the robot: a square of a minute, the same for all."""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np

from diffdrive_mj import maneuvers
from diffdrive_mj.commands import Commands
from diffdrive_mj.errors import DiffdriveError, PhysicsWarning
from diffdrive_mj.judging.standards import residual
from diffdrive_mj.physics.model import suited
from diffdrive_mj.physics.simulation import simulate
from diffdrive_mj.physics.tilt import level_twin
from diffdrive_mj.recording import Recording
from diffdrive_mj.robot import Robot
from diffdrive_mj.world import World


@dataclass(frozen=True)
class Cost:
    """Hold how far off odometry with the true parameters is, and what happened that it cannot see.

    Attributes:
        position: largest position error [ppm of the distance driven]; nan where the robot could not be driven.
        heading: largest heading error [ppm of the angle turned]; likewise.
        events: as of the recording, or why the robot was not driven.

    Example:
        >>> print(Cost(position=1234.5, heading=0.12, events=()))
        1200 ppm, heading 0.12 ppm
    """

    position: float
    heading: float
    events: tuple[str, ...]

    @classmethod
    def of(cls, recording: Recording[Robot, Commands], believed: Robot) -> Cost:
        """What a drive cost the odometry of a believed robot.

        Args:
            recording: of one run.
            believed: the robot that the odometry computes with.
        """
        left = residual(recording, believed)
        return cls(left.position, left.heading, recording.events)

    @classmethod
    def refused(cls, error: DiffdriveError) -> Cost:
        """What a drive that could not begin has instead.

        Args:
            error: why.
        """
        return cls(float("nan"), float("nan"), (str(error),))

    def __str__(self) -> str:
        if self.position != self.position:
            return f"not driven: {self.events[0]}"
        more = f", and {len(self.events) - 1} more" if len(self.events) > 1 else ""
        return f"{_two_digits(self.position)} ppm, heading {_two_digits(self.heading)} ppm" + "".join(
            f"; {event}{more}" for event in self.events[:1]
        )


def minute(robot: Robot) -> Commands:
    """Return a square of 2 m at 0.2 m/s, forward along x and to the left, which takes a minute.

    Args:
        robot: that it is computed for.

    Example:
        >>> round(minute(Robot.load("ct_bot")).duration)
        61
    """
    return maneuvers.square(_as_it_rolls(robot), side=2.0, speed=0.2, yaw_rate=0.5)


def cost(robot: Robot, world: World, commands: Commands | None = None) -> Cost:
    """Drive a robot in a world, and compare odometry with the true parameters with the physics at every time step.

    Args:
        robot: the true robot.
        world: in which it drives.
        commands: what it drives; `minute` if not given.

    Returns:
        How far off odometry is; what falls, slides or gets stuck is no error but says so.

    Raises:
        InvalidType: not a robot, not a world, not commands.

    Example:
        >>> robot = Robot.load("matched")
        >>> cost(robot, World(), maneuvers.straight(robot, speed=0.5, distance=1.0)).position < 1.0
        True
    """
    try:
        recording = driven(robot, world, minute(robot) if commands is None else commands)
    except TypeError:
        raise
    except DiffdriveError as error:
        return Cost.refused(error)
    return Cost.of(recording, _as_it_rolls(robot))


def driven(robot: Robot, world: World, commands: Commands) -> Recording[Robot, Commands]:
    """Drive a robot in a world, to be compared at every time step; what happens is in the recording's events alone.

    Args:
        robot: the true robot.
        world: in which it drives.
        commands: what it drives.

    Raises:
        DiffdriveError: a robot that cannot stand or start there.

    Example:
        >>> robot = Robot.load("matched")
        >>> driven(robot, World(), maneuvers.straight(robot, speed=0.5, distance=1.0)).events
        ()
    """
    physics = suited(robot)
    with warnings.catch_warnings(action="ignore", category=PhysicsWarning):
        return simulate(
            robot, commands, world=world, physics=physics, sample_rate=1 / physics.timestep, on_fall="record"
        )


def _as_it_rolls(robot: Robot) -> Robot:
    """What odometry that knows the robot believes: the level twin, or with skid steer its effective track."""
    twin = level_twin(robot)
    return twin.replace(track_width=twin.effective_track) if twin.skids else twin


def _two_digits(value: float) -> str:
    """A number to two digits, without an exponent."""
    return np.format_float_positional(value, precision=2, fractional=False, trim="-")
