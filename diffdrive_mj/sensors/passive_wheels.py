"""Passive wheels (dead wheels, odometry pods): wheels without a motor that roll along, and the motion that they show.

A passive wheel is sprung onto the floor and neither drives nor carries: it rolls in its own direction and slides freely
across, as an omni wheel does. Over a step of constant twist, along which the robot moves by (dx, dy, dtheta) in its own
frame, the wheel at (x, y) that rolls in the direction a turns by phi, exactly:

    r phi = cos(a) dx + sin(a) dy + l dtheta        l = x sin(a) - y cos(a)

l is its lever arm: minus y of a wheel that points ahead, x of one that points to the left. One row a wheel makes one
linear law; the motion is its least-squares inverse. A motion that the law maps to zero cannot be seen and is refused by
name. The floor is flat to them: what a slope of terrain or a cable adds to their way is left out, and so are hops.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array, array
from diffdrive_mj._described import checked, described
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.sensors import _sight
from diffdrive_mj.sensors._counters import Counts, held_at_first


@described()
@dataclass(frozen=True, kw_only=True)
class PassiveWheel:
    """A wheel without a motor: where it is mounted and how it is read.

    Args:
        x: forward of the driven axle's midpoint [m].
        y: to the left of it [m].
        angle: of the direction in which it rolls, counter-clockwise off the robot's [rad]; pi / 2 rolls to the left.
        radius: [m].
        ticks_per_revolution: all edges counted; need not be whole.

    Raises:
        InvalidValue: a number that is not finite or above 10 m, a radius or a number of ticks that is not positive.
        InvalidType: not a number.
        UnknownName: a field that a passive wheel does not have.

    References:
        The defaults are those of goBILDA's 4-bar pod, 32 mm and 2000 ticks: 19.894 ticks per mm in its Pinpoint driver.

    Example:
        >>> dd.PassiveWheel(y=0.08).lever_arm
        -0.08
    """

    x: float = field(default=0.0, metadata=checked(checks.limited(checks.number, 10.0, "m")))
    y: float = field(default=0.0, metadata=checked(checks.limited(checks.number, 10.0, "m")))
    angle: float = field(default=0.0, metadata=checked(checks.number))
    radius: float = field(default=0.016, metadata=checked(checks.limited(checks.positive, 10.0, "m")))
    ticks_per_revolution: float = field(default=2000.0, metadata=checked(checks.positive))

    @property
    def lever_arm(self) -> float:
        """How far it rolls per radian of turning about the axle's midpoint, x sin(angle) - y cos(angle) [m]."""
        return self.x * math.sin(self.angle) - self.y * math.cos(self.angle)

    def moved(self, lever_arm: float) -> PassiveWheel:
        """Move it along its own axle to another lever arm; where it is along its rolling direction changes nothing.

        Args:
            lever_arm: [m].

        Returns:
            The moved wheel.

        Example:
            >>> dd.PassiveWheel(x=0.03, y=0.08).moved(-0.07)
            PassiveWheel(x=0.03, y=0.07, angle=0.0, radius=0.016, ticks_per_revolution=2000.0)
        """
        by = checks.number("lever_arm", lever_arm) - self.lever_arm
        return replace(self, x=self.x + by * math.sin(self.angle), y=self.y - by * math.cos(self.angle))


def _fixed(values: ArrayLike) -> Array:
    """An array that nobody can change, as part of a description."""
    result = np.array(values, dtype=np.float64)
    result.flags.writeable = False
    return result


def _wheels(name: str, value: Sequence[PassiveWheel]) -> tuple[PassiveWheel, ...]:
    wheels = tuple(checks.instances(name, value, PassiveWheel))
    if not wheels:
        raise InvalidValue(f"{name}: must hold at least one PassiveWheel")
    return wheels


