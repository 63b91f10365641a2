"""A study: a robot and its drive, what of them varies and how, and what is kept of each trial."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from diffdrive_mj import _checks as checks
from diffdrive_mj import maneuvers
from diffdrive_mj._checks import Array
from diffdrive_mj._described import checked, described, given, one
from diffdrive_mj._text import shown
from diffdrive_mj.commands import Commands
from diffdrive_mj.errors import InvalidType
from diffdrive_mj.odometry import METHODS, Method
from diffdrive_mj.robot import Robot
from diffdrive_mj.sensors.encoder import Encoder
from diffdrive_mj.solver import Physics
from diffdrive_mj.sweeps.distributions import Distribution
from diffdrive_mj.sweeps.figures import FIGURES
from diffdrive_mj.world import World

MANEUVERS: dict[str, Callable[..., Commands]] = {
    "straight": maneuvers.straight,
    "arc": maneuvers.arc,
    "spin": maneuvers.spin,
    "square": maneuvers.square,
    "figure_eight": maneuvers.figure_eight,
    "slalom": maneuvers.slalom,
}


@dataclass(frozen=True)
class Maneuver:
    """A standard maneuver by name, with its options.

    Args:
        name: "straight", "arc", "spin", "square", "figure_eight" or "slalom".
        options: of that maneuver (`dd.maneuvers`), by name.

    Raises:
        UnknownName: another name.

    Example:
        >>> dd.sweeps.Maneuver("square", {"side": 1.0}).commands(dd.Robot.load("matched")).period
        0.01
    """

    name: str
    options: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        checks.one_of("maneuver", self.name, MANEUVERS)
        object.__setattr__(self, "options", dict(self.options))

    def commands(self, robot: Robot) -> Commands:
        """Compute the wheel rates for a robot."""
        return MANEUVERS[self.name](robot, **self.options)


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
    """

    index: int
    robot: Robot
    believed: Robot
    commands: Commands
    world: World
    encoder: Encoder | None


def _vary(name: str, value: object) -> dict[str, Distribution]:
    if not isinstance(value, Mapping):
        raise InvalidType(f"{name} = {shown(value)}: must be a mapping from what varies to a distribution")
    return dict(value)


@described()
@dataclass(frozen=True, kw_only=True)
class Study:
    """Describe an experiment on many robots.

    Args:
        name: what messages call it.
        robot: as designed: the commands are computed for it, and its odometry believes in it.
        maneuver: what is driven.
        vary: how the true robot and its world differ from that: distributions by what varies, as "robot.left_radius",
            "robot.tyres.width" or "world.friction"; "believed.track_width" varies what odometry believes.
        trials: how many.
        seed: of the randomness.
        figures: what is kept of each trial, by name (`sweeps.figures`).
        world: in which they drive.
        physics: how it is solved.
        truth: "physics" drives in MuJoCo; "kinematics" rolls without slip, as the commands say.
        encoder: that reads the wheels; None for ideal wheel angles.
        method: of the odometry.
        sample_rate: of the recording [Hz].

    Raises:
        InvalidValue, InvalidType, UnknownName: a field that does not fit; the message names it.

    Example:
        >>> robot = dd.Robot.load("matched")
        >>> spread = {"robot.left_radius": dd.sweeps.Normal(mean=robot.left_radius, sigma=0.0005)}
        >>> study = dd.sweeps.Study(robot=robot, maneuver=dd.sweeps.Maneuver("square"), vary=spread, trials=100)
        >>> study.trial(7).robot.left_radius != robot.left_radius
        True
    """

    robot: Robot = field(metadata=one(Robot))
    maneuver: Maneuver = field(metadata=checked(lambda name, value: checks.instance(name, value, Maneuver)))
    vary: Mapping[str, Distribution] = field(metadata=checked(_vary))
    trials: int = field(default=1000, metadata=checked(checks.whole))
    seed: int = field(default=0, metadata=checked(lambda name, value: checks.whole(name, value, least=0)))
    figures: Sequence[str] = field(default=("final_position", "final_heading"), metadata=checked(checks.strings))
    name: str = field(default="study", metadata=checked(checks.string))
    world: World = field(default=World(), metadata=one(World))
    physics: Physics = field(
        default=Physics.fast(), metadata=checked(lambda name, value: checks.instance(name, value, Physics))
    )
    truth: Literal["physics", "kinematics"] = field(
        default="physics", metadata=checked(lambda name, value: checks.member(name, value, ("physics", "kinematics")))
    )
    encoder: Encoder | None = field(default=None, metadata=checked(lambda _, value: value))
    method: Method = field(default="arc", metadata=checked(lambda name, value: checks.member(name, value, METHODS)))
    sample_rate: float = field(default=100.0, metadata=checked(checks.positive))

    def __post_init__(self) -> None:
        for figure in self.figures:
            checks.one_of("figure", figure, FIGURES)

    def replace(self, **changes: Any) -> Study:
        """Return the study with some fields changed."""
        return type(self)(**{**given(self), **changes})

    def shares(self, first: int, last: int) -> Array:
        """Return where in the unit cube the trials from `first` to before `last` lie (N, D)."""
        # One stream a trial, so that a trial is the same however many there are.
        return np.stack([
            np.random.default_rng([self.seed, 0, index]).random(len(self.vary)) for index in range(first, last)
        ])  # fmt: skip

    def drawn(self, first: int, last: int) -> dict[str, NDArray[Any]]:
        """Return the values (N,) of what varies, by its name, in the trials from `first` to before `last`."""
        shares = self.shares(first, last)
        return {name: spread.at(shares[:, k]) for k, (name, spread) in enumerate(self.vary.items())}

    def trial(self, index: int) -> Trial:
        """Return a trial.

        Raises:
            InvalidValue: a value that a robot or a world cannot have.
        """
        changes: dict[str, dict[str, Any]] = {"robot": {}, "believed": {}, "world": {}}
        for name, values in self.drawn(index, index + 1).items():
            owner, _, path = name.partition(".")
            _put(changes[owner], path.split("."), values[0].item())
        believed = self.robot.replace(**changes["believed"])
        return Trial(
            index=index,
            robot=self.robot.replace(**changes["robot"]),
            believed=believed,
            commands=self.maneuver.commands(believed),
            world=self.world.replace(**changes["world"]),
            encoder=self.encoder,
        )


def _put(changes: dict[str, Any], path: Sequence[str], value: object) -> None:
    """Put a value into nested mappings."""
    for part in path[:-1]:
        changes = changes.setdefault(part, {})
    changes[path[-1]] = value
