"""The mean and the covariance of the pose along a drive: exact, or to first order.

The exact ones are not linearised: with the position as a complex number the moments of the pose follow from those
before a step and the step's own (`_recursion`), whatever the noise. What is the same along the whole drive, such as a
calibrated radius that is off, is a mixture of drives, each with its own moments.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj import _checks as checks
from diffdrive_mj import _covariances
from diffdrive_mj._checks import Array
from diffdrive_mj._progress import progress
from diffdrive_mj._text import html_table, shown, span
from diffdrive_mj.drive import Drive
from diffdrive_mj.errors import InvalidType
from diffdrive_mj.estimation._first_order import linearised
from diffdrive_mj.estimation._placed import Spread, behind, behind_to_first_order
from diffdrive_mj.estimation._recursion import along
from diffdrive_mj.estimation.noise import Noise, Readings, Steps
from diffdrive_mj.estimation.unknowns import Parameters, Unknowns, parameter_covariance
from diffdrive_mj.odometry import accumulate
from diffdrive_mj.recording import Recording
from diffdrive_mj.robot import Robot
from diffdrive_mj.se2 import rotate

CovarianceMethod = Literal["exact", "first_order", "exponential"]
METHODS: tuple[CovarianceMethod, ...] = get_args(CovarianceMethod)
Frame = Literal["world", "mean"]


@dataclass(frozen=True, eq=False)
class PoseMoments:
    """Hold how a pose is distributed, at every sample.

    Attributes:
        mean: (..., T, 3) [m, m, rad].
        covariance: (..., T, 3, 3), of the error: that of x, y and theta.
        frame: "world", where the error is the pose minus the mean; "mean", where it is `se2.log(between(mean, pose))`,
            the arc that leads there, forward, to the left and counter-clockwise.

    Example:
        >>> print(PoseMoments(np.array([[5.0, 0.0, 0.0]]), np.diag([1e-4, 4e-4, 1e-4])[None]))
        the pose after 0 steps
          x      5 m +- 10 mm
          y      0 m +- 20 mm
          theta  0 deg +- 0.573 deg
    """

    mean: Array
    covariance: Array
    frame: Frame = "world"

    @property
    def sigma(self) -> Array:
        """The standard deviations (..., T, 3) [m, m, rad]."""
        return np.sqrt(np.maximum(np.diagonal(self.covariance, axis1=-2, axis2=-1), 0.0))

    def __repr__(self) -> str:
        runs = f"{self.mean.shape[:-2]} runs of " if self.mean.ndim > 2 else ""
        return f"PoseMoments({runs}{self.mean.shape[-2]} samples, in the frame of the {self.frame})"

    def __str__(self) -> str:
        return "\n".join([self._title(), *(f"  {name:6s} {mean} +- {sigma}" for name, mean, sigma in self._rows())])

    def _repr_html_(self) -> str:
        rows = [(name, mean, f"± {sigma}") for name, mean, sigma in self._rows()]
        return html_table(rows, caption=self._title())

    def _title(self) -> str:
        steps = self.mean.shape[-2] - 1
        along_mean = "" if self.frame == "world" else ", its error forward, to the left and in heading"
        return f"the pose after {steps} step{'s' * (steps != 1)}{along_mean}"

    def _rows(self) -> Iterator[tuple[str, str, str]]:
        units = (("m", 1.0, "mm", 1e3), ("m", 1.0, "mm", 1e3), ("deg", np.degrees(1.0), "deg", np.degrees(1.0)))
        for k, (name, (unit, scale, small, fine)) in enumerate(zip(("x", "y", "theta"), units, strict=True)):
            mean, sigma = self.mean[..., -1, k] + 0.0, self.sigma[..., -1, k]
            yield name, span(mean, unit, scale), span(sigma, small, fine, digits=3)


def covariance(
    wheel_angles: ArrayLike | Drive | Recording,
    robot: Robot,
    *,
    noise: Noise | Sequence[Noise] = (),
    parameters: Parameters | None = None,
    method: CovarianceMethod = "exact",
    start: ArrayLike = (0.0, 0.0, 0.0),
    start_covariance: ArrayLike | None = None,
    times: ArrayLike | None = None,
) -> PoseMoments:
    """Compute the mean and the covariance of the true pose, given the wheel angles that were read.

    The true way of a wheel in a step is the one read plus its noise, and odometry on arcs makes poses of the true ways.
    "exact" gives the moments of these poses to rounding; only what is the same along the whole drive takes a quadrature
    (`unknowns`). "first_order" is the covariance of a filter that is linearised about the read poses, "exponential" the
    same of the error on the group, `se2.log(between(mean, pose))`, which follows the bend of the cloud.

    Args:
        wheel_angles: (..., T, 2) [rad], left then right; or a drive or a recording that has them.
        robot: the believed robot.
        noise: `WheelNoise`, `GyroNoise`, `CounterPhases` or a model of your own, or several, applied in their order.
        parameters: how well the robot's numbers are known, the same along the whole drive: a calibration; standard
            deviations by name, such as `{"track_width": 0.001}`; or the covariance (3, 3) of the left radius, the right
            radius and the track width. None for exactly.
        method: "exact", "first_order" or "exponential".
        start: (..., 3) [m, m, rad], the pose at the first sample.
        start_covariance: (..., 3, 3) of the start, which is Gaussian; None for a start that is known.
        times: of an array's samples (T,) [s], for noise that grows with time.

    Returns:
        Mean and covariance at every sample.

    Raises:
        InvalidType: not numbers, a robot and noise.
        UnknownName: the method, a parameter.
        InvalidValue: shapes that do not fit, values that are not finite, covariances that are not symmetric or have
            negative eigenvalues.

    References:
        Chong and Kleeman (1997), for the first order and the noise of the wheels.

    Example:
        On a straight line the mean falls short of the way, to (b^2 / k^2) (1 - exp(-k^2 L / b^2)):

        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> angles = np.linspace(0.0, 500.0, 1001)[:, None] * (1.0, 1.0)  # 50 m
        >>> found = dd.covariance(angles, robot, noise=dd.WheelNoise(left=0.002, right=0.002))
        >>> round(50 - found.mean[-1, 0].item(), 4), round(50 - 4e4 * (1 - np.exp(-50 / 4e4)).item(), 4)
        (0.0312, 0.0312)
        >>> print(found)
        the pose after 1000 steps
          x      49.97 m +- 37.4 mm
          y      0 m +- 1.44e+03 mm
          theta  0 deg +- 2.86 deg
    """
    readings = Readings.of(wheel_angles, times)
    checks.instance("robot", robot, Robot)
    models = _models(noise)
    checks.member("covariance method", method, METHODS)
    uncertain = parameter_covariance(parameters, robot)
    pose = checks.array("start", start, 3)
    scatter = (
        np.zeros((3, 3))
        if start_covariance is None
        else _covariances.covariance("start_covariance", start_covariance, 3)
    )
    shape = checks.broadcast(
        wheel_angles=readings.wheel_angles[..., 0, 0], start=pose[..., 0], start_covariance=scatter[..., 0, 0]
    )
    begin = Spread.of(np.broadcast_to(pose, (*shape, 3)), np.broadcast_to(scatter, (*shape, 3, 3)))
    mixed = _Mixture()
    with progress("covariance", 100, "%") as advance:
        for odds, read in _readings(readings, models):
            unknowns = Unknowns.of(read, robot, models, uncertain)
            if method == "exact":
                for weight, steps in unknowns.nodes():
                    mixed.add(odds * weight, _exact(steps, begin, shape))
                    advance(100 * odds * weight)
            else:
                mixed.add(odds, _to_first_order(unknowns, begin, shape))
                advance(100 * odds)
    found = mixed.moments()
    return _seen_from_the_mean(found) if method == "exponential" else found


def _models(noise: Noise | Sequence[Noise]) -> list[Noise]:
    """The models of noise, one or several."""
    if isinstance(noise, Noise):
        return [noise]
    if noise is None or isinstance(noise, (str, type)) or not np.iterable(noise):
        raise InvalidType(
            f"noise = {shown(noise)}: must be a model of noise, such as WheelNoise(left=0.002, right=0.002), or a list "
            "of such; () for none"
        )
    return checks.instances("noise", noise, Noise)


def _readings(readings: Readings, models: Sequence[Noise]) -> Iterator[tuple[float, Readings]]:
    """What may have been read, by all models."""
    if not models:
        yield 1.0, readings
        return
    for odds, read in models[0].readings(readings):
        for more, each in _readings(read, models[1:]):
            yield odds * more, each


def _exact(steps: Steps, start: Spread, shape: tuple[int, ...]) -> PoseMoments:
    """The moments at every sample, of drives whose steps are independent."""
    count = steps.distance.shape[-1]
    rows = np.stack([
        np.broadcast_to(part, (*shape, count)).reshape(-1, count)
        for part in (steps.distance, steps.turn, steps.var_distance, steps.covariance, steps.var_turn)
    ])  # fmt: skip
    runs = rows.shape[1]
    begin = Spread(*(np.reshape(part, (runs, 1)) for part in start))
    mean, covariances = np.empty((runs, count + 1, 3)), np.empty((runs, count + 1, 3, 3))
    begin.write(mean[:, :1], covariances[:, :1])
    if not rows[2:].any():
        poses = accumulate(np.moveaxis(rows[:2], 0, -1))
        behind(begin, Spread.of(poses, np.zeros((3, 3)))).write(mean, covariances)
    else:
        for some, part, seen in along(rows):
            after = slice(part.start + 1, part.stop + 1)
            placed = behind(Spread(*(value[some] for value in begin)), seen.seen)
            placed.write(mean[some, after], covariances[some, after])
    return PoseMoments(mean.reshape(*shape, count + 1, 3), covariances.reshape(*shape, count + 1, 3, 3))


def _to_first_order(unknowns: Unknowns, start: Spread, shape: tuple[int, ...]) -> PoseMoments:
    """The moments at every sample, to first order in everything that is not known."""
    steps = unknowns.steps(np.zeros(unknowns.count))
    seen = linearised(steps, unknowns.slopes() if unknowns.count else None)
    placed = behind_to_first_order(Spread(*(part[..., None] for part in start)), seen)
    samples = steps.distance.shape[-1] + 1
    mean, covariances = np.empty((*shape, samples, 3)), np.empty((*shape, samples, 3, 3))
    placed.write(mean, covariances)
    return PoseMoments(mean, covariances)


def _seen_from_the_mean(found: PoseMoments) -> PoseMoments:
    """The covariance in the frame of the mean: to first order log(between(mean, pose)) is the error turned into it."""
    turn = found.mean[..., 2]
    turned = found.covariance.copy()
    turned[..., :2] = rotate(turned[..., :2], -turn[..., None])
    turned = np.swapaxes(turned, -1, -2)
    turned[..., :2] = rotate(turned[..., :2], -turn[..., None])
    return replace(found, covariance=turned, frame="mean")


class _Mixture:
    """The moments of a mixture, from those of its parts and their odds."""

    def __init__(self) -> None:
        self._first: PoseMoments | None = None
        self._weight = 0.0
        # Means of the others' means, seen from the first so that squares are small; of these squares; of covariances.
        self._sums: tuple[Array, Array, Array] | None = None

    def add(self, weight: float, part: PoseMoments) -> None:
        """Add a part."""
        if self._first is None:
            self._first, self._weight = part, weight
            return
        if self._sums is None:
            none = np.zeros_like(part.covariance)
            self._sums = np.zeros_like(part.mean), none, self._weight * self._first.covariance
        off = part.mean - self._first.mean
        means, squares, within = self._sums
        means += weight * off
        squares += weight * (off[..., :, None] * off[..., None, :])
        within += weight * part.covariance

    def moments(self) -> PoseMoments:
        """The moments of all."""
        assert self._first is not None
        if self._sums is None:
            return self._first
        means, squares, within = self._sums
        between = squares - means[..., :, None] * means[..., None, :]
        return PoseMoments(self._first.mean + means, within + between)
