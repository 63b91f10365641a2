"""A trial of a study: the robot, the world and the sensors that are driven."""

from __future__ import annotations

from dataclasses import dataclass

from diffdrive_mj.commands import Commands
from diffdrive_mj.robot import Robot
from diffdrive_mj.sensors.encoder import Encoder
from diffdrive_mj.sensors.gyro import Gyro
from diffdrive_mj.world import World


@dataclass(frozen=True)
class Trial:
    """One trial of a study: what is driven, and what its odometry believes.

    Attributes:
        index: of the trial in its study.
        robot: the true one.
        believed: by its odometry.
        commands: computed for the believed robot.
        world: in which it drives.
        encoder: that reads its wheels; None for ideal wheel angles.
        gyro: that turns with it; None for odometry by the wheels alone.

    Example:
        >>> study = dd.sweeps.Study.load("squares")
        >>> study.trial(3).believed == study.robot
        True
    """

    index: int
    robot: Robot
    believed: Robot
    commands: Commands
    world: World
    encoder: Encoder | None
    gyro: Gyro | None = None
