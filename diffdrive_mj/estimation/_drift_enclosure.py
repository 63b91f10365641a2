"""A proven bound on the drift over a box of robots: a Taylor polynomial, its remainder, and all rounding.

The true robot ends at

```
b F,    F = integral of e^(i theta) (kappa dS + g dD / 4),    theta = theta_0 + kappa D + g S
```

(`_robot_box` has the letters). With d how far (kappa, g, theta_0) are from the middle of a box, and e = d . (D, S, 1)
how far that turns the robot at a place of its path, |e^(i e) - 1 - i e + e^2 / 2| <= |e|^3 / 6 leaves

```
F = F_0 + J d + d B d + rest
|rest| <= integral of |kappa dS + g dD / 4| |e|^3 / 6 + |d_kappa dS + d_g dD / 4| e^2 / 2
```

and less where the robot drives circles (`_long_pieces`). Without the last two the drift is |F_0 + J d - P / b| b, with
P where odometry ends: the size of what is linear over what is linear and positive (1 / b), so that none of a polytope
exceeds its corners. The last two are bounded by their sizes.

Rounding: a sum of n terms in any order is off by at most n u of the sum of their sizes, u = 2^-53 (Higham 2002); angles
by a few u of all that leads to them; sines, and polynomials of angles below a radian, by a few u. Each is counted
several times over (`_rounding`).
"""

from __future__ import annotations

import numpy as np

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj.estimation._boxes import Enclosures
from diffdrive_mj.estimation._long_pieces import Circle, LongPieces
from diffdrive_mj.estimation._robot_box import RobotBox, corners, sides
from diffdrive_mj.estimation._series import Complex
from diffdrive_mj.estimation._short_pieces import ShortPieces
from diffdrive_mj.estimation._wheel_path import rolled, turning, wheel_path
from diffdrive_mj.odometry import integrate
from diffdrive_mj.robot import Robot

_UNIT = 2.0**-53
# How many pieces, each counted once a box, are worked on at once.
_NUMBERS = 40_000
# More than what the last steps, from bounds of parts to that of the whole, round off.
_OUTWARD = 1 + 2.0**-40


