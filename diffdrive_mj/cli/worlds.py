"""`diffdrive worlds`: the presets, a file for a world of one's own, and what it costs a robot's odometry."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any

import tyro

from diffdrive_mj._described_file import summary
from diffdrive_mj._files import refuse_existing
from diffdrive_mj.cli._left_out import Number
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.robot import Robot
from diffdrive_mj.world import World, presets


@dataclass(frozen=True)
class List:
    """List the presets: their friction, their slope, and what they are."""

    def __call__(self) -> None:
        """Print a line a preset; its file and models/README.md have the rest."""
        print(_row("preset", "friction", "slope [rad]", "world"))
        for name in presets():
            world = World.load(name)
            angle = 0.0 if world.slope is None else world.slope.angle
            print(_row(name, world.friction, angle, summary(World, name)))


@dataclass(frozen=True)
class Show:
    """Show every number of a world as a TOML file, also what its own file leaves out.

    Args:
        world: the name of a preset, or a TOML file.
    """

    world: Annotated[str, tyro.conf.Positional, tyro.conf.arg(metavar="WORLD")]

    def __call__(self) -> None:
        """Print the world."""
        print(World(**asdict(World.load(self.world))).to_toml(), end="")  # what was left out is given now


@dataclass(frozen=True)
class Cost:
    """Drive a robot for a minute on each floor: what does it cost odometry that knows the robot exactly?

    It drives a square of 2 m at 0.2 m/s. A thousand ppm are a millimetre for each metre driven.

    Args:
        robot: the name of a preset, or a TOML file.
        worlds: names of presets, or TOML files.
    """

    robot: Annotated[str, tyro.conf.Positional, tyro.conf.arg(metavar="ROBOT", help_behavior_hint="(required)")]
    worlds: Annotated[
        tuple[str, ...], tyro.conf.arg(metavar="[WORLD ...]", help_behavior_hint="(default: all presets)")
    ] = ()

    def __call__(self) -> None:
        """Print a line a world."""
        from diffdrive_mj.judging.costs import cost  # loads MuJoCo

        robot, names = Robot.load(self.robot), self.worlds or presets()
        for name, world in [(name, World.load(name)) for name in names]:
            print(f"{name:<12}{cost(robot, world)}")


@dataclass(frozen=True)
class New:
    """Write the TOML file of a world of one's own, for --world.

    `diffdrive worlds show` lists what else the file may say.

    Args:
        output: the file to write, which must not be there yet.
        friction: coefficient of sliding friction between wheels and floor.
        slope: how steep the floor is [rad].
        direction: in which it rises, as a heading [rad].
        gravity: [m/s^2].
    """

    output: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="OUTPUT.toml", help_behavior_hint="(required)")]
    friction: float
    slope: Number = None
    direction: Number = None
    gravity: Number = None

    def __call__(self) -> None:
        """Write the file."""
        refuse_existing(self.output)
        if self.direction is not None and self.slope is None:
            raise InvalidValue("--direction: in which a slope rises; --slope must say how steeply")
        slope = {
            name: value for name, value in (("angle", self.slope), ("direction", self.direction)) if value is not None
        }
        given: dict[str, Any] = {"slope": slope or None, "gravity": self.gravity}
        given = {name: value for name, value in given.items() if value is not None}
        World(name=self.output.stem, friction=self.friction, **given).save(self.output)
        print(f"written: {self.output}")


def command(
    action: tyro.conf.OmitSubcommandPrefixes[
        Annotated[List, tyro.conf.subcommand("list")]
        | Annotated[Show, tyro.conf.subcommand("show")]
        | Annotated[New, tyro.conf.subcommand("new")]
        | Annotated[Cost, tyro.conf.subcommand("cost")]
    ],
) -> None:
    """List the presets, show a world, describe one of one's own, or say what it costs a robot."""
    action()


def _row(name: str, friction: object, slope: object, summary: str) -> str:
    return f"{name:<12}{friction:>9}{slope:>13}  {summary}"