@described()
@dataclass(frozen=True, kw_only=True)
class PassiveWheels:
    """The passive wheels of a robot, read together.

    Args:
        wheels: n of them, in the order of their readings.

    Raises:
        InvalidValue: no wheel.
        InvalidType: something else than passive wheels.

    Example:
        Three pods, of which two point ahead and one to the left, while the robot drives 0.5 m and turns by 0.2 rad:

        >>> left, right = dd.PassiveWheel(y=0.08), dd.PassiveWheel(y=-0.08)
        >>> across = dd.PassiveWheel(x=-0.05, angle=np.pi / 2)
        >>> pods = dd.PassiveWheels(wheels=(left, right, across))
        >>> pods.displacement((0.5, 0.0, 0.2)).round(9).tolist()
        [0.484, 0.516, -0.01]
        >>> np.abs(pods.motion((0.484, 0.516, -0.01))).round(9).tolist()
        [0.5, 0.0, 0.2]

        Two of them do not see everything:

        >>> dd.PassiveWheels(wheels=(left, right)).motion((0.484, 0.516))
        Traceback (most recent call last):
        ...
        diffdrive_mj.errors.InvalidValue: passive wheels: cannot see a slide to the side; ... shows it
    """

    wheels: tuple[PassiveWheel, ...] = field(metadata=checked(_wheels))

    @functools.cached_property
    def matrix(self) -> Array:
        """The law (n, 3): how far each wheel rolls per motion ahead [m], to the left [m] and turn [rad]."""
        return _fixed([(math.cos(w.angle), math.sin(w.angle), w.lever_arm) for w in self.wheels])

    @functools.cached_property
    def radii(self) -> Array:
        """(n,) [m]."""
        return _fixed([wheel.radius for wheel in self.wheels])

    @functools.cached_property
    def tick_angles(self) -> Array:
        """The angle of one tick of each wheel (n,) [rad]."""
        return _fixed([2 * math.pi / wheel.ticks_per_revolution for wheel in self.wheels])

    def displacement(self, motion: ArrayLike) -> Array:
        """Compute how far the wheels roll in steps of the robot.

        ```
        d_i = cos(a_i) dx + sin(a_i) dy + (x_i sin(a_i) - y_i cos(a_i)) dtheta
        ```

        Args:
            motion: (..., 3): the twist times the duration of each step, ahead [m], to the left [m], turn [rad].

        Returns:
            (..., n) [m].

        Raises:
            InvalidType: not numbers.
            InvalidValue: shapes that do not fit, or values that are not finite.
        """
        return array("motion", motion, 3) @ self.matrix.T

    def angles(self, motion: ArrayLike) -> Array:
        """Compute how far the wheels turn in steps of the robot: `displacement` by their radii.

        Args:
            motion: (..., 3), ahead [m], to the left [m], turn [rad].

        Returns:
            (..., n) [rad].
        """
        return self.displacement(motion) / self.radii

    def unseen(self, *, turn_known: bool = False, slides: bool = True) -> tuple[str, ...]:
        """Name the motions that the wheels cannot see; for `motion` there must be none.

        Args:
            turn_known: whether a gyro gives the turn.
            slides: whether the driven axle may slide sideways; if not, the motion to the left is known to be zero.

        Returns:
            Each in words; () where everything is seen.

        Example:
            Wheels on one line that runs through the turn, and an axle that does not slide:

            >>> in_line = dd.PassiveWheels(wheels=(dd.PassiveWheel(x=0.1), dd.PassiveWheel(x=-0.1)))
            >>> in_line.unseen(slides=False)
            ('a turn about (0, 0) m',)
            >>> in_line.unseen()
            ('a slide to the side', 'a turn about (0, 0) m')
            >>> in_line.unseen(turn_known=True, slides=False)
            ()
        """
        spread = max(math.hypot(wheel.x, wheel.y) for wheel in self.wheels)
        known, free = checks.boolean("turn_known", turn_known), checks.boolean("slides", slides)
        return _sight.unseen(self.matrix, spread, known, free)

    def motion(self, displacement: ArrayLike, *, turn: ArrayLike | None = None, slides: bool = True) -> Array:
        """Compute the robot's steps from what the wheels rolled: the least-squares inverse of `displacement`.

        Args:
            displacement: (..., n) [m].
            turn: (...) [rad], the turn of each step where a gyro gives it, taken as it is; the wheels show the rest.
            slides: whether the driven axle may slide sideways. False takes the motion to the left for zero, as wheel
                odometry does; two wheels need it without a gyro.

        Returns:
            (..., 3), ahead [m], to the left [m], turn [rad], as `odometry.accumulate` takes them.

        Raises:
            InvalidType: not numbers.
            InvalidValue: motions that the wheels cannot see, which the message names; shapes that do not fit, or values
                that are not finite.
        """
        rolled = array("displacement", displacement, len(self.wheels))
        self._refuse_blindness(turn is not None, checks.boolean("slides", slides))
        shown = np.flatnonzero([True, slides, turn is None])
        given = np.zeros(()) if turn is None else array("turn", turn)
        result = np.zeros((*checks.broadcast(displacement=rolled[..., 0], turn=given), 3))
        result[..., 2] = given
        straight = rolled - given[..., None] * self.matrix[:, 2]
        result[..., shown] = straight @ np.linalg.pinv(self.matrix[:, shown]).T
        return result

    def from_angles(self, angles: ArrayLike, *, turn: ArrayLike | None = None, slides: bool = True) -> Array:
        """Compute the robot's steps from the wheels' angles.

        Args:
            angles: (..., T, n) [rad], how far each wheel has turned so far (`Recording.passive_angles`).
            turn: (..., T - 1) [rad], as for `motion`.
            slides: as for `motion`.

        Returns:
            (..., T - 1, 3), ahead [m], to the left [m], turn [rad].

        Raises:
            InvalidType: not numbers.
            InvalidValue: as for `motion`, or less than two samples.

        Example:
            >>> pods = dd.PassiveWheels(wheels=(dd.PassiveWheel(y=0.08), dd.PassiveWheel(x=-0.05, angle=np.pi / 2)))
            >>> steps = pods.from_angles([(0.0, 0.0), (50.0, 0.0)], turn=[0.0])
            >>> dd.odometry.accumulate(steps)[-1].round(9) + 0.0
            array([0.8, 0. , 0. ])
        """
        read = array("angles", angles, "T", len(self.wheels))
        if read.shape[-2] < 2:
            raise InvalidValue(f"angles has {read.shape[-2]} sample: must have at least two to move between")
        if turn is not None:
            turn = array("turn", turn, read.shape[-2] - 1)
        return self.motion(np.diff(read, axis=-2) * self.radii, turn=turn, slides=slides)

    def ticks(self, angles: ArrayLike, *, phase: ArrayLike = 0.5) -> Counts:
        """Compute what the wheels' encoders count.

        Args:
            angles: (..., T, n) [rad].
            phase: (..., n) or a number, how full each counter is at first, of 0 to 1 tick; uniform for random drives.

        Returns:
            (..., T, n), zero at first.

        Raises:
            InvalidType: not numbers.
            InvalidValue: shapes that do not fit, a phase out of its range, or more ticks than a number holds.
        """
        turned, filled = array("angles", angles, "T", len(self.wheels)), held_at_first(phase, len(self.wheels))
        checks.broadcast(angles=turned[..., 0, 0], phase=filled[..., 0])
        if (filled < 0).any() or (filled >= 1).any():
            raise InvalidValue("phase: must be at least 0 and below 1 tick")
        counts = np.floor((turned - turned[..., :1, :]) / self.tick_angles + filled[..., None, :])
        if not (np.abs(counts) <= 2**53).all():
            raise InvalidValue(f"angles = {np.abs(turned).max():.3g} rad: more ticks than a number holds, 2^53")
        return counts.astype(np.int64)

    def from_ticks(self, ticks: ArrayLike) -> Array:
        """Compute the wheels' angles from the ticks.

        Args:
            ticks: (..., T, n).

        Returns:
            (..., T, n) [rad].
        """
        return array("ticks", ticks, "T", len(self.wheels)) * self.tick_angles

    def _refuse_blindness(self, turn_known: bool, slides: bool) -> None:
        def blind(turn_known: bool, slides: bool) -> tuple[str, ...]:
            return self.unseen(turn_known=turn_known, slides=slides)

        if unseen := blind(turn_known, slides):
            raise InvalidValue(
                f"passive wheels: cannot see {' or '.join(unseen)}; {_sight.cures(blind, turn_known, slides)} shows it"
            )
