"""What a format of logs is: a kind of file that holds wheels, poses, or both."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from diffdrive_mj._checks import Array
from diffdrive_mj.drive import Drive
from diffdrive_mj.pose_log import PoseLog
from diffdrive_mj.robot import Robot


@dataclass(frozen=True)
class Wheels:
    """Wheel angles (T, 2) [rad] at times (T,) [s], and what to know of them."""

    t: Array
    angles: Array
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True)
class Contents:
    """What a log holds."""

    wheels: Wheels | None = None
    poses: PoseLog | None = None

    def drive(self, name: str) -> Drive:
        """Both as a drive."""
        assert self.wheels is not None
        assert self.poses is not None
        return Drive(
            self.wheels.t,
            self.wheels.angles,
            self.poses.poses,
            self.poses.t,
            name,
            warnings=(*self.wheels.warnings, *self.poses.warnings),
        )


class Load(Protocol):
    """Reads what is asked for, once through the file; raises where it is not there."""

    def __call__(self, path: Path, options: Any, robot: Robot | None, wheels: bool, poses: bool) -> Contents: ...


class Save(Protocol):
    """Writes what there is, whole or not at all."""

    def __call__(self, path: Path, contents: Contents, options: Any) -> None: ...


@dataclass(frozen=True, kw_only=True)
class Format:
    """Describes a format.

    Attributes:
        name: how messages call such a file, with its article.
        endings: of its files; "" is a folder, or a name without an ending.
        options: the class of its options; None if it has none.
        looks: whether a file, of which the beginning is given, or a folder looks like one.
        load: reads it.
        save: writes it; None if nobody does.
    """

    name: str
    endings: tuple[str, ...]
    options: type | None
    looks: Callable[[Path, bytes], bool]
    load: Load
    save: Save | None
