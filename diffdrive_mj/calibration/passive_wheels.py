"""Where passive wheels are mounted, from drives whose motion is known: a spin of whole turns and a straight.

Over a whole drive a wheel turns by phi, while the robot moves by X ahead, Y to the left and Theta around, each summed
in its own frame all the way. For every wheel and every drive

    r phi = cos(a) X + sin(a) Y + l Theta

which is linear in the radius r and the lever arm l, and nearly so in the direction a. A spin shows lever arms, a
straight the radii of wheels that point ahead and the directions of those that point across; what the drives do not show
is held as believed. A motion's error is in the readings of all the wheels, so that theirs are correlated.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj import _checks as checks
from diffdrive_mj import se2
from diffdrive_mj._checks import Array, array
from diffdrive_mj.calibration._passive_fit import KINDS, Drives, scales_of, shown, solve
from diffdrive_mj.calibration.result import Calibration
from diffdrive_mj.errors import CalibrationRefused, InvalidValue
from diffdrive_mj.sensors.passive_wheels import PassiveWheels

# Farther from what was believed than this (radii of themselves, angles [rad]) no wheel is mounted.
_FARTHEST_RADIUS, _FARTHEST_ANGLE = 0.5, 0.5
# A lever arm this far off, in what counts as shown, is taken, and warned of.
_FAR_ARM = 10


@dataclass(frozen=True, eq=False, kw_only=True)
class KnownMotion:
    """How a robot moved on a whole drive, and how well that is known.

    Args:
        motion: (3,), ahead [m], to the left [m] and turned [rad], each summed in the robot's own frame all the way.
        covariance: (3, 3), of its error.

    Raises:
        InvalidType: not numbers.
        InvalidValue: other shapes, values that are not finite, or a matrix that is no covariance.

    Example:
        Ten turns on the spot, back against the same wall:

        >>> spin = KnownMotion.stated((0.0, 0.0, 20 * np.pi), std=(0.001, 0.001, 0.002))
        >>> print(spin)
        ahead 0 +- 0.001 m, to the left 0 +- 0.001 m, turned 62.83 +- 0.002 rad
    """

    motion: Array
    covariance: Array

    def __post_init__(self) -> None:
        covariance = array("KnownMotion.covariance", self.covariance, 3, 3)
        if covariance.ndim > 2 or not np.array_equal(covariance, covariance.T) or not _is_covariance(covariance):
            raise InvalidValue("KnownMotion.covariance: must be (3, 3), symmetric, and not negative in any direction")
        object.__setattr__(self, "motion", checks.vector("KnownMotion.motion", self.motion, 3))
        object.__setattr__(self, "covariance", covariance)

    def __str__(self) -> str:
        parts = zip(("ahead", "to the left", "turned"), self.motion, np.sqrt(np.diag(self.covariance)), strict=True)
        shown = [f"{name} {value:.4g} +- {std:.2g}" for name, value, std in parts]
        return f"{shown[0]} m, {shown[1]} m, {shown[2]} rad"

    @classmethod
    def stated(cls, motion: ArrayLike, std: ArrayLike) -> KnownMotion:
        """State a motion, as from a tape measure, from whole turns or from a gyro.

        Args:
            motion: (3,), ahead [m], to the left [m], turn [rad]; through all turns.
            std: (3,), standard deviations of its error.

        Returns:
            The motion.

        Raises:
            InvalidType: not numbers.
            InvalidValue: other shapes, negative deviations, or values that are not finite.
        """
        spread = checks.not_negative_array("std", checks.vector("std", std, 3))
        return cls(motion=checks.vector("motion", motion, 3), covariance=np.diag(spread**2))

    @classmethod
    def along(cls, poses: ArrayLike, *, position_std: float, heading_std: float) -> KnownMotion:
        """Sum up the motion along true poses of a tracker, the noise of which is independent from pose to pose.

        A pose's noise enters with the turn between its two steps: the more poses, the better is the centre of a spin.

        Args:
            poses: (T, 3) [m, m, rad], headings continuous, close enough for arcs between them.
            position_std: of each coordinate [m].
            heading_std: [rad].

        Returns:
            The motion, with the covariance that the noise gives it to first order.

        Raises:
            InvalidType: not numbers.
            InvalidValue: other shapes, less than two poses, or deviations that are negative.

        Example:
            >>> half_turn = np.linspace((0, 0, 0), (0, 0, np.pi), 200)
            >>> spin = KnownMotion.along(half_turn, position_std=0.001, heading_std=0.0)
            >>> np.sqrt(np.diag(spin.covariance)).round(5).tolist()
            [0.00143, 0.00143, 0.0]
        """
        path = array("poses", poses, "T", 3)
        if path.ndim != 2 or len(path) < 2:
            raise InvalidValue(f"poses has shape {path.shape}: must be (T, 3) with at least two poses")
        position, heading = (
            checks.not_negative("position_std", position_std), checks.not_negative("heading_std", heading_std)
        )  # fmt: skip
        steps = se2.log(se2.between(path[:-1], path[1:]))
        steps[:, 2] = np.diff(path[:, 2])
        middle = path[:-1, 2] + steps[:, 2] / 2
        # Each of the inner positions ends one step and begins another; the rotations between the two do not cancel.
        bends = 2 * (1 - np.cos(np.diff(middle)))
        covariance = np.diag([position**2 * (2 + bends.sum())] * 2 + [2 * heading**2])
        # A heading turns half of the step before it and half of the step after it.
        turned = np.zeros((len(path), 3))
        across = np.stack([steps[:, 1], -steps[:, 0]], axis=-1) / 2
        turned[:-1, :2] += across
        turned[1:, :2] += across
        turned[0, 2], turned[-1, 2] = -1.0, 1.0
        covariance[2, 2] = 0.0
        product = turned.T @ turned
        return cls(motion=steps.sum(axis=0), covariance=covariance + heading**2 * (product + product.T) / 2)


def lever_arms(
    angles: ArrayLike, motions: Sequence[KnownMotion], believed: PassiveWheels, *, angle_std: ArrayLike | None = None
) -> Calibration[PassiveWheels]:
    """Find where passive wheels are mounted, and their radii and directions as far as the drives show them.

    A spin finds lever arms about the point that stands still in it. Where that is not the axle's midpoint, `motions`
    must say so: from a tracker (`KnownMotion.along`), or from the drive wheels' odometry.

    ```
    r phi = cos(a) X + sin(a) Y + l Theta
    ```

    for each wheel and each drive, weighted least squares over all of them.

    Args:
        angles: (K, n) [rad], how far each wheel has turned on each of the drives: its last reading less its first.
        motions: of the K drives.
        believed: what the wheels are taken for.
        angle_std: (n,) or a number [rad], of the angles' error; by default that of counting in whole ticks, tick /
            sqrt(6).

    Returns:
        The wheels, moved along their axles to the lever arms that were found. `parameters` are "lever_arm[0]" [m],
        "radius[0]" [m], "angle[0]" [rad] and so on; `residuals` (K n,) are in metres of rolling.

    Raises:
        InvalidType: not numbers, not known motions, not passive wheels.
        InvalidValue: shapes that do not fit, or values that are not finite.
        CalibrationRefused: drives that show nothing, or a wheel that nobody has mounted so.

    Example:
        A spin of five turns and a straight of 2 m find a wheel 1.5 mm off its place:

        >>> true = dd.PassiveWheels(wheels=(dd.PassiveWheel(y=0.0815), dd.PassiveWheel(y=-0.08)))
        >>> spin = KnownMotion.stated((0.0, 0.0, 10 * np.pi), std=(0.001, 0.001, 0.002))
        >>> straight = KnownMotion.stated((2.0, 0.0, 0.0), std=(0.0005, 0.0, 0.001))
        >>> angles = [true.angles(spin.motion), true.angles(straight.motion)]
        >>> believed = dd.PassiveWheels(wheels=(dd.PassiveWheel(y=0.08), dd.PassiveWheel(y=-0.08)))
        >>> found = lever_arms(angles, [spin, straight], believed)
        >>> [round(wheel.y, 6) for wheel in found.calibrated.wheels]
        [0.0815, -0.08]
        >>> found.parameters
        ('lever_arm[0]', 'radius[0]', 'lever_arm[1]', 'radius[1]')
    """
    checks.instance("believed", believed, PassiveWheels)
    count = len(believed.wheels)
    known = checks.instances("motions", motions, KnownMotion)
    turned = array("angles", angles, len(known), count)
    if turned.ndim != 2:
        raise InvalidValue(f"angles has shape {turned.shape}: must be ({len(known)}, {count})")
    counting = believed.tick_angles / np.sqrt(6)
    std = counting if angle_std is None else checks.positive_array("angle_std", angle_std)
    if std.shape not in ((), (count,)):
        raise InvalidValue(f"angle_std has shape {std.shape}: must be a number or ({count},)")
    drives = Drives(
        turned,
        np.array([drive.motion for drive in known]),
        np.array([drive.covariance for drive in known]),
        np.broadcast_to(std, (count,)),
    )
    values = np.array([(wheel.lever_arm, wheel.radius, wheel.angle) for wheel in believed.wheels])
    free = shown(drives, values, scales_of(believed))
    values, covariance = solve(drives, values, free)
    _refuse_misfits(believed, values)
    names = [f"{KINDS[kind]}[{wheel}]" for wheel, kind in np.argwhere(free)]
    spare = turned.size - len(names)
    warnings = [
        f"{KINDS[kind]}[{wheel}] is held at {values[wheel, kind]:.6g}: these drives do not show it"
        for wheel, kind in np.argwhere(~free)
    ]
    far = np.abs(values[:, 0] - believed.matrix[:, 2]) > _FAR_ARM * scales_of(believed)[:, 0]
    warnings += [
        f"lever_arm[{wheel}] comes out {1e3 * values[wheel, 0]:.4g} mm, believed was {1e3 * arm:.4g} mm: does the "
        "wheel count backwards, or was a turn the other way?"
        for wheel, arm in enumerate(believed.matrix[:, 2])
        if far[wheel]
    ]
    left = np.concatenate(drives.whitened(values, drives.residuals(values)))
    if spare and (worse := float(np.sqrt((left**2).sum() / spare))) > 1 + 3 / np.sqrt(2 * spare):
        warnings.append(f"the drives disagree: what is left is {worse:.2g} times what the stated noise explains")
    return Calibration(
        method="passive wheels",
        believed=believed,
        calibrated=_mounted(believed, values),
        parameters=tuple(names),
        values=values[free],
        covariance=covariance,
        residuals=drives.residuals(values).ravel(),
        warnings=tuple(warnings),
    )


def _is_covariance(matrix: Array) -> bool:
    """Whether no variance of a symmetric matrix is negative, but for rounding, whatever the units."""
    variances = np.diag(matrix)
    std = np.sqrt(np.where(variances > 0, variances, 1.0))
    return not (variances < 0).any() and bool(np.linalg.eigvalsh(matrix / np.outer(std, std)).min() > -1e-9)


def _refuse_misfits(believed: PassiveWheels, values: Array) -> None:
    """Raise if a wheel came out as nobody mounts it."""
    angles = np.array([wheel.angle for wheel in believed.wheels])
    for wheel, (_, radius, angle) in enumerate(values):
        stretched = abs(radius / believed.radii[wheel] - 1) > _FARTHEST_RADIUS
        if stretched or abs(angle - angles[wheel]) > _FARTHEST_ANGLE:
            raise CalibrationRefused(
                f"wheel {wheel} comes out with radius {radius:.4g} m at an angle of {np.degrees(angle):.4g} degrees, "
                f"believed were {believed.radii[wheel]:.4g} m and {np.degrees(angles[wheel]):.4g}: does it count "
                "backwards, is the order of the wheels another, or a drive not as stated?",
                accept="",
            )


def _mounted(believed: PassiveWheels, values: Array) -> PassiveWheels:
    """The wheels with other values, moved along their axles."""
    pairs = zip(believed.wheels, values.tolist(), strict=True)
    wheels = (replace(wheel, angle=a, radius=radius).moved(lever) for wheel, (lever, radius, a) in pairs)
    return PassiveWheels(wheels=tuple(wheels))
