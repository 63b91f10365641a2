"""How well a drive shows a robot's radii and track: what the noise of the poses and the ticks leave, to first order.

Least squares maps errors g of the modelled poses onto errors of the parameters, linearly. The poses' noise is
independent from pose to pose. A tick is not: a reading that is off by d turns the robot for one step, so that all later
poses are displaced. With random phases of the counters the distribution of such sums is known (`sensors.counting`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj.calibration.result import Calibration
from diffdrive_mj.commands import Commands
from diffdrive_mj.drive import Drive
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.estimation.derivatives import parameters_of, trajectory
from diffdrive_mj.maneuvers import Segment, sequence
from diffdrive_mj.odometry import integrate
from diffdrive_mj.physics.tilt import level_twin
from diffdrive_mj.recording import Recording
from diffdrive_mj.robot import Robot
from diffdrive_mj.sensors.counting import summed_errors, wheel_counters
from diffdrive_mj.sensors.encoder import Encoder
from diffdrive_mj.sensors.tracker import Tracker


def mixed_drive(robot: Robot) -> Commands:
    """Drive 20 m of straight lines, turns on the spot and arcs, both ways, each from rest to rest.

    Args:
        robot: the robot the commands are computed for.

    Example:
        >>> mixed_drive(dd.Robot.load("matched")).duration
        52.0
    """
    legs = [
        (2, 0, 3), (0, math.pi / 2, 1.5), (2.5, 2.5, 4), (2.5, -2.5, 4), (0, -2 * math.pi / 3, 2), (1.5, 0, 2.5),
        (3, -4, 5), (0, math.pi, 3), (3, 4, 5), (2, 0, 3), (0, -math.pi / 2, 1.5), (3.5, 1, 5),
    ]  # fmt: skip
    return sequence(robot, [[Segment(*leg)] for leg in legs])


@dataclass(frozen=True, eq=False)
class Fits:
    """What least squares finds of N robots, beside what is expected of it. All is relative to the true values.

    Attributes:
        errors: of left radius, right radius and track width (N, 3).
        expected: their covariances as predicted (N, 3, 3).
        stated: their covariances as the calibrations state them (N, 3, 3).

    Example:
        >>> covariance = 1e-8 * np.eye(3)[None]
        >>> fits = Fits(errors=np.array([[1e-4, -1e-4, 1e-4]]), expected=covariance, stated=covariance)
        >>> fits.standard.round(6).tolist()
        [[1.0, -1.0, 1.0]]
    """

    errors: Array
    expected: Array
    stated: Array

    @classmethod
    def of(cls, found: Sequence[Calibration], robots: Sequence[Robot], expected: Sequence[Array]) -> Fits:
        """Compare calibrations with the true robots.

        Args:
            found: N calibrations of radii and track.
            robots: N true robots.
            expected: N covariances (3, 3), from `expected_covariance`.
        """
        sizes = np.array([parameters_of(level_twin(robot))[:3] for robot in robots])
        units = sizes[:, :, None] * sizes[:, None, :]
        values, stated = (np.array([getattr(one, part) for one in found]) for part in ("values", "covariance"))
        return cls(values / sizes - 1, np.array(expected) / units, stated / units)

    @property
    def standard(self) -> Array:
        """The errors as independent numbers of variance one (N, 3), if the prediction holds."""
        return np.linalg.solve(np.linalg.cholesky(self.expected), self.errors[..., None])[..., 0]

    @property
    def rms(self) -> tuple[float, float, float]:
        """Root mean square of the errors: as found, as predicted, as stated."""
        variances = (np.diagonal(part, axis1=1, axis2=2) for part in (self.expected, self.stated))
        found, expected, stated = (float(np.sqrt(np.mean(v))) for v in (self.errors**2, *variances))
        return found, expected, stated


def expected_covariance(
    recording: Recording[Robot, Any], encoder: Encoder, tracker: Tracker, *, headings: bool = True
) -> Array:
    """Predict the covariance of what least squares finds from a drive with unknown start pose.

    ```
    C = (J^T W J)^-1 + sum_wheels E (G e)(G e)^T,  G = (J^T W J)^-1 J^T W
    ```

    with the derivatives J of the poses, their weights W, and the errors e of the poses that a wheel's ticks leave.

    Args:
        recording: of one run.
        encoder: of both wheels, in a random phase; its rate divides that of the recording.
        tracker: of the true pose, with noise; its rate divides that of the encoder.
        headings: whether the headings of the tracker count.

    Returns:
        (3, 3), of left radius, right radius and track width [m^2].

    Raises:
        InvalidValue: rates that do not divide each other, or a tracker without noise.

    Example:
        >>> robot = dd.Robot.load("matched")
        >>> recording = dd.simulate(robot, dd.maneuvers.square(robot, side=1.0), sample_rate=50.0)
        >>> tracker = dd.Tracker(sample_rate=25.0, position_noise=1e-3, heading_noise=1e-3)
        >>> encoder = dd.Encoder(ticks_per_revolution=4096, sample_rate=50.0)
        >>> covariance = expected_covariance(recording, encoder, tracker)
        >>> print(f"track width within {1e6 * covariance[2, 2] ** 0.5:.0f} um")
        track width within 37 um
    """
    if not (tracker.position_noise > 0 and tracker.heading_noise > 0 and tracker.sample_rate):
        raise InvalidValue("tracker: must have a sample_rate, a position_noise and a heading_noise above zero")
    robot, seen = level_twin(recording.robot), recording.at_rate(encoder.sample_rate)
    stride = checks.multiple("tracker's interval", 1 / tracker.sample_rate, "the encoder's", encoder.interval)
    path = integrate(seen.wheel_angles, robot)
    counters = wheel_counters(encoder, robot, seen.wheel_angles)
    # What the tick of the last reading adds to the noise of each pose.
    along, turn = (sum(getattr(c, part) ** 2 for c in counters) / 12 for part in ("distance", "heading"))
    std = np.sqrt([tracker.position_noise**2 + along / 2] * 2 + [tracker.heading_noise**2 + turn])
    drive = Drive(seen.t, seen.wheel_angles, path[::stride], seen.t[::stride])
    gain, covariance = _estimator(drive, robot, std[: 3 if headings else 2])
    by_distance, by_heading = _through_path(path, gain, stride)
    for counter in counters:
        weights = counter.distance * by_distance + counter.heading * by_heading
        values, odds = summed_errors(counter.exact, weights)
        covariance = covariance + values.T * odds @ values
    return covariance


def _estimator(drive: Drive, robot: Robot, std: Array) -> tuple[Array, Array]:
    """What an error of each pose does to the parameters (M, 3, 3), and the covariance that the poses' noise leaves."""
    path, width = trajectory(drive, parameters_of(robot), count=3), len(std)
    x, y = path.poses[:, 0], path.poses[:, 1]
    one, zero = np.ones_like(x), np.zeros_like(x)
    by_start = np.stack([np.stack(column, axis=-1) for column in ((one, zero, zero), (zero, one, zero), (-y, x, one))])
    columns = np.concatenate([path.by_parameters, by_start])[..., :width] / std
    rows = columns.reshape(6, -1)
    covariance = np.asarray(np.linalg.inv(rows @ rows.T)[:3], dtype=np.float64)
    gain: Array = np.zeros((len(x), 3, 3))
    gain[:, :width] = np.moveaxis((covariance @ rows).reshape(3, -1, width) / std, 0, -1)
    return gain, covariance[:, :3]


def _through_path(path: Array, gain: Array, stride: int) -> tuple[Array, Array]:
    """What an error of the distance so far and of the heading at each reading do to the parameters, (K, 3) each.

    As in `counting.end_error`: the step before the reading, and the one after it, which takes back all but a shift.
    """
    now = np.zeros((len(path), *gain.shape[1:]))
    now[::stride] = gain
    later = now.sum(axis=0) - np.cumsum(now, axis=0)
    step = np.diff(path, axis=0)
    middle = path[:-1, 2] + step[:, 2] / 2
    along = np.stack([np.cos(middle), np.sin(middle)], axis=-1)
    across = np.stack([-step[:, 1], step[:, 0]], axis=-1) / 2
    none = np.zeros((1, 2))

    def shifted(before: Array, after: Array) -> Array:
        shift_now = np.concatenate([none, before])
        shift_later = shift_now + np.concatenate([after, none])
        return np.einsum("ki,kip->kp", shift_now, now[:, :2]) + np.einsum("ki,kip->kp", shift_later, later[:, :2])

    return shifted(along, -along), shifted(across, across) + now[:, 2]
