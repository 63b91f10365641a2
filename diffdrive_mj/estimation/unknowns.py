"""What is unknown and the same along a whole drive: a robot's parameters, a gyro's bias; and quadrature over it.

The heading is off by a linear function G z of the unknown values z at every sample (with their covariance's square
root put in). Its singular vectors are the axes of the quadrature: the first ones turn the robot, and take the more
nodes the farther they do; the others only lengthen or shorten its way, which the moments are polynomials of.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj import _checks as checks
from diffdrive_mj import _covariances
from diffdrive_mj._checks import Array
from diffdrive_mj._text import shown
from diffdrive_mj.errors import InvalidType, InvalidValue, UnknownName
from diffdrive_mj.estimation.derivatives import PARAMETERS
from diffdrive_mj.estimation.noise import Noise, Readings, Steps
from diffdrive_mj.robot import Robot

# The largest standard deviation of a length, as a share of it, and of a heading [rad].
_VAGUEST, _MOST_TURN = 0.1, 2 * math.pi
# What quadrature may be off by, as a share; its fewest nodes on an axis; the weight of a node that may be left out.
_ACCURACY, _FEWEST, _UNLIKELY = 1e-4, 3, 1e-9
# A heading that is uncertain by less, cubed, is rounding [rad].
_SURE = 1e-6
# Of a central difference, in standard deviations.
_STEP = 1e-3
_RATIOS = ("radius_ratio", "speed_ratio")


@runtime_checkable
class Calibrated(Protocol):
    """What a calibration has to say of parameters: their names and their covariance.

    Example:
        >>> class Measured:
        ...     parameters, covariance = ("track_width",), [[1e-6]]
        >>> isinstance(Measured(), Calibrated)
        True
    """

    parameters: tuple[str, ...]
    covariance: Any


Parameters = Calibrated | Mapping[str, float] | ArrayLike


def parameter_covariance(parameters: Parameters | None, robot: Robot) -> Array:
    """Find how the parameters of a robot scatter.

    A radius ratio, and the speed ratio that stands for it, moves both radii against each other, their mean kept:

    ```
    dr_l = -2 r / (1 + q)^2 dq        dr_r = 2 r / (1 + q)^2 dq        r the mean radius, q the ratio
    ```

    Args:
        parameters: a calibration; or standard deviations by name; or the covariance (3, 3) of the left radius, the
            right radius and the track width, or (4, 4) with the turning gain. None for a robot that is known.
        robot: the believed one.

    Returns:
        (4, 4), in the order of `derivatives.PARAMETERS`.

    Raises:
        UnknownName: a parameter that is none.
        InvalidType: not numbers, or one number alone.
        InvalidValue: a covariance of another shape, not symmetric or not positive, or parameters that are too vague.

    Example:
        >>> found = parameter_covariance({"track_width": 0.001}, dd.Robot.load("matched"))
        >>> found[2, 2].round(9).item()
        1e-06
    """
    count = len(PARAMETERS)
    if parameters is None:
        return np.zeros((count, count))
    if isinstance(parameters, Mapping):
        names: Sequence[str] = [checks.string("parameters", name) for name in parameters]
        values = [checks.not_negative(f"parameters[{name!r}]", value) for name, value in parameters.items()]
        given = np.diag(np.square(values)) if values else np.zeros((0, 0))
    elif isinstance(parameters, Calibrated):
        names = checks.strings("parameters.parameters", parameters.parameters)
        given = _covariances.covariance("parameters.covariance", parameters.covariance, len(names))
    elif isinstance(parameters, (str, float, int)):
        raise InvalidType(
            f"parameters = {shown(parameters)}: must be a calibration, standard deviations by name, such as "
            '{"track_width": 0.001}, or a covariance (3, 3)'
        )
    else:
        found = checks.array("parameters", parameters, "P", "P")
        if found.shape not in ((3, 3), (4, 4)):
            raise InvalidValue(f"parameters has shape {found.shape}: must be (3, 3) or (4, 4), a covariance")
        names, given = PARAMETERS[: len(found)], _covariances.covariance("parameters", found, len(found))
    by_name = np.array([_row(name, robot) for name in names]).reshape(-1, count)
    covariance: Array = by_name.T @ given @ by_name
    for name, sigma in zip(PARAMETERS[:3], np.sqrt(np.diag(covariance)), strict=False):
        if sigma > _VAGUEST * getattr(robot, name):
            raise InvalidValue(
                f"parameters: {name} = {getattr(robot, name):g} m is uncertain by {sigma:.3g} m: must be known to a "
                "tenth; calibrate on drives that show it, turns and straight lines"
            )
    return covariance


def _row(name: str, robot: Robot) -> Array:
    """How the robot's parameters (4,) change with one that has a name."""
    if name in _RATIOS:
        slope = 2 * robot.mean_radius / (1 + robot.radius_ratio) ** 2
        return np.array([-slope, slope, 0.0, 0.0])
    if name not in PARAMETERS:
        raise UnknownName("parameter", name, (*PARAMETERS, *_RATIOS))
    return np.eye(len(PARAMETERS))[PARAMETERS.index(name)]