class DriftOverBoxes:
    """How far the robots of a box are from where odometry takes them to be, on one drive.

    Args:
        wheel_angles: (T, 2) [rad].
        believed: the robot of the odometry.
        box: of true robots.
        anywhere: the largest drift at any sample, not that at the end.
    """

    def __init__(self, wheel_angles: Array, believed: Robot, box: RobotBox, anywhere: bool) -> None:
        self._box = box
        angles = wheel_angles - wheel_angles[0]
        path = wheel_path(angles, box, anywhere)
        short, long = len(path.short), len(path.long)
        self.pieces = short + long
        self._at_once = max(1, _NUMBERS // (short + 1))
        self._parts: list[ShortPieces | LongPieces] = [ShortPieces(path, box)] if short else []
        self._parts += [LongPieces(path)] if long else []
        self._circle = Circle(path.circle) if path.circle is not None else None
        poses = integrate(angles, believed)
        at = poses[1:] if anywhere and len(angles) > 1 else poses[-1:]
        self._estimate: Complex = at[:, 0] + 1j * at[:, 1]

        size, turned = rolled(angles), np.abs(turning(angles))
        lengths = box.lengths(box.corners)
        radius = max(believed.left_radius, believed.right_radius)
        rim, own = size * (lengths[:, :2] / lengths[:, 2:]).max(), size * radius / believed.track_width
        # Any path as close to the drive turns a robot by as little more or less, and moves it by as little.
        self._off = _rounding(rim, len(angles)) + 4 * path.off / max(size, checks.SMALLEST) * rim * (1 + rim)
        self._estimate_off = believed.track_width * _rounding(own, len(angles), added=len(angles))
        self._farthest = float((lengths[:, :2].max() + radius) * size) * _OUTWARD
        self._most_turned, self._mean_turned = turned.max(axis=0), turned.mean(axis=0)
        self.heading = self._heading(angles if anywhere else angles[-1:], believed)

    def enclose(self, boxes: Array) -> Enclosures:
        """Bounds on the drift over boxes (N, 2, 4), some at a time, so that memory does not grow with the drive."""
        several = [self._enclosed(boxes[k : k + self._at_once]) for k in range(0, len(boxes), self._at_once)]
        return Enclosures(*(np.concatenate(parts) for parts in zip(*several, strict=True)))

    def _enclosed(self, boxes: Array) -> tuple[Array, Array, Array]:
        edges = corners(boxes)
        track, at = self._box.physical(edges)
        center = self._box.physical(boxes.mean(axis=1))[1]
        d = at - center[:, None]
        width = np.abs(d).max(axis=1)
        series = sum((part.series(center) for part in self._parts[1:]), self._parts[0].series(center))
        where = series.value[:, None] + np.einsum("jnk,nvj->nvk", series.slope, d)
        linear = np.abs(track[..., None] * where - self._estimate)
        curved = np.einsum("ijnk,ni,nj->nk", np.abs(series.bend), width, width)
        rest = sum(part.rest(center, width) for part in self._parts)
        off = self._off * (2 + width @ self._most_turned) ** 2
        widest = track.max(axis=1)
        bound = linear.max(axis=1) + widest[:, None] * (curved + rest + off[:, None]) + self._estimate_off
        bend = self._turned_by(boxes)
        if self._circle is not None:
            rounding = 4 * widest[:, None] * self._off + self._estimate_off
            circled = self._circle.farthest(track, at, self._estimate) + rounding
            open_ended = circled.max(axis=1) < bound.max(axis=1)
            bend[open_ended] = self._circle.changed_by(boxes[open_ended], self._box, bend[open_ended])
            bound = np.minimum(bound, circled)
        each = np.arange(len(boxes))
        worst = edges[each, linear[each, :, bound.argmax(axis=1)].argmax(axis=1)]
        upper = np.minimum(bound.max(axis=1) * _OUTWARD, self._farthest)
        return upper, worst, bend

    def value(self, points: Array) -> Array:
        """The drift of robots (N, 4), not rounded outwards."""
        several = [self._value(points[k : k + self._at_once]) for k in range(0, len(points), self._at_once)]
        return np.concatenate(several)

    def _value(self, points: Array) -> Array:
        track, at = self._box.physical(points)
        where = sum(part.value(at) for part in self._parts)
        found: Array = np.abs(track[:, None] * where - self._estimate).max(axis=1)
        return found

    def _turned_by(self, boxes: Array) -> Array:
        """How much the robots of boxes turn along the path by each of their coordinates (N, 4)."""
        change = self._box.physical(sides(boxes))[1] - self._box.physical(boxes.mean(axis=1))[1][:, None]
        turned: Array = np.abs(change) @ self._mean_turned
        return turned

    def _heading(self, angles: Array, believed: Robot) -> float:
        """The largest error of the heading [rad]: it is linear, so that none exceeds those of the corners."""
        left, right, track = believed.left_radius, believed.right_radius, believed.track_width
        own = np.array([(left + right) / (2 * track), (right - left) / track, 0.0])
        error = np.abs(turning(angles) @ (self._box.physical(self._box.corners)[1] - own).T).max()
        return float(error) * _OUTWARD + self._off + self._estimate_off / track


def _rounding(rim: float, samples: int, added: int = 0) -> float:
    """What rounding adds to F at most: in sums of its pieces, in angles, in products and sines.

    Args:
        rim: how far both wheels roll together, in track widths; there are at most 3 rim more pieces than samples.
        samples: of the drive.
        added: from how many turns a heading is added up.
    """
    return _UNIT * rim * (16 * samples + 64 + (64 + 4 * added) * rim)
