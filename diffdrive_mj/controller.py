"""A simple controller that steers by its own odometry: through waypoints to a pose.

It is told what the robot believes, its radii, its track and where it started, and reads the wheel angles; it never sees
the true pose. What it takes for the goal is therefore as far off as its odometry. (The title is one of [Greek notes].)
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj import se2
from diffdrive_mj._checks import Array, array, positive
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.kinematics import wheel_rates
from diffdrive_mj.odometry import Method, Odometer, Step
from diffdrive_mj.robot import Robot

# Feedback gains [1/s]: distance to speed, bearing to yaw rate. Each error dies out about as exp(-gain t).
_DISTANCE_GAIN = 1.5
_BEARING_GAIN = 3.0
# Within this distance the bearing means little; the robot keeps its heading and takes out the distance ahead [m].
_CLOSE = 0.05
_THERE = 2e-4
_PASSED = 0.15


class GoToPose:
    """Drive robots to goal poses, steering by the odometry of what they believe.

    Towards the goal, at the distance rho and the bearing alpha off the heading,

    ```
    v = k rho cos(alpha)^4        omega = k' alpha
    ```

    and at the goal the robot turns to its heading. Speed, yaw rate and their changes are limited, so that the wheels
    need not slip. An instance is for one drive: it remembers where its robots are.

    Args:
        believed: the robot that the odometry computes with.
        goal: (..., 3) [m, m, rad], a pose for each robot or one for all.
        waypoints: (..., W, 2) [m], passed by on the way.
        start: (..., 3) [m, m, rad], where the robots believe they start.
        speed: largest [m/s].
        yaw_rate: largest [rad/s].
        acceleration: largest [m/s^2].
        yaw_acceleration: largest [rad/s^2].
        method: of the odometry, as for `odometry.integrate`.

    Raises:
        InvalidType: not a robot, not numbers.
        InvalidValue: goals, waypoints or starts that are not finite or do not fit together; limits that are not
            positive.
        UnknownName: the method.

    Example:
        >>> robot = dd.Robot.load("matched")
        >>> driver = dd.GoToPose(robot, goal=(0.1, 0.0, 0.0))
        >>> loop = dd.ClosedLoop(driver, period=0.1, duration=3.0)
        >>> dd.simulate(robot, loop, sample_rate=10.0).truth[-1, :2].round(2).tolist()
        [0.1, 0.0]
    """

    def __init__(
        self,
        believed: Robot,
        *,
        goal: ArrayLike,
        waypoints: ArrayLike | None = None,
        start: ArrayLike = (0.0, 0.0, 0.0),
        speed: float = 0.5,
        yaw_rate: float = 1.5,
        acceleration: float = 0.5,
        yaw_acceleration: float = 3.0,
        method: Method | Step = "arc",
    ) -> None:
        self._believed = believed
        self._odometer = Odometer(believed, method, start)
        goal = array("goal", goal, 3)
        self._heading = goal[..., 2]
        self._points = goal[..., None, :2]
        if waypoints is not None:
            self._points = _joined(array("waypoints", waypoints, "W", 2), self._points)
        self._largest = np.array([positive("speed", speed), positive("yaw_rate", yaw_rate)])
        self._changes = np.array(
            [positive("acceleration", acceleration), positive("yaw_acceleration", yaw_acceleration)]
        )
        self._time: float | None = None
        self._twist = np.zeros(2)
        self._next = np.zeros((), dtype=np.intp)
        self._arrived = np.zeros((), dtype=bool)

    @property
    def pose(self) -> Array:
        """Where the robots believe they are (..., 3) [m, m, rad]."""
        return self._odometer.pose

    def __call__(self, t: float, wheel_angles: ArrayLike) -> Array:
        """Decide the wheel rates for the next control period.

        Args:
            t: time since the start of the drive [s].
            wheel_angles: (..., 2) [rad], left then right.

        Returns:
            (..., 2) [rad/s], left then right.

        Raises:
            InvalidValue: a time that is not after the last one: an instance does not drive twice.
        """
        if self._time is not None and t <= self._time:
            raise InvalidValue(
                f"GoToPose at t = {t:g} s, after {self._time:g} s: an instance is for one drive; make another"
            )
        pose = self._odometer.update(wheel_angles)
        elapsed = 0.0 if self._time is None else t - self._time
        self._time = t
        change = self._changes * elapsed
        self._twist = np.clip(self._wanted(pose), self._twist - change, self._twist + change)
        return wheel_rates(self._twist, self._believed)

    def _wanted(self, pose: Array) -> Array:
        """The twist (..., 2) that leads on from a believed pose."""
        shape = np.broadcast_shapes(pose.shape[:-1], self._heading.shape, self._points.shape[:-2])
        self._next = np.broadcast_to(self._next, shape)
        points = np.broadcast_to(self._points, (*shape, *self._points.shape[-2:]))
        last = self._points.shape[-2] - 1
        target = np.take_along_axis(points, self._next[..., None, None], axis=-2)[..., 0, :]
        gap = target - pose[..., :2]
        distance = np.hypot(gap[..., 0], gap[..., 1])
        self._next = np.minimum(self._next + ((distance < _PASSED) & (self._next < last)), last)

        bearing = se2.wrap_angle(np.arctan2(gap[..., 1], gap[..., 0]) - pose[..., 2])
        ahead = distance * np.cos(bearing)
        close = (distance < _CLOSE) & (self._next == last)
        self._arrived = self._arrived | (close & (np.abs(ahead) < _THERE))

        # Far away drive only as far as the heading leads there; close by take out what is left ahead, backwards too.
        facing = np.maximum(np.cos(bearing), 0.0) ** 4
        braking = np.sqrt(2 * self._changes[0] * 0.5 * distance)
        v = np.where(close, _DISTANCE_GAIN * ahead, facing * np.minimum(_DISTANCE_GAIN * distance, braking))
        omega = np.where(close, 0.0, _BEARING_GAIN * bearing)
        turn = se2.wrap_angle(self._heading - pose[..., 2])
        v, omega = np.where(self._arrived, 0.0, v), np.where(self._arrived, _BEARING_GAIN * turn, omega)
        return np.clip(np.stack([v, omega], axis=-1), -self._largest, self._largest)


def _joined(waypoints: Array, goal: Array) -> Array:
    """Waypoints (..., W, 2) and the goal (..., 1, 2) behind them."""
    try:
        shape = np.broadcast_shapes(waypoints.shape[:-2], goal.shape[:-2])
    except ValueError:
        raise InvalidValue(f"waypoints {waypoints.shape} and goal {goal.shape}: must be for the same robots") from None
    return np.concatenate([np.broadcast_to(part, (*shape, *part.shape[-2:])) for part in (waypoints, goal)], axis=-2)