@dataclass(frozen=True, eq=False)
class Unknowns:
    """Hold what is unknown and the same along a drive, and what the steps are for given values of it.

    Attributes:
        root: (C, R), so that root z has the covariance of the unknown values for z of independent standard normals.
        steps: the steps for given z (R,).

    Example:
        >>> robot = dd.Robot.load("matched")
        >>> readings = Readings.of([(0.0, 0.0), (1.0, 1.0)])
        >>> Unknowns.of(readings, robot, (), np.diag([0.0, 0.0, 1e-6, 0.0])).root.shape
        (4, 1)
    """

    root: Array
    steps: Callable[[Array], Steps]

    @classmethod
    def of(cls, readings: Readings, robot: Robot, models: Sequence[Noise], parameters: Array) -> Unknowns:
        """Put together what robot and models do not know.

        Args:
            readings: of the drive.
            robot: the believed one.
            models: of the noise.
            parameters: covariance of the robot's (4, 4).

        Returns:
            The unknowns.
        """
        parts = [parameters, *(model.common for model in models)]
        ends = np.cumsum([len(part) for part in parts])
        root = np.zeros((int(ends[-1]), 0))
        for end, part in zip(ends.tolist(), parts, strict=True):
            rows = np.zeros((len(root), len(part)))
            rows[end - len(part) : end] = _root(part)
            root = np.hstack([root, rows])
        root = root[:, np.any(root != 0, axis=0)]

        def steps(z: Array) -> Steps:
            values = np.split(root @ z, ends[:-1])
            moved = dict(zip(PARAMETERS, values[0].tolist(), strict=True))
            changes = {name: getattr(robot, name) + value for name, value in moved.items() if value}
            believed = robot.replace(**changes) if changes else robot
            found = Steps.of(readings, believed)
            for model, value in zip(models, values[1:], strict=True):
                found = model.applied(found, readings, believed, value)
            return found

        return cls(root, steps)

    @property
    def count(self) -> int:
        """How many independent unknowns there are, R."""
        return self.root.shape[1]

    def slopes(self) -> tuple[Array, Array]:
        """Compute by how much each unknown changes the steps, a standard deviation of it.

        Returns:
            For distances and turns (R, ..., S) [m, rad].
        """
        axes = np.eye(self.count) * _STEP
        pairs = [(self.steps(axis), self.steps(-axis)) for axis in axes]
        return (
            np.stack([(more.distance - less.distance) / (2 * _STEP) for more, less in pairs]),
            np.stack([(more.turn - less.turn) / (2 * _STEP) for more, less in pairs]),
        )

    def nodes(self) -> Iterator[tuple[float, Steps]]:
        """Go through the nodes of the quadrature.

        Yields:
            A weight and the steps; all weights add up to one.

        Raises:
            InvalidValue: the heading is more uncertain than a turn.
        """
        if not self.count:
            yield 1.0, self.steps(np.zeros(0))
            return
        headings = np.cumsum(self.slopes()[1], axis=-1)
        flat = headings.reshape(self.count, -1)
        axes = np.linalg.eigh(flat @ flat.T)[1][:, ::-1]
        sigmas = np.abs(axes.T @ flat).max(axis=1)
        if sigmas[0] > _MOST_TURN:
            raise InvalidValue(
                f"parameters: make the heading uncertain by {sigmas[0]:.3g} rad along the drive: must be at most a turn"
            )
        rules = [np.polynomial.hermite_e.hermegauss(_node_count(float(sigma))) for sigma in sigmas]
        grid = [list(zip(nodes.tolist(), (weights / weights.sum()).tolist(), strict=True)) for nodes, weights in rules]
        chosen = [
            (math.prod(w for _, w in point), np.array([x for x, _ in point])) for point in itertools.product(*grid)
        ]
        likely = [(weight, point) for weight, point in chosen if weight > _UNLIKELY]
        total = sum(weight for weight, _ in likely)
        for weight, point in likely:
            yield weight / total, self.steps(axes @ point)


def _root(covariance: Array) -> Array:
    """R with R R^T = covariance (N, N); columns of what is certain are zero."""
    values, vectors = np.linalg.eigh(covariance)
    return vectors * np.sqrt(np.where(values > 1e-14 * max(values.max(initial=0.0), 0.0), values, 0.0))


def _node_count(sigma: float) -> int:
    """How many nodes are enough for a heading that is uncertain by sigma [rad]: (2 s)^(2n) n! / (2n)! is small.

    Small beside s^6: after whole turns on the spot a variance has nothing of lower order.
    """
    if sigma < _SURE:
        return _FEWEST
    count, error = 1, (2 * sigma) ** 2 / 2
    while error > _ACCURACY * min(1.0, sigma**6) or count < _FEWEST:
        count += 1
        error *= (2 * sigma) ** 2 * count / ((2 * count - 1) * 2 * count)
    return count
