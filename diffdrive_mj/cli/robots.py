"""`diffdrive robots`: the presets, what a robot is taken to be, and its model for MuJoCo."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any

import tyro

from diffdrive_mj._described_file import summary
from diffdrive_mj._files import refuse_existing, write_whole
from diffdrive_mj.cli._left_out import Number, WorldName, floor
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.robot import Robot, presets

RobotName = Annotated[str, tyro.conf.Positional, tyro.conf.arg(metavar="ROBOT")]


@dataclass(frozen=True)
class List:
    """List the presets: their wheel radii, their track width, and what they are."""

    def __call__(self) -> None:
        """Print a line a preset; its file and models/README.md have the rest."""
        print(_row("preset", "left [m]", "right [m]", "track [m]", "robot"))
        for name in presets():
            robot = Robot.load(name)
            print(_row(name, robot.left_radius, robot.right_radius, robot.track_width, summary(Robot, name)))


@dataclass(frozen=True)
class Show:
    """Show every number of a robot as a TOML file, also what its own file leaves out.

    Args:
        robot: the name of a preset, or a TOML file.
    """

    robot: RobotName

    def __call__(self) -> None:
        """Print the robot."""
        robot = Robot.load(self.robot)
        print(f"# {robot.mass:.4g} kg; radius ratio {robot.radius_ratio:.6g}, right / left")
        numbers = asdict(robot)  # what was left out and has scaled is given now
        if robot.skids:
            del numbers["caster"]
        print(Robot(**numbers).to_toml(), end="")


@dataclass(frozen=True)
class Mjcf:
    """Write a robot's MuJoCo model, to open with python -m mujoco.viewer --mjcf=OUTPUT.xml.

    Each slider drives a wheel; the keyframe "straight" drives.

    Args:
        robot: the name of a preset, or a TOML file.
        output: the file to write.
        world: its floor: the name of a preset, or a TOML file; level and smooth if not given.
    """

    robot: RobotName
    output: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="OUTPUT.xml", help_behavior_hint="(required)")]
    world: WorldName = None

    def __call__(self) -> None:
        """Write the file."""
        from diffdrive_mj.physics.mjcf import to_mjcf  # loads MuJoCo

        if self.output.suffix != ".xml":
            raise InvalidValue(f"{self.output}: a MuJoCo model is named .xml")
        write_whole(self.output, to_mjcf(Robot.load(self.robot), world=floor(self.world)))
        print(f"written: {self.output}")


@dataclass(frozen=True)
class New:
    """Write the TOML file of a robot of one's own, for --robot.

    Measured are the radii, under load, and the track, between the wheels' contacts; what the robot weighs and how its
    motors are is scaled from them. `diffdrive robots show` lists what else the file may say.

    Args:
        output: the file to write, which must not be there yet.
        left_radius: of the left wheel [m].
        right_radius: of the right wheel [m]; that of the left one if not given.
        track_width: between the wheels' contacts [m].
        ticks_per_revolution: of the encoder.
        gear: turns of the encoder for a turn of the wheel.
        body_mass: of all but the wheels [kg].
    """

    output: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="OUTPUT.toml", help_behavior_hint="(required)")]
    left_radius: float
    track_width: float
    right_radius: Number = None
    ticks_per_revolution: Number = None
    gear: Number = None
    body_mass: Number = None

    def __call__(self) -> None:
        """Write the file."""
        refuse_existing(self.output)
        right = self.left_radius if self.right_radius is None else self.right_radius
        counts = {"ticks_per_revolution": self.ticks_per_revolution, "gear": self.gear}
        given: dict[str, Any] = {"encoder": {name: value for name, value in counts.items() if value is not None}}
        if self.body_mass is not None:
            given["body_mass"] = self.body_mass
        given = {name: value for name, value in given.items() if value != {}}
        robot = Robot(left_radius=self.left_radius, right_radius=right, track_width=self.track_width, **given)
        robot.replace(name=self.output.stem).save(self.output)
        print(f"written: {self.output}")


def command(
    action: tyro.conf.OmitSubcommandPrefixes[
        Annotated[List, tyro.conf.subcommand("list")]
        | Annotated[Show, tyro.conf.subcommand("show")]
        | Annotated[New, tyro.conf.subcommand("new")]
        | Annotated[Mjcf, tyro.conf.subcommand("mjcf")]
    ],
) -> None:
    """List the presets, show a robot, describe one of one's own, or write its MuJoCo model."""
    action()


def _row(name: str, left: object, right: object, track: object, summary: str) -> str:
    return f"{name:<18}{left:>10}{right:>11}{track:>11}  {summary}"
