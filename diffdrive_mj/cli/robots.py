"""`diffdrive robots`: the presets, what a robot is taken to be, and its model for MuJoCo."""

from __future__ import annotations

import re
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated

import tyro

from diffdrive_mj._files import write_whole
from diffdrive_mj._resources import MODELS
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
            print(_row(name, robot.left_radius, robot.right_radius, robot.track_width, _summary(name)))


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
        print(Robot(**asdict(robot)).to_toml(), end="")  # what was left out and has scaled is given now


@dataclass(frozen=True)
class Mjcf:
    """Write a robot's MuJoCo model, to open with python -m mujoco.viewer --mjcf=OUTPUT.xml.

    Each slider drives a wheel; the keyframe "straight" drives.

    Args:
        robot: the name of a preset, or a TOML file.
        output: the file to write.
    """

    robot: RobotName
    output: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="OUTPUT.xml", help_behavior_hint="(required)")]

    def __call__(self) -> None:
        """Write the file."""
        from diffdrive_mj.physics.mjcf import to_mjcf  # loads MuJoCo

        if self.output.suffix != ".xml":
            raise InvalidValue(f"{self.output}: a MuJoCo model is named .xml")
        write_whole(self.output, to_mjcf(Robot.load(self.robot)))
        print(f"written: {self.output}")


def command(
    action: tyro.conf.OmitSubcommandPrefixes[
        Annotated[List, tyro.conf.subcommand("list")]
        | Annotated[Show, tyro.conf.subcommand("show")]
        | Annotated[Mjcf, tyro.conf.subcommand("mjcf")]
    ],
) -> None:
    """List the presets, show a robot, or write its MuJoCo model."""
    action()


def _row(name: str, left: object, right: object, track: object, summary: str) -> str:
    return f"{name:<18}{left:>10}{right:>11}{track:>11}  {summary}"


def _summary(preset: str) -> str:
    """What the comment at the head of a preset's file says first."""
    lines = (MODELS / "robots" / f"{preset}.toml").read_text(encoding="utf-8").splitlines()
    head = " ".join(line[2:] for line in lines[:2] if line.startswith("# "))
    return re.split("[:;]", head)[0]
