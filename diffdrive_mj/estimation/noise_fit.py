"""The noise of the wheels, estimated from drives with true poses.

Each drive is cut into stretches of about a metre. Where a stretch ends, seen from where it began, is known from the
true poses, and is expected by odometry with a mean and a covariance that follow from the noise. The noise that is found
explains the scatter of the errors; what an error of the radii or of the track would explain of them is taken out first,
so that a robot that is calibrated badly does not pass for a noisy one.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj._text import html_table
from diffdrive_mj.drive import Drive, checked_drives
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.estimation._scoring import is_none, scored, start
from diffdrive_mj.estimation._stretches import Stretches, cut
from diffdrive_mj.estimation.wheel_noise import WheelNoise
from diffdrive_mj.robot import Robot

# Stretches that are needed, and what is worth a warning: a relative deviation, a correlation, the chance of an error.
_LEAST, _VAGUE, _ALIKE, _CHANCE = 5, 0.25, 0.8, 1e-3
# So many rounds at most, and below what part of their deviations the variances have settled.
_ROUNDS, _SETTLED = 20, 1e-3
_NAMES = ("left radius", "right radius", "track width")


@dataclass(frozen=True, eq=False)
class NoiseFit:
    """Holds the noise of the wheels that drives show, and prints as a short report.

    Attributes:
        noise: what was found.
        covariance: of k of the left and of the right wheel (2, 2) [m]; where k is 0, what it may be.
        systematic: by what part radii and track are off beside the noise (3,), left radius, right radius, track width;
            0 where the drives do not show it.
        systematic_std: standard deviations of these (3,).
        drives: how many there were.
        stretches: into how many they were cut.
        warnings: what to know before relying on it.

    Example:
        >>> from diffdrive_mj.estimation.noise_fit import NoiseFit
        >>> noise = dd.WheelNoise(left=0.002, right=0.001)
        >>> found = NoiseFit(noise, 1e-8 * np.eye(2), np.zeros(3), np.full(3, 1e-3), drives=10, stretches=200)
        >>> print(found)
        noise of the wheels, from 10 drives in 200 stretches
          left   0.002 +- 0.0001 m / sqrt(m)
          right  0.001 +- 0.0001 m / sqrt(m)
    """

    noise: WheelNoise
    covariance: Array
    systematic: Array
    systematic_std: Array
    drives: int
    stretches: int
    warnings: tuple[str, ...] = ()

    @property
    def std(self) -> Array:
        """The standard deviations of k of the left and of the right wheel (2,)."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def correlation(self) -> float:
        """The correlation of both: near -1 where the drives show their sum alone."""
        return float(self.covariance[0, 1] / np.prod(self.std))

    def __str__(self) -> str:
        return "\n".join(
            [
                self._title(),
                *(f"  {name:5s}  {k:.4g} +- {std:.2g} m / sqrt(m)" for name, k, std in self._rows()),
                *(f"  warning: {warning}" for warning in self.warnings),
            ]
        )

    def _repr_html_(self) -> str:
        rows = [(name, f"{k:.4g} ± {std:.2g} m / √m") for name, k, std in self._rows()]
        return html_table([*rows, *(("warning", warning) for warning in self.warnings)], caption=self._title())

    def _title(self) -> str:
        return f"noise of the wheels, from {self.drives} drives in {self.stretches} stretches"

    def _rows(self) -> list[tuple[str, float, float]]:
        left, right = self.std.tolist()
        return [("left", self.noise.left, left), ("right", self.noise.right, right)]


