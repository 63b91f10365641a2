"""`diffdrive simulate`: a drive in physics, written as the log of a robot and its tracker."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import tyro

from diffdrive_mj import _checks as checks
from diffdrive_mj import logs
from diffdrive_mj.cli._left_out import Number, WorldName, floor
from diffdrive_mj.errors import InvalidValue, UnknownName
from diffdrive_mj.judging.by_name import MANEUVERS
from diffdrive_mj.logs.formats import to_write
from diffdrive_mj.pose_log import PoseLog
from diffdrive_mj.robot import Robot


def command(
    maneuver: Annotated[str, tyro.conf.Positional, tyro.conf.arg(metavar="MANEUVER", help_behavior_hint="(required)")],
    output: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="LOG", help_behavior_hint="(required)")],
    /,
    robot: Annotated[str, tyro.conf.arg(metavar="ROBOT")],
    rate: float = 50.0,
    tracker_rate: Number = None,
    position_noise: float = 0.0,
    heading_noise: float = 0.0,
    world: WorldName = None,
    friction: Number = None,
    seed: int = 0,
    odometry: Annotated[Path | None, tyro.conf.arg(metavar="LOG")] = None,
    believed: Annotated[str | None, tyro.conf.arg(metavar="ROBOT")] = None,
) -> None:
    """Simulate a drive, and write what the robot's encoder and a tracker of its true pose log.

      diffdrive simulate square drive.csv --robot ct_bot

    The ending of a log says its format: .csv, .tum (poses alone), .mcap, .db3, or none for a rosbag2 folder.

    Exit status: 0, or 2 for bad input, of which one line on stderr says what is wrong.

    Args:
        maneuver: straight, square, figure_eight, spin or slalom.
        output: the log; an earlier one is replaced.
        robot: that is driven: the name of a preset, or a TOML file.
        rate: at which the encoder is read [Hz].
        tracker_rate: of the true poses [Hz]; that of the encoder if not given.
        position_noise: of the true poses, standard deviation of x and of y [m].
        heading_noise: of the true poses, standard deviation [rad].
        world: in which it drives: the name of a preset, or a TOML file; ideal if not given.
        friction: of the floor; that of the world if not given.
        seed: of the noise, and of the phase of the encoder's counters.
        odometry: where to write what the robot believes, too.
        believed: the robot that its odometry takes it for; the true one if not given.

    Raises:
        DiffdriveError: bad input; nothing is written then.

    Example:
        >>> from diffdrive_mj.cli import main
        >>> main(["simulate", "squar", "drive.csv", "--robot", "ct_bot"])
        Traceback (most recent call last):
        ...
        SystemExit: 2
    """
    if maneuver not in MANEUVERS:
        raise UnknownName("maneuver", maneuver, MANEUVERS)
    if odometry is not None and odometry.resolve() == output.resolve():
        raise InvalidValue(f"--odometry {odometry}: is the drive's own log; must be another file")
    for log in filter(None, (output, odometry)):
        to_write(log)
    true, place, seed = Robot.load(robot), floor(world, friction), checks.whole("seed", seed, least=0)
    if believed is not None and odometry is None:
        raise InvalidValue("--believed says whose odometry is written: --odometry must say where")
    taken_for = true if believed is None else Robot.load(believed)
    from diffdrive_mj.physics.simulation import simulate  # loads MuJoCo
    from diffdrive_mj.sensors import Encoder, Tracker, measure

    encoder = Encoder(true, sample_rate=checks.positive("rate", rate))
    tracker = Tracker(
        sample_rate=rate if tracker_rate is None else tracker_rate,
        position_noise=position_noise,
        heading_noise=heading_noise,
    )
    drive = measure(simulate(true, MANEUVERS[maneuver](true), world=place), encoder=encoder, tracker=tracker, seed=seed)
    logs.write(output, drive)
    written = [output]
    if odometry is not None:
        poses = drive.odometry(taken_for)
        logs.write(odometry, PoseLog(drive.clock, poses, name=taken_for.name))
        written.append(odometry)
    print(f"{drive!r}\nwritten: {' '.join(map(str, written))}")
