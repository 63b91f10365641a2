"""Wheel odometry: from wheel angles to poses.

A step's wheel increments give the distance ds and the turn dtheta (`kinematics.body_twist`). The three methods
differ in the length and the direction of the straight line that stands for the step:

```
euler      ds                      along the heading at the start of the step
midpoint   ds                      along the heading half-way: the chord taken for the arc
arc        ds sinc(dtheta / 2)     along the heading half-way: the exact chord
```

The midpoint is that of [Greek notes], the exact chord that of [ct-Sim]; [Behnke] and [Odometrie wiki 2016] have the
same arc about the ICC, the latter without the start heading. A function of one's own may take their place (`Step`).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from diffdrive_mj._checks import MOST_SAMPLES, Array, array, instance, member, positive
from diffdrive_mj._text import shown
from diffdrive_mj.errors import InvalidType, InvalidValue
from diffdrive_mj.kinematics import body_twist
from diffdrive_mj.robot import Robot
from diffdrive_mj.se2 import rotate, sinc

Method = Literal["euler", "midpoint", "arc"]
METHODS: tuple[Method, ...] = get_args(Method)
# From wheel-angle increments (..., S, 2) [rad] and the believed robot to the motion of each step, in the frame of the
# pose before it (..., S, 3): forward [m], to the left [m], turn [rad].
Step = Callable[[Array, Robot], ArrayLike]
TEN_DEGREES = np.radians(10.0)


def integrate(
    wheel_angles: ArrayLike, robot: Robot, method: Method | Step = "arc", start: ArrayLike = (0.0, 0.0, 0.0)
) -> Array:
    """Compute the poses that a robot believes in, from its wheel angles.

    Args:
        wheel_angles: (..., T, 2) [rad], left then right: absolute rotations, as an encoder counts them.
        robot: the believed robot; its radii, track width and turning gain are read.
        method: "euler", "midpoint", "arc", or a function of your own: it is called with the wheels' increments
            (..., T - 1, 2) [rad] and the robot, and returns how each step moves in the frame of the pose before it,
            (..., T - 1, 3): forward [m], to the left [m], turn [rad].
        start: (..., 3) [m, m, rad], the pose at the first sample.

    Returns:
        (..., T, 3) [m, m, rad]; headings are continuous.

    Raises:
        UnknownName: the method.
        InvalidType: not a robot, not numbers, a class for a method.
        InvalidValue: shapes that do not fit, also of what a function returns, or values that are not finite.

    References:
        [Greek notes]: midpoint.
        [ct-Sim]: arc, equations 1.3 to 1.14.

    Example:
        A quarter of a circle of radius 1 m to the left, in a single step:

        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> angles = [(0.0, 0.0), (4.0 * np.pi, 6.0 * np.pi)]
        >>> dd.odometry.integrate(angles, robot)[-1].round(4).tolist()
        [1.0, 1.0, 1.5708]
        >>> dd.odometry.integrate(angles, robot, method="euler")[-1].round(4).tolist()
        [1.5708, 0.0, 1.5708]

        Euler's method as a function of one's own:

        >>> def mine(increments, robot):
        ...     distance, turn = np.moveaxis(dd.kinematics.body_twist(increments, robot), -1, 0)
        ...     return np.stack([distance, np.zeros_like(turn), turn], axis=-1)
        >>> dd.odometry.integrate(angles, robot, mine)[-1].round(4).tolist()
        [1.5708, 0.0, 1.5708]
    """
    angles, start = array("wheel_angles", wheel_angles, "T", 2), array("start", start, 3)
    instance("robot", robot, Robot)
    method = checked_method(method)
    shape = _common_shape("wheel_angles", angles, start)
    if angles.shape[-2] == 1:
        return np.broadcast_to(start[..., None, :], (*shape, 1, 3)).copy()
    increments = np.diff(angles, axis=-2)
    if callable(method):
        return _chained(_steps(method, increments, robot), start, shape)
    return accumulate(body_twist(increments, robot), method, start)


def checked_method(method: Method | Step) -> Method | Step:
    """Check a method of odometry.

    Args:
        method: "euler", "midpoint", "arc", or a function.

    Returns:
        The method.

    Raises:
        InvalidType: a class.
        UnknownName: another name.

    Example:
        >>> checked_method("arc")
        'arc'
    """
    if isinstance(method, type):
        raise InvalidType(f"odometry method = {shown(method)}: must be a name or a function, not a class")
    return method if callable(method) else member("odometry method", method, METHODS)


def _steps(method: Step, increments: Array, robot: Robot) -> Array:
    """The motion of each step (..., S, 3) by a function of the user's own."""
    steps = array("what the odometry method returns", method(increments.copy(), robot), "S", 3)
    wanted = (*increments.shape[:-1], 3)
    if steps.shape != wanted:
        raise InvalidValue(
            f"what the odometry method returns has shape {steps.shape}: must be {wanted} for wheel increments of shape "
            f"{increments.shape}"
        )
    return steps


