"""A study: a robot and its drive, what of them varies and how, and what is kept of each trial."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from diffdrive_mj import _checks as checks
from diffdrive_mj import _described_file
from diffdrive_mj._checks import Array
from diffdrive_mj._described import checked, described, given, one
from diffdrive_mj.errors import DiffdriveError, InvalidValue
from diffdrive_mj.odometry import METHODS, Method
from diffdrive_mj.robot import Robot
from diffdrive_mj.sensors.encoder import Encoder
from diffdrive_mj.sensors.gyro import Gyro
from diffdrive_mj.solver import Physics
from diffdrive_mj.sweeps import _study_fields as fields
from diffdrive_mj.sweeps import _study_file, designs
from diffdrive_mj.sweeps._assembly import made_trials
from diffdrive_mj.sweeps.choices import Grid
from diffdrive_mj.sweeps.designs import Design
from diffdrive_mj.sweeps.distributions import Distribution, Normal
from diffdrive_mj.sweeps.figures import FIGURES
from diffdrive_mj.sweeps.making import Trial
from diffdrive_mj.sweeps.named_maneuvers import Maneuver, maneuver
from diffdrive_mj.world import World


def _one_of(*words: str) -> dict[str, Any]:
    return checked(lambda name, value: checks.member(name, value, words))


@described()
@dataclass(frozen=True, kw_only=True, eq=False)
class Study:
    """Describe an experiment on many robots.

    What varies is named by its owner and its field: "robot.left_radius", "robot.tyres.width", "world.friction",
    "world.slope.angle", "encoder.latency", "gyro.bias", "maneuver.speed"; "believed.track_width" varies what odometry
    and driver believe. "robot.mean_radius" and "robot.radius_ratio" are the two radii as causes apart: the ratio varies
    about a mean that is kept. Two studies are equal where their trials are.

    Args:
        robot: as designed: the commands are computed for it, and its odometry believes in it.
        maneuver: what is driven; a `Maneuver`, or a mapping of its name and its options.
        vary: distributions by what varies; in whatever order.
        trials: how many in all. Every combination of grids is driven equally often, by the same draws of all else, so
            that it is a multiple of how many combinations there are.
        seed: of the randomness.
        design: "random"; "sobol", more even than chance; "saltelli", for Sobol' indices, a multiple of D + 2 trials
            where D numbers vary. More trials leave the earlier ones what they were, but for "saltelli".
        figures: what is kept of each trial, by name (`sweeps.figures`).
        name: what messages call it.
        world: in which they drive.
        physics: how it is solved; `Physics`, "fast", "default", "sliding", or a mapping of its fields.
        truth: "physics" drives in MuJoCo; "kinematics" rolls without slip, as the commands say.
        encoder: that reads the wheels, or a mapping of its fields, the robot's own where they are left out; None for
            ideal wheel angles.
        gyro: as designed and as believed, of which odometry takes every turn; `Gyro`, or a mapping of its fields; None
            for odometry by the wheels alone.
        method: of the odometry.
        sample_rate: of the recording [Hz].

    Raises:
        InvalidValue, InvalidType, UnknownName: a field that does not fit, or something that varies and cannot; the
            message names it. Whatever lies in the middle of what varies must be possible; a trial that is not is
            counted when it is its turn.

    Example:
        >>> robot = dd.Robot.load("matched")
        >>> spread = {"robot.left_radius": dd.sweeps.Normal(mean=robot.left_radius, sigma=0.0005)}
        >>> study = dd.sweeps.Study(robot=robot, maneuver=dd.sweeps.Maneuver("square"), vary=spread, trials=100)
        >>> study.trial(7).robot.left_radius != robot.left_radius
        True
        >>> print(study)
        study: 100 trials of matched, square, physics, random
          robot.left_radius: Normal(mean=0.1, sigma=0.0005)
    """

    name: str = field(default="study", metadata=checked(checks.string))
    trials: int = field(default=1000, metadata=checked(checks.whole))
    seed: int = field(default=0, metadata=checked(lambda name, value: checks.whole(name, value, least=0)))
    design: Design = field(default="random", metadata=_one_of(*designs.DESIGNS))
    figures: Sequence[str] = field(default=("final_position", "final_heading"), metadata=checked(checks.strings))
    truth: Literal["physics", "kinematics"] = field(default="physics", metadata=_one_of("physics", "kinematics"))
    physics: Physics = field(default=Physics.fast(), metadata=checked(fields.physics))
    method: Method = field(default="arc", metadata=_one_of(*METHODS))
    sample_rate: float = field(default=100.0, metadata=checked(checks.positive))
    maneuver: Maneuver = field(metadata=checked(maneuver))
    vary: Mapping[str, Distribution] = field(metadata=checked(fields.spreads))
    encoder: Encoder | None = field(default=None, metadata=checked(lambda _, value: value))
    gyro: Gyro | None = field(default=None, metadata=checked(lambda name, value: fields.made(Gyro, name, value)))
    robot: Robot = field(metadata=one(Robot))
    world: World = field(default=World(), metadata=one(World))

    def __post_init__(self) -> None:
        # Which encoder the robot has is known only now.
        object.__setattr__(self, "encoder", fields.made(Encoder, "Study.encoder", self.encoder, robot=self.robot))
        for figure in self.figures:
            checks.one_of("figure", figure, FIGURES)
        if self.gyro is not None and self.method != "arc":
            raise InvalidValue(f"Study.method = {self.method!r}: must be 'arc' with a gyro, which gives the turns")
        fields.refuse_trials(self.trials, self.design, self._grids)
        fields.refuse_impossible(self._owners, self.vary)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Study) and self.to_toml() == other.to_toml()

    def __hash__(self) -> int:
        return hash(self.to_toml())

    def __str__(self) -> str:
        options = ", ".join(f"{name} {value}" for name, value in self.maneuver.options.items())
        drive = f"{self.maneuver.name} ({options})" if options else self.maneuver.name
        head = f"{self.name}: {self.trials} trials of {self.robot.name}, {drive}, {self.truth}, {self.design}"
        return "\n".join([head, *(f"  {name}: {spread!r}" for name, spread in self.vary.items())])

    @property
    def _owners(self) -> dict[str, Any]:
        """What may vary from trial to trial."""
        own = {name: getattr(self, name) for name in ("robot", "maneuver", "world", "encoder", "gyro")}
        return {**own, "believed": self.robot}

    @property
    def _grids(self) -> dict[str, int]:
        """How many values the grid of each number has, 0 for one that has no grid."""
        return {name: len(spread.values) if isinstance(spread, Grid) else 0 for name, spread in self.vary.items()}

    def replace(self, **changes: Any) -> Study:
        """Return the study with some fields changed."""
        return type(self)(**{**given(self), **changes})

    @classmethod
    def of_tolerances(cls, robot: Robot, maneuver: Maneuver, **options: Any) -> Study:
        """Describe robots that differ from their design by its tolerances, while odometry believes the design.

        Mean radius, radius ratio and track width are normal, with the robot's own tolerances (`Robot.tolerances`) as
        standard deviations; one of zero does not vary.

        Args:
            robot: as designed.
            maneuver: what is driven.
            options: other fields of a study.

        Returns:
            The study.

        Raises:
            InvalidType: not a robot.
            InvalidValue, InvalidType, UnknownName: as for a new study; or a robot all of whose tolerances are zero.

        Example:
            >>> study = dd.sweeps.Study.of_tolerances(dd.Robot.load("ct_bot"), dd.sweeps.Maneuver("square"))
            >>> list(study.vary)
            ['robot.mean_radius', 'robot.radius_ratio', 'robot.track_width']
        """
        tolerances = checks.instance("robot", robot, Robot).tolerances
        designed = {
            "mean_radius": (robot.mean_radius, tolerances.radius),
            "radius_ratio": (robot.radius_ratio, tolerances.radius_ratio),
            "track_width": (robot.track_width, tolerances.track_width),
        }
        vary = {f"robot.{k}": Normal(mean=mean, sigma=part * mean) for k, (mean, part) in designed.items() if part}
        if not vary:
            raise InvalidValue("Robot.tolerances: all are zero, so that nothing varies")
        return cls(robot=robot, maneuver=maneuver, vary=vary, **options)

    @classmethod
    def load(cls, name_or_path: str | Path) -> Study:
        """Read the study of a preset's name, or of a path to a TOML file (docs/studies.md).

        Args:
            name_or_path: one of `presets()`, or a path that ends on .toml or has a folder. The robots and worlds that
                it names are presets, or files beside it.

        Raises:
            UnknownName: no such preset, or a key that is not a field.
            MissingFile: no file at the path.
            InvalidValue: not a TOML file, or a field that is missing or out of range.
            InvalidType: neither a name nor a path, or a field of the wrong kind.

        Example:
            >>> dd.sweeps.Study.load("squares").maneuver
            Maneuver(name='square', options={'side': 4.0, 'speed': 0.2})
        """
        return _study_file.load(cls, name_or_path)

    def save(self, path: str | Path) -> None:
        """Write the study's TOML file, whole or not at all; `Study.load` reads it back equal.

        Args:
            path: must end on .toml.

        Raises:
            InvalidType: not a path.
            InvalidValue: the file is not named .toml, or cannot be written.

        Example:
            >>> dd.sweeps.Study.load("squares").save("/no/such/folder/mine.toml")
            Traceback (most recent call last):
            diffdrive_mj.errors.InvalidValue: /no/such/folder/mine.toml: cannot be written (No such file or directory)
        """
        _described_file.save(self, path)

    def to_toml(self) -> str:
        """Return the study as TOML, whole: two studies are the same where this text is.

        Example:
            >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
            >>> study = dd.sweeps.Study(robot=robot, maneuver=dd.sweeps.Maneuver("spin"), vary={}, trials=10)
            >>> study.to_toml().splitlines()[:4]
            ['name = "study"', 'trials = 10', 'seed = 0', 'design = "random"']
        """
        return _study_file.text(self)

    def continues(self, other: Study) -> bool:
        """Tell whether the trials of another study are the first ones of this study, or all of them.

        Args:
            other: whose trials may be there already.

        Example:
            >>> study = dd.sweeps.Study.load("squares")
            >>> study.replace(trials=2 * study.trials).continues(study)
            True
        """
        if self.trials < checks.instance("other", other, Study).trials or (
            self.design == "saltelli" and self.trials != other.trials
        ):
            return False
        return other.replace(trials=self.trials) == self

    @property
    def blocks(self) -> NDArray[np.int64]:
        """Which trials belong together in a study with the design "saltelli".

        (D + 2, n) indices of trials: block A, block B, and for each number in the order of `vary` block A with that
        number out of B. Column r is row r of the design.

        Raises:
            InvalidValue: another design.

        Example:
            >>> study = dd.sweeps.Study.load("squares").replace(trials=15, design="saltelli")
            >>> study.blocks[:2].tolist()
            [[0, 1, 2], [3, 4, 5]]
        """
        if self.design != "saltelli":
            raise InvalidValue(f"Study.design = {self.design!r}: must be 'saltelli', which has blocks")
        return np.arange(self.trials).reshape(len(self.vary) + 2, -1)

    def shares(self, first: int, last: int) -> Array:
        """Return where in the unit cube the trials from `first` to before `last` lie (N, D), in the order of `vary`."""
        return designs.placed(self.design, self.seed, self._grids, first, last, self.trials)

    def drawn(self, first: int, last: int) -> dict[str, NDArray[Any]]:
        """Return the values (N,) of what varies, by its name, in the trials from `first` to before `last`."""
        shares = self.shares(first, last)
        return {name: spread.at(shares[:, k]) for k, (name, spread) in enumerate(self.vary.items())}

    def trials_between(self, first: int, last: int) -> tuple[list[Trial], dict[int, DiffdriveError]]:
        """Return the trials from `first` to before `last`, and by index why the others of them cannot be."""
        drawn = self.drawn(first, last)
        return made_trials(self._owners, range(first, last), drawn)

    def trial(self, index: int) -> Trial:
        """Return a trial.

        Raises:
            InvalidValue, InvalidType: something that cannot be, as a robot with its weight behind its caster.
        """
        trials, refused = self.trials_between(index, checks.whole("index", index, least=0) + 1)
        for error in refused.values():
            raise error
        return trials[0]


def presets() -> tuple[str, ...]:
    """Return the names that `Study.load` knows.

    Example:
        >>> "squares" in presets()
        True
    """
    return _described_file.presets(Study)
