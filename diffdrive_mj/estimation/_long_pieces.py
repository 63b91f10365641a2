"""Where a robot is after pieces of a path in which it turns far: circles, of which the ends alone count.

On a piece that turns a robot by y = kappa dD + g dS, while it goes w = kappa dS + g dD / 4, F grows by

```
rho (e^(i theta_1) - e^(i theta_0)) / i,    rho = w / y
```

the radius of a circle in track widths: however long the piece, it matters no more than that. With n and h how rho and y
change relatively, at deviations d,

```
rho = rho_0 + n d - (n d) (h d) + (n d) (h d)^2 / (1 + h d)
```
"""

from __future__ import annotations

import numpy as np

from diffdrive_mj._checks import Array
from diffdrive_mj.estimation._robot_box import RobotBox, sides
from diffdrive_mj.estimation._series import Complex, Series, symmetric
from diffdrive_mj.estimation._wheel_path import WheelPath, turning, way


class LongPieces:
    """The long pieces of a path.

    Args:
        path: of wheel angles.
    """

    def __init__(self, path: WheelPath) -> None:
        # Of L pieces: (2, L) by kappa and g; of their beginnings and ends (3, 2 L), these with their signs.
        self._way = np.diff(way(path.long), axis=1)[:, 0].T
        self._turn = np.diff(turning(path.long), axis=1)[:, 0, :2].T
        self._at = np.concatenate([turning(path.long[:, 0]), turning(path.long[:, 1])]).T
        self._sign = np.repeat([-1.0, 1.0], len(path.long))

    def value(self, center: Array) -> Complex:
        """F of robots (N, 3): (N, 1)."""
        radius = (center[:, :2] @ self._way) / (center[:, :2] @ self._turn)
        return self._summed(np.tile(radius, 2) * np.exp(1j * (center @ self._at)))

    def series(self, center: Array) -> Series:
        """F and its derivatives about robots (N, 3)."""
        end = np.exp(1j * (center @ self._at))
        radius, by_radius, by_turn = self._radius(center)
        at = self._at
        slope = [end * (by_radius[j] + 1j * radius * at[j]) for j in (0, 1)]
        bend = [
            end * (-by_radius[j] * by_turn[k] - by_radius[k] * by_turn[j] - radius * at[j] * at[k]
                   + 1j * (by_radius[j] * at[k] + by_radius[k] * at[j]))
            for j, k in ((0, 0), (0, 1), (1, 1))
        ]  # fmt: skip
        rows: Complex = np.stack([radius * end, *slope, *bend])
        return symmetric(self._summed(rows))

    def rest(self, center: Array, width: Array) -> Array:
        """What third powers and above of deviations up to `width` (N, 3) add to F at most (N, 1).

        Infinite where a robot might not turn at all.
        """
        radius, by_radius, by_turn = self._radius(center)
        turned = width @ np.abs(self._at)
        wider, slower = (np.einsum("nj,jnl->nl", width[:, :2], np.abs(part)) for part in (by_radius, by_turn))
        turns = slower < 1
        more = wider * (turned**2 / 2 + slower * turned + slower**2) / np.where(turns, 1 - slower, 1.0)
        found: Array = np.where(turns, np.abs(radius) * turned**3 / 6 + more, np.inf).sum(axis=1, keepdims=True)
        return found

    def _radius(self, center: Array) -> tuple[Array, Array, Array]:
        """The radius rho (N, 2 L), n and h (2, N, 2 L) about robots (N, 3), for the beginnings and the ends."""
        turn = center[:, :2] @ self._turn
        radius = (center[:, :2] @ self._way) / turn
        by_turn = self._turn[:, None] / turn
        by_radius = self._way[:, None] / turn - radius * by_turn
        return np.tile(radius, 2), np.tile(by_radius, 2), np.tile(by_turn, 2)

    def _summed(self, ends: Complex) -> Complex:
        found: Complex = -1j * (ends * self._sign).sum(axis=-1, keepdims=True)
        return found


class Circle:
    """A drive that is a single piece: where on its circle a robot is, nobody knows.

    However far the robots of a box turn, if all to the same side, each stays on a circle of radius b rho, whose middle
    lies to the left of the start. The distance of its farthest point from an estimate is convex in middle and radius,
    and the radius is monotone in each of the robot's coordinates: none exceeds those of the corners.

    Args:
        piece: its begin and end (2, 2) [rad].
    """

    def __init__(self, piece: Array) -> None:
        self._way = np.diff(way(piece), axis=0)[0]
        self._turn = np.diff(turning(piece), axis=0)[0, :2]

    def farthest(self, track: Array, at: Array, estimate: Complex) -> Array:
        """A bound on the distance from estimates (K,) [m] over boxes (N, K), of their corners (N, C) and (N, C, 3).

        Infinite where the robots of a box might turn to either side.
        """
        turn: Array = at[..., :2] @ self._turn
        together = (turn.min(axis=1) > 0) | (turn.max(axis=1) < 0)
        radius = track * (at[..., :2] @ self._way) / np.where(together[:, None], turn, 1.0)
        middle = 1j * radius * np.exp(1j * at[..., 2])
        off = np.abs(middle[..., None] - estimate) + np.abs(radius)[..., None]
        # The middle of the circle moves along an arc where the heading at the start is not known.
        turned = np.ptp(at[..., 2], axis=1) / 2
        found = off.max(axis=1) + (np.abs(radius).max(axis=1) * turned**2 / 2)[:, None]
        return np.where(together[:, None], found, np.inf)

    def changed_by(self, boxes: Array, box: RobotBox, turned: Array) -> Array:
        """What is to be halved first (N, 4): what changes the radius by some per cent, else what turns the robot."""
        change = (
            self._radius(*box.physical(sides(boxes))) / self._radius(*box.physical(boxes.mean(axis=1)))[:, None] - 1
        )
        return np.minimum(turned, np.pi) + 100 * np.abs(change)

    def _radius(self, track: Array, at: Array) -> Array:
        radius: Array = track * (at[..., :2] @ self._way) / (at[..., :2] @ self._turn)
        return radius