def _chained(steps: Array, start: Array, shape: tuple[int, ...]) -> Array:
    """The poses (..., S + 1, 3) along steps (..., S, 3), each in the frame of the pose before it."""
    poses = np.empty((*shape, steps.shape[-2] + 1, 3))
    poses[..., 0, :] = start
    poses[..., 1:, 2] = steps[..., 2]
    poses[..., 2] = np.cumsum(poses[..., 2], axis=-1)
    poses[..., 1:, :2] = rotate(steps[..., :2], poses[..., :-1, 2])
    poses[..., :2] = np.cumsum(poses[..., :2], axis=-2)
    return poses


def accumulate(motion: ArrayLike, method: Method = "arc", start: ArrayLike = (0.0, 0.0, 0.0)) -> Array:
    """Compute the poses along steps of known distance and turn, whatever measured them.

    Args:
        motion: (..., S, 2), distance [m] and turn [rad] of each step, or (..., S, 3), distance [m], slide to the left
            [m] and turn [rad]: the twist times the duration of the step.
        method: "euler", "midpoint" or "arc".
        start: (..., 3) [m, m, rad], the pose before the first step.

    Returns:
        (..., S + 1, 3) [m, m, rad], the start pose first.

    Raises:
        UnknownName: the method.
        InvalidType: not numbers.
        InvalidValue: shapes that do not fit, or values that are not finite.

    Example:
        >>> dd.odometry.accumulate([(1.0, 0.0), (0.0, np.pi / 2), (1.0, 0.0)])[:, :2].round(9).tolist()
        [[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [1.0, 1.0]]
    """
    steps, start = array("motion", motion, "S", "2 or 3"), array("start", start, 3)
    if steps.shape[-1] not in (2, 3):
        raise InvalidValue(f"motion has shape {steps.shape}: must be (..., S, 2 or 3)")
    member("odometry method", method, METHODS)
    length, turn = steps[..., 0], steps[..., -1]
    slide = steps[..., 1] if steps.shape[-1] == 3 else None
    shape = _common_shape("motion", steps, start)
    # One row a pose coordinate: the sums then run through contiguous memory.
    terms = np.empty((3, *shape, steps.shape[-2] + 1))
    terms[..., 0] = np.moveaxis(np.broadcast_to(start, (*shape, 3)), -1, 0)
    terms[2, ..., 1:] = turn
    direction = np.cumsum(terms[2], axis=-1)[..., :-1]
    if method != "euler":
        half = turn / 2
        direction += half
        if method == "arc":
            length = length * sinc(half)
            slide = None if slide is None else slide * sinc(half)
    cos, sin = np.cos(direction), np.sin(direction)
    np.multiply(length, cos, out=terms[0, ..., 1:])
    np.multiply(length, sin, out=terms[1, ..., 1:])
    if slide is not None:
        terms[0, ..., 1:] -= slide * sin
        terms[1, ..., 1:] += slide * cos
    return np.moveaxis(np.cumsum(terms, axis=-1), 0, -1)


def _common_shape(name: str, samples: Array, start: Array) -> tuple[int, ...]:
    """The leading dimensions of samples (..., T, 2) and start poses (..., 3)."""
    try:
        return np.broadcast_shapes(samples.shape[:-2], start.shape[:-1])
    except ValueError:
        raise InvalidValue(f"start has shape {start.shape}: must broadcast with {name} {samples.shape}") from None