def fit_noise(
    drives: Iterable[Drive],
    robot: Robot,
    *,
    stretch: float = 1.0,
    position_noise: float = 0.0,
    heading_noise: float = 0.0,
) -> NoiseFit:
    """Estimate the noise of the wheels from drives with true poses, of one maneuver or several.

    ```
    variance of a wheel's way s = k^2 |s|
    ```

    An error of the radii or of the track is taken out, and reported where it is more than chance. What else is
    systematic, such as a bump that every drive crosses, or ticks that are long against k, counts as noise.

    Args:
        drives: repeated ones, with true poses along the way or at the ends alone.
        robot: with which odometry is computed.
        stretch: way of the wheels in a stretch, about [m]: long against the ticks of the encoder, and so short that the
            heading is known within a few degrees at its end.
        position_noise: standard deviation of each coordinate of the true poses [m].
        heading_noise: that of their headings [rad].

    Returns:
        The noise with its covariance; k is never negative.

    Raises:
        InvalidType: not drives, not a robot, not numbers.
        InvalidValue: numbers out of range; wheels that never turn; stretches with too few samples; too few of them.

    References:
        Patterson and Thompson 1971; Chong and Kleeman 1997.

    Example:
        Twenty drives on an arc, whose true ways are those that were read and some noise:

        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> rng, t = np.random.default_rng(0), np.linspace(0.0, 20.0, 201)
        >>> read = np.stack([5 * t, 6 * t], axis=-1)
        >>> sigma = 0.002 * np.sqrt(np.diff(read, axis=0) * 0.1) / 0.1
        >>> wander = [np.cumsum(sigma * rng.normal(size=sigma.shape), axis=0) for _ in range(20)]
        >>> paths = [dd.odometry.integrate(read + np.vstack([(0, 0), one]), robot) for one in wander]
        >>> found = dd.fit_noise([dd.Drive(t, read, path) for path in paths], robot)
        >>> bool(np.all(np.abs(np.array([found.noise.left, found.noise.right]) - 0.002) < 3 * found.std))
        True
    """
    given = checked_drives(drives)
    checks.instance("robot", robot, Robot)
    length = checks.positive("stretch", stretch)
    tracked = checks.not_negative("position_noise", position_noise), checks.not_negative("heading_noise", heading_noise)
    pieces = [piece for k, drive in enumerate(given) for piece in cut(f"drives[{k}]", drive, robot, length, tracked)]
    count = sum(len(piece) for piece in pieces)
    if count < _LEAST:
        raise InvalidValue(
            f"drives: {count} stretches of {length:g} m: must be at least {_LEAST}; give more drives, or true poses "
            "along them and a shorter stretch"
        )
    variances = start(pieces)
    for _ in range(_ROUNDS):
        before = variances
        variances, spread, off = scored(pieces, variances)
        if np.all(np.abs(variances - before) < _SETTLED * np.sqrt(np.diag(spread))):
            return _result(pieces, len(given), variances, spread, off)
        for piece in pieces:
            piece.expect(variances)
    raise InvalidValue(f"drives: the noise is not found in {_ROUNDS} rounds; give more drives, or a shorter stretch")


def _result(
    pieces: list[Stretches], drives: int, variances: Array, spread: Array, systematic: tuple[Array, Array]
) -> NoiseFit:
    deviations = np.sqrt(np.diag(spread))
    none = is_none(variances, deviations)
    k = np.where(none, 0.0, np.sqrt(variances))
    # A k of zero may be what its variance may be.
    slope = np.where(none, 1 / np.sqrt(deviations), 0.5 / np.sqrt(variances))
    covariance = spread * np.outer(slope, slope)
    off, normal = systematic
    shown = np.diag(normal) > 1e-12 * np.diag(normal).max()
    off_std = np.where(shown, np.sqrt(np.diag(np.linalg.pinv(normal, rcond=1e-12, hermitian=True))), np.inf)
    found = NoiseFit(
        WheelNoise(left=float(k[0]), right=float(k[1])),
        covariance,
        off,
        off_std,
        drives,
        sum(len(piece) for piece in pieces),
    )
    warnings = [*_vague(found), *_off(off, normal), *_far(pieces, variances, off)]
    return NoiseFit(found.noise, covariance, off, off_std, drives, found.stretches, tuple(warnings))


def _vague(found: NoiseFit) -> list[str]:
    """What the drives do not show well."""
    said = []
    if found.correlation < -_ALIKE:
        said.append(
            f"the noise of the left and of the right wheel are not separated (correlation {found.correlation:.2f}), "
            "only their sum; drive arcs both ways, or track the position better"
        )
    for name, k, std in found._rows():
        if k == 0:
            said.append(f"no noise is seen of the {name} wheel: k may be {std:.2g} m / sqrt(m)")
        elif std > _VAGUE * k and found.correlation >= -_ALIKE:
            more = np.ceil((std / (_VAGUE * k)) ** 2)
            said.append(f"k of the {name} wheel is known to {100 * std / k:.0f} %: drive {more:.0f} times as much")
    return said


def _off(off: Array, normal: Array) -> list[str]:
    """That odometry is off by more than noise."""
    from scipy.special import chdtrc

    if chdtrc(np.linalg.matrix_rank(normal, rtol=1e-12, hermitian=True), float(off @ normal @ off)) > _CHANCE:
        return []
    what = ", ".join(f"{name} {100 * part:+.2g} %" for name, part in zip(_NAMES, off.tolist(), strict=True))
    return [f"odometry is systematically off, as by {what}; that is not counted as noise: calibrate"]


def _far(pieces: list[Stretches], variances: Array, off: Array) -> list[str]:
    """That single stretches are off by more than noise."""
    from scipy.special import chdtrc

    squares = []
    for piece in pieces:
        left = (piece.errors - piece.by_parameters @ off).reshape(-1, 3)
        blocks = piece.blocks(piece.covariance(variances))
        squares += np.einsum("ni,nij,nj->n", left, np.linalg.inv(blocks), left).tolist()
    if len(squares) * chdtrc(3, max(squares)) > _CHANCE:
        return []
    return [
        f"of {len(squares)} stretches one is {max(squares) ** 0.5:.1f} deviations off: slip, a bump, or a true pose "
        "that is wrong; leave such drives out"
    ]
