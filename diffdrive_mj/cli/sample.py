"""`diffdrive sample`: logs of a made-up robot, to try the calibration on."""

from __future__ import annotations

import math
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import numpy as np
import tyro

from diffdrive_mj import maneuvers, se2
from diffdrive_mj._files import as_path, refuse_existing, write_whole
from diffdrive_mj.commands import Commands
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.odometry import integrate
from diffdrive_mj.parts import WheelEncoder
from diffdrive_mj.robot import Robot
from diffdrive_mj.sensors import Encoder, Tracker

# What the robot is, and what it should be. Encoder and tracker are like those of a small robot under motion capture.
TRUE = Robot(
    left_radius=0.0331, right_radius=0.0327, track_width=0.163, encoder=WheelEncoder(ticks_per_revolution=4096)
)
NOMINAL = TRUE.replace(left_radius=0.033, right_radius=0.033, track_width=0.160, name="nominal")
ENCODER = Encoder(TRUE, sample_rate=50.0, counter_bits=16)
TRACKER = Tracker(sample_rate=10.0, position_noise=0.0005, heading_noise=math.radians(0.1))
HEADER = "stamp,enc_l,enc_r,x,y,yaw"

_NEXT = """\
written: {left}, {right} and {robot}. To calibrate:

diffdrive calibrate {left} {right} --robot {robot} --time stamp --time-unit ms \\
    --left enc_l --right enc_r --wheel-unit ticks --counter-bits 16 --theta yaw --angle-unit deg"""


def command(
    folder: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="FOLDER", help_behavior_hint="(required)")],
    /,
    seed: int = 0,
) -> None:
    """Write logs of a made-up robot, to try the calibration on.

      diffdrive sample lab

    Two squares, left.csv to the left and right.csv to the right: encoder counts every 20 ms, and the true pose from a
    tracker every 100 ms, with its noise. nominal.toml is what the robot should be; its wheels are 0.3 and 0.9 % and its
    track width 1.9 % off. Prints the command that calibrates it. No file is overwritten.

    Exit status: 0, or 2 for bad input, of which one line on stderr says what is wrong.

    Args:
        folder: where to write the files; made if it is not there.
        seed: of the noise.

    Raises:
        DiffdriveError: bad input, or a file that is there already; nothing is written then.

    Example:
        >>> from diffdrive_mj.cli import main
        >>> from tempfile import TemporaryDirectory
        >>> with TemporaryDirectory() as folder:
        ...     main(["sample", folder])
        written: ...
    """
    if seed < 0:
        raise InvalidValue(f"seed = {seed}: must not be negative")
    folder = as_path("folder", folder)
    files = {"left": folder / "left.csv", "right": folder / "right.csv", "robot": folder / "nominal.toml"}
    for path in files.values():
        refuse_existing(path, "folder")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InvalidValue(f"{folder}: cannot be made ({error.strerror})") from None
    rng = np.random.default_rng(seed)
    for side in ("left", "right"):
        square = maneuvers.square(TRUE, side=1.0, speed=0.2, clockwise=side == "right")
        write_whole(files[side], "\n".join([HEADER, *_rows(square, rng), ""]))
    NOMINAL.save(files["robot"])
    print(_NEXT.format(**{name: shlex.quote(str(path)) for name, path in files.items()}))


def _rows(commands: Commands, rng: np.random.Generator) -> Iterator[str]:
    """The lines of a log: wheels that follow the commands exactly, read by the encoder and seen by the tracker."""
    angles = commands.wheel_angles
    t = commands.period * np.arange(len(angles))
    readings = ENCODER.read(t, angles, rng, phase="random")
    track = TRACKER.read(t, integrate(angles, TRUE), rng)
    seen = {round(1e3 * at): pose for at, pose in zip(track.t, track.poses, strict=True)}
    for at, (left, right) in zip(readings.t, readings.counts, strict=True):
        stamp = round(1e3 * at)
        pose = ",,"
        if stamp in seen:
            x, y, theta = seen[stamp]
            pose = f"{x:.4f},{y:.4f},{np.degrees(se2.wrap_angle(theta)):.2f}"
        yield f"{stamp},{left},{right},{pose}"
