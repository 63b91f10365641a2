"""Odometry with a gyro: the distance from the wheels, the turn from the gyro, from both, or filtered.

Each function takes a drive that has a gyro, simulated or from a log, and gives poses at the times of its true poses, as
`Drive.odometry` does. Where the gyro has not seen a step, or was at its range, the wheels' turn is taken, and a warning
says so.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from diffdrive_mj import _checks as checks
from diffdrive_mj import metrics, se2
from diffdrive_mj._checks import Array
from diffdrive_mj._text import html_table, quantity
from diffdrive_mj.drive import Drive
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.estimation import heading
from diffdrive_mj.estimation.heading import Flags
from diffdrive_mj.gyro_log import GyroLog
from diffdrive_mj.kinematics import body_twist
from diffdrive_mj.odometry import accumulate
from diffdrive_mj.robot import Robot
from diffdrive_mj.sensors._sampling import poses_between
from diffdrive_mj.sensors.gyro import Gyro


@dataclass(frozen=True, eq=False)
class GyroEstimate:
    """What odometry with a gyro makes of a drive.

    Attributes:
        t: the times of the true poses (M,) [s].
        poses: (M, 3) [m, m, rad], started at the first true pose.
        drift: how far off they are.
        by_gyro: (T - 1,), on which steps of the encoder the turn is the gyro's.
        sigma: (M,) [rad], the heading's stated standard deviation since the encoder's first reading; None where the
            method states none.
        bias: (M,) [rad/s], the gyro's, as taken or as estimated.
        warnings: what to know before relying on it.

    Example:
        >>> robot = dd.Robot.load("matched")
        >>> recording = dd.simulate(robot, dd.maneuvers.spin(robot, turns=0.5), sample_rate=100.0)
        >>> drive = dd.sensors.measure(recording, gyro=dd.Gyro())
        >>> print(dd.gyrodometry.by_gyro(drive, robot, bias=0.0))
        odometry with a gyro: turn by the gyro on 100 % of the steps
        final heading error 0.000 deg, final position error 0.00 mm
    """

    t: Array
    poses: Array
    drift: metrics.Drift
    by_gyro: Flags
    bias: Array
    sigma: Array | None = None
    warnings: tuple[str, ...] = field(default=())

    def __repr__(self) -> str:
        return f"GyroEstimate({len(self.t)} poses, turn by the gyro on {100 * self.by_gyro.mean():.0f} % of the steps)"

    def __str__(self) -> str:
        stated = "" if self.sigma is None else f", stated {np.degrees(self.sigma[-1]):.3f} deg"
        lines = [
            f"odometry with a gyro: turn by the gyro on {100 * self.by_gyro.mean():.0f} % of the steps",
            f"final heading error {np.degrees(abs(float(self.drift.final_heading))):.3f} deg{stated}, "
            f"final position error {1e3 * float(self.drift.final_position):.2f} mm",
            *(f"warning: {warning}" for warning in self.warnings),
        ]
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        rows = [
            ("turn by the gyro", f"{100 * self.by_gyro.mean():.0f} % of the steps"),
            ("final heading error", f"{np.degrees(abs(float(self.drift.final_heading))):.3f} deg"),
            *([] if self.sigma is None else [("stated", f"{np.degrees(self.sigma[-1]):.3f} deg")]),
            ("final position error", quantity(float(self.drift.final_position), "m")),
            *(("warning", warning) for warning in self.warnings),
        ]
        return html_table(rows, caption="odometry with a gyro")


def by_gyro(drive: Drive, robot: Robot, gyro: Gyro | None = None, *, bias: float | None = None) -> GyroEstimate:
    """Take every turn from the gyro.

    ```
    dtheta = (w - b) dt / gain
    ```

    Args:
        drive: with a gyro.
        robot: the believed robot.
        gyro: the believed gyro, whose scale error and tilt are taken out; None for one without.
        bias: of the gyro [rad/s]; None for what it reads while the robot stands at first.

    Returns:
        The poses and how far off they are.

    Raises:
        InvalidType: not a drive, not a robot, not a gyro.
        InvalidValue: a drive without a gyro, or one that does not stand at first where no bias is given.

    Example:
        >>> robot = dd.Robot.load("matched")
        >>> recording = dd.simulate(robot, dd.maneuvers.spin(robot, turns=0.5), sample_rate=100.0)
        >>> drive = dd.sensors.measure(recording, gyro=dd.Gyro(scale_error=0.01))
        >>> round(float(np.degrees(dd.gyrodometry.by_gyro(drive, robot, bias=0.0).drift.final_heading)), 3)
        1.8
    """
    seen = _Seen.of(drive, robot)
    turns, taken = seen.without_bias(gyro, bias)
    return seen.estimate(turns, seen.whole, taken)


def switched(
    drive: Drive, robot: Robot, gyro: Gyro | None = None, *, threshold: float, bias: float | None = None
) -> GyroEstimate:
    """Take each turn from the wheels, or from the gyro where their rates differ by more than a threshold.

    Args:
        drive: with a gyro.
        robot: the believed robot.
        gyro: the believed gyro, as for `by_gyro`.
        threshold: [rad/s], as for `heading.switched`.
        bias: of the gyro [rad/s]; None for what it reads while the robot stands at first.

    Returns:
        The poses and how far off they are.

    Raises:
        InvalidType: not a drive, not a robot, not a number.
        InvalidValue: a drive without a gyro, one that does not stand at first where no bias is given, a threshold that
            is negative.

    References:
        Borenstein and Feng (1996), gyrodometry.

    Example:
        >>> robot = dd.Robot.load("matched")
        >>> recording = dd.simulate(robot, dd.maneuvers.spin(robot, turns=0.5), sample_rate=100.0)
        >>> drive = dd.sensors.measure(recording, gyro=dd.Gyro(scale_error=0.01))
        >>> dd.gyrodometry.switched(drive, robot, threshold=0.05, bias=0.0).by_gyro.any().item()
        False
    """
    seen = _Seen.of(drive, robot)
    by_gyro, taken = seen.without_bias(gyro, bias)
    turns, believed = heading.switched(seen.rolled, by_gyro, seen.dt, threshold)
    return seen.estimate(turns, believed, taken)


def filtered(
    drive: Drive, robot: Robot, gyro: Gyro, *, bias_sigma: float = 1.0, scale_sigma: float = 0.0
) -> GyroEstimate:
    """Take every turn from the gyro, whose bias is filtered out of what it reads while the robot stands.

    Args:
        drive: with a gyro.
        robot: the believed robot.
        gyro: the believed gyro, as for `heading.filtered`.
        bias_sigma: how well its bias is known before the start [rad/s].
        scale_sigma: how well its scale error is known.

    Returns:
        The poses, how far off they are, and the heading's stated standard deviation.

    Raises:
        InvalidType: not a drive, not a robot, not a gyro.
        InvalidValue: a drive without a gyro.

    Example:
        >>> robot, gyro = dd.Robot.load("matched"), dd.Gyro.load("adis16495", scale_error=0.0)
        >>> recording = dd.simulate(robot, dd.maneuvers.square(robot, side=0.5, rest=1.0), sample_rate=100.0)
        >>> drive = dd.sensors.measure(recording, gyro=gyro, seed=0)
        >>> estimate = dd.gyrodometry.filtered(drive, robot, gyro)
        >>> bool(abs(estimate.drift.heading_error[-1]) < 3 * estimate.sigma[-1])
        True
    """
    seen = _Seen.of(drive, robot)
    still = _standing(drive)
    found = heading.filtered(
        seen.turns, seen.dt, still, gyro, wheels=seen.rolled, seen=seen.whole, bias_sigma=bias_sigma,
        scale_sigma=scale_sigma,
    )  # fmt: skip
    estimate = seen.estimate(np.diff(found.heading), seen.whole, 0.0)
    sigma, bias = (np.interp(drive.clock, drive.t, values) for values in (found.sigma, found.bias))
    if not found.standing.any():
        why = "the gyro did not see the robot stand" if still.any() else "the robot never stands"
        if (still & seen.whole).any():
            why = "where the wheels stand the gyro reads more than `bias_sigma` allows"
        said = (*estimate.warnings, f"{drive.name}: {why}: the gyro's bias is not known")
        estimate = replace(estimate, warnings=said)
    return replace(estimate, sigma=sigma, bias=bias)


def scale_error(drive: Drive, *, bias: float | None = None) -> float:
    """Find by which part a gyro reads too much, from a drive whose first and last heading are known.

    ```
    s = (sum of (w - b) dt) / (theta_end - theta_start) - 1
    ```

    Its tilt is part of it. Turns on the spot along a wall, the same number each time, are such a drive.

    Args:
        drive: with a gyro that saw all of it. True headings more than a quarter turn apart must be continuous.
        bias: of the gyro [rad/s]; None for what it reads while the robot stands at first.

    Returns:
        The scale error, 0 for a gyro that reads right.

    Raises:
        InvalidType: not a drive.
        InvalidValue: a drive without a gyro, one that turns by less than half a turn in all, one that the gyro did not
            see, or one that does not stand at first where no bias is given.

    Example:
        >>> robot = dd.Robot.load("matched")
        >>> recording = dd.simulate(robot, dd.maneuvers.spin(robot, turns=2.0), sample_rate=100.0)
        >>> drive = dd.sensors.measure(recording, gyro=dd.Gyro(scale_error=0.02, bias=0.1))
        >>> round(dd.gyrodometry.scale_error(drive, bias=0.1), 6)
        0.02
    """
    read, seen = _gyro_of(drive).turns(drive.clock)
    if not seen.all():
        raise InvalidValue(f"{drive.name}: the gyro did not see {np.count_nonzero(~seen)} of {len(seen)} steps")
    taken = _bias_at_rest(drive) if bias is None else checks.number("bias", bias)
    read = read - taken * np.diff(drive.clock)
    steps = np.diff(drive.truth[:, 2])
    # Headings of a log may be wrapped: between two that are close the gyro knows.
    steps = np.where(np.abs(read) < np.pi / 2, read + se2.wrap_angle(steps - read), steps)
    if abs(turned := float(steps.sum())) < np.pi:
        raise InvalidValue(
            f"{drive.name}: turns by {turned:.3g} rad in all: must be half a turn or more to show the scale"
        )
    return float(read.sum()) / turned - 1


@dataclass(frozen=True, eq=False)
class _Seen:
    """What wheels and gyro saw of a drive on the encoder's steps: distances, turns by both, and what the gyro saw."""

    drive: Drive
    dt: Array
    distance: Array
    rolled: Array
    turns: Array
    whole: Flags

    @classmethod
    def of(cls, drive: Drive, robot: Robot) -> _Seen:
        log = _gyro_of(drive)
        distance, rolled = body_twist(np.diff(drive.wheel_angles, axis=0), robot).T
        return cls(drive, np.diff(drive.t), distance, rolled, *log.turns(drive.t))

    def without_bias(self, gyro: Gyro | None, bias: float | None) -> tuple[Array, float]:
        """The gyro's turns (T - 1,) [rad], the wheels' where it saw none, and the bias that was taken out [rad/s]."""
        taken = _bias_at_rest(self.drive) if bias is None else checks.number("bias", bias)
        gain = 1.0 if gyro is None else checks.instance("gyro", gyro, Gyro).gain
        return np.where(self.whole, (self.turns - taken * self.dt) / gain, self.rolled), taken

    def estimate(self, turns: Array, believed: Flags, bias: float) -> GyroEstimate:
        """The poses of turns (T - 1,) and the wheels' distances, at the true poses and from the first of them."""
        drive = self.drive
        path = poses_between(drive.t, accumulate(np.stack([self.distance, turns], axis=-1)), drive.clock)
        poses = se2.compose(drive.truth[0], se2.between(path[0], path))
        said = list(drive.warnings)
        if missing := int(np.count_nonzero(~self.whole)):
            said.append(
                f"{drive.name}: the gyro did not see {missing} of {len(turns)} steps; the wheels' turns are taken"
            )
        drift = replace(metrics.drift(drive.truth, poses), warnings=tuple(said))
        return GyroEstimate(drive.clock, poses, drift, believed, np.full(len(poses), bias), warnings=tuple(said))


def _gyro_of(drive: Drive) -> GyroLog:
    if checks.instance("drive", drive, Drive).gyro is None:
        raise InvalidValue(
            f"{drive.name}: has no gyro; sensors.measure(recording, gyro=...) adds one, as Drive(gyro=...)"
        )
    assert drive.gyro is not None
    return drive.gyro


def _standing(drive: Drive) -> Flags:
    """On which steps the robot stands (T - 1,), and no reading of the gyro that has seen it move counts."""
    longest = _gyro_of(drive).longest
    return heading.standing(drive.t, drive.wheel_angles, settle=max(0.5, longest), lead=max(0.1, longest))


def _bias_at_rest(drive: Drive) -> float:
    """What the gyro reads while the robot stands at first [rad/s]."""
    turns, seen = _gyro_of(drive).turns(drive.t)
    still = np.logical_and.accumulate(_standing(drive))
    at_first = still & seen
    if not at_first.any():
        why = "the gyro did not see the robot stand at first" if still.any() else "the robot does not stand at first"
        raise InvalidValue(f"{drive.name}: bias = None: must be given, for {why}")
    return float(turns[at_first].sum() / np.diff(drive.t)[at_first].sum())
