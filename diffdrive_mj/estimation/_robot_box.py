"""Boxes of robots: the coordinates in which tolerances are intervals, and those in which odometry is nearly linear.

A wheel path of sums S = (phi_l + phi_r) / 2 and differences D = phi_r - phi_l turns a robot by

```
theta = theta_0 + kappa D + g S        kappa = (r_l + r_r) / 2 b        g = (r_r - r_l) / b
```

which is linear in kappa and g. A box of radii (or of mean radius and asymmetry) and track width is a polytope in
(kappa, g, 1 / b), whose corners are those of the box: each of its faces is linear there.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.robot import Robot
from diffdrive_mj.tolerances import Tolerances

Interval = tuple[float, float]
# Of a rounded bound of an interval: it is moved outwards by more than the rounding of whatever led to it.
_OUTWARD = 2.0**-48


@dataclass(frozen=True, eq=False)
class RobotBox:
    """A box of robots and of headings at the start.

    Attributes:
        low: (4,), the lower corner: left and right radius [m], or mean radius [m] and asymmetry q, of radii R (1 - q)
            and R (1 + q); track width [m]; heading at the start [rad].
        high: (4,), the upper corner.
        by_radii: whether the first two are the radii.
    """

    low: Array
    high: Array
    by_radii: bool

    @property
    def corners(self) -> Array:
        """The corners of the whole box (C, 4)."""
        return corners(np.stack([self.low, self.high])[None])[0]

    @property
    def faces(self) -> Array:
        """Boxes (N, 2, 4) that hold a worst robot.

        At one kappa and one g the drift is convex in the robot's size, as is the distance of a point from a line's: it
        is largest for the smallest robot or for the largest one, and these lie on faces of lengths.
        """
        lengths = [0, 1, 2] if self.by_radii else [0, 2]
        box = np.stack([self.low, self.high])
        faces = np.repeat(box[None], 2 * len(lengths), axis=0)
        for k, (which, side) in enumerate(itertools.product(lengths, (0, 1))):
            faces[k, :, which] = box[side, which]
        return faces

    def physical(self, points: Array) -> tuple[Array, Array]:
        """Track width (...) [m], and kappa, g and the heading at the start (..., 3), of points (..., 4)."""
        left, right, track = np.moveaxis(self.lengths(points), -1, 0)
        return track, np.stack([(left + right) / (2 * track), (right - left) / track, points[..., 3]], axis=-1)

    def lengths(self, points: Array) -> Array:
        """Left radius, right radius and track width (..., 3) [m] of points (..., 4)."""
        if self.by_radii:
            return points[..., :3]
        mean, asymmetry, track = points[..., 0], points[..., 1], points[..., 2]
        return np.stack([mean * (1 - asymmetry), mean * (1 + asymmetry), track], axis=-1)

    def robot(self, point: Array) -> Robot:
        """The robot of a point (4,)."""
        left, right, track = self.lengths(point).tolist()
        return Robot(left_radius=left, right_radius=right, track_width=track)


def corners(boxes: Array) -> Array:
    """The corners of boxes (N, 2, P): (N, C, P), of coordinates in which no box has a width one."""
    wide = np.any(boxes[:, 0] < boxes[:, 1], axis=0).tolist()
    picks = np.array(list(itertools.product(*[(0, 1) if is_wide else (0,) for is_wide in wide])))
    return boxes[:, picks, np.arange(boxes.shape[2])]


def sides(boxes: Array) -> Array:
    """The middles of a side of boxes (N, 2, P) by each of their coordinates (N, P, P)."""
    center = boxes.mean(axis=1)
    return center[:, None] + np.eye(boxes.shape[2]) * (boxes[:, 1] - center)[:, None]


def robot_box(
    robot: Robot,
    tolerances: Tolerances | None,
    left_radius: Interval | None,
    right_radius: Interval | None,
    track_width: Interval | None,
    heading: float,
) -> RobotBox:
    """The box of robots around one within tolerances, or within intervals of lengths where these are given."""
    checks.instance("robot", robot, Robot)
    known = robot.tolerances if tolerances is None else checks.instance("tolerances", tolerances, Tolerances)
    turned = checks.not_negative("heading", heading)
    if turned > np.pi:
        raise InvalidValue(f"heading = {turned:g} rad: must be at most pi; in degrees? then {np.radians(turned):.4g}")
    if (left_radius is None) != (right_radius is None):
        raise InvalidValue("left_radius and right_radius: give both intervals, or none and tolerances")
    by_radii = left_radius is not None
    first = ("left_radius", left_radius) if by_radii else ("mean radius", _within(robot.mean_radius, known.radius))
    ratio = np.array(_within(robot.radius_ratio, known.radius_ratio))
    second = ("right_radius", right_radius) if by_radii else ("asymmetry", (ratio - 1) / (ratio + 1))
    third = _within(robot.track_width, known.track_width) if track_width is None else track_width
    ends = np.array([*(_interval(*span) for span in (first, second, ("track_width", third))), (-turned, turned)])
    # An asymmetry is a difference: what it rounds off is a part of 1.
    widen = _OUTWARD * np.maximum(np.abs(ends), [[0.0], [0.0 if by_radii else 1.0], [0.0], [0.0]])
    box = RobotBox(ends[:, 0] - widen[:, 0], ends[:, 1] + widen[:, 1], by_radii)
    for point in box.corners:
        try:
            box.robot(point)
        except InvalidValue as error:
            raise InvalidValue(f"tolerances hold robots that cannot be: {error}") from None
    return box


def _within(value: float, part: float) -> Interval:
    return value * (1 - part), value * (1 + part)


def _interval(name: str, value: object) -> Interval:
    low, high = checks.vector(name, value, 2).tolist()  # type: ignore[arg-type]
    if low > high:
        raise InvalidValue(f"{name} = ({low:g}, {high:g}): must go from a smaller to a larger number")
    return low, high
