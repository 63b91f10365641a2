"""The mouse sensor: an optical flow sensor under the robot, and the motion that it shows.

It measures how its own site moves over the floor, forward and to the left in its own frame. Mounted a distance m
ahead of the axle's midpoint, a turn by dtheta moves it sideways by m dtheta, so that one sensor separates turn and
distance as long as the axle itself does not move sideways:

    [ct-Sim], part 2:   X = alpha m to the right, Y = alpha r forward;   alpha = X / m, r = Y / alpha, alpha clockwise
    here:               left = m dtheta,          forward = ds;          dtheta = left / m, ds = forward

Y is the arc, not the chord, and both are defined for a straight line as they stand.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj import _checks as checks
from diffdrive_mj import se2
from diffdrive_mj._checks import Array, array
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.sensors._counters import Counts, held_at_first

COUNTS_PER_INCH = 1 / 0.0254


@dataclass(frozen=True, kw_only=True)
class FlowSensor:
    """An optical flow sensor and where it is mounted.

    Args:
        x: forward of the axle's midpoint [m]. Not zero: on the axle a turn does not move it sideways.
        y: to the left of it [m].
        angle: of its forward axis, counter-clockwise off the robot's [rad].
        counts_per_metre: resolution; 400 counts per inch by default.

    Raises:
        InvalidType: a field is not a number; the message names it.
        InvalidValue: a mounting on the axle, a resolution that is not positive.

    Example:
        A sensor 20 mm ahead of the axle, while the robot drives 10 mm and turns by 0.1 rad:

        >>> sensor = dd.FlowSensor(x=0.020)
        >>> sensor.displacement((0.010, 0.1)).round(6).tolist()
        [0.01, 0.002]
        >>> sensor.motion((0.010, 0.002)).round(6).tolist()
        [0.01, 0.1]
    """

    x: float
    y: float = 0.0
    angle: float = 0.0
    counts_per_metre: float = 400 * COUNTS_PER_INCH

    def __post_init__(self) -> None:
        for field in ("x", "y", "angle"):
            checks.number(f"FlowSensor.{field}", getattr(self, field))
        checks.positive("FlowSensor.counts_per_metre", self.counts_per_metre)
        if self.x == 0:
            raise InvalidValue(
                "FlowSensor.x = 0: must not be zero, since a sensor on the axle's line does not move sideways when "
                "the robot turns, so that rotation cannot be seen"
            )

    def displacement(self, motion: ArrayLike) -> Array:
        """Compute what the sensor sees of steps of the robot.

        ```
        forward = ds - y dtheta        left = dl + x dtheta
        ```

        turned by -angle into the sensor's axes.

        Args:
            motion: (..., 2), distance ds [m] and turn dtheta [rad], or (..., 3), distance, slide to the left dl [m] and
                turn, of steps on which both keep their ratio (arcs).

        Returns:
            (..., 2) forward, left [m].

        Raises:
            InvalidType: not numbers.
            InvalidValue: shapes that do not fit, or values that are not finite.

        References:
            [ct-Sim]: equations 2.4 to 2.8, for a sensor on the robot's axis; its m is x.
        """
        steps = array("motion", motion, "2 or 3")
        if steps.shape[-1] not in (2, 3):
            raise InvalidValue(f"motion has shape {steps.shape}: must be (..., 2) or (..., 3)")
        turn = steps[..., -1]
        slide = steps[..., 1] if steps.shape[-1] == 3 else 0.0
        seen = np.stack([steps[..., 0] - self.y * turn, slide + self.x * turn], axis=-1)
        return se2.rotate(seen, -self.angle)

    def motion(self, displacement: ArrayLike) -> Array:
        """Compute the robot's steps from what the sensor saw, if the axle did not slide: `displacement`'s inverse.

        Args:
            displacement: (..., 2) forward, left in the sensor's axes [m].

        Returns:
            (..., 2), distance [m] and turn [rad], as `odometry.accumulate` takes them.

        References:
            [ct-Sim]: equations 2.9 and 2.10.
        """
        seen = se2.rotate(array("displacement", displacement, 2), self.angle)
        turn = seen[..., 1] / self.x
        return np.stack([seen[..., 0] + self.y * turn, turn], axis=-1)

    def counts(self, flow: ArrayLike, *, phase: ArrayLike = 0.5, lifted: ArrayLike | None = None) -> Counts:
        """Compute what the sensor's two counters show.

        Args:
            flow: (..., T, 2) [m], how far its site has moved so far, forward and to the left (`Recording.flow`).
            phase: (..., 2), how full each counter is at first, of 0 to 1 count; draw it uniformly for random drives.
            lifted: (..., T), whether the sensor has lost the floor since the sample before; it then counts nothing.

        Returns:
            (..., T, 2), zero at first.

        Raises:
            InvalidType: not numbers; `lifted` not of bools.
            InvalidValue: shapes that do not fit, a phase out of its range, or more counts than a number holds.
        """
        moved, filled = array("flow", flow, "T", 2), held_at_first(phase)
        if (filled < 0).any() or (filled >= 1).any():
            raise InvalidValue("phase: must be at least 0 and below 1 count")
        lost = (
            np.zeros(moved.shape[-2], dtype=np.bool_)
            if lifted is None
            else checks.flags("lifted", lifted, moved.shape[-2])
        )
        checks.broadcast(flow=moved[..., 0, 0], phase=filled[..., 0], lifted=lost[..., 0])
        if lifted is not None:
            steps = np.diff(moved, axis=-2, prepend=moved[..., :1, :])
            moved = np.cumsum(np.where(lost[..., None], 0.0, steps), axis=-2)
        with np.errstate(over="ignore", invalid="ignore"):
            exact = (moved - moved[..., :1, :]) * self.counts_per_metre
        counts = np.floor(exact + filled[..., None, :])
        if not (np.abs(counts) <= 2**53).all():
            raise InvalidValue(f"flow = {np.abs(moved).max():.3g} m: more counts than a number holds, 2^53")
        return counts.astype(np.int64)

    def from_counts(self, counts: ArrayLike) -> Array:
        """Compute the robot's steps from the counters.

        Args:
            counts: (..., T, 2), forward and to the left.

        Returns:
            (..., T - 1, 2), distance [m] and turn [rad].
        """
        return self.from_flow(array("counts", counts, "T", 2) / self.counts_per_metre)

    def from_flow(self, flow: ArrayLike) -> Array:
        """Compute the robot's steps from the flow.

        Args:
            flow: (..., T, 2) [m], how far the sensor has moved so far, forward and to the left.

        Returns:
            (..., T - 1, 2), distance [m] and turn [rad].
        """
        moved = array("flow", flow, "T", 2)
        if moved.shape[-2] < 2:
            raise InvalidValue(f"flow has {moved.shape[-2]} sample: must have at least two to move between")
        return self.motion(np.diff(moved, axis=-2))


def lever_arm(displacement: ArrayLike, turned: ArrayLike, angle: float = 0.0) -> Array:
    """Find where a sensor is mounted, from a turn on the spot by a known angle.

    ```
    x = left / turned        y = -forward / turned
    ```

    in the robot's axes.

    Args:
        displacement: (..., 2), sum of what it saw on the way, forward and left [m].
        turned: (...) [rad], counter-clockwise, through all turns; not zero.
        angle: of the sensor's forward axis off the robot's [rad]; a straight drive shows it, `mounting_angle`.

    Returns:
        (..., 2) x, y [m].

    Raises:
        InvalidType: not numbers.
        InvalidValue: no turn, shapes that do not fit, or values that are not finite.

    Example:
        >>> sensor = dd.FlowSensor(x=0.015, y=-0.003)
        >>> three_turns = 6 * np.pi
        >>> dd.optical_flow.lever_arm(sensor.displacement((0.0, three_turns)), three_turns).round(9).tolist()
        [0.015, -0.003]
    """
    seen, turn = se2.rotate(array("displacement", displacement, 2), angle), array("turned", turned)
    checks.broadcast(displacement=seen[..., 0], turned=turn)
    if (np.abs(turn) < checks.SMALLEST).any():
        raise InvalidValue("turned = 0: must not be zero, or the lever arm cannot be seen")
    return np.stack([seen[..., 1] / turn, -seen[..., 0] / turn], axis=-1)


def mounting_angle(displacement: ArrayLike) -> Array:
    """Find the angle of a sensor's forward axis off the robot's, from what it saw on a straight drive ahead.

    Args:
        displacement: (..., 2), forward and left [m].

    Returns:
        (...) [rad], counter-clockwise.

    Raises:
        InvalidType: not numbers.
        InvalidValue: no motion, shapes that do not fit, or values that are not finite.

    Example:
        >>> sensor = dd.FlowSensor(x=0.015, angle=0.02)
        >>> dd.optical_flow.mounting_angle(sensor.displacement((1.0, 0.0))).round(9).item()
        0.02
    """
    seen = array("displacement", displacement, 2)
    if (seen == 0).all(axis=-1).any():
        raise InvalidValue("displacement = (0, 0): must not be zero, or the angle cannot be seen")
    return -np.arctan2(seen[..., 1], seen[..., 0])


def count_error_covariance(exact: ArrayLike) -> Array:
    """Compute the covariance of the errors of one counter at several times, over a uniformly random phase.

    A counter that was filled by the phase U reads floor(n + U) for an exact n; its error is -a with the probability
    1 - a and 1 - a with the probability a, a being the fraction of n; two errors share U:

    ```
    cov_jk = min(a_j, a_k) - a_j a_k
    ```

    Args:
        exact: (..., K), what the counter should read, not rounded [counts].

    Returns:
        (..., K, K) [counts^2].

    Raises:
        InvalidType: not numbers.
        InvalidValue: no dimension, or values that are not finite.

    Example:
        >>> dd.optical_flow.count_error_covariance([7.0, 7.5]).tolist()
        [[0.0, 0.0], [0.0, 0.25]]
    """
    n = array("exact", exact, "K")
    a = n - np.floor(n)
    return np.minimum(a[..., :, None], a[..., None, :]) - a[..., :, None] * a[..., None, :]
