"""A drive as it was measured: wheel angles, and true poses on a clock of their own."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from diffdrive_mj import _checks as checks
from diffdrive_mj import metrics, se2
from diffdrive_mj._checks import Array
from diffdrive_mj._text import one_line
from diffdrive_mj.errors import InvalidType, InvalidValue
from diffdrive_mj.gyro_log import GyroLog
from diffdrive_mj.odometry import Method, Step, integrate
from diffdrive_mj.robot import Robot

# Times that are equal up to rounding [s].
_SLACK = 1e-9


@dataclass(frozen=True, eq=False)
class Drive:
    """What was measured on one drive of a robot, simulated or real.

    Args:
        t: times of the encoder's samples (T,) [s], increasing.
        wheel_angles: (T, 2) [rad], left then right, absolute.
        truth: true poses (M, 3) [m, m, rad]; two are enough, the start's and the end's; headings may be wrapped.
        truth_t: their times (M,) [s], increasing; the encoder's by default, if there are as many.
        name: what messages call it.
        dropped: how many true poses were left out; those outside the encoder's times are, and counted here.
        warnings: what to know before relying on it, such as gaps in a log; `drift` repeats them.
        gyro: what a gyro on the robot read (S,), on the encoder's clock; None without one.

    Raises:
        InvalidType: not numbers, a name that is not a string, or a gyro that is no GyroLog.
        InvalidValue: values that are not finite, times that repeat or go back, fewer than two poses within the
            encoder's times.

    Example:
        Both wheels turn twice; a tape measure says where the robot stood before and after:

        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> turns = 2 * np.pi * np.array([0.0, 1.0, 2.0])
        >>> drive = dd.Drive(
        ...     t=[0.0, 1.0, 2.0], wheel_angles=np.stack([turns, turns], axis=-1),
        ...     truth=[(0.0, 0.0, 0.0), (1.25, 0.0, 0.0)], truth_t=[0.0, 2.0],
        ... )
        >>> drive.drift(robot).final_position.round(4).item()
        0.0066
    """

    t: Array
    wheel_angles: Array
    truth: Array
    truth_t: Array | None = None
    name: str = "drive"
    dropped: int = 0
    warnings: tuple[str, ...] = ()
    gyro: GyroLog | None = None

    def __repr__(self) -> str:
        return f"Drive({self.name}: {len(self.t)} samples, {len(self.truth)} true poses, {self.t[-1] - self.t[0]:g} s)"

    def __post_init__(self) -> None:
        object.__setattr__(self, "name", one_line(checks.string("Drive.name", self.name)))
        dropped = checks.whole("Drive.dropped", self.dropped, least=0)
        object.__setattr__(self, "warnings", checks.strings("Drive.warnings", self.warnings))
        if self.gyro is not None and checks.instance("Drive.gyro", self.gyro, GyroLog).rates.ndim != 1:
            raise InvalidValue(
                f"{self.name}: gyro has rates of shape {self.gyro.rates.shape}: must be those of one run"
            )
        t = checks.increasing(f"{self.name}: t", self.t)
        angles = _rows(f"{self.name}: wheel_angles", self.wheel_angles, 2)
        truth = _rows(f"{self.name}: truth", self.truth, 3)
        if len(angles) != len(t):
            raise InvalidValue(f"{self.name}: wheel_angles has {len(angles)} samples and t {len(t)}: must be as many")
        if self.truth_t is None and len(truth) != len(t):
            raise InvalidValue(
                f"{self.name}: truth has {len(truth)} poses and t {len(t)} samples: truth_t must say when they were"
            )
        clock = t if self.truth_t is None else checks.increasing(f"{self.name}: truth_t", self.truth_t)
        if len(clock) != len(truth):
            raise InvalidValue(f"{self.name}: truth has {len(truth)} poses and truth_t {len(clock)}: must be as many")
        kept = (clock >= t[0] - _SLACK) & (clock <= t[-1] + _SLACK)
        if np.count_nonzero(kept) < 2:
            raise InvalidValue(
                f"{self.name}: the true poses span {clock[0]:g} to {clock[-1]:g} s and the encoder {t[0]:g} to "
                f"{t[-1]:g} s: at least two poses must lie within the encoder's times"
            )
        # Copies, which whoever made the drive cannot change after they were checked.
        own = {"t": t.copy(), "wheel_angles": angles.copy(), "truth": truth[kept], "truth_t": clock[kept]}
        for name, value in own.items():
            value.flags.writeable = False
            object.__setattr__(self, name, value)
        object.__setattr__(self, "dropped", dropped + int(np.count_nonzero(~kept)))

    @property
    def clock(self) -> Array:
        """The times of the true poses (M,) [s]."""
        assert self.truth_t is not None
        return self.truth_t

    def angles_at(self, times: ArrayLike) -> Array:
        """Interpolate the wheel angles: between two samples of the encoder the wheels are taken to turn evenly.

        Args:
            times: (M,) [s], such as the `clock` of the true poses.

        Returns:
            (M, 2) [rad], left then right.

        Raises:
            InvalidValue: times before the first sample or after the last.
        """
        at = checks.array("times", times, "M")
        outside = (at < self.t[0] - _SLACK) | (at > self.t[-1] + _SLACK)
        if outside.any():
            raise InvalidValue(
                f"{self.name}: times holds {at[outside][0]:g} s: must lie within those of the encoder, {self.t[0]:g} "
                f"to {self.t[-1]:g} s"
            )
        return np.stack([np.interp(at, self.t, wheel) for wheel in self.wheel_angles.T], axis=-1)

    @cached_property
    def _angles(self) -> tuple[Array, NDArray[np.intp]]:
        """The wheel angles at the times of the encoder and of the true poses, and which of them are the latter's."""
        times = np.union1d(self.t, self.clock)
        return self.angles_at(times), np.searchsorted(times, self.clock)

    def odometry(self, robot: Robot, method: Method | Step = "arc") -> Array:
        """Compute what a robot believes, at the times of the true poses and from the first of them.

        Args:
            robot: the believed robot.
            method: "euler", "midpoint", "arc", or a function as `odometry.integrate` takes it.

        Returns:
            (M, 3) [m, m, rad].

        Raises:
            InvalidType: not a robot.
            UnknownName: the method.
        """
        angles, at = self._angles
        poses = integrate(angles, robot, method)[at]
        return se2.compose(self.truth[0], se2.between(poses[0], poses))

    def drift(self, robot: Robot, method: Method | Step = "arc") -> metrics.Drift:
        """Compute how far off a robot's odometry is at the true poses, started at the first of them.

        Args:
            robot: the believed robot.
            method: "euler", "midpoint", "arc", or a function as `odometry.integrate` takes it.

        Returns:
            The errors of `odometry` against the truth. The distance is that along arcs through the true poses: shorter
            than what was driven where these are sparse.

        Raises:
            InvalidType: not a robot.
            UnknownName: the method.
        """
        return replace(metrics.drift(self.truth, self.odometry(robot, method)), warnings=self.warnings)


def checked_drives(drives: Iterable[Drive]) -> list[Drive]:
    """Check that drives are drives.

    Args:
        drives: at least one.

    Returns:
        The drives as a list.

    Raises:
        InvalidType: something other than drives, or a single one.
        InvalidValue: no drive.

    Example:
        >>> still = dd.Drive([0.0, 1.0], np.zeros((2, 2)), np.zeros((2, 3)))
        >>> len(dd.drive.checked_drives([still, still]))
        2
    """
    if isinstance(drives, Drive):
        raise InvalidType("drives = a Drive: must be a list of drives; give one as [drive]")
    if not isinstance(drives, Iterable):
        checks.instance("drives", drives, Drive)  # which says how a recording becomes one
    found = checks.instances("drives", drives, Drive)
    if not found:
        raise InvalidValue("drives: must hold at least one")
    return found


def _rows(name: str, value: ArrayLike, width: int) -> Array:
    rows = checks.array(name, value, "T", width)
    if rows.ndim != 2:
        raise InvalidValue(f"{name} has shape {rows.shape}: must be (T, {width})")
    return rows
