"""What a study's tolerances cost to first order, by derivatives: no trial, and a check of those that are driven."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj.drive import Drive
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.estimation.derivatives import parameters_of, trajectory
from diffdrive_mj.robot import Robot
from diffdrive_mj.sweeps.distributions import Distribution
from diffdrive_mj.sweeps.studies import Study

# How the parameters of odometry (left radius, right radius, track width, gain) change with what varies: with the mean
# radius m and the ratio k the radii are 2 m / (1 + k) and 2 m k / (1 + k).
_CHAIN: dict[str, Callable[[Robot], tuple[float, float, float, float]]] = {
    "robot.left_radius": lambda robot: (1, 0, 0, 0),
    "robot.right_radius": lambda robot: (0, 1, 0, 0),
    "robot.track_width": lambda robot: (0, 0, 1, 0),
    "robot.mean_radius": lambda robot: (2 / (1 + robot.radius_ratio), 2 - 2 / (1 + robot.radius_ratio), 0, 0),
    "robot.radius_ratio": lambda robot: (
        -2 * robot.mean_radius / (1 + robot.radius_ratio) ** 2,
        2 * robot.mean_radius / (1 + robot.radius_ratio) ** 2,
        0,
        0,
    ),
}
_POINTS = 4096


@dataclass(frozen=True, eq=False)
class FirstOrder:
    """Hold how far each tolerance puts the end of a drive off, to first order.

    Attributes:
        names: of what varies.
        errors: of the pose at the end for one standard deviation of each (D, 3) [m, m, rad], estimate minus truth.

    Example:
        >>> FirstOrder(("robot.track_width",), np.array([[0.03, 0.04, 0.1]])).position_rms.round(9)
        np.float64(0.05)
    """

    names: tuple[str, ...]
    errors: Array

    @property
    def covariance(self) -> Array:
        """Of the error of the pose at the end (3, 3)."""
        return self.errors.T @ self.errors

    @property
    def position_rms(self) -> float:
        """Root mean square of the position error at the end [m]."""
        return np.sqrt(np.trace(self.covariance[:2, :2]))

    @property
    def heading_sigma(self) -> float:
        """Standard deviation of the heading error at the end [rad]."""
        return np.sqrt(self.covariance[2, 2])

    @property
    def heading_shares(self) -> Array:
        """Which share of the heading's variance each makes (D,): its Sobol' indices, since nothing is done together."""
        return np.asarray(self.errors[:, 2] ** 2 / self.covariance[2, 2])


def first_order(study: Study) -> FirstOrder:
    """Compute what the tolerances of radii and track cost at the end of a study's drive, to first order.

    ```
    e = sum_k (d pose / d p_k) sigma_k z_k,  z_k independent, of mean zero and variance one
    ```

    Args:
        study: that varies the true robot's radii, or their mean and ratio, and its track width.

    Returns:
        The errors.

    Raises:
        InvalidType: not a study.
        InvalidValue: something else varies, of which odometry's derivatives know nothing.

    Example:
        On a straight line of 2 m a ratio that is 0.1 % too large turns the robot by 2 m * 0.001 / 0.4 m:

        >>> spread = {"robot.radius_ratio": dd.sweeps.Normal(mean=1.0, sigma=0.001)}
        >>> drive = dd.sweeps.Maneuver("straight", {"speed": 0.5, "distance": 2.0})
        >>> study = dd.sweeps.Study(robot=dd.Robot.load("matched"), maneuver=drive, vary=spread)
        >>> first_order(study).errors.round(5).tolist()
        [[-0.0, -0.005, -0.005]]
    """
    checks.instance("study", study, Study)
    if unknown := [name for name in study.vary if name not in _CHAIN]:
        raise InvalidValue(f"{unknown[0]!r} varies: first order knows {', '.join(_CHAIN)}")
    commands = study.maneuver.commands(study.robot)
    angles = commands.wheel_angles
    t = commands.period * np.arange(len(angles), dtype=np.float64)
    drive = Drive(t, angles, np.zeros((2, 3)), t[[0, -1]])
    by_parameters = trajectory(drive, parameters_of(study.robot)).by_parameters[:, -1]
    steps = [_sigma(spread) * np.array(_CHAIN[name](study.robot)) for name, spread in study.vary.items()]
    return FirstOrder(tuple(study.vary), -np.reshape(steps, (-1, 4)) @ by_parameters)


def _sigma(spread: Distribution) -> float:
    """The standard deviation of a distribution, from its quantiles."""
    return float(np.std(spread.at((np.arange(_POINTS) + 0.5) / _POINTS)))
