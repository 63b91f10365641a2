"""Odometry that reads exact wheel angles at some rate, and what the rate costs."""

from __future__ import annotations

from dataclasses import dataclass

from diffdrive_mj import metrics
from diffdrive_mj._checks import Array
from diffdrive_mj.commands import Commands
from diffdrive_mj.recording import Recording
from diffdrive_mj.robot import Robot
from diffdrive_mj.sensors.encoder import Encoder
from diffdrive_mj.sensors.measuring import measure
from diffdrive_mj.sensors.tracker import Tracker


@dataclass(frozen=True, eq=False)
class SampledOdometry:
    """Odometry that reads the wheels at some rate.

    Attributes:
        path: (T, 3) [m, m, rad], as believed at its samples.
        drift: how far off it is.
        loss: largest distance from what the same odometry would believe if it read the wheels always [m].

    Example:
        >>> robot = dd.Robot.load("matched")
        >>> drive = dd.simulate(robot, dd.maneuvers.straight(robot, distance=1.0))
        >>> sampled_odometry(drive, robot, 10.0).loss < 1e-6
        True
    """

    path: Array
    drift: metrics.Drift
    loss: float


def sampled_odometry(recording: Recording[Robot, Commands], believed: Robot, rate: float) -> SampledOdometry:
    """Compute what exact wheel angles at some rate make of a drive.

    Args:
        recording: of one run.
        believed: the robot that the odometry computes with.
        rate: of the readings [Hz]; between two samples of the recording they are interpolated.

    Returns:
        The odometry at its samples.

    Raises:
        InvalidValue: a rate at which the drive has less than two samples.

    Example:
        >>> robot = dd.Robot.load("matched")
        >>> drive = dd.simulate(robot, dd.maneuvers.straight(robot, speed=0.5, distance=1.0))
        >>> len(sampled_odometry(drive, robot, rate=3.0).path)
        11
    """
    tracker = Tracker(sample_rate=rate)
    exact = Encoder(ticks_per_revolution=2**30, sample_rate=rate)
    read, always = measure(recording, encoder=exact, tracker=tracker, seed=0), measure(recording, tracker=tracker)
    path = read.odometry(believed)
    loss = metrics.drift(always.odometry(believed), path)
    return SampledOdometry(path, read.drift(believed), float(loss.max_position))