class Odometer:
    """Odometry one sample at a time, as it runs on a robot; `integrate` gives the same numbers.

    Args:
        robot: the believed robot.
        method: as for `integrate`.
        start: (..., 3) [m, m, rad], the pose at the first sample.

    Raises:
        UnknownName: the method.
        InvalidType: not a robot, not numbers.
        InvalidValue: a start of another shape, or not finite.

    Example:
        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> odometer = dd.odometry.Odometer(robot, start=(5.0, 0.0, 0.0))
        >>> for angles in [(0.0, 0.0), (10.0, 10.0)]:  # as they come from the encoders
        ...     pose = odometer.update(angles)
        >>> pose.tolist()
        [6.0, 0.0, 0.0]
    """

    def __init__(self, robot: Robot, method: Method | Step = "arc", start: ArrayLike = (0.0, 0.0, 0.0)) -> None:
        self._robot = instance("robot", robot, Robot)
        self._method = checked_method(method)
        self._pose = array("start", start, 3).copy()
        self._last: Array | None = None

    @property
    def pose(self) -> Array:
        """The pose after the last sample (..., 3) [m, m, rad]."""
        return self._pose.copy()

    def update(self, wheel_angles: ArrayLike) -> Array:
        """Take in one sample and return the pose; the first sample returns the start.

        Args:
            wheel_angles: (..., 2) [rad], left then right; leading dimensions are robots that share a belief.

        Returns:
            (..., 3) [m, m, rad].

        Raises:
            InvalidType: not numbers.
            InvalidValue: another shape than the last sample's, or values that are not finite.
        """
        angles = array("wheel_angles", wheel_angles, 2)
        last = angles if self._last is None else self._last
        if last.shape != angles.shape:
            raise InvalidValue(f"wheel_angles has shape {angles.shape}: must be that of the last sample, {last.shape}")
        pair = np.stack([last, angles], axis=-2)
        self._pose = integrate(pair, self._robot, self._method, self._pose)[..., -1, :]
        self._last = angles
        return self.pose


def subdivide(wheel_angles: ArrayLike, robot: Robot, max_turn: float = TEN_DEGREES) -> tuple[Array, NDArray[np.intp]]:
    """Put samples between the given ones, so that the heading turns by at most `max_turn` a segment.

    Each segment is divided evenly, at constant wheel rates. It makes "euler" and "midpoint" better;
    "arc" is exact for constant rates and does not need it.

    Args:
        wheel_angles: (..., T, 2) [rad]; all runs are divided alike, as the sharpest of them needs.
        robot: the believed robot.
        max_turn: the largest turn of a segment [rad].

    Returns:
        The finer angles (..., S, 2), and the indices (T,) of the given samples in them.

    Raises:
        InvalidType: not a robot, not numbers.
        InvalidValue: shapes that do not fit, values that are not finite, or more samples than fit in memory.

    References:
        [Odometrie wiki 2016]: quotes the advice of G. W. Lucas, at most 10 degrees.

    Example:
        A turn of 45 degrees on the spot takes five segments:

        >>> robot = dd.Robot(left_radius=0.1, right_radius=0.1, track_width=0.4)
        >>> fine, given = dd.odometry.subdivide([(0.0, 0.0), (-np.pi / 2, np.pi / 2)], robot)
        >>> len(fine) - 1, given.tolist()
        (5, [0, 5])
    """
    angles = array("wheel_angles", wheel_angles, "T", 2)
    instance("robot", robot, Robot)
    limit = positive("max_turn", max_turn)
    if angles.shape[-2] == 1:
        return angles.copy(), np.zeros(1, dtype=np.intp)
    turns = np.abs(body_twist(np.diff(angles, axis=-2), robot)[..., 1])
    widest = turns.reshape(-1, turns.shape[-1]).max(axis=0)
    # The small slack keeps a turn that is the limit up to rounding in one piece.
    with np.errstate(over="ignore"):
        wanted = np.maximum(1, np.ceil(widest / limit * (1 - 1e-12)))
    if not wanted.sum() <= MOST_SAMPLES:
        raise InvalidValue(f"max_turn = {limit:g} rad: {wanted.sum():.3g} segments, must be at most {MOST_SAMPLES}")
    pieces = wanted.astype(np.intp)
    given = np.concatenate([[0], np.cumsum(pieces)])
    segment = np.repeat(np.arange(len(pieces)), pieces)
    fraction = (np.arange(given[-1]) - given[segment]) / pieces[segment]
    start, end = angles[..., segment, :], angles[..., segment + 1, :]
    fine = start + (end - start) * fraction[:, None]
    return np.concatenate([fine, angles[..., -1:, :]], axis=-2), given
