"""What a calibration of passive wheels is worth: lever arms found many times, from motions known with noise."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj.calibration.passive_wheels import KnownMotion, lever_arms
from diffdrive_mj.calibration.result import Calibration
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.recording import Recording
from diffdrive_mj.sensors.passive_wheels import PassiveWheels

# What is known of a drive's motion, with noise of its own each time.
Knowing = Callable[[Recording, np.random.Generator], KnownMotion]


@dataclass(frozen=True, eq=False)
class ArmTrials:
    """Hold the lever arms of many calibrations against the true ones.

    Attributes:
        errors: (K, n) [m], of each calibration and each wheel.
        covariance: (n, n) [m^2], of a calibration's errors as the first of them states it.
        first: the first of them.

    Example:
        >>> found = ArmTrials(np.array([[1e-5], [-3e-5]]), np.array([[4e-10]]), first=None)
        >>> found.worst, found.scores.round(3).ravel().tolist()
        (3e-05, [0.5, -1.5])
    """

    errors: Array
    covariance: Array
    first: Calibration[PassiveWheels]

    @property
    def stated(self) -> Array:
        """The stated standard deviations (n,) [m]."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def scores(self) -> Array:
        """The errors in their stated deviations, freed of the correlations between the wheels (K, n)."""
        return np.linalg.solve(np.linalg.cholesky(self.covariance), self.errors.T).T

    @property
    def worst(self) -> float:
        """The largest error [m]."""
        return float(np.abs(self.errors).max())


def tracked(position_std: float, heading_std: float) -> Knowing:
    """Know a motion from a tracker that sees every sample of the drive, with white noise.

    Args:
        position_std: of each coordinate [m].
        heading_std: [rad].

    Returns:
        What `arm_trials` takes.

    Example:
        >>> callable(tracked(0.001, 0.001))
        True
    """

    def known(recording: Recording, rng: np.random.Generator) -> KnownMotion:
        noise = (position_std, position_std, heading_std) * rng.normal(size=recording.truth.shape)
        return KnownMotion.along(recording.truth + noise, position_std=position_std, heading_std=heading_std)

    return known


def told(position_std: float, heading_std: float, scale_std: float = 0.0) -> Knowing:
    """Know a motion as a whole: from a tape measure and whole turns, or from a gyro.

    Args:
        position_std: of the distance, ahead and to the left [m].
        heading_std: of the turn [rad].
        scale_std: of a gyro's scale, a part of the turn.

    Returns:
        What `arm_trials` takes.

    Example:
        >>> callable(told(0.001, 0.001))
        True
    """

    def known(recording: Recording, rng: np.random.Generator) -> KnownMotion:
        motion = KnownMotion.along(recording.truth, position_std=0.0, heading_std=0.0).motion
        std = np.array([position_std, position_std, np.hypot(heading_std, scale_std * motion[2])])
        return KnownMotion.stated(motion + std * rng.normal(size=3), std=std)

    return known


def arm_trials(
    drives: Sequence[Recording],
    wheels: PassiveWheels,
    believed: PassiveWheels,
    know: Knowing,
    *,
    count: int,
    rng: np.random.Generator,
) -> ArmTrials:
    """Calibrate many times, with random phases of the encoders and noise of its own each time.

    Args:
        drives: simulated with the wheels, such as a spin and a straight.
        wheels: the true ones.
        believed: what they are taken for.
        know: what is known of a drive's motion, `tracked` or `told`.
        count: of calibrations.
        rng: of phases and noise.

    Returns:
        The trials.

    Raises:
        InvalidType, InvalidValue: drives without passive wheels, or that do not show every lever arm; no calibration.
        CalibrationRefused: as for `calibration.lever_arms`.

    Example:
        >>> robot, pods = dd.Robot.load("matched"), dd.PassiveWheels(wheels=(dd.PassiveWheel(y=0.1),))
        >>> drives = [dd.maneuvers.spin(robot, turns=1), dd.maneuvers.straight(robot, distance=1.0)]
        >>> seen = [dd.simulate(robot, drive, passive_wheels=pods) for drive in drives]
        >>> found = arm_trials(seen, pods, pods, told(0.001, 0.001), count=20, rng=np.random.default_rng(0))
        >>> found.worst < 1e-3
        True
    """
    checks.whole("count", count)
    angles = [_angles(f"drives[{k}]", drive) for k, drive in enumerate(checks.instances("drives", drives, Recording))]
    found = []
    for _ in range(count):
        read = [wheels.from_ticks(wheels.ticks(some, phase=rng.random(len(wheels.wheels))))[-1] for some in angles]
        found.append(lever_arms(read, [know(drive, rng) for drive in drives], believed))
    own = [k for k, name in enumerate(found[0].parameters) if name.startswith("lever_arm")]
    if len(own) < len(wheels.wheels):
        raise InvalidValue("drives: must show every lever arm; spin by more turns, or know the motion better")
    arms = np.array([one.calibrated.matrix[:, 2] for one in found])
    return ArmTrials(arms - wheels.matrix[:, 2], found[0].covariance[np.ix_(own, own)], found[0])


def _angles(name: str, drive: Recording) -> Array:
    """The wheels' angles at the beginning and the end (2, n)."""
    if drive.passive_angles is None:
        raise InvalidValue(f"{name} has no passive_angles: simulate it with passive_wheels=")
    return drive.passive_angles[[0, -1]]
